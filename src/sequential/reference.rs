//! What C1 − C2 is on a healthy cylinder: along the stroke and with speed.

/// Hat functions along the stroke and one term in velocity. With it go a and b of (5-20), what no
/// straight line takes away, and the time by which one transducer samples after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Of the first node, m.
    pub first: f64,
    /// From node to node, m.
    pub spacing: f64,
    /// C1 − C2 at rest at each node, m; at least two.
    pub nodes: Vec<f64>,
    /// For each cell between two nodes, whether the calibration has covered it.
    pub covered: Vec<bool>,
    /// What it grows by with the velocity, s.
    pub velocity: f64,
}

/// A place on the stroke: the cell, and how far into it, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    pub cell: usize,
    pub part: f64,
}

impl Reference {
    /// Where `length`, m, is among `nodes` nodes; `None` beyond them.
    pub fn place(first: f64, spacing: f64, nodes: usize, length: f64) -> Option<Place> {
        let along = (length - first) / spacing;
        // Not `floor`, which is a call: what is negative is beyond the nodes.
        let floor = along as u32;
        let cell = floor as usize;
        let inside = along >= 0.0 && cell < nodes.saturating_sub(1);
        inside.then_some(Place { cell, part: along - f64::from(floor) })
    }

    /// C1 − (C2 + φᵀθ), m, of readings in m and a velocity in m/s; `None` where the calibration
    /// has not been by either of them: one may be wrong by a lot.
    pub fn residual(&self, c1: f64, c2: f64, velocity: f64) -> Option<f64> {
        let place = self.covered(c2).or_else(|| self.covered(c1))?;
        Some(c1 - c2 - self.at(place, velocity))
    }

    /// C1 − C2, m, of healthy readings where C2 reads `c2`, m, at a velocity in m/s; `None` where the
    /// calibration has not been.
    pub fn healthy(&self, c2: f64, velocity: f64) -> Option<f64> {
        self.covered(c2).map(|place| self.at(place, velocity))
    }

    fn at(&self, place: Place, velocity: f64) -> f64 {
        let [low, high] = [self.nodes[place.cell], self.nodes[place.cell + 1]];
        low + place.part * (high - low) + self.velocity * velocity
    }

    fn covered(&self, length: f64) -> Option<Place> {
        let place = Self::place(self.first, self.spacing, self.nodes.len(), length)?;
        self.covered[place.cell].then_some(place)
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
            covered: vec![true, false],
            velocity: 1e-4,
        }
    }

    #[test]
    fn between_two_nodes_it_is_a_straight_line() {
        let residual = reference().residual(-0.75 + 1.5e-3 + 2e-5, -0.75, 0.2);
        assert!(residual.is_some_and(|r| r.abs() < 1e-15), "{residual:?}");
    }

    #[test]
    fn a_reading_that_left_the_covered_stroke_is_still_compared() {
        let residual = reference().residual(-0.75, 0.4, 0.0).expect("C1 is where it is known");
        assert!((residual - (-1.15 - 1.5e-3)).abs() < 1e-12, "{residual}");
    }

    #[test]
    fn where_the_calibration_has_not_been_nothing_is_known() {
        for c2 in [-0.25, -1.01, 0.0, 7.0, f64::NAN, f64::INFINITY] {
            assert_eq!(reference().residual(c2, c2, 0.0), None, "{c2}");
        }
    }
}
