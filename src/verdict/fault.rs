//! The kind of a fault, from the residuals around its onset.
//!
//! A step and a ramp on a reading leave known signatures in the innovation of an observer. The
//! newest residuals are compared with both signatures at every onset within the window; the one
//! that explains most of their energy names the fault, and what neither explains is noise.

use crate::observe::observer::Design;
use nalgebra::{Vector2, Vector3};

/// Residuals that a classification looks at: 0.32 s at 50 Hz.
pub const WINDOW: usize = 16;

/// A signature must explain this share of the residuals' energy; white noise stays far below it.
const EXPLAINED: f64 = 0.5;

/// A ramp must explain this much more than a step, since one sample alone fits both.
const RAMP_ADVANTAGE: f64 = 1.02;

/// The kinds of Table 5-1 and of the plausibility checks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fault {
    #[default]
    Unclassified,
    /// Type I: a step.
    Abrupt,
    /// Type II: more noise.
    Noise,
    /// Type III: slowly developing.
    Incipient,
    OutOfRange,
    BrokenWire,
    Frozen,
    Stale,
}

impl Fault {
    /// The name in files and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Unclassified => "unclassified",
            Self::Abrupt => "abrupt",
            Self::Noise => "noise",
            Self::Incipient => "incipient",
            Self::OutOfRange => "out_of_range",
            Self::BrokenWire => "broken_wire",
            Self::Frozen => "frozen",
            Self::Stale => "stale",
        }
    }
}

/// What a unit step, and a ramp of one unit a sample, on a reading leave in a residual.
#[derive(Clone, Debug)]
pub struct Signatures {
    step: [f64; WINDOW],
    ramp: [f64; WINDOW],
}

impl Signatures {
    /// The signatures in the innovation of an observer: e(k+1) = (A − L C) e(k) − L f(k),
    /// ν(k) = C e(k) + f(k), with the fault f on the position only.
    pub fn of_innovation(design: &Design) -> Self {
        let respond = |fault: fn(usize) -> f64| {
            let mut error = Vector3::zeros();
            std::array::from_fn(|k| {
                let innovation = Vector2::new(error[0] + fault(k), error[1]);
                error = design.a * error - design.l * innovation;
                innovation[0]
            })
        };
        Self { step: respond(|_| 1.0), ramp: respond(|k| k as f64 + 1.0) }
    }

    /// The signatures in R3, which shows a fault as it is.
    pub fn of_difference() -> Self {
        Self { step: [1.0; WINDOW], ramp: std::array::from_fn(|k| k as f64 + 1.0) }
    }

    /// Names the fault in `residuals`, m, oldest first.
    pub fn classify(&self, residuals: &[f64; WINDOW]) -> Fault {
        let energy: f64 = residuals.iter().map(|r| r * r).sum();
        let step = explained(&self.step, residuals);
        let ramp = explained(&self.ramp, residuals);
        if step.max(ramp) < EXPLAINED * energy {
            Fault::Noise
        } else if ramp > RAMP_ADVANTAGE * step {
            Fault::Incipient
        } else {
            Fault::Abrupt
        }
    }
}

/// The largest energy that `signature`, begun at any onset in the window and scaled at will,
/// explains of `residuals`.
fn explained(signature: &[f64; WINDOW], residuals: &[f64; WINDOW]) -> f64 {
    (0..WINDOW)
        .map(|onset| {
            let (mut dot, mut norm) = (0.0, 0.0);
            for (s, r) in signature.iter().zip(&residuals[onset..]) {
                dot += s * r;
                norm += s * s;
            }
            dot * dot / norm
        })
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Matrix3x2};

    fn observer() -> Signatures {
        Signatures::of_innovation(&Design {
            a: Matrix3::new(1., 0.02, 0., -0.0101, 0.8769, -1.6891e-5, 0., -10.7104, 0.9977),
            b: Vector3::new(0., 0.0926, 6.5427),
            l: Matrix3x2::new(1.70226778, 1.94488386e-3, 32.0305, 0.0840157, -9612.37466, -20.917),
            settle: 0,
            max_gap: 0,
        })
    }

    #[test]
    fn the_signature_of_a_step_is_what_the_observer_shows() {
        // Computed with NumPy from (A, L, C) of the same numbers.
        let expected = [1.0, -0.702, -0.085, 0.005];
        for (found, expected) in observer().step.into_iter().zip(expected) {
            assert!((found - expected).abs() < 5e-4, "{found} {expected}");
        }
    }

    #[test]
    fn steps_ramps_and_noise_are_told_apart() {
        for (signatures, name) in [(observer(), "R1"), (Signatures::of_difference(), "R3")] {
            for onset in [4, 8, 11] {
                let shifted = |signature: [f64; WINDOW]| {
                    std::array::from_fn(|k| {
                        let small = 1e-4 * if k % 3 == 0 { -1.0 } else { 1.0 };
                        small + if k < onset { 0.0 } else { 2e-3 * signature[k - onset] }
                    })
                };
                let step = signatures.classify(&shifted(signatures.step));
                assert_eq!(step, Fault::Abrupt, "{name} from {onset}");
                let ramp = signatures.classify(&shifted(signatures.ramp));
                assert_eq!(ramp, Fault::Incipient, "{name} from {onset}");
            }
            let noise = [1., -1., 0., 1., 1., -1., 0., 0., -1., 1., 0., -1., -1., 1., 0., 1.];
            assert_eq!(signatures.classify(&noise), Fault::Noise, "{name}");
        }
    }

    #[test]
    fn a_first_sample_alone_is_a_step() {
        let mut residuals = [0.0; WINDOW];
        residuals[WINDOW - 1] = -2e-3;
        assert_eq!(observer().classify(&residuals), Fault::Abrupt);
    }
}
