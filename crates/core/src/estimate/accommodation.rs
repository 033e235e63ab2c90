//! Accommodation of a step (thesis, 6-2): a reading that is off by a constant is good once that is subtracted.
//!
//! While the other transducer is trusted, the difference of the two is averaged over two halves of a configured time. If
//! these agree and nothing but the usual noise is left, the newer mean is the size of the step. How far the halves are
//! apart is a rate, and widens what is subtracted for as long as nobody confirms it.

use super::parameters::EstimateParameters;
use crate::state::{state, whole};

/// When a step is subtracted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AccommodationDesign {
    /// Cycles that a filter takes to follow a step, which do not count.
    pub settle: u32,
    /// Cycles that a difference has to stand still, at least 2.
    pub after: u32,
    /// Most cycles since the other transducer confirmed the size.
    pub most: u32,
}

/// Differences of half of [`AccommodationDesign::after`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Half {
    count: u32,
    mean: f64,
    /// Sum of the squared deviations from the mean, m².
    squares: f64,
}

whole! { Half { count, mean, squares } }

impl Half {
    fn add(&mut self, value: f64) {
        self.count = self.count.saturating_add(1);
        let apart = value - self.mean;
        self.mean += apart / f64::from(self.count);
        self.squares += apart * (value - self.mean);
    }

    fn variance(&self) -> f64 {
        self.squares / f64::from(self.count.max(1))
    }
}

/// What is to be subtracted from the length by one transducer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offset {
    /// m.
    pub size: f64,
    /// Its variance, m².
    pub variance: f64,
}

/// The step of one transducer.
#[derive(Clone, Debug)]
pub struct Accommodation {
    design: AccommodationDesign,
    /// Cycles since the step, up to [`AccommodationDesign::settle`].
    followed: u32,
    open: Half,
    halves: [Half; 2],
    /// Cycles since the other transducer confirmed it.
    age: u32,
}

state! {
    Accommodation { followed, open, halves, age }
    but { design }
}

impl Accommodation {
    pub fn new(design: AccommodationDesign) -> Self {
        let nothing = Half::default();
        Self { design, followed: 0, open: nothing, halves: [nothing; 2], age: 0 }
    }

    /// Forgets the step: the reading is another one now.
    pub fn forget(&mut self) {
        *self = Self::new(self.design);
    }

    /// Takes a cycle in which the length by this transducer was `difference` more than that by the other one, which is
    /// trusted, m; `None` where there is none.
    pub fn step(&mut self, difference: Option<f64>) {
        let Some(difference) = difference else {
            self.age = self.age.saturating_add(1);
            return;
        };
        if self.age > 0 {
            // What the other one was in between is not known.
            self.open = Half::default();
        }
        self.age = 0;
        if self.followed < self.design.settle {
            self.followed += 1;
            return;
        }
        self.open.add(difference);
        if self.open.count >= self.design.after / 2 {
            let [_, newer] = self.halves;
            (self.halves, self.open) = ([newer, self.open], Half::default());
        }
    }

    /// What to subtract, where healthy differences have the mean square `usual`, m²; `None` unless it stood still for
    /// long enough, not too long ago.
    pub fn offset(&self, usual: f64, parameters: &EstimateParameters) -> Option<Offset> {
        let [older, newer] = self.halves;
        let half = f64::from(self.design.after / 2);
        let most = parameters.still * parameters.still * usual;
        let apart = newer.mean - older.mean;
        let is_still = older.count > 0
            && older.variance().max(newer.variance()) <= most
            && apart * apart <= most;
        let since = f64::from(self.open.count) + f64::from(self.age) + 0.5 * half;
        let drifted = apart / half * since;
        let offset = Offset { size: newer.mean, variance: newer.variance() + drifted * drifted };
        (is_still && self.age <= self.design.most).then_some(offset)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DESIGN: AccommodationDesign = AccommodationDesign { settle: 10, after: 200, most: 1000 };
    const P: &EstimateParameters = &EstimateParameters::DEFAULT;
    /// Mean square of a usual difference, m².
    const USUAL: f64 = 1e-8;

    /// Differences of 0.1 mm about `of`, m, in `cycles`.
    fn after(cycles: u32, of: impl Fn(u32) -> f64) -> Accommodation {
        let mut it = Accommodation::new(DESIGN);
        for k in 0..cycles {
            if k == 0 {
                (0..DESIGN.settle).for_each(|_| it.step(Some(0.5)));
            }
            it.step(Some(of(k) + if k % 2 == 0 { 1e-4 } else { -1e-4 }));
        }
        it
    }

    #[test]
    fn a_step_is_known_once_it_stood_still_and_for_as_long_as_configured() {
        assert_eq!(after(199, |_| 0.01).offset(USUAL, P), None);
        let mut step = after(200, |_| 0.01);
        let offset = step.offset(USUAL, P).expect("it stood still");
        assert!((offset.size - 0.01).abs() < 1e-9 && (offset.variance - 1e-8).abs() < 1e-10);
        (0..1000).for_each(|_| step.step(None));
        assert!(step.offset(USUAL, P).is_some());
        step.step(None);
        assert_eq!(step.offset(USUAL, P), None, "it is too old");
        step.step(Some(0.01));
        assert!(step.offset(USUAL, P).is_some(), "it was confirmed");
        step.forget();
        assert_eq!(step.offset(USUAL, P), None);
    }

    #[test]
    fn what_does_not_stand_still_is_no_step() {
        // 1 mm/s, and noise of 1 mm.
        assert_eq!(after(400, |k| 2e-5 * f64::from(k)).offset(USUAL, P), None);
        assert_eq!(after(400, |k| if k % 4 < 2 { 1e-3 } else { -1e-3 }).offset(USUAL, P), None);
        // It was a step, and went on.
        assert_eq!(after(400, |k| if k < 250 { 0.01 } else { 0.02 }).offset(USUAL, P), None);
    }

    /// A drift of 0.05 mm/s at 50 cycles a second.
    #[test]
    fn a_slow_drift_is_within_what_it_is_thought_to_be_off_by() {
        let (speed, cycles) = (1e-6, 300);
        let mut drift = after(cycles, |k| speed * f64::from(k));
        for k in cycles..cycles + 1000 {
            drift.step(None);
            let Offset { size, variance } = drift.offset(USUAL, P).expect("it is slow");
            let off = (speed * f64::from(k) - size).abs();
            assert!(off < 2.0 * variance.sqrt(), "{k}: {off} {variance}");
        }
    }
}
