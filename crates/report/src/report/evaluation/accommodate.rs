//! Table of accommodation.

use super::percent;
use crate::report::sheet::{Section, Sheet};
use tertius_core::text::Millimetres;
use tertius_lab::evaluate::accommodate::{AccommodateFigures, AccommodateResult};

/// The estimates by a transducer less its step, and those of the same machines without accommodation.
pub fn section(result: &AccommodateResult) -> Section {
    let mut sheet = Sheet::new(&[
        "transducers",
        "fault",
        "accommodation",
        "cylinders",
        "valid",
        "error (median, largest)",
        "ever wrong",
        "wrong (median, maximum)",
    ]);
    for figures in &result.cases {
        let AccommodateFigures { grade, label, accommodates, cylinders, valid, .. } = figures;
        let AccommodateFigures { errors, wrong, wrong_for: [median, most], .. } = figures;
        let errors = errors.map(|[median, largest]| {
            format!("{:.2}, {:.2}", Millimetres(median), Millimetres(largest))
        });
        sheet.add_row([
            (*grade).to_owned(),
            label.clone(),
            if *accommodates { "on" } else { "off" }.to_owned(),
            cylinders.to_string(),
            format!("{:.1} %", valid * 1e2),
            errors.unwrap_or("–".to_owned()),
            percent(wrong),
            format!("{median:.2} s, {most:.2} s"),
        ]);
    }
    sheet.about(
        "accommodation: one transducer has the fault, the other one is lost 90 s later, and the estimate is watched for \
         60 s; cycles with a valid estimate; their errors; cylinders of which the estimate is ever valid and off by more \
         than 3 σ, and for how long",
    )
}
