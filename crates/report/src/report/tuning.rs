//! A tuning as a page for people.

use super::sheet::{Section, Sheet};
use crate::report::ReadWith;
use std::fmt::Write as _;
use tertius_core::text::Millimetres;
use tertius_learn::extremes::{HOURS_PER_YEAR, four_digits, per_second, times};
use tertius_learn::tables::tuning::{length, meaning, name, sequential_meaning};
use tertius_learn::tune::criterion::STEP;
use tertius_learn::tune::{Score, Search, Thresholds, Tuning, Weights};

/// The page; the recordings were read with the configuration `with`.
pub fn page(result: &Tuning, with: &ReadWith) -> String {
    let Tuning { machine, inputs, .. } = result;
    let mut text = format!("{machine}: {inputs} with {with}\n{}\n\n", part(result));
    text += &format!("{}{}\n\n", search(&result.search).text(), tried(&result.search));
    text += &format!("{}\n{}\n", tails(result).text(), ladder(result).text());
    text += &format!("{}\n{}", thresholds(result), sensitivity(result).text());
    text += &sequential(result);
    for (place, remark) in result.remarks.iter().enumerate() {
        _ = writeln!(text, "{}{remark}", if place == 0 { "\n" } else { "" });
    }
    text
}

/// Part of the recording that was used.
pub fn part(result: &Tuning) -> String {
    let (from, to) = (result.window.from, result.window.to);
    format!("tuned on {from:.1} s to {to:.1} s; monitored states only")
}

/// The weights before and after.
pub fn search(search: &Search) -> Section {
    let header =
        ["weights", "q", "r", "threshold", "of 1 mm", "of (5-18)", "over after", "criterion"];
    let mut table = Sheet::new(&header);
    for (name, weights, score) in
        [("configured", &search.begun, &search.before), ("taken", &search.weights, &search.score)]
    {
        let Weights { q, r } = weights;
        let Score { threshold, peak, incipient, settled, times } = score;
        table.add_row([
            name.to_owned(),
            format!("{:.2e} {:.2e} {:.2e}", q[0], q[1], q[2]),
            format!("{:.2e} {:.2e}", r[0], r[1]),
            format!("{:.3}", Millimetres(*threshold)),
            format!("{:.2}", Millimetres(peak * STEP)),
            format!("{:.2}", Millimetres(*incipient)),
            format!("{settled} cycles"),
            if times.is_finite() { format!("{times:.2}") } else { "not sharp".to_owned() },
        ]);
    }
    table.about(
        "weights: the criterion is the threshold at the wanted rate (by exponential tails) divided \
         by the residual of a step of 1 mm within 0.1 s, or of the incipient fault (5-18) of 70 mm \
        and b = 1 averaged over its onset, whichever is less; at 1 and below both are seen. Nine \
        tenths of a step have to be over within alarm.coincidence",
    )
}

/// Extent of the search.
pub fn tried(search: &Search) -> String {
    format!("{} sets of weights tried on {} stored cycles", search.tried, search.cycles)
}

/// The tail of each residual.
pub fn tails(result: &Tuning) -> Section {
    let header = [
        "cylinder",
        "residual",
        "hours",
        "RMS",
        "99.9 %",
        "largest",
        "beyond",
        "peaks",
        "mean excess",
        "Pareto ξ",
        "σ",
        "taken",
        "level alone",
    ];
    let mut table = Sheet::new(&header);
    let rate = per_second(result.thresholds.per_year) / result.detectors.len() as f64;
    for detector in &result.detectors {
        let Some(tail) = &detector.tail else { continue };
        let [number, residual] = name(detector);
        table.add_row([
            number,
            residual,
            format!("{:.4}", tail.seconds / 3600.0),
            format!("{:.3}", Millimetres(detector.residuals.rms())),
            format!("{:.3}", Millimetres(detector.magnitudes.quantile(0.999).unwrap_or(0.0))),
            format!("{:.3}", Millimetres(tail.worst)),
            format!("{:.3}", Millimetres(tail.floor)),
            tail.peaks.to_string(),
            format!("{:.4}", Millimetres(tail.mean)),
            format!("{:.2}", tail.pareto.shape),
            format!("{:.4}", Millimetres(tail.pareto.scale)),
            if tail.heavy { "Pareto".to_owned() } else { "exponential".to_owned() },
            format!("{:.3} ± {:.3} mm", tail.level(rate) * 1e3, tail.error(rate) * 1e3),
        ]);
    }
    table.about(
        "healthy residuals, and the tail of the largest of each second (of alarm.clear): a \
         generalised Pareto where it is heavier than an exponential beyond chance (5 %), as far as \
         it was seen; level \
         alone: at the detector's equal share of the wanted rate, ± the error from the number of \
         peaks",
    )
}

/// Thresholds at other rates.
pub fn ladder(result: &Tuning) -> Section {
    let mut table =
        Sheet::new(&["false alarms a year", "one in", "threshold", "beyond the evidence"]);
    let hours = result.thresholds.hours;
    let wanted = (result.thresholds.per_year, result.thresholds.high);
    let mut rows = result.ladder.clone();
    if rows.iter().all(|(rate, _)| *rate != wanted.0) {
        rows.push(wanted);
    }
    rows.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (rate, level) in rows {
        let mark = if rate == wanted.0 { " ←" } else { "" };
        table.add_row([
            format!("{rate}{mark}"),
            period(HOURS_PER_YEAR / rate),
            length(four_digits(level)),
            format!("{} times", times(HOURS_PER_YEAR / rate / hours)),
        ]);
    }
    table.about("the extrapolation, of all detectors together")
}

fn period(hours: f64) -> String {
    match hours {
        hours if hours < 1.0 => format!("{:.1} min", hours * 60.0),
        hours if hours < 48.0 => format!("{hours:.1} h"),
        hours => format!("{:.0} days", hours / 24.0),
    }
}

/// Both thresholds, and their meaning.
pub fn thresholds(result: &Tuning) -> String {
    let Thresholds { low, high, .. } = result.thresholds;
    format!(
        "δ_l {}, δ_h {}\n  {}\n",
        length(four_digits(low)),
        length(four_digits(high)),
        meaning(result).join("\n  ")
    )
}

/// The result in a sentence, and whether it is within what was recorded: a threshold at the thesis's own.
pub fn verdict(result: &Tuning) -> (bool, String) {
    let Thresholds { low, high, .. } = result.thresholds;
    let steps = || result.detectors.iter().map(|detector| detector.step);
    let largest = steps().flatten().reduce(f64::max).filter(|_| steps().all(|step| step.is_some()));
    let step = largest.map_or_else(
        || "not every transducer has a step that is surely found".to_owned(),
        |step| format!("steps from {} on are found on every transducer", length(step)),
    );
    let [low, high] = [low, high].map(|it| length(four_digits(it)));
    (largest.is_some(), format!("R1 and R2 raise at {high} and clear below {low}: {step}."))
}

/// Smallest faults that are found.
pub fn sensitivity(result: &Tuning) -> Section {
    let mut table =
        Sheet::new(&["cylinder", "transducer", "smallest step", "smallest noise", "n of n·σ"]);
    for detector in &result.detectors {
        let [number, _] = name(detector);
        let amplitude = detector.noise.map_or("–".to_owned(), length);
        let times = detector.noise.map_or("–".to_owned(), |n| format!("{:.1}", n / result.sigma));
        table.add_row([
            number,
            format!("C{}", detector.transducer + 1),
            detector.step.map_or("–".to_owned(), length),
            amplitude,
            times,
        ]);
    }
    table.about(format!(
        "what is found: steps within 0.1 s in 95 % of the stored places, noise (5-17) within 1 s in \
         95 % of trials; σ = {:.3}",
        Millimetres(result.sigma)
    ))
}

/// The level of the sequential detectors, where there are any.
pub fn sequential(result: &Tuning) -> String {
    let Some(level) = &result.sequential else { return String::new() };
    format!(
        "\nsequential detectors: h {:.2} nats\n  {}\n",
        four_digits(level.nats),
        sequential_meaning(level, result.thresholds.per_year).join("\n  ")
    )
}
