//! A calibration as a page for people.

use super::coverage;
use super::sheet::{Section, Sheet};
use crate::report::ReadWith;
use std::fmt::Write as _;
use tertius_config::settings::{CylinderProcess, FrictionTable};
use tertius_core::sequential::reference::LARGEST_DOUBT;
use tertius_core::text::Millimetres;
use tertius_learn::calibrate::{Calibration, LearntExcursions, Scatter, TriedBand};
use tertius_learn::extremes::four_digits;
use tertius_learn::tables::calibration::{fits, meaning};
use tertius_learn::tables::cylinders::by_cylinders;

/// The page; the recordings were read with the configuration `with`.
pub fn page(result: &Calibration, with: &ReadWith) -> String {
    let Calibration { machine, inputs, .. } = result;
    let mut text = format!("{machine}: {inputs} with {with}\n{}\n\n", parts(result));
    let coverage = coverage::section(result);
    let (process, supply) = (process(result), supply(result));
    let (sequential, excursions) = (sequential(result), excursions(result));
    for section in [lines(result), bands(result), sequential, excursions, process, supply, coverage]
    {
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

/// Parts of the recording that were used.
pub fn parts(result: &Calibration) -> String {
    let Calibration { fitted, tried, .. } = result;
    let [from, middle, begin, to] = [fitted.from, fitted.to, tried.from, tried.to];
    if fitted == tried {
        return format!("fitted and tried on {from:.1} s to {to:.1} s, by alternating blocks");
    }
    format!("fitted on {from:.1} s to {middle:.1} s, tried on {begin:.1} s to {to:.1} s")
}

/// a and b of each cylinder.
pub fn lines(result: &Calibration) -> Section {
    let mut table = Sheet::new(&["cylinder", "a", "b", "RMS of the fit", "samples", "left out"]);
    for (cylinder, fitted) in fits(result) {
        table.add_row([
            cylinder.number.to_string(),
            format!("{:.6} ± {:.0e}", fitted.line.gain, fitted.errors[0]),
            format!("{:.4} ± {:.0e}", Millimetres(fitted.line.offset), fitted.errors[1] * 1e3),
            format!("{:.4}", Millimetres(fitted.rms)),
            fitted.rows.to_string(),
            format!("{} beyond {:.2}", fitted.trimmed, Millimetres(fitted.limit)),
        ]);
    }
    table.about("C1 = a·C2 + b (5-20), least squares without the samples left out")
}

/// Band of each cylinder.
pub fn bands(result: &Calibration) -> Section {
    let mut table = Sheet::new(&["cylinder", "C1 − C2", "C1 − Ĉ2", "99.9 %", "RMS", "faulty"]);
    for cylinder in &result.cylinders {
        let Some(tried) = cylinder.tried.as_ref().filter(|tried| tried.after.count > 0) else {
            continue;
        };
        let TriedBand { before, after, .. } = tried;
        table.add_row([
            cylinder.number.to_string(),
            format!("{:.3} to {:.3} mm", before.low * 1e3, before.high * 1e3),
            format!("{:.3} to {:.3} mm", after.low * 1e3, after.high * 1e3),
            format!("{:.3}", Millimetres(tried.magnitudes.quantile(0.999).unwrap_or(0.0))),
            format!("{:.4}", Millimetres(after.rms())),
            faulty(tried),
        ]);
    }
    table.about("the difference before (Figure 5-14) and after (Figure 5-15), where it was tried")
}

/// Basis of the sequential detectors.
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
            format!("{:.4}", Millimetres(scatter.deviation)),
            format!("{:.3}", Millimetres(scatter.largest)),
            format!("{:.3} ms", reference.velocity * 1e3),
            scatter
                .prediction
                .map_or("none".to_owned(), |it| format!("{:.4}", Millimetres(it.deviation))),
            cylinder.level.map_or("by rate".to_owned(), |nats| format!("{nats:.2} nats")),
        ]);
    }
    table.about(
        "for the sequential detectors: stroke covered, C1 − C2 beyond hat functions and velocity \
         (where it was tried), the deviation from the command's prediction in a cycle, and the \
         level",
    )
}

/// Excursions of transducers that fluctuate, and what their limits find.
pub fn excursions(result: &Calibration) -> Section {
    let mut table = Sheet::new(&[
        "cylinder",
        "up",
        "down",
        "a minute",
        "size",
        "largest",
        "lasts",
        "longest",
        "step in 0.1 s",
        "0.3 s",
        "1 s",
    ]);
    for cylinder in &result.cylinders {
        let Some((_, Scatter { excursions: Some(learnt), .. })) = &cylinder.sequential else {
            continue;
        };
        let LearntExcursions { rate, directions: [up, down], sizes, lengths, smallest, .. } =
            learnt;
        let millimetres = |size: f64| format!("{:.2}", Millimetres(size));
        let step = |within: usize| {
            let size = smallest[within].size;
            size.map_or_else(|| "none".to_owned(), millimetres)
        };
        table.add_row([
            cylinder.number.to_string(),
            up.to_string(),
            down.to_string(),
            format!("{:.1}", rate * 60.0),
            millimetres(sizes[0]),
            millimetres(sizes[2]),
            format!("{:.2} s", lengths[0]),
            format!("{:.2} s", lengths[2]),
            step(0),
            step(1),
            step(2),
        ]);
    }
    table.about(
        "transducers that fluctuate: excursions of C1 − C2 up and down, median and largest of all cylinders, and the smallest \
         steps that the limits computed from them find within a time",
    )
}

/// Basis of the process detectors.
pub fn process(result: &Calibration) -> Section {
    let mut table = Sheet::new(&["cylinder", "spool", "largest", "chambers", "flow", "friction"]);
    let none = || "none".to_owned();
    for cylinder in &result.cylinders {
        let learnt = cylinder.process.as_ref().and_then(|it| it.table(cylinder.sample_time));
        let Some(CylinderProcess { spool, chambers, flow, friction, .. }) = learnt else {
            continue;
        };
        let of_spool = spool.as_ref().map(|it| [it.deviation, it.largest]);
        table.add_row([
            cylinder.number.to_string(),
            of_spool.map_or_else(none, |[deviation, _]| format!("{deviation:.3}")),
            of_spool.map_or_else(none, |[_, largest]| format!("{largest:.1}")),
            chambers.map_or_else(none, |it| format!("{:.2} bar", it.deviation)),
            flow.map_or_else(none, |it| format!("{:.2} mm/s a bar", it.leakage * 1e3)),
            friction.map_or_else(none, |it| coulomb(&it)),
        ]);
    }
    table.about(
        "for the process detectors: the deviation of the spool beside what its command says and its largest position, \
         in the signal's unit, the deviation of the sum of the chambers' \
         pressures, what leaks of the flow, and the pressure that Coulomb's friction takes",
    )
}

/// Basis of the process detector of the supply.
pub fn supply(result: &Calibration) -> Section {
    let mut table = Sheet::new(&["from", "to", "the pump adds", "rods out", "rods in", "scatter"]);
    if let Some(Ok(learnt)) = &result.supply {
        let [lowest, highest] = learnt.taught;
        let ends = [learnt.pump.first(), learnt.pump.last()].map(|it| it.map_or(0.0, |it| *it));
        table.add_row([
            format!("{lowest:.1} bar"),
            format!("{highest:.1} bar"),
            format!("{:.1} to {:.1} bar/s", ends[0], ends[1]),
            format!("{:.2} bar/m", learnt.taken[0]),
            format!("{:.2} bar/m", learnt.taken[1]),
            format!("{:.2} bar", learnt.deviation),
        ]);
    }
    table.about(
        "for the process detector of the supply: the pressures that were taught, what the pump adds at them, what the \
         rods take as they go out and in, and the scatter of the pressure about both after a block of 0.2 s (ten \
         samples below 50 Hz)",
    )
}

fn coulomb(table: &FrictionTable) -> String {
    let [.., coulomb] = table.coefficients;
    format!("{coulomb:.2} bar")
}

fn faulty(tried: &TriedBand) -> String {
    match tried.faulty {
        0 => format!("none beyond {:.2}", Millimetres(tried.limit())),
        some => format!(
            "{some} beyond {:.2}, up to {:.2}",
            Millimetres(tried.limit()),
            Millimetres(tried.worst_faulty)
        ),
    }
}

/// Proposed bound, or why there is none.
pub fn bound(result: &Calibration) -> String {
    match &result.bound {
        Some(bound) => format!(
            "proposed bound of R3: {:.3}\n  {}\n",
            Millimetres(four_digits(bound.level)),
            meaning(bound).join("\n  ")
        ),
        None => "no bound is proposed: the second part has less than 50 s (50 times \
                 alarm.clear), or no cylinder has a calibration\n"
            .to_owned(),
    }
}

/// The result in a sentence, and whether it is whole: of all cylinders, with a bound of R3.
pub fn verdict(result: &Calibration) -> (bool, String) {
    let all = result.cylinders.iter().filter(|it| it.has_c2()).count();
    let without = match result.cylinders.len() - all {
        0 => "",
        1 => "; 1 cylinder has no C2",
        _ => "; some cylinders have no C2",
    };
    let corrected = result.cylinders.iter().filter(|it| it.result.is_ok()).count();
    let taught = result.cylinders.iter().filter(|it| it.sequential.is_some()).count();
    let bound = result.bound.as_ref().map_or_else(
        || "no bound of R3 is proposed".to_owned(),
        |bound| format!("R3 may be bounded at {:.3}", Millimetres(four_digits(bound.level))),
    );
    let text = format!(
        "C2 is corrected on {corrected} of {all} cylinders, and the sequential detectors of {taught} are calibrated; \
         {bound}{without}."
    );
    (corrected == all && taught == all && result.bound.is_some(), text)
}

/// Remarks, one line each.
pub fn remarks(result: &Calibration) -> String {
    let mut text = String::new();
    let own = result.cylinders.iter();
    let own = own.flat_map(|it| it.remarks.iter().map(|remark| (it.number, &**remark)));
    for line in by_cylinders(own) {
        _ = writeln!(text, "{line}");
    }
    for cylinder in result.cylinders.iter().filter(|it| it.has_c2()) {
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
