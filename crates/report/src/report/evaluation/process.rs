//! Tables of the faults of the cylinders themselves.

use super::{percent, rate};
use crate::report::sheet::{Section, Sheet};
use tertius_lab::evaluate::process::{ProcessFigures, ProcessResult};

/// What was found of each fault, and the false alarms.
pub fn sections(result: &ProcessResult) -> [Section; 2] {
    let header = [
        "machine",
        "fault",
        "found",
        "after (median, 95 %)",
        "called right",
        "size",
        "transducer named, at last",
    ];
    let mut sheet = Sheet::new(&header.map(str::to_owned));
    for figures in &result.faults {
        let ProcessFigures { grade, lag, label, found, delay, kind, size, blamed } = figures;
        let none = || "–".to_owned();
        sheet.add_row(vec![
            machine(grade, *lag),
            (*label).to_owned(),
            percent(found),
            delay.map_or_else(none, |[median, late]| format!("{median:.2} s, {late:.2} s")),
            kind.as_ref().map_or_else(none, percent),
            size.map_or_else(none, |[of, off]| format!("{:.0} % ± {:.0} %", 1e2 * of, 1e2 * off)),
            blamed.each_ref().map(percent).join(", "),
        ]);
    }
    let faults = sheet.about(
        "faults of the cylinders themselves, and of C1 inside the loop, which the process detector should not name; \
         size: median of what is told over the truth, and within how much 95 % are",
    );
    let header = ["machine", "hours", "false alarms", "a year at most"];
    let mut sheet = Sheet::new(&header.map(str::to_owned));
    for healthy in &result.healthy {
        sheet.add_row(vec![
            machine(healthy.grade, healthy.lag),
            format!("{:.1}", healthy.hours),
            healthy.false_alarms.events.to_string(),
            rate(healthy.false_alarms.at_most),
        ]);
    }
    let healthy = sheet.about(
        "process detectors on healthy machines of other loads (70 to 130 %) and more friction (to 110 %) than taught",
    );
    [faults, healthy]
}

/// A machine in words; `lag` is its spools' time constant, s.
pub(super) fn machine(grade: &str, lag: f64) -> String {
    format!("{grade}, spool {:.0} ms", 1e3 * lag)
}
