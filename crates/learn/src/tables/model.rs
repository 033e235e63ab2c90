//! Identified models as tables that the configuration reads.

use super::nonlinear;
use super::provenance::{date, one_line};
use crate::identify::outcome::{Choice, Identified, Outcome};
use std::fmt::Write as _;

/// Keys of a cylinder that belong to its model.
pub const OF_A_MODEL: [&str; 4] = ["theta", "gamma", "sample_time", "command_offset"];

/// Key of a cylinder for its flow curve and friction.
pub const NONLINEAR: &str = "nonlinear";

/// Keys of a cylinder that an identification makes anew.
pub fn anew(outcome: &Outcome) -> Vec<&'static str> {
    let nonlinear = outcome.nonlinear.as_ref().map(|_| NONLINEAR);
    OF_A_MODEL.into_iter().chain(nonlinear).collect()
}

/// The tables of `outcome`, with their origin; `per_cylinder`: each cylinder gets its own model
/// instead of the one chosen for all. `None` where there is no model.
pub fn of(outcome: &Outcome, version: &str, per_cylinder: bool) -> Option<String> {
    let choice = outcome.choice?;
    let chosen = outcome.identified(choice.of)?;
    let mut text = provenance(outcome, version);
    let taken = if choice.asked { "asked for" } else { "its worst is the best of all" };
    let Choice { of, worst, .. } = choice;
    _ = writeln!(
        text,
        "\n# (4-1), identified on cylinder {of}: {taken}; simulated on every cylinder its position \
         VAF is at least {worst:.2} %.\n[model]\n{}",
        parameters(chosen, outcome.shaping.sample_time)
    );
    for cylinder in &outcome.cylinders {
        let nonlinear = outcome.nonlinear.as_ref();
        let nonlinear = nonlinear.and_then(|it| nonlinear::table(it, cylinder.number));
        let own = cylinder.result.as_ref().ok();
        let offset = own.and_then(|own| own.estimate.command_offset);
        let model = own.filter(|_| per_cylinder);
        if model.is_none() && offset.is_none() && nonlinear.is_none() {
            continue;
        }
        _ = writeln!(text, "\n[[cylinder]]\nn = {}", cylinder.number);
        if let Some(own) = model {
            _ = writeln!(text, "{}", parameters(own, outcome.shaping.sample_time));
        }
        if let Some(offset) = offset {
            _ = writeln!(text, "command_offset = {offset:?}  # m/s; the command at which it rests");
        }
        text += nonlinear.as_deref().unwrap_or("");
    }
    Some(text)
}

/// Origin of the model, as comments.
fn provenance(outcome: &Outcome, version: &str) -> String {
    let at = |seconds: f64| date(outcome.timeline.at(seconds));
    let window = |name: &str, window: &crate::survey::Window| {
        let (from, to) = (window.from, window.to);
        format!("# {name} {from:.2} s to {to:.2} s, {} to {}\n", at(from), at(to))
    };
    let mut text = format!(
        "# By tertius {version} identify, for {}.\n# From {}\n",
        one_line(&outcome.machine),
        one_line(&outcome.inputs)
    );
    text += &window("fitted   ", &outcome.fitted);
    text += &window("validated", &outcome.validated);
    let shaping = &outcome.shaping;
    _ = writeln!(
        text,
        "# moving average over {} cycles of {} s; area ratio {} of (3-5)",
        shaping.window, shaping.sample_time, shaping.area_ratio
    );
    for cylinder in &outcome.cylinders {
        if let Err(refusal) = &cylinder.result {
            let refusal = one_line(&refusal.to_string());
            _ = writeln!(text, "# cylinder {} was refused: {refusal}", cylinder.number);
        }
    }
    text += "# Keys of [[cylinder]] belong in that cylinder's table, if the file has one.\n";
    text
}

fn parameters(identified: &Identified, sample_time: f64) -> String {
    let estimate = &identified.estimate;
    let (theta, gamma) = (estimate.theta, estimate.gamma);
    format!("theta = {theta:?}\ngamma = {gamma:?}\nsample_time = {sample_time:?}")
}
