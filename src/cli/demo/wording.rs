//! Texts for the frames that were received.

use super::listener::{Limit, Status, Warning};
use crate::text::Millimetres;

/// Suspect of a warning, for people.
pub fn suspect(name: &str) -> &'static str {
    match name {
        "c1" => "C1",
        "c2" => "C2",
        "undecided" => "C1 or C2",
        // The process.
        _ => "neither C1 nor C2",
    }
}

/// A warning without its level: `FDE1 C1 of cylinder 3: abrupt, 1.84 mm (limit 1.00 mm)`.
pub fn warning(warning: &Warning) -> String {
    let Warning { cylinder, detector, fault, .. } = warning;
    let detector = detector.replace("fde", "FDE");
    if !warning.raised {
        return format!("{detector} of cylinder {cylinder} is quiet again");
    }
    let whom = suspect(&warning.suspect);
    let mut text = format!("{detector} {whom} of cylinder {cylinder}: {fault}");
    if let Some(residual) = warning.residual {
        text += &format!(", {}", Millimetres(residual.abs()));
        text += &match warning.threshold {
            Some(Limit::Of(limit)) => format!(" (limit {:.2})", Millimetres(limit)),
            Some(Limit::Above(limit)) => format!(" (limit above {:.1})", Millimetres(limit)),
            None => String::new(),
        };
    }
    text
}

/// Transducers of a status: those that are not healthy, or the number of each kind.
pub fn status(status: &Status) -> String {
    let Status { states, level, mode, .. } = status;
    let mut text = format!("gateway {mode}, level {level}: ");
    let all = |state: &str| states.iter().flatten().all(|it| it == state);
    if let Some(state) = ["healthy", "unknown"].into_iter().find(|state| all(state)) {
        return text + "every transducer " + state;
    }
    let mut parts = Vec::new();
    for (index, [c1, c2]) in states.iter().enumerate() {
        let of = |name: &str, state: &String| format!("{name} of cylinder {} {state}", index + 1);
        match (c1.as_str(), c2.as_str()) {
            ("healthy", "healthy") => {}
            (one, other) if one == other => parts.push(of("C1 and C2", c1)),
            (_, "healthy") => parts.push(of("C1", c1)),
            ("healthy", _) => parts.push(of("C2", c2)),
            _ => parts.push(format!("cylinder {}: C1 {c1}, C2 {c2}", index + 1)),
        }
    }
    if let [one] = &parts[..] {
        return text + one;
    }
    let count = |state: &str| states.iter().flatten().filter(|it| *it == state).count();
    let counts = ["faulty", "suspect", "healthy", "unknown"].map(|state| (count(state), state));
    let counts = counts.iter().filter(|(count, _)| *count > 0);
    let counts = counts.map(|(count, state)| format!("{count} {state}")).collect::<Vec<_>>();
    text += &counts.join(", ");
    text
}
