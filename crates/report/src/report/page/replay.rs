//! The page of a replay.

use super::axis::Axis;
use super::figure::{Band, Curve, Figure, FigureMark, HALF, Level, Panel, Shape, WIDE};
use super::palette;
use super::recorder::{Bounds, Gathered, Raised, Recorded};
use super::zoom::Zoom;
use super::{Page, histogram::Histogram, incidents, stops};
use crate::report::human::{self, Heading, Notices};
use crate::report::{Summary, verdict, wording};
use tertius_config::MachineNames;
use tertius_core::alarm::Detector;
use tertius_core::alarm::detector::Basis;
use tertius_core::text::Millimetres;

const TIME: &str = "time since the first frame";

const RESIDUALS: [&str; 3] = ["R1", "R2", "R3"];

/// Range of the residuals' scale, as a multiple of the threshold; values beyond are drawn as
/// triangles at the border.
const SCALE: f64 = 8.0;

/// The whole page, from the same facts as the text for a terminal.
pub fn page(
    heading: &Heading<'_>,
    summary: &Summary<'_>,
    notices: &Notices,
    recorded: &Recorded,
) -> String {
    let mut page = Page::new("replay", &format!("Replay: {}", heading.machine));
    let (inputs, config) = (heading.inputs, heading.config);
    page.paragraph(&format!("{inputs} with {config}: {}", summary.judged_by()));
    page.alarm(&summary.judgement.headline());
    incidents::verdict(&mut page, &verdict::lines(summary, heading.zone), summary);
    for remark in summary.remarks {
        page.alarm(&format!("Look at {remark}."));
    }
    page.lines(&human::overview(summary));
    page.paragraph(&wording::warnings(summary));
    page.contents();
    around_warnings(&mut page, heading, summary, recorded);
    page.heading("Cylinders");
    let rows: Vec<Vec<String>> =
        wording::cylinder_rows(summary).into_iter().map(Vec::from).collect();
    page.table(&wording::CYLINDER_COLUMNS, &rows);
    page.lines(&wording::counter_jumps(summary));
    let known: Vec<Vec<String>> =
        wording::coverage_rows(summary).into_iter().map(Vec::from).collect();
    if !known.is_empty() {
        page.paragraph(&format!("{}.", wording::COVERAGE));
        page.table(&wording::COVERAGE_COLUMNS, &known);
    }
    let known: Vec<Vec<String>> =
        wording::process_rows(summary).into_iter().map(Vec::from).collect();
    if !known.is_empty() {
        page.paragraph(&format!("{}.", wording::PROCESS_COVERAGE));
        page.table(&wording::PROCESS_COLUMNS, &known);
    }
    stops::section(&mut page, summary.stops);
    over_time(&mut page, summary, recorded);
    histograms(&mut page, summary, recorded);
    warnings(&mut page, heading, summary);
    noticed(&mut page, heading, summary, notices);
    let bad = human::what_was_bad(summary);
    if !bad.is_empty() {
        page.heading("What could not be read");
        page.lines(&bad);
    }
    page.finish()
}

fn over_time(page: &mut Page, summary: &Summary<'_>, recorded: &Recorded) {
    let figure = |(n, it)| residuals((n, summary.names), it, recorded);
    let figures: Vec<(Figure, String)> =
        (1..).zip(&recorded.cylinders).filter_map(figure).collect();
    if figures.is_empty() {
        return;
    }
    page.heading("Residuals over time");
    page.paragraph(
        "R1 and R2 are the innovations of the observers on C1 and C2, where they are judged; R3 is C1 \
         minus the calibrated C2. The line goes through the least and the largest value of each \
         step of time, so that no spike is lost.",
    );
    if recorded.jumps > 0 {
        page.paragraph(&format!(
            "The time stamps jumped {}. The figures continue there as if no time had passed, so \
             that after the first jump their time differs from that in the table of warnings.",
            wording::times(recorded.jumps)
        ));
    }
    for (figure, caption) in &figures {
        page.figure(figure, caption);
    }
}

fn mm(metres: f64) -> f64 {
    metres * 1e3
}

fn residuals(
    (number, names): (u8, &MachineNames),
    cylinder: &Gathered,
    recorded: &Recorded,
) -> Option<(Figure, String)> {
    let mut caption = format!("{}: residuals", wording::capitalised(&names.cylinder(number)));
    let mut panels = Vec::new();
    for (i, name) in RESIDUALS.into_iter().enumerate() {
        match cylinder.residuals.extremes(i) {
            Some(extremes) => {
                let (panel, beyond) = residual(i, number, cylinder, extremes, recorded);
                caption += &beyond;
                panels.push(panel);
            }
            None => caption += &format!("\n{name} was never judged."),
        }
    }
    let end = recorded.end();
    let x = Axis::clock(TIME, 0.0, end).with_ticks(9);
    (!panels.is_empty()).then_some((Figure { width: WIDE, x, panels }, caption))
}

/// Panel of one residual, with a remark on values beyond its scale.
fn residual(
    i: usize,
    number: u8,
    cylinder: &Gathered,
    [low, high]: [f64; 2],
    recorded: &Recorded,
) -> (Panel, String) {
    let bounds = cylinder.bounds[i];
    let largest = low.abs().max(high.abs());
    let reach = (1.1 * largest).clamp(1.5 * bounds.high, SCALE * bounds.high);
    let runs = cylinder.residuals.runs(i);
    let runs = runs.into_iter().map(|run| run.into_iter().map(|(t, r)| (t, mm(r))).collect());
    let curve = Curve {
        name: "residual".to_owned(),
        colour: palette::BLUE,
        shape: Shape::Line,
        runs: runs.collect(),
    };
    let y = Axis::linear(&format!("{} (mm)", RESIDUALS[i]), -mm(reach), mm(reach)).with_ticks(5);
    let mut panel = thresholds(Panel::new(105, y, vec![curve]), i, bounds);
    let shows = |raised: &&Raised| {
        raised.cylinder == number && place(raised.detector).is_none_or(|place| place == i)
    };
    panel.marks.extend(marks(recorded.raised.iter().filter(shows)));
    for (name, places) in [("time jump", &recorded.jumped_at), ("bus lost", &recorded.lost_at)] {
        let broken =
            |at: &f64| FigureMark { name: name.to_owned(), colour: palette::GREY, at: *at };
        panel.marks.extend(places.iter().map(broken));
    }
    if i < 2 {
        panel.bands = cylinder.residuals.shaded().into_iter().map(not_judged).collect();
    }
    let mut beyond = String::new();
    if largest > reach {
        beyond = format!(
            "\n{} goes up to {:.2}, beyond its scale: ▲▼ at the border.",
            RESIDUALS[i],
            Millimetres(largest)
        );
    }
    (panel, beyond)
}

/// Adds both thresholds of the residual `i`.
fn thresholds(panel: Panel, i: usize, bounds: Bounds) -> Panel {
    let [low, high] = [bounds.low, bounds.high].map(Millimetres);
    let [clears, raises] = if i < 2 {
        [format!("δ_l of R1, R2: {low:.2}"), format!("δ_h of R1, R2: {high:.2}")]
    } else {
        [format!("R3 clears below {low:.2}"), format!("bound of R3: {high:.2}")]
    };
    panel.with_bounds(&clears, palette::LOW, mm(bounds.low)).with_bounds(
        &raises,
        palette::HIGH,
        mm(bounds.high),
    )
}

/// Index of the residual that a detector judges; `None` where it judges none.
const fn place(detector: Detector) -> Option<usize> {
    match detector.basis() {
        Basis::Residual(index) => Some(index),
        Basis::Readings | Basis::Samples => None,
    }
}

/// Marks of warnings, the worst last, since a mark covers those that were drawn before it.
fn marks<'a>(raised: impl Iterator<Item = &'a Raised>) -> Vec<FigureMark> {
    let mut raised: Vec<&Raised> = raised.collect();
    raised.sort_by_key(|raised| raised.level);
    raised.into_iter().map(mark).collect()
}

fn mark(raised: &Raised) -> FigureMark {
    FigureMark {
        name: format!("warning, {}", raised.level.name()),
        colour: palette::level(raised.level),
        at: raised.t,
    }
}

fn not_judged((from, to): (f64, f64)) -> Band {
    Band { name: "not judged by FDE1, FDE2".to_owned(), colour: palette::PALE, from, to }
}

fn around_warnings(
    page: &mut Page,
    heading: &Heading<'_>,
    summary: &Summary<'_>,
    recorded: &Recorded,
) {
    let shown = recorded
        .zooms
        .iter()
        .map(|zoom| (zoom, zoomed(zoom, recorded), zoom_caption(zoom, heading, summary)));
    incidents::section(page, heading, summary, shown.collect());
    if recorded.not_zoomed > 0 {
        page.paragraph(&format!(
            "The first {} places are drawn; {} warnings elsewhere are not.",
            recorded.zooms.len(),
            recorded.not_zoomed
        ));
    }
}

fn zoom_caption(zoom: &Zoom, heading: &Heading<'_>, summary: &Summary<'_>) -> String {
    let mut caption = wording::capitalised(&summary.names.cylinder(zoom.cylinder));
    if let Some((_, t)) = zoom.warnings.first() {
        caption += &format!(" at {}", wording::clock(*t));
    }
    for (order, t) in &zoom.warnings {
        caption += &match summary.episodes.kept().get(*order) {
            Some(episode) => {
                format!("\n{}", wording::episode_line(heading.zone.first(), episode, summary.names))
            }
            None => format!("\n{}: one more", wording::clock(*t)),
        };
    }
    caption
}

/// The residuals of the detectors that warned with their own thresholds, under the readings.
fn zoomed(zoom: &Zoom, recorded: &Recorded) -> Figure {
    let ends = [zoom.moments.first(), zoom.moments.last()].map(|it| it.map_or(0.0, |it| it.t));
    let raised: Vec<&Raised> =
        zoom.warnings.iter().filter_map(|(order, _)| recorded.raised.get(*order)).collect();
    let mut bands = Vec::new();
    for pair in zoom.moments.windows(2).filter(|pair| pair[0].gated) {
        bands.push((pair[0].t, pair[1].t));
    }
    bands.dedup_by(|next, before| {
        let joins = next.0 <= before.1;
        if joins {
            before.1 = next.1;
        }
        joins
    });
    let mut readings = readings(zoom);
    readings.marks = marks(raised.iter().copied());
    let mut panels = vec![readings];
    for i in 0..3 {
        let own: Vec<&&Raised> =
            raised.iter().filter(|raised| place(raised.detector) == Some(i)).collect();
        let Some(cylinder) = recorded.cylinders.get(usize::from(zoom.cylinder).wrapping_sub(1))
        else {
            continue;
        };
        if own.is_empty() {
            continue;
        }
        let mut panel = residual_around(zoom, i, cylinder.bounds[i]);
        panel.marks = marks(own.into_iter().copied());
        if i < 2 {
            panel.bands = bands.iter().copied().map(not_judged).collect();
        }
        panels.push(panel);
    }
    Figure { width: HALF, x: Axis::clock(TIME, ends[0], ends[1]).with_ticks(4), panels }
}

fn readings(zoom: &Zoom) -> Panel {
    let curve = |name: &str, colour, of: &dyn Fn(usize) -> Option<f64>| {
        let values = zoom.moments.iter().enumerate().map(|(k, moment)| (moment.t, of(k)));
        Curve::broken(name, colour, values)
    };
    let moments = &zoom.moments;
    let curves = vec![
        curve("estimate of C1", palette::SKY, &|k| moments[k].estimates[0]),
        curve("estimate of Ĉ2", palette::ORANGE, &|k| moments[k].estimates[1]),
        curve("C1", palette::BLUE, &|k| moments[k].readings[0]).shaped(Shape::Hairline),
        curve("Ĉ2", palette::VERMILION, &|k| moments[k].readings[1]).shaped(Shape::Hairline),
    ];
    let y = Axis::over("position (m)", curves.iter().flat_map(Curve::values)).with_ticks(4);
    Panel::new(95, y, curves)
}

fn residual_around(zoom: &Zoom, i: usize, bounds: Bounds) -> Panel {
    let values = zoom.moments.iter().map(|moment| (moment.t, moment.residuals[i].map(mm)));
    let curve = Curve::broken("residual", palette::BLUE, values);
    let largest = curve.values().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let reach = (1.1 * largest).max(1.5 * mm(bounds.high));
    let y = Axis::linear(&format!("{} (mm)", RESIDUALS[i]), -reach, reach).with_ticks(4);
    thresholds(Panel::new(95, y, vec![curve]), i, bounds)
}

fn histograms(page: &mut Page, summary: &Summary<'_>, recorded: &Recorded) {
    let figures: Vec<(Figure, String)> =
        (0..3).filter_map(|i| distribution(i, summary.names, recorded)).collect();
    if figures.is_empty() {
        return;
    }
    page.heading("How large the residuals were");
    page.captioned(&figures);
}

/// Histograms of one residual, for all cylinders together and for each.
fn distribution(i: usize, names: &MachineNames, recorded: &Recorded) -> Option<(Figure, String)> {
    let bounds = recorded.cylinders.first()?.bounds[i];
    let mut all = Histogram::new(bounds.high);
    let judged = |cylinder: &&Gathered| cylinder.histograms[i].count() > 0;
    let alike = |cylinder: &&Gathered| cylinder.bounds[i] == bounds;
    let steps = |histogram: &Histogram| {
        histogram.steps().into_iter().map(|(r, count)| (mm(r), count)).collect::<Vec<_>>()
    };
    let mut curves = Vec::new();
    for (n, cylinder) in (1..).zip(&recorded.cylinders) {
        if judged(&cylinder) && alike(&cylinder) {
            all.merge(&cylinder.histograms[i]);
            let name = names.cylinder(n);
            let curve = Curve::line(&name, palette::cylinder(n), steps(&cylinder.histograms[i]));
            curves.push(curve.shaped(Shape::Steps));
        }
    }
    if curves.is_empty() {
        return None;
    }
    let most = steps(&all).iter().fold(0.0, |most: f64, (_, count)| most.max(*count));
    if curves.len() > 1 {
        let together = Curve::line("all cylinders", palette::PALE, steps(&all));
        curves.insert(0, together.shaped(Shape::Bars));
    }
    let reach = mm(all.reach());
    let label = format!("cycles in {:.3}", Millimetres(all.width()));
    let mut panel = Panel::new(190, Axis::log(&label, 0.6, 2.0 * most).with_ticks(6), curves);
    // The same names as the levels of the panels above.
    let levels =
        thresholds(Panel::new(0, Axis::linear("", 0.0, 1.0), Vec::new()), i, bounds).levels;
    let upright = |Level { name, colour, value }| FigureMark { name, colour, at: value };
    panel.marks = levels.into_iter().map(upright).collect();
    let x = Axis::linear(&format!("{} (mm)", RESIDUALS[i]), -reach, reach).with_ticks(7);
    let mut caption = format!("{}: {} values", RESIDUALS[i], all.count());
    if all.beyond() > 0 {
        caption += &format!(", of which {} are beyond the scale", all.beyond());
    }
    Some((Figure::single(HALF, x, panel), caption))
}

fn warnings(page: &mut Page, heading: &Heading<'_>, summary: &Summary<'_>) {
    let episodes = summary.episodes;
    if episodes.kept().is_empty() {
        return;
    }
    page.heading("Warnings");
    let row = |episode| wording::episode_row(heading.zone.first(), episode, summary.names).to_vec();
    let rows: Vec<Vec<String>> = episodes.kept().iter().map(row).collect();
    page.folded(&wording::warnings(summary), |page| page.table(&wording::EPISODE_COLUMNS, &rows));
    if episodes.left_out() > 0 {
        let left_out = episodes.left_out();
        page.paragraph(&format!("… and {left_out} more; --format jsonl gives them all"));
    }
}

fn noticed(page: &mut Page, heading: &Heading<'_>, summary: &Summary<'_>, notices: &Notices) {
    if notices.kept().is_empty() {
        return;
    }
    page.heading("Noticed");
    let row = |notice| wording::notice(heading.zone.first(), notice, summary.names).to_vec();
    let rows: Vec<Vec<String>> = notices.kept().iter().map(row).collect();
    page.table(&["at", "what"], &rows);
    if notices.left_out() > 0 {
        let left_out = notices.left_out();
        page.paragraph(&format!("… and {left_out} more; --format jsonl gives them all"));
    }
}
