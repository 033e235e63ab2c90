//! Response of a vessel to a wave.

use super::GRAVITY;
use num_complex::Complex;
use serde::Deserialize;

/// Response of one degree of freedom: gain / (1 − r² + 2iζr) · e^(i phase), where r is the wave's
/// frequency over the natural one. A translation is in m per m of wave amplitude, a rotation in rad
/// per rad of wave slope, ω²/g in deep water.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Response {
    pub gain: f64,
    /// Natural period of the free motion, s.
    pub natural_period: f64,
    /// Damping ζ, part of the critical damping.
    pub damping: f64,
    /// Phase by which the motion leads the wave, rad; it shifts the degrees of freedom against each
    /// other.
    #[serde(default)]
    pub phase: f64,
}

impl Response {
    /// The complex response to a wave of `frequency`, rad/s, per amplitude or slope.
    pub fn at(&self, frequency: f64) -> Complex<f64> {
        let relative = frequency * self.natural_period / std::f64::consts::TAU;
        let below = Complex::new(1.0 - relative * relative, 2.0 * self.damping * relative);
        Complex::from_polar(self.gain, self.phase) / below
    }
}

/// The six responses of a vessel, at the hexapod's base.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Vessel {
    pub surge: Response,
    pub sway: Response,
    pub heave: Response,
    pub roll: Response,
    pub pitch: Response,
    pub yaw: Response,
}

impl Vessel {
    /// The responses per wave amplitude: m/m and rad/m, in the order surge, sway, heave, roll,
    /// pitch, yaw.
    pub fn answers(&self, frequency: f64) -> [Complex<f64>; 6] {
        let slope = frequency * frequency / GRAVITY;
        let translations = [&self.surge, &self.sway, &self.heave].map(|one| one.at(frequency));
        let rotations = [&self.roll, &self.pitch, &self.yaw].map(|one| one.at(frequency) * slope);
        let [surge, sway, heave] = translations;
        let [roll, pitch, yaw] = rotations;
        [surge, sway, heave, roll, pitch, yaw]
    }
}
