//! An identification as a page for people.

use super::sheet::{Section, Sheet};
use crate::report::ReadWith;
use std::fmt::Write as _;
use tertius_core::text::Millimetres;
use tertius_learn::identify::correlate::{LAGS, Whiteness};
use tertius_learn::identify::outcome::{CylinderOutcome, Identified, Outcome};
use tertius_learn::identify::qr::Regression;
use tertius_learn::identify::validate::SignalScore;
use tertius_learn::tables::cylinders::by_cylinders;

/// The page; the recordings were read with the configuration `with`.
pub fn page(outcome: &Outcome, with: &ReadWith) -> String {
    let Outcome { machine, inputs, .. } = outcome;
    let mut text = format!("{machine}: {inputs} with {with}\n{}\n", parts(outcome));
    for section in [parameters(outcome), character(outcome), cross_validation(outcome)] {
        text += &spaced(&section.text());
    }
    text += &spaced(&taken(outcome));
    text += &spaced(&own_scores(outcome).text());
    let tests = residual_tests(outcome).text();
    if !tests.is_empty() {
        text += &format!("{tests}\n{CLOSED_LOOP}\n");
    }
    text += &outcome.nonlinear.as_ref().map_or(String::new(), super::nonlinear::section);
    let remarks = remarks(outcome);
    if !remarks.is_empty() {
        text += &format!("\n{remarks}");
    }
    text
}

/// Caveat about a correlation of a residual with the command.
pub const CLOSED_LOOP: &str = "the loop was closed when this was recorded: the command depends on \
                               past positions, so a correlation with it is no proof against the \
                               model";

/// `text` with an empty line after it; empty where `text` is.
fn spaced(text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("{text}\n") }
}

/// Parts of the recording that were used, and how.
pub fn parts(outcome: &Outcome) -> String {
    let Outcome { fitted, validated, shaping, .. } = outcome;
    let held_back = if fitted == validated {
        "nothing was held back: the scores below are on the data of the fit".to_owned()
    } else {
        format!("validated on {:.1} s to {:.1} s", validated.from, validated.to)
    };
    format!(
        "fitted on {:.1} s to {:.1} s, {held_back}; monitored states only\nmoving average \
         of velocity and load pressure over {} cycles\n",
        fitted.from, fitted.to, shaping.window
    )
}

fn identified(outcome: &Outcome) -> impl Iterator<Item = (&CylinderOutcome, &Identified)> {
    outcome.cylinders.iter().filter_map(|c| c.result.as_ref().ok().map(|own| (c, own)))
}

/// θ and γ of each cylinder, with their errors.
pub fn parameters(outcome: &Outcome) -> Section {
    let header = ["cylinder", "θ1", "θ2", "θ3", "θ4", "θ5", "γ1", "γ2", "offset", "rows"];
    let mut table = Sheet::new(&header);
    for (cylinder, own) in identified(outcome) {
        let estimate = &own.estimate;
        let values = estimate.theta.iter().chain(&estimate.gamma);
        let errors = estimate.theta_errors.iter().chain(&estimate.gamma_errors);
        let mut row = vec![cylinder.number.to_string()];
        row.extend(values.clone().map(|value| format!("{value:.5e}")));
        row.push(estimate.command_offset.map_or("–".to_owned(), |offset| format!("{offset:.4}")));
        row.push(estimate.velocity_row.rows.to_string());
        table.add_row(row);
        let mut row = vec!["  ±".to_owned()];
        row.extend(errors.map(|error| format!("{error:.1e}")));
        table.add_row(row);
    }
    table.about("parameters of (4-1), with standard errors (lower bounds: residuals are not white)")
}

/// Characteristics of the models.
pub fn character(outcome: &Outcome) -> Section {
    let header =
        ["cylinder", "poles", "gain u→l̇", "observable", "(4-7)", "explains", "(4-8)", "explains"];
    let mut table = Sheet::new(&header);
    for (cylinder, own) in identified(outcome) {
        let poles = own.poles.map_or("not finite".to_owned(), |poles| {
            let one = |pole: nalgebra::Complex<f64>| match pole.im {
                0.0 => format!("{:.5}", pole.re),
                im => format!("{:.5}{im:+.5}i", pole.re),
            };
            poles.map(one).join("  ")
        });
        let observable = format!(
            "rank {}, condition {:.1e}",
            own.observability.rank, own.observability.condition
        );
        let estimate = &own.estimate;
        let pressure = estimate.pressure_row.as_ref();
        table.add_row([
            cylinder.number.to_string(),
            poles,
            own.velocity_gain.map_or("none".to_owned(), |gain| format!("{gain:.4}")),
            observable,
            format!("{:.0}", estimate.velocity_row.condition),
            share(&estimate.velocity_row),
            pressure.map_or("–".to_owned(), |row| format!("{:.0}", row.condition)),
            pressure.map_or("–".to_owned(), share),
        ]);
    }
    table.about(
        "poles, gain, observability from the position; for the regressions (4-7) and (4-8) the condition \
         numbers of the regressors, and how much they explain of the change from one cycle to the next",
    )
}

fn share(row: &Regression) -> String {
    format!("{:.1} %", 100.0 * row.share())
}

/// Figure 4-3 as a table.
pub fn cross_validation(outcome: &Outcome) -> Section {
    let tried: Vec<u8> = outcome
        .cylinders
        .iter()
        .filter(|cylinder| cylinder.trials.is_some())
        .map(|cylinder| cylinder.number)
        .collect();
    if outcome.choice.is_none() {
        return Section::default();
    }
    let mut header = vec!["model of".to_owned()];
    header.extend(tried.iter().map(|on| format!("on {on}")));
    header.push("worst".to_owned());
    let mut table = Sheet::new(&header);
    for (cylinder, _) in identified(outcome) {
        let of = cylinder.number;
        let mut row = vec![of.to_string()];
        row.extend(tried.iter().map(|on| {
            outcome.simulated(of, *on).map_or("–".to_owned(), |fit| percent(&fit.position))
        }));
        row.push(outcome.worst(of).map_or("–".to_owned(), |worst| format!("{worst:.2}")));
        table.add_row(row);
    }
    table.about("position VAF in %, simulated open loop (Figure 4-3)")
}

/// The model that was chosen, and why; empty where there is none.
pub fn taken(outcome: &Outcome) -> String {
    let Some(choice) = outcome.choice else { return String::new() };
    let why = if choice.asked { "as requested" } else { "its worst is the best" };
    format!("the model of cylinder {} is chosen: {why}, {:.2} %\n", choice.of, choice.worst)
}

fn percent(score: &SignalScore) -> String {
    format!("{:.2}", score.vaf())
}

/// Results of the chosen model on each cylinder.
pub fn own_scores(outcome: &Outcome) -> Section {
    let Some(choice) = outcome.choice else { return Section::default() };
    let header = ["cylinder", "by", "VAF l", "RMS l", "worst l", "VAF l̇", "RMS l̇", "worst l̇"];
    let mut table = Sheet::new(&header);
    for cylinder in &outcome.cylinders {
        let Some(tried) = outcome.tried(choice.of, cylinder.number) else { continue };
        for (name, fit) in [("simulated", &tried.simulated), ("predicted", &tried.predicted)] {
            let (l, v) = (&fit.position, &fit.velocity);
            if l.count() == 0 {
                continue;
            }
            table.add_row([
                if name == "simulated" { cylinder.number.to_string() } else { String::new() },
                name.to_owned(),
                format!("{:.3} %", l.vaf()),
                format!("{:.3}", Millimetres(l.rms())),
                format!("{:.2}", Millimetres(l.largest())),
                format!("{:.3} %", v.vaf()),
                format!("{:.2} mm/s", v.rms() * 1e3),
                format!("{:.1} mm/s", v.largest() * 1e3),
            ]);
        }
    }
    table.about(
        "the chosen model on every cylinder: simulated open loop, and predicted by the observer \
         from \
         one cycle to the next",
    )
}

/// Figure 4-9 as a table.
pub fn residual_tests(outcome: &Outcome) -> Section {
    let Some(choice) = outcome.choice else { return Section::default() };
    let header = [
        "cylinder",
        "residual",
        "r(1)",
        "auto beyond",
        "with u beyond",
        "Ljung-Box Q",
        "p",
        "verdict",
    ];
    let mut table = Sheet::new(&header);
    for cylinder in &outcome.cylinders {
        let Some(tried) = outcome.tried(choice.of, cylinder.number) else { continue };
        for (name, whiteness) in ["l", "l̇"].into_iter().zip(&tried.whiteness) {
            let Some(whiteness) = whiteness else { continue };
            table.add_row(tests_of(cylinder.number, name, whiteness));
        }
    }
    table.about(format!(
        "residuals of the prediction (Figure 4-9): correlations beyond the 99 % bounds, of {LAGS} \
         lags with themselves and {} with the command",
        LAGS + 1
    ))
}

fn tests_of(number: u8, name: &str, whiteness: &Whiteness) -> [String; 8] {
    [
        number.to_string(),
        name.to_owned(),
        format!("{:.3}", whiteness.auto[1]),
        format!("{} of {LAGS}", whiteness.auto_beyond()),
        format!("{} of {}", whiteness.cross_beyond(), LAGS + 1),
        format!("{:.1}", whiteness.ljung_box),
        format!("{:.2e}", whiteness.p_value),
        if whiteness.is_white() { "white".to_owned() } else { "not white".to_owned() },
    ]
}

/// The result in a sentence, and whether it is whole: a model of every cylinder, tried on data held back.
pub fn verdict(outcome: &Outcome) -> (bool, String) {
    let all = outcome.cylinders.len();
    let numbers = || outcome.cylinders.iter().map(|cylinder| cylinder.number);
    let identified = numbers().filter(|number| outcome.identified(*number).is_some()).count();
    let own = numbers().filter_map(|number| outcome.simulated(number, number));
    let worst = own.map(|fit| fit.position.vaf()).reduce(f64::min);
    let fit = worst.map_or_else(
        || "none was tried on data held back".to_owned(),
        |vaf| {
            format!("each explains at least {vaf:.1} % of its own motion in the data held back (VAF, open loop)")
        },
    );
    (
        identified == all && worst.is_some(),
        format!("{identified} of {all} cylinders have a model; {fit}."),
    )
}

/// Remarks, one line each.
pub fn remarks(outcome: &Outcome) -> String {
    let mut text = String::new();
    let own = outcome.cylinders.iter();
    let own = own.flat_map(|it| it.remarks.iter().map(|remark| (it.number, &**remark)));
    for line in by_cylinders(own) {
        _ = writeln!(text, "{line}");
    }
    for cylinder in &outcome.cylinders {
        if let Err(refusal) = &cylinder.result {
            _ = writeln!(text, "cylinder {} is refused: {refusal}", cylinder.number);
        }
    }
    for remark in &outcome.remarks {
        _ = writeln!(text, "{remark}");
    }
    text
}
