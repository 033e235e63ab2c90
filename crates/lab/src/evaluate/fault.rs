//! Names and sizes of the faults that are tried. Where a fault is optional, `None` is no fault and shows what is found by
//! chance.

use tertius_core::verdict::Fault;
use tertius_machine::inject::{Shape, Wanted};

/// Unit of noise amplitudes (5-17), a standard deviation of four counts, m.
pub const SIGMA: f64 = 4.34e-4;

/// The name of the fault, as in `inject`.
pub const fn fault_name(wanted: Option<Wanted>) -> &'static str {
    match wanted {
        None => "none",
        Some(Wanted::OutOfRange(_)) => "out_of_range",
        Some(Wanted::BrokenWire(_)) => "broken_wire",
        Some(Wanted::Shape(shape)) => shape_name(shape),
        Some(Wanted::Machine(ailment)) => ailment.name(),
    }
}

/// Size of the fault: m, m/s (a drift) or a part of the reading (a scale).
pub const fn fault_size(wanted: Option<Wanted>) -> Option<f64> {
    let Some(Wanted::Shape(shape)) = wanted else { return None };
    match shape {
        Shape::Step { size }
        | Shape::Noise { size }
        | Shape::Incipient { size, .. }
        | Shape::Spike { size, .. } => Some(size),
        Shape::Drift { rate } => Some(rate),
        Shape::Scale { gain } => Some(gain),
        Shape::Freeze | Shape::Constant(_) | Shape::Stale | Shape::Loss { .. } => None,
    }
}

/// b of (5-18), or the probability of a spike or a loss.
pub const fn fault_parameter(wanted: Option<Wanted>) -> Option<f64> {
    let Some(Wanted::Shape(shape)) = wanted else { return None };
    match shape {
        Shape::Incipient { b, .. } => Some(b),
        Shape::Spike { probability, .. } | Shape::Loss { probability } => Some(probability),
        _ => None,
    }
}

/// The name that warnings should give the fault; `None` where Table 5-1 has none.
pub const fn fault_kind(wanted: Option<Wanted>) -> Option<Fault> {
    match wanted {
        None | Some(Wanted::Machine(_)) => None,
        Some(Wanted::OutOfRange(_)) => Some(Fault::OutOfRange),
        Some(Wanted::BrokenWire(_)) => Some(Fault::BrokenWire),
        Some(Wanted::Shape(shape)) => match shape {
            Shape::Step { .. } => Some(Fault::Abrupt),
            Shape::Noise { .. } => Some(Fault::Noise),
            Shape::Incipient { .. } | Shape::Drift { .. } => Some(Fault::Incipient),
            Shape::Freeze => Some(Fault::Frozen),
            Shape::Stale => Some(Fault::Stale),
            Shape::Loss { probability } if probability >= 1.0 => Some(Fault::Stale),
            Shape::Loss { .. } | Shape::Scale { .. } | Shape::Spike { .. } | Shape::Constant(_) => {
                None
            }
        },
    }
}

/// The fault in words.
pub fn fault_label(wanted: Option<Wanted>) -> String {
    match wanted {
        Some(Wanted::Shape(shape)) => shape_label(shape),
        _ => fault_name(wanted).replace('_', " "),
    }
}

/// The name of a fault of that shape, as in `inject`.
const fn shape_name(shape: Shape) -> &'static str {
    match shape {
        Shape::Step { .. } => "step",
        Shape::Noise { .. } => "noise",
        Shape::Incipient { .. } => "incipient",
        Shape::Drift { .. } => "drift",
        Shape::Scale { .. } => "scale",
        Shape::Freeze => "freeze",
        Shape::Spike { .. } => "spike",
        Shape::Constant(_) => "constant",
        Shape::Stale => "stale",
        Shape::Loss { .. } => "loss",
    }
}

/// A fault of that shape in words.
pub fn shape_label(shape: Shape) -> String {
    let name = shape_name(shape);
    match shape {
        Shape::Step { size } => format!("{name} {} mm", tidy(size * 1e3)),
        Shape::Noise { size } => format!("{name} {} σ", tidy(size / SIGMA)),
        Shape::Incipient { size, b } => format!("{name} {} mm, b {b}", tidy(size * 1e3)),
        Shape::Drift { rate } => format!("{name} {} mm/s", tidy(rate * 1e3)),
        Shape::Scale { gain } => format!("{name} {} %", tidy(gain * 1e2)),
        Shape::Spike { size, probability } => {
            format!("{name} {} mm in {} %", tidy(size * 1e3), tidy(probability * 1e2))
        }
        Shape::Loss { probability } => format!("{name} of {} %", tidy(probability * 1e2)),
        Shape::Freeze | Shape::Stale | Shape::Constant(_) => name.to_owned(),
    }
}

/// `value` without the rounding residue of binary fractions.
fn tidy(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}
