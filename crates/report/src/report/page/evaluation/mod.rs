//! The page of an evaluation.

mod contest;

use super::axis::Axis;
use super::figure::{Curve, Figure, HALF, Panel, Shape};
use super::html::capitalised;
use super::{Page, palette};
use crate::report::evaluation;
use plotters::style::RGBColor;
use tertius_config::Fingerprints;
use tertius_lab::evaluate::rows::{RowGroup, RowResult};
use tertius_lab::evaluate::{Delay, Evaluation, Grade, Plan, SIGMA, WITHIN};

/// A kind of fault whose size is an axis.
struct Sized {
    group: RowGroup,
    label: &'static str,
    /// Unit of the axis, in SI units.
    unit: f64,
    /// Index of the time in [`WITHIN`] for which its probability is shown.
    within: usize,
}

const SIZED: [Sized; 4] = [
    Sized { group: RowGroup::Step, label: "step (mm)", unit: 1e-3, within: 0 },
    Sized { group: RowGroup::Noise, label: "noise (σ)", unit: SIGMA, within: 1 },
    Sized { group: RowGroup::Drift, label: "drift (mm/s)", unit: 1e-3, within: 2 },
    Sized { group: RowGroup::Scale, label: "scale (%)", unit: 1e-2, within: 2 },
];

/// Colours of the seas, in order.
const COLOURS: [RGBColor; 6] = [
    palette::BLUE,
    palette::VERMILION,
    palette::GREEN,
    palette::PURPLE,
    palette::ORANGE,
    palette::INK,
];

/// The whole page, from the same tables as the text for a terminal; `with` is the configuration that was evaluated.
pub fn page(plan: &Plan, result: &Evaluation, with: &Fingerprints) -> String {
    let mut page = Page::new("evaluate", &format!("Evaluation: {}", result.machine));
    page.paragraph(&format!("With {with}: {}", evaluation::extent(plan)));
    let figures = [Grade::Fine, Grade::Coarse]
        .into_iter()
        .flat_map(|grade| SIZED.iter().filter_map(move |it| probability(plan, result, it, grade)));
    shown(&mut page, "How probable it is that a fault is found", figures.collect());
    let delays = SIZED.iter().filter_map(|sized| delays(plan, result, sized));
    shown(&mut page, "How long it takes", delays.collect());
    shown(&mut page, "The loop", moved(result).into_iter().collect());
    shown(
        &mut page,
        "Delay against false alarms",
        contest::figures(result.contest.as_deref().unwrap_or_default()),
    );
    page.heading("Tables");
    for section in evaluation::sections(plan, result) {
        page.section(&section);
    }
    page.finish()
}

fn shown(page: &mut Page, heading: &str, figures: Vec<(Figure, String)>) {
    if !figures.is_empty() {
        page.heading(heading);
        page.figures(figures.iter().map(|(figure, caption)| (figure, caption.as_str())));
    }
}

/// Rows of a kind on one grade in one sea, by size.
fn sizes<'a>(
    result: &'a Evaluation,
    sized: &'a Sized,
    grade: Grade,
    sea: [f64; 2],
) -> impl Iterator<Item = (f64, &'a RowResult)> {
    let rows = result.rows.iter().flatten().filter(move |it| {
        it.row.group == sized.group && it.row.cell.grade == grade && it.row.cell.sea == sea
    });
    rows.filter_map(|row| Some((row.size? / sized.unit, row)))
}

/// An axis over the sizes of the curves; logarithmic if they span a decade.
fn by_size(sized: &Sized, curves: &[Curve]) -> Axis {
    let sizes = || curves.iter().flat_map(|curve| curve.runs.iter().flatten()).map(|(x, _)| *x);
    let (low, high) = (sizes().fold(f64::INFINITY, f64::min), sizes().fold(0.0, f64::max));
    if high < 10.0 * low {
        return Axis::linear(sized.label, 0.0, 1.1 * high).with_ticks(7);
    }
    Axis::log(sized.label, 0.8 * low, 1.25 * high).with_ticks(5)
}

fn probability(
    plan: &Plan,
    result: &Evaluation,
    sized: &Sized,
    grade: Grade,
) -> Option<(Figure, String)> {
    let of_sea = |(sea, colour): (&[f64; 2], RGBColor)| {
        let found = sizes(result, sized, grade, *sea).filter_map(|(size, row)| {
            Some((size, 1e2 * row.figures.found[sized.within].found.probability?))
        });
        let points: Vec<(f64, f64)> = found.collect();
        let name = format!("{} m {} s", sea[0], sea[1]);
        [Curve::line(&name, colour, points.clone()), Curve::dots("", colour, points)]
    };
    let seas = plan.extent.seas.iter().zip(COLOURS);
    let curves: Vec<Curve> = seas.flat_map(of_sea).filter(has_points).collect();
    if curves.is_empty() {
        return None;
    }
    let x = by_size(sized, &curves);
    let y = Axis::linear("found (%)", -3.0, 103.0).with_ticks(6);
    let title = format!(
        "{}, {} transducers\nFound within {} s by any detector; the colours are seas.",
        capitalised(sized.group.name()),
        grade.name(),
        WITHIN[sized.within]
    );
    Some((Figure::single(HALF, x, Panel::new(180, y, curves)), title))
}

fn has_points(curve: &Curve) -> bool {
    curve.runs.iter().any(|run| !run.is_empty())
}

/// Median, and the middle 90 %, in the first sea.
fn delays(plan: &Plan, result: &Evaluation, sized: &Sized) -> Option<(Figure, String)> {
    let sea = *plan.extent.seas.first()?;
    let of_grade = |(grade, colour): (Grade, RGBColor)| {
        let curve = |name: &str, which: fn(&Delay) -> Option<f64>| {
            let rows = sizes(result, sized, grade, sea);
            Curve::broken(name, colour, rows.map(|(size, row)| (size, which(&row.figures.delay))))
        };
        [
            curve(grade.name(), |delay| delay.median),
            curve("", |delay| delay.p05).shaped(Shape::Hairline),
            curve("", |delay| delay.p95).shaped(Shape::Hairline),
        ]
    };
    let grades = [(Grade::Fine, palette::BLUE), (Grade::Coarse, palette::VERMILION)];
    let curves: Vec<Curve> = grades.into_iter().flat_map(of_grade).filter(has_points).collect();
    let slowest = curves.iter().flat_map(Curve::values).reduce(f64::max)?;
    let fastest = curves.iter().flat_map(Curve::values).fold(slowest, f64::min);
    let x = by_size(sized, &curves);
    let y = Axis::log("delay (s)", 0.7 * fastest, 1.5 * slowest).with_ticks(5);
    let title = format!(
        "{}\nMedian; the thin lines are 5 % and 95 %. A line ends where fewer are found.",
        capitalised(sized.group.name())
    );
    Some((Figure::single(HALF, x, Panel::new(180, y, curves)), title))
}

/// Displacements by each fault: of C1's reading beside the loop, and of the rod in it.
fn moved(result: &Evaluation) -> Option<(Figure, String)> {
    let rows = || result.rows.iter().flatten();
    let open = rows().filter(|it| it.row.group == RowGroup::Loop && !it.in_loop);
    let points = open.filter_map(|open| {
        let closed = rows().find(|it| it.in_loop && it.label == open.label)?;
        let (reading, rod) = (open.figures.moved?.reading_median, closed.figures.moved?.rod_median);
        (reading > 0.0 && rod > 0.0).then_some((1e3 * reading, 1e3 * rod))
    });
    let points: Vec<(f64, f64)> = points.collect();
    let largest = points.iter().map(|(x, y)| x.max(*y)).reduce(f64::max)?;
    let least = points.iter().map(|(x, y)| x.min(*y)).fold(largest, f64::min);
    let (low, high) = (0.5 * least, 2.0 * largest);
    let axis = |label: &str| Axis::log(label, low, high).with_ticks(5);
    let curves = vec![
        Curve::line("as far", palette::GREY, vec![(low, low), (high, high)])
            .shaped(Shape::Hairline),
        Curve::dots("a kind and size of fault", palette::VERMILION, points),
    ];
    let panel = Panel::new(220, axis("displacement of the rod in the loop (mm)"), curves);
    let title = "What the controller does with a faulty C1\nBeside the loop C1's reading is off \
        and the rod moves as before; in the loop C1 stays near its reference and the rod is \
    displaced.";
    Some((Figure::single(HALF, axis("error of C1 beside the loop (mm)"), panel), title.to_owned()))
}
