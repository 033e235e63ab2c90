//! A calibration as a page for people, and as tables that the configuration reads.

use super::coverage;
use super::provenance::{self, four_digits, one_line};
use super::sheet::{Section, Sheet};
use crate::calibrate::{Bound, Calibration, CylinderCalibration, Fitted, LEAST_BOUND, Tried};
use crate::calibrate::{Profile, Scatter};
use crate::sequential::Drive;
use crate::sequential::reference::{DOUBTED, LARGEST_DOUBT};
use std::fmt::Write as _;

/// What is rarer than the evidence by more than this is bounded by it, and not measured.
const FAR: f64 = 100.0;

/// The page.
pub fn page(result: &Calibration) -> String {
    let mut text = format!("{}: {}\n{}\n\n", result.machine, result.inputs, parts(result));
    let coverage = coverage::section(result);
    for section in [lines(result), bands(result), sequential(result), coverage] {
        let section = section.text();
        if !section.is_empty() {
            text += &section;
            text += "\n";
        }
    }
    text += &bound(result);
    let remarks = remarks(result);
    if !remarks.is_empty() {
        text += "\n";
        text += &remarks;
    }
    text
}

/// Which parts of the recording it was made from.
pub fn parts(result: &Calibration) -> String {
    let Calibration { fitted, tried, .. } = result;
    let [from, middle, begin, to] = [fitted.from, fitted.to, tried.from, tried.to];
    if fitted == tried {
        return format!("fitted and tried on {from:.1} s to {to:.1} s, by blocks that alternate");
    }
    format!("fitted on {from:.1} s to {middle:.1} s, tried on {begin:.1} s to {to:.1} s")
}

fn fits(result: &Calibration) -> impl Iterator<Item = (&CylinderCalibration, &Fitted)> {
    result.cylinders.iter().filter_map(|cylinder| Some((cylinder, cylinder.result.as_ref().ok()?)))
}

/// a and b of each cylinder.
pub fn lines(result: &Calibration) -> Section {
    let mut table = Sheet::new(&["cylinder", "a", "b", "RMS of the fit", "samples", "left out"]);
    for (cylinder, fitted) in fits(result) {
        table.add_row([
            cylinder.number.to_string(),
            format!("{:.6} ± {:.0e}", fitted.line.gain, fitted.errors[0]),
            format!("{:.4} mm ± {:.0e}", fitted.line.offset * 1e3, fitted.errors[1] * 1e3),
            format!("{:.4} mm", fitted.rms * 1e3),
            fitted.rows.to_string(),
            format!("{} beyond {:.2} mm", fitted.trimmed, fitted.limit * 1e3),
        ]);
    }
    table.about("C1 = a·C2 + b (5-20), least squares without the samples left out")
}

/// The band of each cylinder.
pub fn bands(result: &Calibration) -> Section {
    let mut table = Sheet::new(&["cylinder", "C1 − C2", "C1 − Ĉ2", "99.9 %", "RMS", "faulty"]);
    for cylinder in &result.cylinders {
        let Some(tried) = cylinder.tried.as_ref().filter(|tried| tried.after.count > 0) else {
            continue;
        };
        let Tried { before, after, .. } = tried;
        table.add_row([
            cylinder.number.to_string(),
            format!("{:.3} to {:.3} mm", before.low * 1e3, before.high * 1e3),
            format!("{:.3} to {:.3} mm", after.low * 1e3, after.high * 1e3),
            format!("{:.3} mm", tried.magnitudes.quantile(0.999).unwrap_or(0.0) * 1e3),
            format!("{:.4} mm", after.rms() * 1e3),
            faulty(tried),
        ]);
    }
    table.about("the difference before (Figure 5-14) and after (Figure 5-15), where it was tried")
}

/// What the sequential detectors start from.
pub fn sequential(result: &Calibration) -> Section {
    let mut table =
        Sheet::new(&["cylinder", "covered", "deviation", "largest", "by velocity", "command", "h"]);
    for cylinder in &result.cylinders {
        let Some((profile, scatter)) = &cylinder.sequential else { continue };
        let reference = &profile.reference;
        let known = reference.spans(f64::NEG_INFINITY, LARGEST_DOUBT);
        let known: f64 = known.iter().map(|[from, to]| to - from).sum();
        table.add_row([
            cylinder.number.to_string(),
            format!("{known:.1} m"),
            format!("{:.4} mm", scatter.deviation * 1e3),
            format!("{:.3} mm", scatter.largest * 1e3),
            format!("{:.3} ms", reference.velocity * 1e3),
            scatter.prediction.map_or("none".to_owned(), |p| format!("{:.4} mm", p * 1e3)),
            cylinder.level.map_or("by rate".to_owned(), |nats| format!("{nats:.2} nats")),
        ]);
    }
    table.about(
        "for the sequential detectors: stroke covered, C1 − C2 beyond hat functions and velocity \
         (where it was tried), what a cycle differs by from the command's prediction, and the level",
    )
}

fn faulty(tried: &Tried) -> String {
    match tried.faulty {
        0 => format!("none beyond {:.2} mm", tried.limit() * 1e3),
        some => format!(
            "{some} beyond {:.2} mm, up to {:.2} mm",
            tried.limit() * 1e3,
            tried.worst_faulty * 1e3
        ),
    }
}

/// The bound that is proposed, or why none is.
pub fn bound(result: &Calibration) -> String {
    match &result.bound {
        Some(bound) => format!(
            "proposed bound of R3: {:.3} mm\n  {}\n",
            four_digits(bound.level) * 1e3,
            meaning(bound).join("\n  ")
        ),
        None => "no bound is proposed: there are less than 50 s of the second part (50 times \
                 alarm.clear), or no cylinder has a calibration\n"
            .to_owned(),
    }
}

/// What the number means, and how far it can be believed.
fn meaning(bound: &Bound) -> Vec<String> {
    let years = 1.0 / bound.per_year;
    let factor = years * crate::extremes::HOURS_PER_YEAR / bound.hours;
    let tail = provenance::tail(bound.heavy);
    let asked = format!(
        "exceeded {} times a year at most, all cylinders together, by {tail} tail of the largest |R3| of \
         each second; at least 1.2 times the largest seen, {:.3} mm, and the thesis's {:.1} mm",
        bound.per_year,
        bound.worst * 1e3,
        LEAST_BOUND * 1e3
    );
    let evidence = format!("evidence: {:.3} cylinder hours", bound.hours);
    let beyond = "other temperatures, ranges and wear are not in it";
    if factor > FAR {
        // Of what was never seen in a time, less than three are in as much of it (95 %).
        let most = 3.0 * crate::extremes::HOURS_PER_YEAR * bound.cylinders as f64 / bound.hours;
        return vec![
            asked,
            format!(
                "{evidence}, none of it beyond the bound: that proves at most {} a year (95 %), and \
                 what is said of one in {:.0} times as long is extrapolated; {beyond}",
                four_digits(most),
                factor
            ),
        ];
    }
    vec![asked, format!("{evidence}; the wanted rate is {factor:.1e} times beyond it; {beyond}")]
}

/// A line for each.
pub fn remarks(result: &Calibration) -> String {
    let mut text = String::new();
    let mut told: Vec<(&str, Vec<String>)> = Vec::new();
    for cylinder in &result.cylinders {
        let number = cylinder.number.to_string();
        for remark in &cylinder.remarks {
            match told.iter_mut().find(|(known, _)| known == remark) {
                Some((_, numbers)) => numbers.push(number.clone()),
                None => told.push((remark, vec![number.clone()])),
            }
        }
    }
    for (remark, numbers) in told {
        _ = writeln!(text, "cylinder {}: {remark}", numbers.join(", "));
    }
    for cylinder in &result.cylinders {
        if let Err(refusal) = &cylinder.result {
            _ = writeln!(text, "cylinder {} is refused: {refusal}", cylinder.number);
        }
        if let Some(contradiction) = &cylinder.contradiction {
            _ = writeln!(text, "cylinder {}: {contradiction}", cylinder.number);
        }
    }
    for remark in &result.remarks {
        _ = writeln!(text, "{remark}");
    }
    text
}

/// The tables, with what they were made from; `None` where no cylinder has a calibration.
pub fn tables(result: &Calibration, version: &str) -> Option<String> {
    fits(result).next()?;
    let Calibration { machine, inputs, timeline, .. } = result;
    let both = [("fitted", result.fitted), ("tried ", result.tried)];
    let parts = if result.fitted == result.tried { &both[..1] } else { &both[..] };
    let mut text = provenance::heading(version, "calibrate", machine, inputs, timeline, parts);
    for cylinder in &result.cylinders {
        if let Err(refusal) = &cylinder.result {
            let refusal = one_line(&refusal.to_string());
            _ = writeln!(text, "# cylinder {} was refused: {refusal}", cylinder.number);
        }
        if let Some(contradiction) = &cylinder.contradiction {
            let told = one_line(&contradiction.to_string());
            _ = writeln!(text, "# cylinder {} has no sequential detector: {told}", cylinder.number);
        }
    }
    text += "# Keys of [[cylinder]] belong into that cylinder's table, where the file has one.\n";
    if let Some(bound) = &result.bound {
        text += "\n";
        for line in meaning(bound) {
            _ = writeln!(text, "# {line}");
        }
        _ = writeln!(text, "[comparator]\nbound = {:?}", four_digits(bound.level));
    }
    for (cylinder, fitted) in fits(result) {
        let line = fitted.line;
        _ = writeln!(
            text,
            "\n[[cylinder]]\nn = {}\nc2_gain = {:?}\nc2_offset = {:?}",
            cylinder.number, line.gain, line.offset
        );
        if let Some((profile, scatter)) = &cylinder.sequential {
            text += &sequential_table(cylinder, profile, scatter);
        }
    }
    Some(text)
}

fn sequential_table(
    cylinder: &CylinderCalibration,
    profile: &Profile,
    scatter: &Scatter,
) -> String {
    let sample_time = cylinder.sample_time;
    let Profile { reference, samples, drive, .. } = profile;
    let deviations: Vec<f64> = reference.doubts.iter().map(|doubt| doubt / DOUBTED).collect();
    let Scatter { rate, square_rate, dependence, deviation, spread, prediction, .. } = scatter;
    let six = |values: &[f64]| {
        let texts: Vec<String> = values.iter().map(|value| format!("{value:.6e}")).collect();
        format!("[{}]", texts.join(", "))
    };
    let mut text = format!(
        "\n[cylinder.sequential]\nsample_time = {sample_time:?}\nfirst = {:?}\nspacing = {:?}\nnodes = {}\nnode_deviations = {}\nsamples = {samples:?}\n\
         velocity = {:e}\ndeviation = {deviation:e}\nnoise = {:e}\ntiming = {:e}\nresolution = {}\nrate_spacing = {:e}\nrate = {}\n\
         square_rate = {}\nmean_dependence = {}\nsquare_dependence = {}\n",
        reference.first,
        reference.spacing,
        six(&reference.nodes),
        six(&deviations),
        reference.velocity,
        spread.noise.rest,
        spread.noise.timing,
        six(&spread.resolution),
        rate.spacing(),
        six(&rate.values()),
        six(&square_rate.values()),
        six(&dependence[0]),
        six(&dependence[1]),
    );
    if let Some(nats) = cylinder.level {
        _ = writeln!(text, "level = {:?}", four_digits(nats));
    }
    if let Some((Drive(coefficients), prediction)) = drive.zip(*prediction) {
        _ = writeln!(text, "drive = {}\nprediction = {prediction:e}", six(&coefficients));
    }
    text
}
