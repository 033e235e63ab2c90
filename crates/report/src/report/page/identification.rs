//! The page of an identification.

use super::axis::Axis;
use super::curves;
use super::figure::{Curve, Figure, HALF, Level, Panel, Shape, WIDE};
use super::html::{Captioned, capitalised};
use super::{Page, palette};
use crate::report::ReadWith;
use crate::report::identification as text;
use tertius_learn::identify::correlate::{LAGS, Whiteness};
use tertius_learn::identify::outcome::{CylinderOutcome, Outcome};
use tertius_learn::identify::validate::{Shown, Trials};

/// Length of the excerpt that shows single cycles, s.
const STRETCH: f64 = 12.0;

const TIME: &str = "time since the first frame";

/// The whole page; the recordings were read with the configuration `with`.
pub fn page(outcome: &Outcome, with: &ReadWith) -> String {
    let mut page = Page::new("identify", &format!("Identification: {}", outcome.machine));
    page.paragraph(&format!("{} with {with}", outcome.inputs));
    page.verdict(&text::verdict(outcome));
    page.contents();
    add(&mut page, outcome);
    page.finish()
}

/// Adds everything except the origin of the data.
pub fn add(page: &mut Page, outcome: &Outcome) {
    page.lines(&capitalised(&text::parts(outcome)));
    page.lines(&text::remarks(outcome));
    page.heading("The model (4-1)");
    page.section(&text::parameters(outcome));
    page.section(&text::character(outcome));
    page.section(&text::cross_validation(outcome));
    page.paragraph(&capitalised(&text::taken(outcome)));
    page.section(&text::own_scores(outcome));
    tried(page, outcome);
    let tests = text::residual_tests(outcome);
    if !tests.sheet.rows.is_empty() {
        page.heading("Residuals of the prediction (Figure 4-9)");
        page.section(&tests);
        page.paragraph(&capitalised(text::CLOSED_LOOP));
        page.captioned(&shown(outcome, correlations));
    }
    show_data(page, outcome);
    if let Some(nonlinear) = &outcome.nonlinear {
        curves::add(page, nonlinear);
    }
}

/// Figures by `of` for each cylinder that was tried.
fn shown(
    outcome: &Outcome,
    of: impl Fn(&Outcome, &CylinderOutcome, &Trials) -> Vec<Captioned>,
) -> Vec<Captioned> {
    let tried = outcome.cylinders.iter().filter_map(|it| Some((it, it.trials.as_ref()?)));
    tried.flat_map(|(cylinder, trials)| of(outcome, cylinder, trials)).collect()
}

/// Values by `of` for each cycle, broken where cycles are missing.
fn over_time(
    name: &str,
    colour: plotters::style::RGBColor,
    excerpt: &[Shown],
    sample_time: f64,
    of: impl Fn(&Shown) -> Option<f64>,
) -> Curve {
    let mut values = Vec::new();
    for (place, shown) in excerpt.iter().enumerate() {
        let t = shown.sample.t;
        let before = place.checked_sub(1).map(|before| excerpt[before].sample.t);
        if before.is_some_and(|before| t - before > 1.5 * sample_time) {
            values.push((t, None));
        }
        values.push((t, of(shown)));
    }
    Curve::broken(name, colour, values)
}

fn panel(height: u32, label: &str, curves: Vec<Curve>) -> Panel {
    let y = Axis::over(label, curves.iter().flat_map(Curve::values)).with_ticks(4);
    Panel::new(height, y, curves)
}

fn time_axis(excerpt: &[Shown], ticks: usize) -> Axis {
    let ends = [excerpt.first(), excerpt.last()].map(|it| it.map_or(0.0, |it| it.sample.t));
    Axis::clock(TIME, ends[0], ends[1]).with_ticks(ticks)
}

/// Adds the comparison of the model with the readings, on the part that was held back.
fn tried(page: &mut Page, outcome: &Outcome) {
    let figures = shown(outcome, |outcome, cylinder, trials| {
        simulated(outcome, cylinder, trials).into_iter().collect()
    });
    if figures.is_empty() {
        return;
    }
    page.heading("Simulated and observed");
    let where_from = if outcome.fitted == outcome.validated {
        "on the beginning of the data of the fit"
    } else {
        "on the beginning of the part that was held back"
    };
    page.paragraph(&format!(
        "Each cylinder's own model {where_from}: simulated open loop by the commands alone, and \
         predicted by the observer from one cycle to the next; below them the errors (recorded \
         minus model)."
    ));
    for (figure, caption) in &figures {
        page.figure(figure, caption);
    }
}

fn simulated(outcome: &Outcome, cylinder: &CylinderOutcome, trials: &Trials) -> Option<Captioned> {
    let excerpt = &trials.excerpt[..];
    let sample_time = outcome.shaping.sample_time;
    if excerpt.is_empty() {
        return None;
    }
    let curve = |name: &str, colour, of: &dyn Fn(&Shown) -> Option<f64>| {
        over_time(name, colour, excerpt, sample_time, of)
    };
    let mut panels = Vec::new();
    for (i, [signal, error]) in
        [["position (m)", "error (mm)"], ["velocity (m/s)", "error (mm/s)"]].into_iter().enumerate()
    {
        let recorded = |it: &Shown| if i == 0 { it.sample.l } else { it.sample.v };
        // What the observer is led by is the velocity as it came.
        let led = move |it: &Shown| {
            if i == 0 { it.sample.l } else { it.sample.raw_v.unwrap_or(it.sample.v) }
        };
        panels.push(panel(
            110,
            signal,
            vec![
                curve("recorded", palette::INK, &|it| Some(recorded(it))),
                curve("simulated", palette::VERMILION, &|it| Some(it.simulated[i])),
                curve("predicted", palette::SKY, &|it| it.predicted.map(|p| p[i]))
                    .shaped(Shape::Hairline),
            ],
        ));
        let simulated = |it: &Shown| Some(1e3 * (recorded(it) - it.simulated[i]));
        let predicted = move |it: &Shown| it.predicted.map(|p| 1e3 * (led(it) - p[i]));
        panels.push(panel(
            80,
            error,
            vec![
                curve("simulated", palette::VERMILION, &simulated),
                curve("predicted", palette::SKY, &predicted).shaped(Shape::Hairline),
            ],
        ));
    }
    let figure = Figure { width: WIDE, x: time_axis(excerpt, 9), panels };
    Some((figure, format!("Cylinder {}: position and velocity", cylinder.number)))
}

fn correlations(outcome: &Outcome, cylinder: &CylinderOutcome, _: &Trials) -> Vec<Captioned> {
    let number = cylinder.number;
    let tried = outcome.choice.and_then(|choice| outcome.tried(choice.of, number));
    let Some(tried) = tried else { return Vec::new() };
    let whiteness = ["position", "velocity"].into_iter().zip(&tried.whiteness);
    let known: Vec<(&str, &Whiteness)> =
        whiteness.filter_map(|(name, it)| Some((name, it.as_ref()?))).collect();
    if known.is_empty() {
        return Vec::new();
    }
    let lags = LAGS as f64;
    let panel = |name: &str, values: Vec<(f64, f64)>, bound: f64| {
        // One stem for each lag, from zero.
        let stems = values.iter().map(|(lag, r)| vec![(*lag, 0.0), (*lag, *r)]).collect();
        let curve = Curve {
            name: "correlation".to_owned(),
            colour: palette::BLUE,
            shape: Shape::Line,
            runs: stems,
        };
        let reach = values.iter().map(|(_, r)| r.abs()).fold(1.3 * bound, f64::max);
        let y = Axis::linear(name, -1.08 * reach, 1.08 * reach).with_ticks(4);
        let panel = Panel::new(85, y, vec![curve]);
        let zero = Level { name: String::new(), colour: palette::GREY, value: 0.0 };
        let mut panel = panel.with_bounds("99 % of white noise", palette::RED, bound);
        panel.levels.push(zero);
        panel
    };
    let auto = known.iter().map(|(name, it)| {
        let values = it.auto.iter().enumerate().skip(1).map(|(lag, r)| (lag as f64, *r)).collect();
        panel(name, values, it.bound)
    });
    let cross = known.iter().map(|(name, it)| {
        let values = it.cross.iter().enumerate().map(|(k, r)| (k as f64 - lags, *r)).collect();
        panel(&format!("{name} with u"), values, it.bound)
    });
    let [auto, cross]: [Vec<Panel>; 2] = [auto.collect(), cross.collect()];
    let axis = |low: f64| Axis::linear("lag (cycles)", low, lags + 0.5).with_ticks(7);
    vec![
        (
            Figure { width: HALF, x: axis(0.0), panels: auto },
            format!("Cylinder {number}: residuals with themselves"),
        ),
        (
            Figure { width: HALF, x: axis(-lags - 0.5), panels: cross },
            format!(
                "Cylinder {number}: residuals with the command\nat positive lags the command was \
                 there first"
            ),
        ),
    ]
}

/// Adds the recorded signals and those that the fit used.
fn show_data(page: &mut Page, outcome: &Outcome) {
    let figures = shown(outcome, |outcome, cylinder, trials| {
        smoothed(outcome, cylinder, trials).into_iter().collect()
    });
    if figures.is_empty() {
        return;
    }
    page.heading("Data and smoothed data");
    page.paragraph(&format!(
        "The beginning of the part that the models were tried on, {STRETCH:.0} s of it."
    ));
    page.captioned(&figures);
}

fn smoothed(outcome: &Outcome, cylinder: &CylinderOutcome, trials: &Trials) -> Option<Captioned> {
    let first = trials.excerpt.first()?.sample.t;
    let length = trials.excerpt.iter().take_while(|it| it.sample.t < first + STRETCH).count();
    let excerpt = &trials.excerpt[..length];
    let curve = |name: &str, colour, of: &dyn Fn(&Shown) -> Option<f64>| {
        over_time(name, colour, excerpt, outcome.shaping.sample_time, of)
    };
    let both =
        |label: &str, raw: &dyn Fn(&Shown) -> Option<f64>, mean: &dyn Fn(&Shown) -> Option<f64>| {
            let curves = vec![
                curve("recorded", palette::PALE, raw),
                curve("smoothed", palette::BLUE, mean).shaped(Shape::Hairline),
            ];
            panel(100, label, curves)
        };
    let mut panels = vec![both("velocity (m/s)", &|it| it.sample.raw_v, &|it| Some(it.sample.v))];
    if cylinder.sources.pressure {
        panels.push(both("P_L (bar)", &|it| it.sample.raw_p, &|it| it.sample.p));
    }
    let command = curve("command", palette::GREEN, &|it| Some(it.sample.u));
    panels.push(panel(70, "u (m/s)", vec![command]));
    let figure = Figure { width: HALF, x: time_axis(excerpt, 5), panels };
    Some((figure, format!("Cylinder {}: velocity, load pressure and command", cylinder.number)))
}
