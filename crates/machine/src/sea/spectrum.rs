//! The JONSWAP spectrum, as components of equal energy.

use super::SeaError;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Number of components of a sea.
pub const COMPONENTS: usize = 40;

/// Band of frequencies, as parts of the peak's. A hundredth of the energy lies beyond.
const BAND: [f64; 2] = [0.5, 4.0];

/// Number of steps of the integral over the band.
const STEPS: usize = 4000;

/// A sea state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spectrum {
    /// Significant wave height Hs, m.
    height: f64,
    /// Peak period Tp, s.
    period: f64,
    /// Peakedness γ; the JONSWAP mean is 3.3.
    peakedness: f64,
}

/// A regular wave, ζ(t) = amplitude · cos(frequency · t + phase).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Component {
    /// Frequency, rad/s.
    pub frequency: f64,
    /// Amplitude, m.
    pub amplitude: f64,
    /// Phase, rad.
    pub phase: f64,
}

impl Spectrum {
    /// A sea of significant wave height `height`, m (0: calm), and peak period `period`, s.
    ///
    /// # Errors
    /// A value that no sea can have.
    pub fn new(height: f64, period: f64, peakedness: f64) -> Result<Self, SeaError> {
        if !(0.0..=20.0).contains(&height) {
            return Err(SeaError::Height(height));
        }
        if !(2.0..=30.0).contains(&period) {
            return Err(SeaError::Period(period));
        }
        Ok(Self { height, period, peakedness })
    }

    pub fn height(&self) -> f64 {
        self.height
    }

    pub fn period(&self) -> f64 {
        self.period
    }

    /// S(ω) up to a factor: ω⁻⁵ exp(−1.25 (ωp/ω)⁴) γ^exp(−(ω − ωp)² / 2σ²ωp²), with σ = 0.07 below
    /// the peak and 0.09 above.
    pub fn shape(&self, frequency: f64) -> f64 {
        let relative = frequency * self.period / TAU;
        let width = if relative <= 1.0 { 0.07 } else { 0.09 };
        let bump = (-(relative - 1.0).powi(2) / (2.0 * width * width)).exp();
        relative.powi(-5) * (-1.25 * relative.powi(-4)).exp() * self.peakedness.powf(bump)
    }

    /// [`COMPONENTS`] waves of equal energy; the energy of all together is m₀ = Hs²/16. The
    /// frequency of each is drawn from its share of the spectrum, so that the sea does not repeat
    /// itself.
    pub fn components(&self, rng: &mut ChaCha8Rng) -> [Component; COMPONENTS] {
        let peak = TAU / self.period;
        let step = (BAND[1] - BAND[0]) * peak / STEPS as f64;
        let at = |index: usize| BAND[0] * peak + index as f64 * step;
        let mut energy = Vec::with_capacity(STEPS + 1);
        let mut sum = 0.0;
        energy.push(0.0);
        for index in 0..STEPS {
            sum += 0.5 * (self.shape(at(index)) + self.shape(at(index + 1)));
            energy.push(sum);
        }
        let amplitude = self.height / 4.0 * (2.0 / COMPONENTS as f64).sqrt();
        std::array::from_fn(|number| {
            let share = (number as f64 + rng.random::<f64>()) / COMPONENTS as f64 * sum;
            // The step in which the energy up to a frequency passes the share.
            let after = energy.partition_point(|energy| *energy <= share).clamp(1, STEPS);
            let (low, high) = (energy[after - 1], energy[after]);
            let part = if high > low { (share - low) / (high - low) } else { 0.5 };
            Component {
                frequency: at(after - 1) + part * step,
                amplitude,
                phase: rng.random::<f64>() * TAU,
            }
        })
    }
}
