//! Tables of the drifts in the loop.

use super::process::machine;
use super::{millimetres, percent, rate};
use crate::report::sheet::{Section, Sheet};
use tertius_lab::evaluate::side::{SideFigures, SideResult};

/// Whom the drifts were laid to, and when, and the false alarms.
pub fn sections(result: &SideResult) -> [Section; 2] {
    let header = [
        "machine",
        "drift",
        "found at (median, 95 %)",
        "named in time",
        "named at (median, 95 %)",
        "the other one named, by any detector",
        "taken for the process",
    ];
    let mut sheet = Sheet::new(&header.map(str::to_owned));
    for figures in &result.drifts {
        let SideFigures { grade, lag, transducer, rate, named, at, found_at, wrong, process } =
            figures;
        sheet.add_row(vec![
            machine(grade, *lag),
            format!("{}, {:.1} mm/s", transducer.to_uppercase(), 1e3 * rate),
            millimetres(found_at),
            percent(named),
            millimetres(at),
            wrong.each_ref().map(percent).join(", "),
            percent(process),
        ]);
    }
    let drifts = sheet.about(
        "drifts of C1 and of C2 inside the loop, five minutes after the machine began to work: of which the right one \
         was named before it was 20 mm off, and how far it was off then",
    );
    let header = ["machine", "hours", "false alarms", "a transducer named", "a year at most"];
    let mut sheet = Sheet::new(&header.map(str::to_owned));
    for healthy in &result.healthy {
        sheet.add_row(vec![
            machine(healthy.grade, healthy.lag),
            format!("{:.1}", healthy.hours),
            healthy.false_alarms.events.to_string(),
            healthy.named.events.to_string(),
            rate(healthy.named.at_most),
        ]);
    }
    let healthy = sheet.about(
        "sequential and process detectors on healthy machines of other loads (70 to 130 %) and more friction (to 110 %) \
         than taught",
    );
    [drifts, healthy]
}
