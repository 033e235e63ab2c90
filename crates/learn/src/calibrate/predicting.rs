//! How well the command predicts the mean of both readings: by how much it is off, and for how long.

use tertius_core::sequential::whitening::ORDER;

/// What a wild reading has moved in the filter is gone after so many cycles.
const DISTURBED: usize = 16;

/// Fewer errors do not tell how they go on: half a minute at 50 Hz.
const LEAST_ERRORS: u64 = 1500;

/// Errors of the command's prediction: sums of both innovations, each with half the weight, times √2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predicted {
    /// Standard deviation, m.
    pub deviation: f64,
    /// Correlation of those that are 1, 2, … cycles apart; `None` of too few.
    pub correlation: Option<[f64; ORDER]>,
}

/// Takes the errors one by one.
#[derive(Clone, Debug, Default)]
pub(super) struct Predicting {
    count: u64,
    squares: f64,
    /// Errors that are told how they go on, the sums of their products with those 0, 1, … cycles
    /// before, m², and the newest of them, as many as there are in a row.
    undisturbed: u64,
    products: [f64; ORDER + 1],
    newest: [f64; ORDER + 1],
    in_a_row: usize,
    /// Cycles until the filter is over a wild reading.
    disturbed: usize,
}

impl Predicting {
    /// Cycles are missing: the filter starts again, and is over every wild reading.
    pub(super) const fn restart(&mut self) {
        self.interrupt();
        self.disturbed = 0;
    }

    /// What follows does not go on from what was before.
    pub(super) const fn interrupt(&mut self) {
        self.in_a_row = 0;
    }

    /// One of both readings is wild.
    pub(super) const fn disturb(&mut self) {
        self.disturbed = DISTURBED;
    }

    /// The innovations of one cycle, m.
    pub(super) fn take(&mut self, [n1, n2]: [f64; 2]) {
        let error = (n1 + n2) * std::f64::consts::FRAC_1_SQRT_2;
        self.count += 1;
        self.squares += error * error;
        if self.disturbed > 0 {
            self.disturbed -= 1;
            return self.interrupt();
        }
        self.newest.rotate_right(1);
        self.newest[0] = error;
        self.in_a_row = (self.in_a_row + 1).min(self.newest.len());
        self.undisturbed += 1;
        let before = &self.newest[..self.in_a_row];
        for (product, before) in self.products.iter_mut().zip(before) {
            *product += error * before;
        }
    }

    /// `None` before there was any.
    pub(super) fn result(&self) -> Option<Predicted> {
        let deviation = (self.squares / self.count.max(1) as f64).sqrt();
        let [variance, together @ ..] = self.products;
        let known = self.undisturbed >= LEAST_ERRORS && variance > 0.0;
        let correlation = known.then(|| together.map(|product| product / variance));
        (self.count > 0).then_some(Predicted { deviation, correlation })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};
    use tertius_core::sequential::whitening::Whitening;

    /// Errors of which each goes on by 0.6, with a wild reading and a gap now and then.
    fn taken(cycles: usize) -> Predicting {
        let (mut rng, mut predicting) = (ChaCha8Rng::seed_from_u64(5), Predicting::default());
        let mut error = 0.0;
        for k in 0..cycles {
            let noise: f64 = StandardNormal.sample(&mut rng);
            error = if k % 90 == 0 { noise } else { 0.6 * error + 0.8 * noise };
            if k % 90 == 0 {
                predicting.interrupt();
            }
            let wild = if k % 50 == 49 { 20.0 } else { 0.0 };
            if wild > 0.0 {
                predicting.disturb();
            }
            predicting.take([1e-4 * (error + wild), 1e-4 * error]);
        }
        predicting
    }

    #[test]
    fn errors_go_on_whatever_wild_readings_and_gaps_there_are() {
        let predicted = taken(100_000).result().expect("there were errors");
        let correlation = predicted.correlation.expect("there were enough");
        for (place, found) in (1..).zip(correlation) {
            let expected = 0.6_f64.powi(place);
            // Runs of 34 cycles and less: each lag has by so much fewer products.
            assert!((found - expected).abs() < 0.06, "{place}: {found}, {expected}");
        }
        assert!(Whitening::of(&correlation).is_some() && correlation[0] > 0.5);
    }

    #[test]
    fn few_errors_do_not_tell_how_they_go_on() {
        assert_eq!(Predicting::default().result(), None);
        let few = taken(1000).result().expect("there were errors");
        assert_eq!(few.correlation, None);
        assert!(few.deviation > 1e-4);
    }
}
