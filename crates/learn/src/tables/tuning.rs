//! A tuning as tables that the configuration reads.

use super::provenance;
use crate::calibrate::watch::Level;
use crate::extremes::{HOURS_PER_YEAR, four_digits, times as factor};
use crate::tune::{Detector, LEAST_HIGH, Score, Thresholds, Tuning, Weights};
use std::fmt::Write as _;
use tertius_core::observe::commands::LearntCommands;
use tertius_core::text::Millimetres;

/// Cylinder number and name of the detector's residual.
pub fn name(detector: &Detector) -> [String; 2] {
    [detector.cylinder.to_string(), format!("R{}", detector.transducer + 1)]
}

/// A length in millimetres, or in metres where it is too large for a threshold.
pub fn length(metres: f64) -> String {
    if metres < 3.0 { format!("{:.3}", Millimetres(metres)) } else { format!("{metres:.1} m") }
}

/// Meaning of the numbers, and their reliability.
pub fn meaning(result: &Tuning) -> Vec<String> {
    let Thresholds { per_year, hours, joint, commands, .. } = result.thresholds;
    let (count, often) = (result.detectors.len(), provenance::times(per_year));
    let settle = result.settle;
    let mut lines = vec![
        format!(
            "high: {count} residuals together exceed it at most {often} in a year of monitoring; \
             one number for all, since their rates are added up; at least the thesis's {:.1}",
            Millimetres(LEAST_HIGH)
        ),
        "low: the residual that varies most stays below it in 95 % of the seconds (of alarm.clear), \
         so that a warning ends soon after its fault; at most 0.75 high"
            .to_owned(),
        format!(
            "evidence: {hours:.4} h for each residual; the wanted rate is {} times beyond it. \
             What was not recorded (weather, load, temperature, wear) is not covered; residuals \
             that coincide count twice, as do bursts at the border of two seconds",
            factor(HOURS_PER_YEAR / per_year / hours)
        ),
    ];
    lines.extend(joint.map(|joint| {
        format!(
            "joint: R1 beyond {:.1} is a fault of C1 where R2 shows less than a quarter of it and C1 - C2 has moved by at \
             least three quarters of it, and R2 of C2 likewise; not extrapolated: at least 1.25 times the largest one in \
             the recording, and the thesis's 1.0 mm",
            Millimetres(joint)
        )
    }));
    lines.extend(commands.map(|commands| {
        format!(
            "command, command_change: commands of more than {:.3} m/s, or that change by more than {:.4} m/s from one cycle \
             to the next, are too rare in the recording to teach a threshold. For {settle} s (observer.settle) after such a command, R1 or R2 \
             raises a warning only where the other shows less than half of it: an error of the model is in both",
            commands.size, commands.change
        )
    }));
    lines
}

/// Meaning of the level of the sequential detectors, where `per_year` false alarms were wanted.
pub fn sequential_meaning(level: &Level, per_year: f64) -> Vec<String> {
    let often = provenance::times(per_year);
    vec![format!(
        "level: reached {often} a year, all cylinders together, by a tail of the largest \
         evidence of each ten seconds whose slope is one by theory, and at least 0.75 a nat; at least \
         the largest seen, {:.2} nats, in {:.3} cylinder hours; the wanted rate is {} times beyond \
         them",
        level.worst,
        level.hours,
        factor(HOURS_PER_YEAR / per_year / level.hours)
    )]
}

/// The tables, with their origin.
pub fn of(result: &Tuning, version: &str) -> String {
    let Tuning { machine, inputs, timeline, window, .. } = result;
    let parts = [("tuned on", *window)];
    let mut text = provenance::heading(version, "tune", machine, inputs, timeline, &parts);
    let Weights { q, r } = result.search.weights;
    let Score { threshold, peak, incipient, settled, .. } = result.search.score;
    _ = writeln!(
        text,
        "\n# {} sets of weights tried; threshold by exponential tails {:.4} mm, peak of a unit step \
         {peak:.2}, over after {settled} cycles, of the incipient fault (5-18) {:.2} mm.\n[observer]\nq = {q:?}\nr = {r:?}\n\
         sample_time = {:?}\n",
        result.search.tried,
        threshold * 1e3,
        incipient * 1e3,
        result.sample_time
    );
    for line in meaning(result) {
        _ = writeln!(text, "# {line}");
    }
    for detector in &result.detectors {
        if let Some(step) = detector.step {
            let [number, _] = name(detector);
            let transducer = detector.transducer + 1;
            let step = length(step);
            _ = writeln!(text, "# smallest step of C{transducer} of cylinder {number}: {step}");
        }
    }
    for remark in &result.remarks {
        _ = writeln!(text, "# {}", provenance::one_line(remark));
    }
    let Thresholds { low, high, joint, commands, .. } = result.thresholds;
    let (low, high) = (four_digits(low), four_digits(high));
    // Rounding up may put them past each other where they are the same.
    _ = writeln!(text, "[fde]\nlow = {:?}\nhigh = {high:?}", low.min(high));
    if let Some(joint) = joint {
        _ = writeln!(text, "joint = {:?}", four_digits(joint));
    }
    if let Some(commands) = commands {
        let LearntCommands { size, change } = commands;
        _ = writeln!(text, "command = {size:?}\ncommand_change = {change:?}");
    }
    if let Some(level) = &result.sequential {
        for line in sequential_meaning(level, result.thresholds.per_year) {
            _ = writeln!(text, "\n# {line}");
        }
        _ = writeln!(text, "[sequential]\nlevel = {:?}", four_digits(level.nats));
    }
    text
}
