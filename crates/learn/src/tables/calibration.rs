//! A calibration as tables that the configuration reads.

use super::digits::six;
use super::process;
use super::provenance::{self, one_line};
use crate::calibrate::{Bound, Calibration, CylinderCalibration, Fitted, LEAST_BOUND};
use crate::extremes::{HOURS_PER_YEAR, four_digits, times};
use std::fmt::Write as _;
use tertius_config::settings::{Cylinder, CylinderExcursions, CylinderSequential};
use tertius_core::text::Millimetres;

/// Factor in rarity beyond which a rate is bounded by the evidence, and not measured.
const FAR: f64 = 100.0;

/// The cylinders that have a calibration, with their fits.
pub fn fits(result: &Calibration) -> impl Iterator<Item = (&CylinderCalibration, &Fitted)> {
    result.cylinders.iter().filter_map(|cylinder| Some((cylinder, cylinder.result.as_ref().ok()?)))
}

/// Meaning of the bound, and its reliability.
pub fn meaning(bound: &Bound) -> Vec<String> {
    let years = 1.0 / bound.per_year;
    let factor = years * HOURS_PER_YEAR / bound.hours;
    let tail = provenance::tail(bound.heavy);
    let asked = format!(
        "exceeded at most {} a year, all cylinders together, by {tail} tail of the largest |R3| of \
         each second; at least 1.2 times the largest seen, {:.3}, and the thesis's {:.1}",
        provenance::times(bound.per_year),
        Millimetres(bound.worst),
        Millimetres(LEAST_BOUND)
    );
    let evidence = format!("evidence: {:.3} cylinder hours", bound.hours);
    let beyond = "other temperatures, ranges and wear are not covered";
    if factor > FAR {
        // Of what was never seen in a time, less than three are in as much of it (95 %).
        let most = 3.0 * HOURS_PER_YEAR * bound.cylinders as f64 / bound.hours;
        return vec![
            asked,
            format!(
                "{evidence}, none of it beyond the bound: this proves at most {} a year (95 %), \
                 and the bound is extrapolated to {} times that time; {beyond}",
                four_digits(most),
                times(factor)
            ),
        ];
    }
    vec![
        asked,
        format!("{evidence}; the wanted rate is {} times beyond it; {beyond}", times(factor)),
    ]
}

/// The tables, with their origin, and with the `bounded` R3; `None` where nothing was learnt of any cylinder.
pub fn of(result: &Calibration, version: &str, bounded: bool) -> Option<String> {
    result.cylinders.iter().find_map(CylinderCalibration::table)?;
    let Calibration { machine, inputs, timeline, .. } = result;
    let both = [("fitted", result.fitted), ("tried ", result.tried)];
    let parts = if result.fitted == result.tried { &both[..1] } else { &both[..] };
    let mut text = provenance::heading(version, "calibrate", machine, inputs, timeline, parts);
    for cylinder in &result.cylinders {
        if !cylinder.has_c2() {
            _ = writeln!(text, "# cylinder {} has no C2", cylinder.number);
        } else if let Err(refusal) = &cylinder.result {
            let refusal = one_line(&refusal.to_string());
            _ = writeln!(text, "# cylinder {} was refused: {refusal}", cylinder.number);
        }
        if let Some(contradiction) = &cylinder.contradiction {
            let told = one_line(&contradiction.to_string());
            _ = writeln!(text, "# cylinder {} has no sequential detector: {told}", cylinder.number);
        }
    }
    text += "# Keys of [[cylinder]] belong in that cylinder's table, if the file has one.\n";
    if let Some(bound) = result.bound.as_ref().filter(|_| bounded) {
        text += "\n";
        for line in meaning(bound) {
            _ = writeln!(text, "# {line}");
        }
        _ = writeln!(text, "[comparator]\nbound = {:?}", four_digits(bound.level));
    }
    let end = timeline.at(result.fitted.to.max(result.tried.to));
    if let Some(day) = provenance::day(end) {
        _ = writeln!(text, "\n[calibration]\nrecorded = \"{day}\"");
    }
    if let Some(Ok(supply)) = &result.supply {
        text += &process::of_supply(supply);
    }
    for cylinder in result.cylinders.iter().filter_map(CylinderCalibration::table) {
        let Cylinder { n, c2, c2_gain, c2_offset, sequential, process, .. } = cylinder;
        _ = writeln!(text, "\n[[cylinder]]\nn = {n}");
        if c2 {
            _ = writeln!(text, "c2_gain = {c2_gain:?}\nc2_offset = {c2_offset:?}");
        }
        if let Some(sequential) = &sequential {
            text += &sequential_table(sequential);
        }
        if let Some(process) = &process {
            text += &process::table(process);
        }
    }
    Some(text)
}

fn excursions_table(table: &CylinderExcursions) -> String {
    let CylinderExcursions {
        level,
        rate,
        size,
        longest,
        first_box,
        box_width,
        runs,
        clips,
        sums,
        squares,
        elsewhere,
    } = table;
    format!(
        "\n[cylinder.sequential.excursions]\nlevel = {:?}\nrate = {:?}\nsize = {size:e}\nlongest = {longest}\n\
         first_box = {first_box:e}\nbox_width = {box_width:e}\nruns = {runs:?}\nclips = {}\nsums = {}\nsquares = {}\n\
         elsewhere = {}\n",
        four_digits(*level),
        four_digits(*rate),
        six(clips),
        six(sums),
        six(squares),
        six(elsewhere),
    )
}

fn sequential_table(table: &CylinderSequential) -> String {
    // All of it: what is not written is read as what it was before there was a key for it.
    let CylinderSequential {
        sample_time,
        level,
        first,
        spacing,
        nodes,
        node_deviations,
        samples,
        velocity,
        outlier_share,
        deviation,
        noise,
        timing,
        resolution,
        rate_spacing,
        rate,
        square_rate,
        mean_dependence,
        square_dependence,
        drive,
        prediction,
        prediction_correlation,
        excursions,
    } = table;
    let mut text = "\n[cylinder.sequential]\n".to_owned();
    if let Some(seconds) = sample_time {
        _ = writeln!(text, "sample_time = {seconds:?}");
    }
    _ = write!(
        text,
        "first = {first:?}\nspacing = {spacing:?}\nnodes = {}\nnode_deviations = {}\nsamples = {samples:?}\n\
         outlier_share = {outlier_share:?}\nvelocity = {velocity:e}\ndeviation = {deviation:e}\nnoise = {noise:e}\n\
         timing = {timing:e}\nresolution = {}\nrate_spacing = {rate_spacing:e}\nrate = {}\nsquare_rate = {}\n\
         mean_dependence = {}\nsquare_dependence = {}\n",
        six(nodes),
        six(node_deviations),
        six(resolution),
        six(rate),
        six(square_rate),
        six(mean_dependence),
        six(square_dependence),
    );
    if let Some(nats) = level {
        _ = writeln!(text, "level = {:?}", four_digits(*nats));
    }
    if let Some(coefficients) = drive {
        _ = writeln!(text, "drive = {}\nprediction = {prediction:e}", six(coefficients));
    }
    if let Some(correlation) = prediction_correlation {
        _ = writeln!(text, "prediction_correlation = {}", six(correlation));
    }
    if let Some(excursions) = excursions {
        text += &excursions_table(excursions);
    }
    text
}
