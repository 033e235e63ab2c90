//! The faults of a recording as a table, which `inject` can also read.

use crate::inject::table::HEADER;
use crate::inject::{Code, Fault, Shape, Wanted};

/// The table, with a line for each fault. A code for which a table has no column is left out; the
/// monitor names such a fault by its kind.
pub fn table(faults: &[Fault]) -> String {
    let mut text = HEADER.join(",");
    text.push('\n');
    for fault in faults {
        text += &row(fault);
        text.push('\n');
    }
    text
}

fn row(fault: &Fault) -> String {
    let (kind, magnitude, parameter) = columns(fault.wanted);
    let number = |number: Option<f64>| number.map_or(String::new(), |number| number.to_string());
    let until = fault.window.until.map(|until| until.as_seconds());
    [
        fault.cylinder.to_string(),
        fault.sensor.to_ascii_uppercase(),
        kind.to_owned(),
        fault.window.from.as_seconds().to_string(),
        number(magnitude),
        number(parameter),
        number(until),
    ]
    .join(",")
}

/// Kind, magnitude and parameter.
fn columns(wanted: Wanted) -> (&'static str, Option<f64>, Option<f64>) {
    let shape = match wanted {
        Wanted::Shape(shape) => shape,
        Wanted::Machine(ailment) => return (ailment.name(), Some(ailment.size()), None),
        Wanted::OutOfRange(_) => return ("out_of_range", None, None),
        Wanted::BrokenWire(_) => return ("broken_wire", None, None),
    };
    match shape {
        Shape::Step { size } => ("step", Some(size), None),
        Shape::Noise { size } => ("noise", Some(size), None),
        Shape::Incipient { size, b } => ("incipient", Some(size), Some(b)),
        Shape::Drift { rate } => ("drift", Some(rate), None),
        Shape::Scale { gain } => ("scale", Some(gain), None),
        Shape::Freeze => ("freeze", None, None),
        Shape::Spike { size, probability } => ("spike", Some(size), Some(probability)),
        // A placed fault's: it is out of range or a broken wire, and a fault asked for is not.
        Shape::Constant(Code::Raw(_) | Code::Physical(_)) => ("out_of_range", None, None),
        Shape::Stale => ("stale", None, None),
        Shape::Loss { probability } => ("loss", Some(probability), None),
    }
}
