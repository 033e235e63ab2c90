//! Tables of the drifts that the deck's attitude names.

use super::{millimetres, percent, rate};
use crate::report::sheet::{Section, Sheet};
use tertius_lab::evaluate::hexapod::{HexapodFigures, HexapodResult};

/// Whom the drifts were laid to by the deck's attitude, and when, and the false alarms.
pub fn sections(result: &HexapodResult) -> [Section; 2] {
    let header = [
        "attitude by",
        "transducers",
        "drift",
        "found at (median, 95 %)",
        "named right",
        "named wrong",
        "named at (median, 95 %)",
        "by another detector before, wrong",
    ];
    let mut sheet = Sheet::new(&header.map(str::to_owned));
    for figures in &result.drifts {
        let HexapodFigures { grade, witness, transducer, rate, named, wrong, at, found_at, others } =
            figures;
        sheet.add_row(vec![
            witness.clone(),
            (*grade).to_owned(),
            format!("{}, {:.1} mm/s", transducer.to_uppercase(), 1e3 * rate),
            millimetres(found_at),
            percent(named),
            percent(wrong),
            millimetres(at),
            others.each_ref().map(percent).join(", "),
        ]);
    }
    let drifts = sheet.about(
        "drifts of one transducer inside the loop, minutes after the machine began to work: whom the deck's attitude \
         named before it was 20 mm off, and how far it was off then",
    );
    let header = [
        "attitude by",
        "transducers",
        "hours",
        "sequential",
        "named by the deck",
        "a year at most",
    ];
    let mut sheet = Sheet::new(&header.map(str::to_owned));
    for healthy in &result.healthy {
        sheet.add_row(vec![
            healthy.witness.clone(),
            healthy.grade.to_owned(),
            format!("{:.1}", healthy.hours),
            healthy.sequential.events.to_string(),
            healthy.hexapod.events.to_string(),
            rate(healthy.hexapod.at_most),
        ]);
    }
    let healthy = sheet.about(
        "warnings on healthy machines of other loads (70 to 130 %) and more friction (to 110 %) than taught",
    );
    [drifts, healthy]
}
