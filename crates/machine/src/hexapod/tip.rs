//! Where the tip of the gangway is, by the cylinders' lengths.

use super::{Hexapod, LEGS, Pose};
use nalgebra::Vector3;

/// A gangway that points forward, and where its tip is. It follows the deck through the forward kinematics.
#[derive(Clone, Copy, Debug)]
pub struct Tip {
    /// The tip from the middle of the deck, m.
    arm: Vector3<f64>,
    /// The deck over the base in the cycle before, from which the search begins.
    deck: Option<Pose>,
}

impl Tip {
    /// The tip of a gangway of `length`, m, from the middle of the deck.
    pub fn new(length: f64) -> Self {
        Self { arm: Vector3::new(length, 0.0, 0.0), deck: None }
    }

    /// How far the tip is from where it would be if the deck stood still, m, with the base at `base` and these true
    /// strokes, m; `None` where no pose has such strokes.
    pub fn motion(&mut self, hexapod: &Hexapod, base: &Pose, strokes: &[f64; LEGS]) -> Option<f64> {
        let neutral = hexapod.neutral();
        let guess = self.deck.unwrap_or(neutral);
        self.deck = hexapod.forward(strokes, &guess).ok().map(|solution| solution.pose);
        let deck = self.deck?;
        let on_base = deck.rotation() * self.arm + deck.translation;
        let tip = base.rotation() * on_base + base.translation;
        Some((tip - (self.arm + neutral.translation)).norm())
    }
}

#[cfg(test)]
mod tests {
    use super::super::Geometry;
    use super::*;

    const GEOMETRY: Geometry = Geometry {
        base_radius: 2.9,
        base_half_angle: 0.12,
        top_radius: 2.3,
        top_half_angle: 0.14,
        neutral_height: 4.2,
        reach: [-1.5, 1.5],
    };

    #[test]
    fn the_tip_stands_still_where_the_strokes_follow_the_vessel_and_moves_where_one_does_not() {
        let hexapod = Hexapod::new(&GEOMETRY);
        let base = Pose::new([0.2, -0.1, 0.3], [0.02, -0.03, 0.01]);
        let strokes = hexapod.inverse(&base, &hexapod.neutral()).expect("it is within reach");
        let mut tip = Tip::new(20.0);
        let still = tip.motion(&hexapod, &base, &strokes).expect("there is a pose");
        assert!(still < 1e-8, "{still}");
        let mut off = strokes;
        off[1] += 0.01;
        let moved = tip.motion(&hexapod, &base, &off).expect("there is a pose");
        assert!((0.01..0.2).contains(&moved), "a lever of 20 m on a deck of 2.3 m: {moved}");
    }
}
