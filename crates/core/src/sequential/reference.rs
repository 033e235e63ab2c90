//! The reference: C1 − C2 on a healthy cylinder along the stroke and with speed, and its
//! uncertainty.

use super::parameters::ResidualParameters;
use alloc::vec::Vec;

/// Where the reference may be off by more than this, nothing is known, m: so much is a fault elsewhere.
pub const LARGEST_DOUBT: f64 = ResidualParameters::DEFAULT.largest_doubt;

/// It may be off by so many of its standard deviations.
pub const DOUBTED: f64 = ResidualParameters::DEFAULT.doubted;

/// Hat functions along the stroke and one term in velocity. They include a and b of (5-20), the
/// deviation from a straight line, and the time by which one transducer samples after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Position of the first node, m.
    pub first: f64,
    /// Distance between nodes, m.
    pub spacing: f64,
    /// C1 − C2 at rest at each node, m; at least two.
    pub nodes: Vec<f64>,
    /// Uncertainty at each node, m.
    pub doubts: Vec<f64>,
    /// For each cell between two nodes, whether the calibration has covered it.
    pub covered: Vec<bool>,
    /// Growth of C1 − C2 with the velocity, s.
    pub velocity: f64,
}

/// A place on the stroke: the cell, and how far into it, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    pub cell: usize,
    pub part: f64,
}

impl Reference {
    /// The place of `length`, m, among `nodes` nodes; `None` beyond them.
    pub fn place(first: f64, spacing: f64, nodes: usize, length: f64) -> Option<Place> {
        let along = (length - first) / spacing;
        // Not `floor`, which is a call: what is negative is beyond the nodes.
        let floor = along as u32;
        let cell = floor as usize;
        let inside = along >= 0.0 && cell < nodes.saturating_sub(1);
        inside.then_some(Place { cell, part: along - f64::from(floor) })
    }

    /// Residual C1 − (C2 + φᵀθ), m, of readings in m and a velocity in m/s, and its uncertainty, m;
    /// `None` where the calibration does not know the place of either reading, one of which may be
    /// grossly wrong.
    #[inline]
    pub fn residual(&self, c1: f64, c2: f64, velocity: f64) -> Option<(f64, f64)> {
        let (place, doubt) = self.known(c2).or_else(|| self.known(c1))?;
        Some((c1 - c2 - self.at(place, velocity), doubt))
    }

    /// C1 − C2, m, of healthy readings where C2 reads `c2`, m, at a velocity in m/s; `None` where
    /// it is not known.
    pub fn healthy(&self, c2: f64, velocity: f64) -> Option<f64> {
        self.known(c2).map(|(place, _)| self.at(place, velocity))
    }

    /// The parts of the stroke, from and to in m, whose uncertainty is beyond `above`, m, and at
    /// most `most`.
    pub fn spans(&self, above: f64, most: f64) -> Vec<[f64; 2]> {
        let mut spans: Vec<[f64; 2]> = Vec::new();
        let cells = self.doubts.windows(2).zip(&self.covered).enumerate();
        for (cell, (ends, _)) in cells.filter(|(_, (_, covered))| **covered) {
            let (low, grows) = (ends[0], ends[1] - ends[0]);
            let crossing = |doubt: f64| ((doubt - low) / grows).clamp(0.0, 1.0);
            let mut cuts = [0.0, crossing(above), crossing(most), 1.0];
            if grows == 0.0 {
                cuts = [0.0, 0.0, 0.0, 1.0];
            }
            cuts.sort_by(f64::total_cmp);
            for part in cuts.windows(2).filter(|part| part[0] < part[1]) {
                let doubt = low + 0.5 * (part[0] + part[1]) * grows;
                let [from, to] =
                    [part[0], part[1]].map(|part| self.first + self.spacing * (cell as f64 + part));
                match spans.last_mut() {
                    _ if doubt <= above || doubt > most => {}
                    Some(last) if from - last[1] < 1e-9 => last[1] = to,
                    _ => spans.push([from, to]),
                }
            }
        }
        spans
    }

    fn at(&self, place: Place, velocity: f64) -> f64 {
        let [low, high] = [self.nodes[place.cell], self.nodes[place.cell + 1]];
        low + place.part * (high - low) + self.velocity * velocity
    }

    /// The place of a length, m, and the uncertainty of the reference there, m: between two nodes
    /// it does not exceed that between theirs.
    #[inline]
    fn known(&self, length: f64) -> Option<(Place, f64)> {
        let place = Self::place(self.first, self.spacing, self.nodes.len(), length)?;
        let [low, high] = [self.doubts[place.cell], self.doubts[place.cell + 1]];
        let doubt = low + place.part * (high - low);
        (self.covered[place.cell] && doubt <= LARGEST_DOUBT).then_some((place, doubt))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reference() -> Reference {
        Reference {
            first: -1.0,
            spacing: 0.5,
            nodes: vec![1e-3, 2e-3, 4e-3],
            doubts: vec![0.0; 3],
            covered: vec![true, false],
            velocity: 1e-4,
        }
    }

    /// A reference that is uncertain from the first node to half of the last cell, and gets better
    /// towards the second.
    fn doubtful() -> Reference {
        Reference { doubts: vec![1.5e-4, 0.5e-4, 3.5e-4], covered: vec![true; 2], ..reference() }
    }

    #[test]
    fn between_two_nodes_it_is_a_straight_line() {
        let residual = reference().residual(-0.75 + 1.5e-3 + 2e-5, -0.75, 0.2);
        assert!(residual.is_some_and(|(r, doubt)| r.abs() < 1e-15 && doubt == 0.0), "{residual:?}");
    }

    #[test]
    fn a_reading_that_left_the_covered_stroke_is_still_compared() {
        let (residual, _) = reference().residual(-0.75, 0.4, 0.0).expect("C1 is where it is known");
        assert!((residual - (-1.15 - 1.5e-3)).abs() < 1e-12, "{residual}");
    }

    #[test]
    fn where_the_calibration_has_not_been_nothing_is_known() {
        for c2 in [-0.25, -1.01, 0.0, 7.0, f64::NAN, f64::INFINITY] {
            assert_eq!(reference().residual(c2, c2, 0.0), None, "{c2}");
        }
    }

    #[test]
    fn what_is_known_badly_is_told_and_what_is_not_known_is_not_judged() {
        let doubt = |c2: f64| doubtful().residual(c2, c2, 0.0).map(|(_, doubt)| doubt);
        assert!(doubt(-0.75).is_some_and(|doubt| (doubt - 1e-4).abs() < 1e-12));
        assert!(doubt(-0.26).is_some_and(|doubt| (1.9e-4..2e-4).contains(&doubt)));
        assert_eq!(doubt(-0.24), None);
        assert_eq!(doubtful().healthy(-0.24, 0.0), None);
    }

    #[test]
    fn the_spans_of_a_doubt_are_cut_where_it_crosses() {
        let near = |found: &[[f64; 2]], expected: &[[f64; 2]]| {
            assert_eq!(found.len(), expected.len(), "{found:?}");
            let both = found.iter().flatten().zip(expected.iter().flatten());
            both.for_each(|(one, other)| assert!((one - other).abs() < 1e-9, "{found:?}"));
        };
        let spans = |above, most| doubtful().spans(above, most);
        near(&spans(-1.0, LARGEST_DOUBT), &[[-1.0, -0.25]]);
        near(&spans(1e-4, LARGEST_DOUBT), &[[-1.0, -0.75], [-0.5 + 0.5 / 6.0, -0.25]]);
        near(&spans(LARGEST_DOUBT, 1.0), &[[-0.25, 0.0]]);
        near(&reference().spans(-1.0, LARGEST_DOUBT), &[[-1.0, -0.5]]);
    }
}
