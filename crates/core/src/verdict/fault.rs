//! The kind of a fault, from the residuals around its onset.
//!
//! A step and a ramp on a reading leave known signatures in the innovation of an observer. The
//! newest residuals are compared with both signatures at every onset within the window; the one
//! that explains most of their energy names the fault, and what neither explains is noise.

use super::parameters::{LONGEST_DIFFERENCES, LONGEST_WINDOW, VerdictCycles, VerdictParameters};
use crate::observe::observer::ObserverDesign;
use crate::state::choice;
use nalgebra::{Vector2, Vector3};

/// Kinds of faults of Table 5-1, of the plausibility checks and of the process detectors.
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
    /// The valve's spool sticks.
    ValveSticking,
    /// Oil passes the piston or the valve's edges.
    Leakage,
    /// The valve's spool stands beside its command, or its null has moved.
    ValveOffset,
    /// The supply, or the sensor of its pressure.
    Supply,
    /// A sensor of a chamber's pressure.
    PressureSensor,
    /// The command comes late, or the valve follows another one.
    Command,
    /// The rod goes harder.
    Friction,
    /// None: C1 and C2 have differed since the start, and no calibration says by how much they should.
    NotCalibrated,
    /// The valve's ports open later, or earlier.
    ValveDeadBand,
}

choice! {
    Fault {
        Unclassified, Abrupt, Noise, Incipient, OutOfRange, BrokenWire, Frozen, Stale,
        ValveSticking, Leakage, ValveOffset, Supply, PressureSensor, Command,
        Friction, NotCalibrated, ValveDeadBand,
    }
}

impl Fault {
    /// All kinds, in the order of their numbers.
    pub const ALL: [Self; 17] = [
        Self::Unclassified,
        Self::Abrupt,
        Self::Noise,
        Self::Incipient,
        Self::OutOfRange,
        Self::BrokenWire,
        Self::Frozen,
        Self::Stale,
        Self::ValveSticking,
        Self::Leakage,
        Self::ValveOffset,
        Self::Supply,
        Self::PressureSensor,
        Self::Command,
        Self::Friction,
        Self::NotCalibrated,
        Self::ValveDeadBand,
    ];

    /// Name in files and reports.
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
            Self::ValveSticking => "valve_sticking",
            Self::Leakage => "leakage",
            Self::ValveOffset => "valve_offset",
            Self::Supply => "supply",
            Self::PressureSensor => "pressure_sensor",
            Self::Command => "command",
            Self::Friction => "friction",
            Self::ValveDeadBand => "valve_dead_band",
            Self::NotCalibrated => "not_calibrated",
        }
    }
}

/// Responses of a residual to a unit step, and to a ramp of one unit a sample, on a reading.
#[derive(Clone, Debug)]
pub struct Signatures {
    step: [f64; LONGEST_WINDOW],
    ramp: [f64; LONGEST_WINDOW],
}

impl Signatures {
    /// The signatures in the innovation of an observer: e(k+1) = (A − L C) e(k) − L f(k), ν(k) = C
    /// e(k) + f(k), with the fault f on the position only.
    pub fn of_innovation(design: &ObserverDesign) -> Self {
        let respond = |fault: fn(usize) -> f64| {
            let mut error = Vector3::zeros();
            core::array::from_fn(|k| {
                let innovation = Vector2::new(error[0] + fault(k), error[1]);
                error = design.a * error - design.l * innovation;
                innovation[0]
            })
        };
        Self { step: respond(|_| 1.0), ramp: respond(|k| k as f64 + 1.0) }
    }

    /// Names the fault in `residuals`, m, oldest first, of which the newest [`VerdictCycles::window`] count.
    pub fn classify(
        &self,
        residuals: &[f64; LONGEST_WINDOW],
        parameters: &VerdictParameters,
        cycles: &VerdictCycles,
    ) -> Fault {
        let residuals = &residuals[LONGEST_WINDOW - cycles.window..];
        let energy = residuals.iter().map(|r| r * r).sum();
        let [step, ramp] = [&self.step, &self.ramp].map(|form| explained(form, residuals));
        name(step, ramp, energy, parameters)
    }
}

/// Names the fault in R3, m, oldest first, of which the newest `known` were compared. R3 shows a fault as it is, beside
/// an offset that the calibration has left, so step and ramp are fitted with a free constant. A fault most of which
/// already existed a second ago has grown to its bound too slowly for either. What was before the first known one is
/// taken to have been the same: a first sample is no step, and of what it has shown the kind is not known.
pub fn classify_difference(
    differences: &[f64; LONGEST_DIFFERENCES],
    known: usize,
    parameters: &VerdictParameters,
    cycles: &VerdictCycles,
) -> Fault {
    let mut differences = *differences;
    let differences = &mut differences[LONGEST_DIFFERENCES - cycles.differences..];
    let count = differences.len();
    let unknown = count.saturating_sub(known.max(1));
    let first = differences[unknown];
    differences[..unknown].fill(first);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let before = mean(&differences[..count - cycles.window]);
    let now = differences[count - 1];
    if (now - before).abs() < (1.0 - parameters.crept) * now.abs() {
        return if unknown == 0 { Fault::Incipient } else { Fault::Unclassified };
    }
    let offset = mean(differences);
    let energy = differences.iter().map(|r| (r - offset) * (r - offset)).sum();
    let (mut step, mut ramp) = (0.0_f64, 0.0_f64);
    for onset in 1..count {
        let share = |signature: fn(f64) -> f64| {
            let mut values = [0.0; LONGEST_DIFFERENCES];
            let values = &mut values[..count];
            for (age, value) in values[onset..].iter_mut().enumerate() {
                *value = signature(age as f64);
            }
            let offset_of_values = mean(values);
            let (mut dot, mut norm) = (0.0, 0.0);
            for (s, r) in values.iter().zip(&*differences) {
                dot += (s - offset_of_values) * (r - offset);
                norm += (s - offset_of_values) * (s - offset_of_values);
            }
            dot * dot / norm
        };
        step = step.max(share(|_| 1.0));
        ramp = ramp.max(share(|age| age + 1.0));
    }
    name(step, ramp, energy, parameters)
}

/// The kind of fault, from the parts of `energy` that the best step and the best ramp explain.
fn name(step: f64, ramp: f64, energy: f64, parameters: &VerdictParameters) -> Fault {
    if step.max(ramp) < parameters.explained * energy {
        Fault::Noise
    } else if ramp > parameters.ramp_advantage * step {
        Fault::Incipient
    } else {
        Fault::Abrupt
    }
}

/// The largest energy of `residuals` that `signature` explains, with any onset in the window and
/// any scale.
fn explained(signature: &[f64; LONGEST_WINDOW], residuals: &[f64]) -> f64 {
    (0..residuals.len())
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
        Signatures::of_innovation(&ObserverDesign {
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

    /// At 50 Hz.
    const WINDOW: usize = 16;
    const NEWEST: usize = LONGEST_WINDOW - WINDOW;

    /// What `values` are of the newest samples at 50 Hz, behind what does not count.
    fn classify(values: impl Fn(usize) -> f64) -> Fault {
        let ring = std::array::from_fn(|k| k.checked_sub(NEWEST).map_or(7e-3, &values));
        let parameters = VerdictParameters::DEFAULT;
        observer().classify(&ring, &parameters, &parameters.cycles(0.02))
    }

    const NOISE: [f64; WINDOW] =
        [1., -1., 0., 1., 1., -1., 0., 0., -1., 1., 0., -1., -1., 1., 0., 1.];

    /// A small pseudo-random number for a sample's number.
    fn small(k: usize) -> f64 {
        1e-4 * NOISE[(7 * k) % WINDOW]
    }

    #[test]
    fn steps_ramps_and_noise_are_told_apart() {
        let signatures = observer();
        for onset in [4, 8, 11] {
            let shifted = |signature: [f64; LONGEST_WINDOW]| {
                move |k| small(k) + if k < onset { 0.0 } else { 2e-3 * signature[k - onset] }
            };
            assert_eq!(classify(shifted(signatures.step)), Fault::Abrupt, "from {onset}");
            assert_eq!(classify(shifted(signatures.ramp)), Fault::Incipient, "from {onset}");
        }
        assert_eq!(classify(|k| NOISE[k]), Fault::Noise);
    }

    #[test]
    fn steps_ramps_and_noise_are_told_apart_in_the_difference() {
        let with = |offset: f64, fault: &dyn Fn(usize) -> f64| {
            let value = |k: usize| offset + small(k) + fault(k);
            let ring = std::array::from_fn(|k| k.checked_sub(64).map_or(7e-3, value));
            classify_difference(
                &ring,
                64,
                &VerdictParameters::DEFAULT,
                &VerdictParameters::DEFAULT.cycles(0.02),
            )
        };
        for offset in [-5e-4, 0.0, 5e-4] {
            for onset in [40, 56, 63] {
                let step = with(offset, &|k| if k < onset { 0.0 } else { 2e-3 });
                assert_eq!(step, Fault::Abrupt, "{offset} from {onset}");
            }
            // 1, 3 and 10 mm/s, when they reach 1.5 mm.
            for rate in [2e-5, 6e-5, 2e-4] {
                let age = (1.5e-3 - offset) / rate;
                let ramp = with(offset, &|k| rate * (age - (63 - k) as f64).max(0.0));
                assert_eq!(ramp, Fault::Incipient, "{offset}, {rate} m a sample");
            }
            let creep = with(offset, &|k| 1.5e-3 - offset + 2e-6 * k as f64);
            assert_eq!(creep, Fault::Incipient);
            let noise = with(offset, &|k| if k < 40 { 0.0 } else { 1.3e-3 * NOISE[k % WINDOW] });
            assert_eq!(noise, Fault::Noise);
        }
    }

    /// Nothing is known of what was before.
    #[test]
    fn a_first_difference_is_no_step() {
        let parameters = VerdictParameters::DEFAULT;
        let of = |known: usize, value: &dyn Fn(usize) -> f64| {
            let unknown = LONGEST_DIFFERENCES - known;
            let ring = std::array::from_fn(|k| k.checked_sub(unknown).map_or(0.0, value));
            classify_difference(&ring, known, &parameters, &parameters.cycles(0.02))
        };
        for known in [1, 2, 5, 16, 40, 63] {
            assert_eq!(of(known, &|k| 5e-3 + small(k)), Fault::Unclassified, "{known}");
        }
        assert_eq!(of(64, &|k| 5e-3 + small(k)), Fault::Incipient);
        let step = |k: usize| small(k) + if k < 20 { 1e-4 } else { 3e-3 };
        assert_eq!(of(30, &step), Fault::Abrupt, "what came later is seen to come");
    }

    #[test]
    fn a_first_sample_alone_is_a_step() {
        let first = classify(|k| if k == WINDOW - 1 { -2e-3 } else { 0.0 });
        assert_eq!(first, Fault::Abrupt);
    }
}
