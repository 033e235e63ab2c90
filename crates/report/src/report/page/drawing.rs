//! Draws figures as SVG, with plotters.
//!
//! plotters draws in whole units; there are two of them to a CSS pixel, so that curves are smooth.

use super::axis::Axis;
use super::escaping::escaped;
use super::figure::{Curve, Figure, FigureMark, Panel, Shape};
use super::palette::{GREY, INK};
use plotters::chart::ChartContext;
use plotters::coord::Shift;
use plotters::prelude::{
    Cartesian2d, ChartBuilder, Circle, Color, DrawingArea, IntoDrawingArea, PathElement, Polygon,
    RGBColor, Rectangle, SVGBackend, TRANSPARENT,
};

/// Units of the drawing in a CSS pixel.
const FINE: u32 = 2;

/// Margin around a plot, CSS pixels: room for accents of the y label.
const MARGIN: u32 = 5;
/// Margin at the left of a plot, CSS pixels: ticks and label of y.
const LEFT: u32 = 71;
/// Margin below a plot, CSS pixels: ticks and label of x.
const BELOW: u32 = 42;
/// Margin above a plot, CSS pixels: flags.
const ABOVE: u32 = 10;
/// Margin at the right of a plot, CSS pixels: half a tick's text.
const RIGHT: u32 = 22;
/// Space under a panel that has another one below, CSS pixels.
const BETWEEN: u32 = 4;

/// Font size: plotters divides it by 1.24, so this is 12 CSS pixels.
const TEXT: u32 = 30;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Axis, Axis>>;
type Drawn = Result<(), Box<dyn std::error::Error>>;

/// `figure` as an SVG element of the figure's size.
pub fn svg(figure: &Figure, label: &str) -> String {
    let inner: u32 = figure.panels.iter().map(|panel| panel.height + ABOVE + BETWEEN).sum();
    let (width, height) = (figure.width, inner + BELOW);
    let mut text = String::new();
    draw(figure, &mut text, (FINE * width, FINE * height))
        .expect("a string takes whatever is drawn, and no font is loaded");
    // plotters begins with the size in its units.
    let body = text.split_once('>').map_or("", |(_, body)| body);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" aria-label=\"{}\" width=\"{width}\" \
         height=\"{height}\" viewBox=\"0 0 {} {}\">{body}",
        escaped(label),
        FINE * width,
        FINE * height
    )
}

fn draw(figure: &Figure, text: &mut String, size: (u32, u32)) -> Drawn {
    let root = SVGBackend::with_string(text, size).into_drawing_area();
    let mut rest = root.clone();
    for (place, panel) in figure.panels.iter().enumerate() {
        let last = place + 1 == figure.panels.len();
        let below = if last { BELOW } else { 0 };
        let (area, under) = rest.split_vertically(FINE * (panel.height + ABOVE + BETWEEN + below));
        rest = under;
        draw_panel(&area, &root, &figure.x, panel, last)?;
    }
    root.present()?;
    Ok(())
}

fn draw_panel(area: &Area, root: &Area, x: &Axis, panel: &Panel, last: bool) -> Drawn {
    let mut chart = ChartBuilder::on(area)
        .margin_left(FINE * MARGIN)
        .margin_top(FINE * ABOVE)
        .margin_right(FINE * RIGHT)
        .margin_bottom(FINE * BETWEEN)
        .y_label_area_size(FINE * LEFT)
        .x_label_area_size(if last { FINE * BELOW } else { 0 })
        .build_cartesian_2d(x.clone(), panel.y.clone())?;
    let (low, high) = (panel.y.low(), panel.y.high());
    let shade = |from: f64, to: f64, colour: RGBColor| {
        Rectangle::new([(from, low), (to, high)], colour.mix(0.3).filled())
    };
    chart.draw_series(panel.bands.iter().map(|band| shade(band.from, band.to, band.colour)))?;
    draw_mesh(&mut chart, x, panel, last)?;
    let screen = root.use_screen_coord();
    for mark in panel.marks.iter().filter(|mark| x.holds(mark.at)) {
        draw_mark(&mut chart, &screen, panel, mark)?;
    }
    for level in panel.levels.iter().filter(|level| panel.y.holds(level.value)) {
        let points = vec![(x.low(), level.value), (x.high(), level.value)];
        chart.plotting_area().draw(&PathElement::new(points, level.colour.stroke_width(2)))?;
    }
    for curve in &panel.curves {
        draw_curve(&mut chart, panel, curve)?;
        draw_overflow(&chart, &screen, panel, curve)?;
    }
    let frame = Rectangle::new([(x.low(), low), (x.high(), high)], GREY.stroke_width(1));
    chart.plotting_area().draw(&frame)?;
    Ok(())
}

fn draw_mesh(chart: &mut Chart, x: &Axis, panel: &Panel, last: bool) -> Drawn {
    let text = ("sans-serif", TEXT, &INK);
    let (x_text, y_text) = (|value: &f64| x.text(*value), |value: &f64| panel.y.text(*value));
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(TRANSPARENT)
        .bold_line_style(INK.mix(0.12))
        .axis_style(GREY)
        .label_style(text)
        .axis_desc_style(text)
        .x_label_formatter(&x_text)
        .y_label_formatter(&y_text)
        .y_desc(panel.y.label.as_str());
    if last {
        mesh.x_desc(x.label.as_str());
    }
    mesh.draw()?;
    Ok(())
}

/// Draws a translucent line behind the curves, with a flag above the plot that no curve hides.
fn draw_mark(chart: &mut Chart, screen: &Area, panel: &Panel, mark: &FigureMark) -> Drawn {
    let ends = [(mark.at, panel.y.low()), (mark.at, panel.y.high())];
    let line = PathElement::new(ends.to_vec(), mark.colour.mix(0.5).stroke_width(3));
    chart.plotting_area().draw(&line)?;
    let (x, y) = chart.backend_coord(&ends[1]);
    let flag = vec![(x - 6, y - 12), (x + 6, y - 12), (x, y - 1)];
    screen.draw(&Polygon::new(flag, mark.colour.filled()))?;
    Ok(())
}

fn draw_curve(chart: &mut Chart, panel: &Panel, curve: &Curve) -> Drawn {
    let area = chart.plotting_area();
    let colour = curve.colour;
    for run in curve.runs.iter().filter(|run| !run.is_empty()) {
        match curve.shape {
            Shape::Line if run.len() == 1 => {
                area.draw(&Circle::new(run[0], 2, colour.filled()))?;
            }
            Shape::Line => area.draw(&PathElement::new(run.clone(), colour.stroke_width(2)))?,
            Shape::Hairline => area.draw(&PathElement::new(run.clone(), colour.stroke_width(1)))?,
            Shape::Dots => {
                // At the border they would stand for a value that they do not have.
                for point in run.iter().filter(|(_, y)| panel.y.holds(*y)) {
                    area.draw(&Circle::new(*point, 3, colour.mix(0.6).filled()))?;
                }
            }
            Shape::Steps => area.draw(&PathElement::new(steps(run), colour.stroke_width(2)))?,
            Shape::Bars => {
                let mut points = steps(run);
                let ends = [run[run.len() - 1].0, run[0].0];
                points.extend(ends.map(|x| (x, panel.y.low())));
                area.draw(&Polygon::new(points, colour.filled()))?;
            }
        }
    }
    Ok(())
}

/// Steps from each x to the next at its own height; the last point ends the line.
fn steps(run: &[(f64, f64)]) -> Vec<(f64, f64)> {
    run.windows(2).flat_map(|pair| [pair[0], (pair[1].0, pair[0].1)]).collect()
}

/// Draws small triangles where a line leaves the panel.
fn draw_overflow(chart: &Chart, screen: &Area, panel: &Panel, curve: &Curve) -> Drawn {
    if !matches!(curve.shape, Shape::Line | Shape::Hairline) {
        return Ok(());
    }
    // Nearer than their own width they are one.
    let mut newest = [i32::MIN; 2];
    for (x, y) in curve.runs.iter().flatten().filter(|(_, y)| !panel.y.holds(*y)) {
        let up = *y > panel.y.high();
        let (px, py) = chart.backend_coord(&(*x, *y));
        if px.saturating_sub(newest[usize::from(up)]) < 10 {
            continue;
        }
        newest[usize::from(up)] = px;
        let towards = if up { 1 } else { -1 };
        let base = py + 11 * towards;
        let triangle = vec![(px - 5, base), (px + 5, base), (px, py + towards)];
        screen.draw(&Polygon::new(triangle, INK.filled()))?;
    }
    Ok(())
}
