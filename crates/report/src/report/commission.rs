//! A commissioning as a page for people: the verdict first.

use super::calibration;
use super::sheet::{Section, Sheet};
use crate::report::ReadWith;
use std::fmt::Write as _;
use tertius_core::alarm::Detector;
use tertius_core::alarm::detector::Basis;
use tertius_lab::commission::trial::{DETECTORS, KindResult};
use tertius_lab::commission::{Commissioned, Fitness, Taught, Threshold, Trial, coverage};
use tertius_lab::evaluate::{CONFIDENCE, poisson_upper};
use tertius_learn::calibrate::Calibration;
use tertius_learn::extremes::four_digits;
use tertius_learn::tables::cylinders::by_cylinders;
use tertius_learn::tables::tuning::length;
use tertius_learn::tune::{OF_A_LEVEL, WOULD_HAVE_WARNED};

/// The page; the recordings were read with the configuration `with`.
pub fn page(result: &Commissioned, with: &ReadWith) -> String {
    let mut text = format!("{}\n", result.verdict.sentence);
    for (head, lines) in [("why", &result.verdict.reasons), ("what to do", &result.verdict.advice)]
    {
        text += &listed(head, lines);
    }
    _ = writeln!(text, "\n{}", origin(result, with));
    let excursions = result.taught.calibration.as_ref().map(calibration::excursions);
    for section in [Some(tables(result)), excursions, Some(trial(result)), Some(faults(result))]
        .into_iter()
        .flatten()
    {
        let section = section.text();
        if !section.is_empty() {
            _ = write!(text, "\n{section}");
        }
    }
    text += &listed("what a longer recording would add", &wins(result));
    text += &listed("to be known", &remarks(result));
    text
}

fn listed(head: &str, lines: &[String]) -> String {
    if lines.is_empty() {
        return String::new();
    }
    let lines: String = lines.iter().map(|line| format!("  {line}\n")).collect();
    format!("\n{head}:\n{lines}")
}

/// Recordings that were learnt from, and the configuration that they were read with.
pub fn origin(result: &Commissioned, with: &ReadWith) -> String {
    let minutes = result.recorded / 60.0;
    let tried = result.trial.as_ref().map_or(String::new(), |trial| {
        let held = trial.held / 60.0;
        format!("; the trial uses tables that were learnt without its own {held:.1} min")
    });
    format!("learnt from all {minutes:.1} min recorded in {} with {with}{tried}", result.inputs)
}

/// Tables of the resulting configuration.
pub fn tables(result: &Commissioned) -> Section {
    let mut table = Sheet::new(&["what", "learnt", "of"]);
    let taught = &result.taught;
    let mut add = |name: &str, learnt: String, of: String| {
        table.add_row([name.to_owned(), learnt, of]);
    };
    if let Some(choice) = taught.identification.as_ref().and_then(|it| it.choice) {
        let of =
            format!("position VAF at least {:.2} %, simulated on every cylinder", choice.worst);
        add("model (4-1)", format!("that of cylinder {}", choice.of), of);
    }
    if let Some(bound) = taught.calibration.as_ref().and_then(|it| it.bound) {
        let of = format!("largest |C1 − Ĉ2| seen {}", length(bound.worst));
        let off = off(taught, Threshold::OfDifference);
        add("bound of R3", format!("{}{off}", length(four_digits(bound.level))), of);
    }
    if let Some(tuning) = &taught.tuning {
        let worst = tuning.detectors.iter().filter_map(|it| it.tail).map(|it| it.worst);
        let of = format!("largest |R1|, |R2| seen {}", length(worst.fold(0.0, f64::max)));
        let [low, high] = [tuning.thresholds.low, tuning.thresholds.high].map(four_digits);
        let off = off(taught, Threshold::OfObservers);
        add("δ_l, δ_h of R1 and R2", format!("{}, {}{off}", length(low), length(high)), of);
    }
    let cylinders = || taught.calibration.iter().flat_map(|it| &it.cylinders);
    let sequential = cylinders().filter(|it| it.sequential.is_some());
    let levels: Vec<f64> = sequential.filter_map(|it| it.level).collect();
    let seen: Vec<f64> = result.coverage.iter().map(|it| it.seen).collect();
    if let (Some([low, high]), Some([least, most])) = (ends(&levels), ends(&seen)) {
        let of = format!("{} % of the strokes known", range(100.0 * least, 100.0 * most, 0));
        add("levels, sequential", format!("{} nats", range(low, high, 1)), of);
    }
    let process = cylinders().filter_map(|it| it.process.as_ref()?.table(it.sample_time));
    let learnt: Vec<[bool; 4]> = process
        .map(|it| {
            [it.spool.is_some(), it.chambers.is_some(), it.flow.is_some(), it.friction.is_some()]
        })
        .collect();
    let of_supply = taught.calibration.iter().any(|it| matches!(it.supply, Some(Ok(_))));
    let relations = [
        ("process, by the spool", "a valve that sticks, an offset, a late or other command"),
        ("process, by the pressures", "a pressure sensor that is off, that of the supply too"),
        ("process, by the flow", "leakage, a null that has moved, a changed dead band"),
        ("process, by the friction", "worn or swollen seals, a bent rod"),
    ];
    for (which, (name, finds)) in relations.into_iter().enumerate() {
        let count = learnt.iter().filter(|learnt| learnt[which]).count();
        if count > 0 {
            add(name, super::counted(count as u64, "cylinder"), format!("finds {finds}"));
        }
    }
    if of_supply {
        let finds = "finds a pump that gives less, or to a lower pressure".to_owned();
        add("process, by the supply", "the machine".to_owned(), finds);
    }
    table.about("what was learnt")
}

/// That the detectors of `threshold` are left out.
fn off(taught: &Taught, threshold: Threshold) -> &'static str {
    if taught.is_left_out(threshold) { ": left out" } else { "" }
}

fn ends(values: &[f64]) -> Option<[f64; 2]> {
    let low = values.iter().copied().reduce(f64::min)?;
    Some([low, values.iter().copied().fold(low, f64::max)])
}

fn name(detector: Detector) -> String {
    match detector.basis() {
        Basis::Residual(index) => format!("{} (R{})", detector.label(), index + 1),
        Basis::Readings | Basis::Samples => detector.label().to_owned(),
    }
}

/// Warnings on the healthy machine in the blocks held back.
pub fn trial(result: &Commissioned) -> Section {
    let header = ["detector", "false alarms", "at most, per hour (95 %)", "judged"];
    let mut table = Sheet::new(&header);
    let Some(trial) = &result.trial else { return table.about("") };
    let calibration = result.taught.calibration.as_ref();
    let has_c2 = calibration.is_none_or(Calibration::has_c2);
    let takes_c2 =
        |it: &Detector| matches!(it, Detector::Fde2 | Detector::Fde3 | Detector::Sequential);
    for detector in DETECTORS.into_iter().filter(|it| has_c2 || !takes_c2(it)) {
        if Threshold::of(detector).is_some_and(|it| result.taught.is_left_out(it)) {
            let none = || "–".to_owned();
            table.add_row([name(detector), none(), none(), "left out".to_owned()]);
            continue;
        }
        let all = trial.false_alarms.iter().chain(&trial.of_process);
        let count = all.filter(|it| it.detector == detector).count() as u64;
        let most = poisson_upper(count, CONFIDENCE) / (trial.held / 3600.0);
        let judged = if detector == Detector::Sequential { known(trial) } else { "–".to_owned() };
        table.add_row([name(detector), count.to_string(), format!("{most:.0}"), judged]);
    }
    table.about(format!("trial on {:.1} min held back: as recorded", trial.held / 60.0))
}

/// Both ends with `digits` decimals, or one where they are the same.
fn range(low: f64, high: f64, digits: usize) -> String {
    let [low, high] = [low, high].map(|end| format!("{end:.digits$}"));
    if low == high { low } else { format!("{low} to {high}") }
}

fn known(trial: &Trial) -> String {
    let parts: Vec<f64> = trial.known.iter().map(|(_, part)| *part).collect();
    ends(&parts).map_or("no cylinder".to_owned(), |[low, high]| {
        format!("{} % of the time", range(100.0 * low, 100.0 * high, 0))
    })
}

/// Results of the faults that were tried.
pub fn faults(result: &Commissioned) -> Section {
    let header =
        ["fault", "tried", "found", "median", "95 %", "right", "undecided", "wrong", "no place"];
    let mut table = Sheet::new(&header);
    for kind in result.trial.iter().flat_map(|it| &it.kinds) {
        let KindResult { tried, unplaced, delays, right, undecided, wrong, .. } = kind;
        let seconds =
            |delay: Option<f64>| delay.map_or("–".to_owned(), |it| format!("{it:.2} s"));
        let most = (0.95 * *tried as f64).ceil() as usize;
        table.add_row([
            kind.kind.to_string(),
            tried.to_string(),
            delays.len().to_string(),
            seconds(kind.median()),
            seconds(most.checked_sub(1).and_then(|place| delays.get(place)).copied()),
            right.to_string(),
            undecided.to_string(),
            wrong.to_string(),
            unplaced.to_string(),
        ]);
    }
    table.about(
        "with faults put into each transducer of each cylinder: how soon the first detector warns, \
         and whether it blames the right transducer",
    )
}

/// What a longer recording would add.
pub fn wins(result: &Commissioned) -> Vec<String> {
    coverage::wins(&result.taught, &result.coverage)
}

/// Remarks of each stage beside its tables, each once.
pub fn remarks(result: &Commissioned) -> Vec<String> {
    let taught = &result.taught;
    let mut remarks: Vec<String> = Vec::new();
    let mut add = |remark: String| {
        if !remarks.contains(&remark) {
            remarks.push(remark);
        }
    };
    taught.identification.iter().flat_map(|it| &it.remarks).for_each(|it| add(it.clone()));
    if let Some(calibration) = &taught.calibration {
        let own = calibration.cylinders.iter();
        let own = own.flat_map(|it| it.remarks.iter().map(|remark| (it.number, remark)));
        // An old calibration is not to be had at the first time.
        let own = own.filter(|(_, remark)| !remark.contains("without an earlier calibration"));
        by_cylinders(own.map(|(number, remark)| (number, &**remark)))
            .into_iter()
            .for_each(&mut add);
        calibration.remarks.iter().for_each(|it| add(it.clone()));
    }
    // What was within the level says nothing here.
    let worth = |it: &&String| !it.starts_with(OF_A_LEVEL) || it.contains(WOULD_HAVE_WARNED);
    let tuning = taught.tuning.iter().flat_map(|it| &it.remarks).filter(worth);
    tuning.for_each(|it| add(it.clone()));
    remarks
}

/// Whether the whole configuration can be written.
pub const fn is_good(result: &Commissioned) -> bool {
    matches!(result.verdict.fitness, Fitness::Fit)
}
