//! Table of the comparison of the observers' weights.

use super::{percent, rate};
use crate::report::sheet::{Section, Sheet};
use tertius_core::text::Millimetres;
use tertius_lab::evaluate::weights::{FAULTS, SetResult};

/// One row for each set on each kind of transducers.
pub fn section(results: &[SetResult]) -> Section {
    let mut header: Vec<String> = [
        "transducers",
        "q",
        "r",
        "hours",
        "crossings of 1 mm",
        "δ_h for 1 an hour",
        "a day",
        "a year",
    ]
    .map(str::to_owned)
    .to_vec();
    let faults = results.first().and_then(|result| result.seen.first());
    for at in ["at 1 mm", "at 1 a day"] {
        let labels = faults.iter().flat_map(|seen| &seen.faults).map(|fault| &fault.label);
        header.extend(labels.map(|label| format!("{label} {at}")));
    }
    let mut sheet = Sheet::new(&header);
    for result in results {
        let mut cells = vec![
            result.kind.to_owned(),
            format!("{:e} {:e} {:e}", result.q[0], result.q[1], result.q[2]),
            format!("{:e} {:e}", result.r[0], result.r[1]),
            format!("{:.1}", result.hours),
            format!("{} an hour", rate(result.crossings.events as f64 / result.hours)),
        ];
        cells.extend((0..3).map(|at| {
            let level = result.levels.map(|levels| levels[at]);
            level.map_or("–".to_owned(), |level| format!("{:.2}", Millimetres(level)))
        }));
        let found = result.seen.iter().flat_map(|seen| &seen.faults);
        cells.extend(found.map(|fault| percent(&fault.found)));
        cells.resize(8 + 2 * FAULTS.len(), "–".to_owned());
        sheet.add_row(cells);
    }
    sheet.about(
        "weights, each with its own thresholds: crossings of the thesis's δ_h on healthy machines, all \
         cylinders together; δ_h for a rate of false alarms, by the tails of the largest of each \
         alarm.clear; faults that the observer on the faulty transducer sees in the first reading \
         (steps), within 0.1 s (incipient), or within 10 s (noise)",
    )
}
