//! Where on the stroke the difference of both readings is known, and how accurately.

use super::sheet::{Section, Sheet};
use tertius_core::sequential::reference::LARGEST_DOUBT;
use tertius_core::sequential::statistic::DEAD_BAND;
use tertius_core::text::Millimetres;
use tertius_learn::calibrate::{Calibration, CylinderCalibration, Profile};

/// The profiles of the cylinders that have one.
pub fn profiles(result: &Calibration) -> impl Iterator<Item = (&CylinderCalibration, &Profile)> {
    result
        .cylinders
        .iter()
        .filter_map(|cylinder| Some((cylinder, &cylinder.sequential.as_ref()?.0)))
}

/// A row for each cylinder.
pub fn section(result: &Calibration) -> Section {
    let mut table = Sheet::new(&["cylinder", "C2 known", "thin places", "in motion", "bend"]);
    for (cylinder, profile) in profiles(result) {
        let samples: u64 = profile.samples.iter().sum();
        table.add_row([
            cylinder.number.to_string(),
            told(&known(profile)),
            told(&profile.reference.spans(DEAD_BAND, LARGEST_DOUBT)),
            format!("{:.1} min", samples as f64 * cylinder.sample_time / 60.0),
            format!("{:.2}", Millimetres(profile.bend)),
        ]);
    }
    table.about(format!(
        "where on the stroke the sequential detectors know C1 − C2 to {:.1} (three standard deviations) or better; in \
         thin places they do not know it to {:.1}, so that small faults take longer there; elsewhere their \
        verdict is unknown; and the bend of the profile that is assumed from node to node",
        Millimetres(LARGEST_DOUBT),
        Millimetres(DEAD_BAND)
    ))
}

/// Spans of the stroke, m, in which the detector can judge.
pub fn known(profile: &Profile) -> Vec<[f64; 2]> {
    profile.reference.spans(f64::NEG_INFINITY, LARGEST_DOUBT)
}

fn told(spans: &[[f64; 2]]) -> String {
    let span = |[from, to]: &[f64; 2]| format!("{from:.2} to {to:.2} m");
    if spans.is_empty() {
        return "none".to_owned();
    }
    spans.iter().map(span).collect::<Vec<_>>().join(", ")
}
