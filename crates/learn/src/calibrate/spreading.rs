//! Dependence of healthy residuals on the velocity: σ² + (s v)², on samples of which a few may be
//! wild.

use super::division::{Division, Halves};
use super::fitting::Fitted;
use super::residuals::Residuals;
use super::resolution::Resolution;
use super::roughness::quantile;
use crate::survey::{Row, Surveyor};
use tertius_core::sequential::{Magnitudes, Noise};

/// Width of the bins of |v|, m/s; the last bin has everything beyond.
const SPEED: f64 = 0.05;
/// Number of bins of |v|.
const SPEEDS: usize = 40;

/// Fewest samples of a bin that is fitted.
const LEAST_SAMPLES: f64 = 100.0;

/// Initial width of the bins of magnitudes, m.
const BIN: f64 = 1e-6;

/// Distance beyond which a sample is wild in the first step, in deviations by the median.
const WILD: f64 = 6.0;
/// Distance beyond which a sample is wild in the first step, in counts.
const WILD_COUNTS: f64 = 3.0;

/// Distance beyond which a sample is wild in the second step, in deviations at its speed.
const FAR: f64 = 4.0;

const ROUNDS: usize = 4;

/// Standard deviation of a normal distribution over its median magnitude.
const BY_MEDIAN: f64 = 1.4826;

/// Scatter of a cylinder's residuals, and the resolution of its readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResidualSpread {
    pub noise: Noise,
    /// Resolutions of C1 and of C2, m; 0 where not known.
    pub resolution: [f64; 2],
}

/// Observes the scatter of the residuals of every cylinder that has a profile.
#[derive(Clone, Debug)]
pub struct Spreading {
    cylinders: Vec<Option<Spreads>>,
}

#[derive(Clone, Debug)]
struct Spreads {
    residuals: Residuals,
    resolutions: [Resolution; 2],
    /// Sum of v² and the residuals' magnitudes, by bins of |v|.
    speeds: Vec<(f64, Magnitudes)>,
}

impl Spreading {
    /// A pass over cylinders with these lines, against the references from the halves of
    /// `division`, sampled every `sample_time` seconds.
    pub fn new<'a>(
        sample_time: f64,
        division: &Division,
        cylinders: impl IntoIterator<Item = Option<(&'a Fitted, &'a Halves)>>,
    ) -> Self {
        let spreads = |(fitted, halves): (&Fitted, &Halves)| Spreads {
            residuals: Residuals::new(sample_time, fitted, division.clone(), halves.clone()),
            resolutions: Default::default(),
            speeds: vec![(0.0, Magnitudes::new(BIN)); SPEEDS],
        };
        Self { cylinders: cylinders.into_iter().map(|both| both.map(spreads)).collect() }
    }

    /// The spread of the cylinder of `index` (from 0); `None` without data.
    pub fn result(&self, index: usize) -> Option<ResidualSpread> {
        self.cylinders[index].as_ref()?.result()
    }
}

impl Surveyor for Spreading {
    fn row(&mut self, row: &Row) {
        if let Some(spreads) = self.cylinders[usize::from(row.cylinder) - 1].as_mut() {
            spreads.take(row);
        }
    }

    fn gap(&mut self, cylinder: u8) {
        if let Some(spreads) = self.cylinders[usize::from(cylinder) - 1].as_mut() {
            spreads.interrupt();
        }
    }
}

impl Spreads {
    fn interrupt(&mut self) {
        self.residuals.interrupt();
        self.resolutions.iter_mut().for_each(Resolution::interrupt);
    }

    fn take(&mut self, row: &Row) {
        if !row.monitored {
            self.residuals.leave();
            return self.interrupt();
        }
        let Some(residual) = self.residuals.take(row) else { return };
        for (resolution, length) in self.resolutions.iter_mut().zip(residual.lengths) {
            resolution.add(length);
        }
        if let Some(beyond) = residual.in_motion() {
            let speed = residual.velocity.abs();
            let bin = ((speed / SPEED) as usize).min(SPEEDS - 1);
            let (squares, magnitudes) = &mut self.speeds[bin];
            *squares += speed * speed;
            magnitudes.add(beyond);
        }
    }

    fn result(&self) -> Option<ResidualSpread> {
        let resolution = [0, 1].map(|which: usize| self.resolutions[which].count());
        let counts = WILD_COUNTS * 0.5 * (resolution[0] + resolution[1]);
        let first =
            |magnitudes: &Magnitudes| (WILD * BY_MEDIAN * quantile(magnitudes, 0.5)).max(counts);
        let mut noise = self.fit(|_, magnitudes| first(magnitudes))?;
        for _ in 1..ROUNDS {
            noise = self.fit(|square, _| FAR * noise.variance(square.sqrt()).sqrt())?;
        }
        let rest = noise.rest.max(Noise::of_rounding(resolution));
        (rest > 0.0).then_some(ResidualSpread { noise: Noise { rest, ..noise }, resolution })
    }

    /// The line of the mean squares over v², for magnitudes within a limit, m, that depends on v²
    /// and the magnitudes of a bin; `None` without data.
    fn fit(&self, limit: impl Fn(f64, &Magnitudes) -> f64) -> Option<Noise> {
        let mut points = Vec::with_capacity(SPEEDS);
        for (squares, magnitudes) in &self.speeds {
            let square = squares / magnitudes.total().max(1) as f64;
            let limit = limit(square, magnitudes);
            let near = magnitudes.bins().filter(|(magnitude, _)| *magnitude <= limit);
            let (count, sum) = near.fold((0.0, 0.0), |(count, sum), (magnitude, samples)| {
                let samples = samples as f64;
                (count + samples, sum + samples * magnitude * magnitude)
            });
            if count > 0.0 {
                points.push((square, sum / count, count));
            }
        }
        let many: Vec<_> =
            points.iter().copied().filter(|(.., count)| *count >= LEAST_SAMPLES).collect();
        line(if many.is_empty() { &points } else { &many })
    }
}

/// Fit of σ² + s² v² to points of v², mean square and number of samples, each weighted by its
/// accuracy.
fn line(points: &[(f64, f64, f64)]) -> Option<Noise> {
    let total: f64 = points.iter().map(|(.., count)| count).sum();
    let mean = points.iter().map(|(_, square, count)| square * count).sum::<f64>() / total;
    if points.is_empty() || mean <= 0.0 {
        return None;
    }
    let mut variance = [mean, 0.0];
    for _ in 0..ROUNDS {
        let (mut w, mut wx, mut wy, mut wxx, mut wxy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (x, y, count) in points {
            let expected = variance[0] + variance[1] * x;
            let weight = count / (expected * expected);
            (w, wx, wy) = (w + weight, wx + weight * x, wy + weight * y);
            (wxx, wxy) = (wxx + weight * x * x, wxy + weight * x * y);
        }
        let spread = w * wxx - wx * wx;
        let slope = if spread > 1e-9 * w * wxx { (w * wxy - wx * wy) / spread } else { 0.0 };
        let slope = slope.max(0.0);
        let level = (wy - slope * wx) / w;
        // At rest it cannot be less than nothing, whatever the fast ones say.
        variance = if level > 0.0 { [level, slope] } else { [1e-3 * mean, wxy / wxx] };
    }
    Some(Noise { rest: variance[0].sqrt(), timing: variance[1].sqrt() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn a_line_has_both_parts() {
        let points: Vec<_> = (0..20)
            .map(|i| (0.05 * f64::from(i)).powi(2))
            .map(|x| (x, 4e-8 + 9e-8 * x, 1000.0))
            .collect();
        let noise = line(&points).expect("there are points");
        assert!((noise.rest - 2e-4).abs() < 1e-9 && (noise.timing - 3e-4).abs() < 1e-9);
        let flat = line(&points[..1]).expect("there is one");
        assert_eq!((flat.rest, flat.timing), (2e-4, 0.0));
        assert_eq!(line(&[]), None);
    }

    #[test]
    fn wild_samples_are_no_scatter() {
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        let mut speeds = vec![(0.0, Magnitudes::new(BIN)); SPEEDS];
        for k in 0..100_000_u32 {
            let speed = 0.5 * (f64::from(k) * 0.01).sin().abs();
            let [rest, timing]: [f64; 2] = [(); 2].map(|()| StandardNormal.sample(&mut rng));
            let wild = if k.is_multiple_of(33) { 6e-4 } else { 0.0 };
            let (squares, magnitudes) = &mut speeds[(speed / SPEED) as usize];
            *squares += speed * speed;
            magnitudes.add(8e-5 * rest + 2e-4 * speed * timing + wild);
        }
        let spreads = Spreads { speeds, ..nothing() };
        let spread = spreads.result().expect("there are samples");
        assert!((spread.noise.rest / 8e-5 - 1.0).abs() < 0.05, "{spread:?}");
        assert!((spread.noise.timing / 2e-4 - 1.0).abs() < 0.15, "{spread:?}");
    }

    fn nothing() -> Spreads {
        let line = crate::calibrate::Line { gain: 1.0, offset: 0.0 };
        let fitted = Fitted {
            line,
            errors: [0.0; 2],
            rms: 1e-4,
            rows: 0,
            trimmed: 0,
            limit: 1e-3,
            roughness: 1e-4,
        };
        let all = crate::survey::Window::ALL;
        let division = Division::new(all, all, crate::survey::Ranking::default());
        Spreads {
            residuals: Residuals::new(0.02, &fitted, division, [None, None]),
            resolutions: Default::default(),
            speeds: Vec::new(),
        }
    }
}
