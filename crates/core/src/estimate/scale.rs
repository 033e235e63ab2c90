//! C2 on the scale of C1.

use crate::compare::Comparator;
use crate::sequential::Reference;
use crate::sequential::velocity::Velocity;

/// Conversion of C2 to the scale of C1.
#[derive(Clone, Debug)]
pub struct LengthScale {
    pub comparator: Comparator,
    /// The fitted reference, which is better than the line, but only as far along the stroke as it
    /// was fitted.
    pub reference: Option<Reference>,
}

impl LengthScale {
    /// Takes the readings of a cycle, m, and C2's velocity where it is measured, m/s; returns both
    /// on the scale of C1.
    pub fn apply(
        &self,
        velocity: &mut Velocity,
        [c1, c2]: [Option<f64>; 2],
        measured: Option<f64>,
    ) -> [Option<f64>; 2] {
        let speed = velocity.step(c2, measured);
        let fitted =
            |c2: f64| self.reference.as_ref()?.healthy(c2, speed?).map(|healthy| c2 + healthy);
        [c1, c2.map(|c2| fitted(c2).unwrap_or_else(|| self.comparator.corrected(c2)))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequential::parameters::ResidualParameters;

    #[test]
    fn c2_is_corrected_by_what_was_fitted_and_beyond_it_by_a_and_b() {
        let reference = Reference {
            first: -1.0,
            spacing: 0.5,
            nodes: vec![1e-3, 2e-3, 4e-3],
            doubts: vec![0.0; 3],
            covered: vec![true, false],
            velocity: 1e-3,
        };
        let comparator = Comparator { gain: 1.0, offset: 9e-3 };
        let scale = LengthScale { comparator, reference: Some(reference) };
        let c2 = |c2| {
            let mut velocity = Velocity::new(&ResidualParameters::DEFAULT, 0.02);
            scale.apply(&mut velocity, [None, Some(c2)], Some(0.1))[1].expect("it was read")
        };
        assert!((c2(-0.75) - (-0.75 + 1.5e-3 + 1e-4)).abs() < 1e-12);
        assert!((c2(-0.25) - (-0.25 + 9e-3)).abs() < 1e-12, "not covered");
    }
}
