//! The vessel's motion in time.

use super::spectrum::{COMPONENTS, Component, Spectrum};
use super::vessel::Vessel;
use crate::hexapod::{Pose, PoseRate};
use num_complex::Complex;
use rand_chacha::ChaCha8Rng;

/// Number of sums: position, rate and acceleration of each degree of freedom.
const SUMS: usize = 18;

/// Number of samples after which the waves are computed anew from the time, before rounding errors
/// add up.
const REFRESH: u64 = 1024;

/// Motion of the vessel at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    pub pose: Pose,
    pub rate: PoseRate,
    /// Acceleration, m/s² and rad/s².
    pub acceleration: PoseRate,
}

/// Waves, and the vessel among them.
#[derive(Clone, Debug)]
pub struct Sea {
    components: [Component; COMPONENTS],
    /// e^i(ωt + φ) of each component at the present time.
    waves: [Complex<f64>; COMPONENTS],
    /// Factor e^iω·Ts by which each component turns in one sample.
    turns: [Complex<f64>; COMPONENTS],
    /// Contribution of the real and the imaginary part of each wave to each sum.
    shares: [[[f64; SUMS]; 2]; COMPONENTS],
    sample_time: f64,
    sample: u64,
}

impl Sea {
    /// A sea of `spectrum` under `vessel`, sampled every `sample_time` seconds from time 0.
    pub fn new(
        spectrum: &Spectrum,
        vessel: &Vessel,
        sample_time: f64,
        rng: &mut ChaCha8Rng,
    ) -> Self {
        let components = spectrum.components(rng);
        let mut sea = Self {
            components,
            waves: [Complex::default(); COMPONENTS],
            turns: components.map(|one| Complex::from_polar(1.0, one.frequency * sample_time)),
            shares: components.map(|component| shares(&component, vessel)),
            sample_time,
            sample: 0,
        };
        sea.refresh();
        sea
    }

    /// Advances by one sample.
    pub fn advance(&mut self) {
        self.sample += 1;
        if self.sample.is_multiple_of(REFRESH) {
            return self.refresh();
        }
        for (wave, turn) in self.waves.iter_mut().zip(&self.turns) {
            *wave *= turn;
        }
    }

    fn refresh(&mut self) {
        let time = self.sample as f64 * self.sample_time;
        for (wave, component) in self.waves.iter_mut().zip(&self.components) {
            *wave = Complex::from_polar(1.0, component.frequency * time + component.phase);
        }
    }

    /// Elevation of the sea at the vessel, m.
    pub fn elevation(&self) -> f64 {
        let heights = self.components.iter().zip(&self.waves);
        heights.map(|(component, wave)| component.amplitude * wave.re).sum()
    }

    /// Motion of the vessel at the present time.
    pub fn motion(&self) -> Motion {
        let mut sums = [0.0; SUMS];
        for (wave, [real, imaginary]) in self.waves.iter().zip(&self.shares) {
            for ((sum, real), imaginary) in sums.iter_mut().zip(real).zip(imaginary) {
                *sum += wave.re * real + wave.im * imaginary;
            }
        }
        let three =
            |from: usize| nalgebra::Vector3::new(sums[from], sums[from + 1], sums[from + 2]);
        Motion {
            pose: Pose { translation: three(0), attitude: three(3) },
            rate: PoseRate { translation: three(6), attitude: three(9) },
            acceleration: PoseRate { translation: three(12), attitude: three(15) },
        }
    }

    /// The standard deviation over all time of `measure`, a linear function of the vessel's motion:
    /// the root of half the sum of the squared amplitudes.
    pub fn deviation(&self, measure: impl Fn(&Pose) -> f64) -> f64 {
        let pose = |shares: &[f64; SUMS]| {
            let [a, b, c, d, e, f, ..] = *shares;
            Pose::new([a, b, c], [d, e, f])
        };
        let square = |[real, imaginary]: &[[f64; SUMS]; 2]| {
            measure(&pose(real)).powi(2) + measure(&pose(imaginary)).powi(2)
        };
        (self.shares.iter().map(square).sum::<f64>() / 2.0).sqrt()
    }
}

/// Contributions by Re(H e^iωt) = H.re cos − H.im sin; a derivative multiplies H by iω.
fn shares(component: &Component, vessel: &Vessel) -> [[f64; SUMS]; 2] {
    let mut shares = [[0.0; SUMS]; 2];
    let derivative = Complex::new(0.0, component.frequency);
    for (dof, answer) in vessel.answers(component.frequency).into_iter().enumerate() {
        let mut answer = answer * component.amplitude;
        for order in 0..3 {
            shares[0][order * 6 + dof] = answer.re;
            shares[1][order * 6 + dof] = -answer.im;
            answer *= derivative;
        }
    }
    shares
}
