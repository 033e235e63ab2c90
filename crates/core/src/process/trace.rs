//! The newest positions of a spool, beside where it should have stood.

use super::parameters::ProcessParameters;
use super::spool::{SpoolDesign, Stand};
use crate::state::state;
use alloc::boxed::Box;

/// Positions that are kept.
pub const KEPT: usize = 512;

/// The most cycles by which a command is tried to be late.
pub const MOST_LATE: usize = 15;

/// What is wrong with a spool or its command, with its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpoolForm {
    /// It stands beside where it should by so much.
    Offset(f64),
    /// It goes where it should so many cycles later.
    Late(usize),
    /// It goes so much further than it should, as a part of its way.
    Gain(f64),
    /// It stays where it is, within so much.
    Sticking(f64),
    /// It goes somewhere else, by so much.
    Elsewhere(f64),
}

/// A ring of positions and of expected ones.
#[derive(Clone, Debug)]
pub struct Trace {
    /// x, not a number where x̂ had not settled, and x̂.
    stands: Box<[[f64; 2]; KEPT]>,
    count: usize,
}

state! { Trace { stands, count } }

impl Default for Trace {
    fn default() -> Self {
        Self { stands: Box::new([[0.0; 2]; KEPT]), count: 0 }
    }
}

impl Trace {
    pub const fn clear(&mut self) {
        self.count = 0;
    }

    pub fn push(&mut self, stand: &Stand) {
        let position = if stand.is_settled { stand.position } else { f64::NAN };
        self.stands[self.count % KEPT] = [position, stand.expected];
        self.count += 1;
    }

    pub fn held(&self) -> usize {
        self.count.min(KEPT)
    }

    fn ago(&self, cycles: usize) -> [f64; 2] {
        self.stands[(self.count + KEPT - 1 - cycles) % KEPT]
    }

    fn expected(&self, ago: usize) -> f64 {
        self.ago(ago)[1]
    }

    /// The form of what the newest `cycles` show of the spool of `design`; `None` while it has not moved enough in
    /// both directions to tell.
    pub fn form(
        &self,
        cycles: usize,
        of: &SpoolDesign,
        by: &ProcessParameters,
    ) -> Option<SpoolForm> {
        let largest = of.largest;
        // A delay needs the positions before.
        let cycles = cycles.min(self.held().saturating_sub(MOST_LATE));
        if !self.has_moved(cycles, by.moving * largest, by.movements) {
            return None;
        }
        let [mean, square] = self.moments(cycles, 0);
        let variance = square - mean * mean;
        if variance < by.left * square {
            return Some(SpoolForm::Offset(mean));
        }
        let delayed = |late: usize| {
            let [mean, square] = self.moments(cycles, late);
            (square - mean * mean, late)
        };
        let best = (1..=MOST_LATE).map(delayed).min_by(|one, other| one.0.total_cmp(&other.0));
        // A spool that sticks lags, too, but with no delay does it stand where it should.
        let most = (by.left * variance).min(by.late_rest * by.late_rest * self.healthy(cycles, of));
        if let Some((_, late)) = best.filter(|(rest, _)| *rest < most) {
            return Some(SpoolForm::Late(late));
        }
        let gain = self.gain(cycles);
        if self.without_gain(cycles, gain) < by.left * square {
            return Some(SpoolForm::Gain(gain));
        }
        let band = self.band(cycles, of, by);
        Some(if band > by.most_sticking * largest {
            SpoolForm::Elsewhere(band)
        } else {
            SpoolForm::Sticking(band)
        })
    }

    /// Those of the newest `cycles` that can be compared: their ages in cycles.
    fn settled(&self, cycles: usize) -> impl Iterator<Item = usize> {
        (0..cycles).filter(|ago| !self.ago(*ago)[0].is_nan())
    }

    /// The mean of what `of` says of those of the newest `cycles` that can be compared.
    fn mean(&self, cycles: usize, of: impl Fn(usize) -> f64) -> f64 {
        let sum = |(sum, count): (f64, f64), ago: usize| (sum + of(ago), count + 1.0);
        let (sum, count) = self.settled(cycles).fold((0.0, 0.0), sum);
        sum / f64::max(count, 1.0)
    }

    /// Mean square of a healthy deviation with these movements.
    fn healthy(&self, cycles: usize, of: &SpoolDesign) -> f64 {
        let way = |ago: usize| of.timing * (self.expected(ago) - self.expected(ago + 1));
        of.deviation * of.deviation + self.mean(cycles, |ago| way(ago) * way(ago))
    }

    fn has_moved(&self, cycles: usize, far: f64, often: usize) -> bool {
        let (mut up, mut down) = (0, 0);
        for ago in self.settled(cycles) {
            let way = self.expected(ago) - self.expected(ago + 1);
            up += usize::from(way > far);
            down += usize::from(way < -far);
        }
        up >= often && down >= often
    }

    /// Mean and mean square of x(k) − x̂(k − `late`).
    fn moments(&self, cycles: usize, late: usize) -> [f64; 2] {
        let rest = |ago: usize| self.ago(ago)[0] - self.expected(ago + late);
        [self.mean(cycles, rest), self.mean(cycles, |ago| rest(ago) * rest(ago))]
    }

    /// Gain of x − x̂ by x̂.
    fn gain(&self, cycles: usize) -> f64 {
        let dot = |ago: usize| (self.ago(ago)[0] - self.expected(ago)) * self.expected(ago);
        let norm = self.mean(cycles, |ago| self.expected(ago) * self.expected(ago));
        self.mean(cycles, dot) / norm.max(f64::MIN_POSITIVE)
    }

    /// Mean square that is left of x − x̂ without a `gain`.
    fn without_gain(&self, cycles: usize, gain: f64) -> f64 {
        let rest = |ago: usize| self.ago(ago)[0] - (1.0 + gain) * self.expected(ago);
        self.mean(cycles, |ago| rest(ago) * rest(ago))
    }

    /// What nearly all deviations are within of where the spool goes to, which it lags behind: without its lag and
    /// what noise alone would be.
    fn band(&self, cycles: usize, of: &SpoolDesign, by: &ProcessParameters) -> f64 {
        let (kept, moved) = (of.retained, 1.0 - of.retained);
        let rest = |ago: usize| self.ago(ago)[0] - self.expected(ago);
        let (mut sizes, mut count) = ([0.0; KEPT], 0);
        for ago in self.settled(cycles) {
            let size = ((rest(ago) - kept * rest(ago + 1)) / moved).abs();
            if !size.is_nan() {
                sizes[count] = size;
                count += 1;
            }
        }
        let sizes = &mut sizes[..count.max(1)];
        let place = (by.in_band * sizes.len() as f64) as usize;
        let (_, band, _) = sizes.select_nth_unstable_by(place, f64::total_cmp);
        let noise = by.in_band_of_noise * of.noise * libm::sqrt(1.0 + kept * kept) / moved;
        // They are spread evenly over the band.
        libm::sqrt((*band * *band - noise * noise).max(0.0)) / by.in_band
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::process::Curve;
    use crate::sequential::windows::WIDTHS;

    fn design() -> SpoolDesign {
        SpoolDesign {
            retained: 0.5,
            limit: 1.0,
            curve: Curve::new(1.0, alloc::vec![-20.0, 0.0, 20.0]),
            before: Curve::new(1.0, alloc::vec![0.0; 3]),
            doubts: alloc::vec![Some(0.0); 2],
            noise: 0.05,
            deviation: 0.05,
            timing: 0.0,
            largest: 40.0,
            dependence: [[1.0; WIDTHS.len()]; 2],
        }
    }

    /// What 500 cycles show of a spool that swings by 20 in 2 s and stands where `at` says, of where it should.
    fn seen(mut at: impl FnMut(usize, &dyn Fn(usize) -> f64) -> f64) -> Option<SpoolForm> {
        let expected = |k: usize| 20.0 * (k as f64 * 0.063).sin() + 1.0;
        let mut trace = Trace::default();
        for k in 100..600 {
            // A standard deviation of 0.05.
            let noise = 0.0866 * ((k * 7919 % 101) as f64 / 50.0 - 1.0);
            let position = at(k, &expected) + noise;
            trace.push(&Stand {
                position,
                expected: expected(k),
                variance: 2.5e-3,
                doubt: 0.0,
                is_settled: true,
            });
        }
        trace.form(480, &design(), &ProcessParameters::DEFAULT)
    }

    #[test]
    fn each_form_is_told_from_the_others() {
        let near = |one: f64, other: f64| (one - other).abs() < 0.03 * other.abs();
        assert!(matches!(seen(|k, x| x(k) + 0.4), Some(SpoolForm::Offset(by)) if near(by, 0.4)));
        assert_eq!(seen(|k, x| x(k - 1)), Some(SpoolForm::Late(1)));
        assert_eq!(seen(|k, x| x(k - 7)), Some(SpoolForm::Late(7)));
        assert!(matches!(seen(|k, x| 1.1 * x(k)), Some(SpoolForm::Gain(by)) if near(by, 0.1)));
        assert!(matches!(seen(|k, x| -x(k)), Some(SpoolForm::Gain(by)) if near(by, -2.0)));
        let elsewhere = seen(|k, _| 15.0 * ((k * k) as f64 * 0.001).sin());
        assert!(matches!(elsewhere, Some(SpoolForm::Elsewhere(_))), "{elsewhere:?}");
    }

    /// The spool goes half of the way to where it wants to be in each cycle, and wants nothing new within its band.
    #[test]
    fn a_sticking_spool_has_its_band_whatever_its_lag() {
        for band in [0.7, 1.0, 2.0, 4.0] {
            let (mut wanted, mut position) = (0.0, 1.0);
            let found = seen(|k, expected| {
                // Where a spool has to go to, so that it is at `expected` in spite of its lag.
                let asked = 2.0 * expected(k) - expected(k - 1);
                if f64::abs(asked - wanted) >= band {
                    wanted = asked;
                }
                position = 0.5 * (position + wanted);
                position
            });
            let Some(SpoolForm::Sticking(found)) = found else { panic!("{band}: {found:?}") };
            assert!((found - band).abs() < 0.15 * band, "{band}: {found}");
        }
    }

    #[test]
    fn a_spool_that_went_one_way_only_is_not_named_yet() {
        let mut trace = Trace::default();
        for k in 0..300 {
            let expected = 0.1 * f64::from(k);
            trace.push(&Stand {
                position: expected + 0.4,
                expected,
                variance: 2.5e-3,
                doubt: 0.0,
                is_settled: true,
            });
        }
        assert_eq!(trace.form(280, &design(), &ProcessParameters::DEFAULT), None);
    }
}
