//! An identification as a page for people.

use crate::identify::correlate::{LAGS, Whiteness};
use crate::identify::outcome::{CylinderOutcome, Identified, Outcome};
use crate::identify::validate::Score;
use comfy_table::{Table, presets};
use std::fmt::Write as _;

/// The page.
pub fn page(outcome: &Outcome) -> String {
    let mut text = heading(outcome);
    text += &parameters(outcome);
    text += &character(outcome);
    text += &cross_validation(outcome);
    text += &own_scores(outcome);
    text += &residual_tests(outcome);
    text += &outcome.nonlinear.as_ref().map_or(String::new(), super::nonlinear::section);
    text += &remarks(outcome);
    text
}

fn heading(outcome: &Outcome) -> String {
    let Outcome { fitted, validated, shaping, .. } = outcome;
    let held_back = if fitted == validated {
        "nothing was held back: the scores below are on the data of the fit".to_owned()
    } else {
        format!("validated on {:.1} s to {:.1} s", validated.from, validated.to)
    };
    format!(
        "{}: {}\nfitted on {:.1} s to {:.1} s, {held_back}; monitored states only\nmoving average \
         of velocity and load pressure over {} cycles\n\n",
        outcome.machine, outcome.inputs, fitted.from, fitted.to, shaping.window
    )
}

fn table(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.force_no_tty();
    table.set_header(header.iter().copied());
    table
}

fn identified(outcome: &Outcome) -> impl Iterator<Item = (&CylinderOutcome, &Identified)> {
    outcome.cylinders.iter().filter_map(|c| c.result.as_ref().ok().map(|own| (c, own)))
}

fn parameters(outcome: &Outcome) -> String {
    let header = ["cylinder", "θ1", "θ2", "θ3", "θ4", "θ5", "γ1", "γ2", "offset", "rows"];
    let mut table = table(&header);
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
    if table.is_empty() {
        return String::new();
    }
    format!(
        "parameters of (4-1), with standard errors (lower bounds: residuals are not white)\n{table}\n\n"
    )
}

fn character(outcome: &Outcome) -> String {
    let header = ["cylinder", "poles", "gain u→l̇", "observable", "(4-7)", "(4-8)"];
    let mut table = table(&header);
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
            pressure.map_or("–".to_owned(), |row| format!("{:.0}", row.condition)),
        ]);
    }
    if table.is_empty() {
        return String::new();
    }
    format!(
        "poles, gain, observability from the position, condition numbers of the regressors\n{table}\n\n"
    )
}

/// Figure 4-3 as a table.
fn cross_validation(outcome: &Outcome) -> String {
    let tried: Vec<u8> = outcome
        .cylinders
        .iter()
        .filter(|cylinder| cylinder.trials.is_some())
        .map(|cylinder| cylinder.number)
        .collect();
    let Some(choice) = outcome.choice else { return String::new() };
    let mut header = vec!["model of".to_owned()];
    header.extend(tried.iter().map(|on| format!("on {on}")));
    header.push("worst".to_owned());
    let mut table = table(&header.iter().map(String::as_str).collect::<Vec<_>>());
    for (cylinder, _) in identified(outcome) {
        let of = cylinder.number;
        let mut row = vec![of.to_string()];
        row.extend(tried.iter().map(|on| {
            outcome.simulated(of, *on).map_or("–".to_owned(), |fit| percent(&fit.position))
        }));
        row.push(outcome.worst(of).map_or("–".to_owned(), |worst| format!("{worst:.2}")));
        table.add_row(row);
    }
    let why = if choice.asked { "as asked for" } else { "its worst is the best" };
    format!(
        "position VAF in %, simulated open loop (Figure 4-3)\n{table}\n\nthe model of cylinder {} \
         is taken: {why}, {:.2} %\n\n",
        choice.of, choice.worst
    )
}

fn percent(score: &Score) -> String {
    format!("{:.2}", score.vaf())
}

fn own_scores(outcome: &Outcome) -> String {
    let Some(choice) = outcome.choice else { return String::new() };
    let header = ["cylinder", "", "VAF l", "RMS l", "worst l", "VAF l̇", "RMS l̇", "worst l̇"];
    let mut table = table(&header);
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
                format!("{:.3} mm", l.rms() * 1e3),
                format!("{:.2} mm", l.largest() * 1e3),
                format!("{:.3} %", v.vaf()),
                format!("{:.2} mm/s", v.rms() * 1e3),
                format!("{:.1} mm/s", v.largest() * 1e3),
            ]);
        }
    }
    format!(
        "the taken model on every cylinder: simulated open loop, and predicted by the observer from \
         one cycle to the next\n{table}\n\n"
    )
}

/// Figure 4-9 as a table.
fn residual_tests(outcome: &Outcome) -> String {
    let Some(choice) = outcome.choice else { return String::new() };
    let header =
        ["cylinder", "residual", "r(1)", "auto beyond", "with u beyond", "Ljung-Box Q", "p", ""];
    let mut table = table(&header);
    for cylinder in &outcome.cylinders {
        let Some(tried) = outcome.tried(choice.of, cylinder.number) else { continue };
        for (name, whiteness) in ["l", "l̇"].into_iter().zip(&tried.whiteness) {
            let Some(whiteness) = whiteness else { continue };
            table.add_row(tests_of(cylinder.number, name, whiteness));
        }
    }
    if table.is_empty() {
        return String::new();
    }
    format!(
        "residuals of the prediction (Figure 4-9): correlations beyond the 99 % bounds, of {LAGS} \
         lags with themselves and {} with the command\n{table}\n\nthe loop was closed when this was \
         recorded: the command depends on past positions, so a correlation with it is no proof \
         against the model\n",
        LAGS + 1
    )
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

fn remarks(outcome: &Outcome) -> String {
    let mut text = String::new();
    let mut told: Vec<(&str, Vec<u8>)> = Vec::new();
    for cylinder in &outcome.cylinders {
        for remark in &cylinder.remarks {
            match told.iter_mut().find(|(known, _)| known == remark) {
                Some((_, numbers)) => numbers.push(cylinder.number),
                None => told.push((remark, vec![cylinder.number])),
            }
        }
    }
    for (remark, numbers) in told {
        let numbers: Vec<String> = numbers.iter().map(u8::to_string).collect();
        _ = writeln!(text, "cylinder {}: {remark}", numbers.join(", "));
    }
    for cylinder in &outcome.cylinders {
        if let Err(refusal) = &cylinder.result {
            _ = writeln!(text, "cylinder {} is refused: {refusal}", cylinder.number);
        }
    }
    for remark in &outcome.remarks {
        _ = writeln!(text, "{remark}");
    }
    if text.is_empty() { text } else { format!("\n{text}") }
}
