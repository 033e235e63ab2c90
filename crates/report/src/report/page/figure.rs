//! Figures as data: panels above each other that share the x axis.

use super::axis::Axis;
use plotters::style::RGBColor;

/// Style of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    Line,
    /// A line of half the weight, for the background.
    Hairline,
    Dots,
    /// Bars from the lower end of the panel to the points, from each x to the next.
    Bars,
    /// Steps from each x to the next.
    Steps,
}

/// One curve, in several runs where data are missing.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Name for the legend.
    pub name: String,
    pub colour: RGBColor,
    pub shape: Shape,
    pub runs: Vec<Vec<(f64, f64)>>,
}

/// A line at one value: a threshold.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    pub name: String,
    pub colour: RGBColor,
    pub value: f64,
}

/// A vertical line behind the curves.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureMark {
    pub name: String,
    pub colour: RGBColor,
    pub at: f64,
}

/// A shaded band behind everything, along the x axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    pub name: String,
    pub colour: RGBColor,
    pub from: f64,
    pub to: f64,
}

/// One panel of a figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Height of the plot itself, CSS pixels.
    pub height: u32,
    pub y: Axis,
    pub curves: Vec<Curve>,
    /// Levels, horizontal lines along the x axis.
    pub levels: Vec<Level>,
    /// Vertical lines.
    pub marks: Vec<FigureMark>,
    /// Shaded bands along the x axis.
    pub bands: Vec<Band>,
}

/// Panels with a common x axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Width, CSS pixels.
    pub width: u32,
    pub x: Axis,
    pub panels: Vec<Panel>,
}

/// Symbol of a legend's entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sample {
    Line,
    Dot,
    Area,
    Upright,
}

/// An entry of a legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    pub name: String,
    pub colour: RGBColor,
    pub sample: Sample,
}

/// Width of a figure over the whole page, CSS pixels.
pub const WIDE: u32 = 960;
/// Width of one of two figures beside each other, CSS pixels.
pub const HALF: u32 = 470;

impl Curve {
    /// A line without gaps.
    pub fn line(name: &str, colour: RGBColor, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.to_owned(), colour, shape: Shape::Line, runs: vec![points] }
    }

    pub fn dots(name: &str, colour: RGBColor, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.to_owned(), colour, shape: Shape::Dots, runs: vec![points] }
    }

    /// This curve, drawn as `shape`.
    #[must_use]
    pub fn shaped(mut self, shape: Shape) -> Self {
        self.shape = shape;
        self
    }

    /// A curve of the points of `values`, split where one is missing.
    pub fn broken(
        name: &str,
        colour: RGBColor,
        values: impl IntoIterator<Item = (f64, Option<f64>)>,
    ) -> Self {
        let mut runs = vec![Vec::new()];
        for (x, value) in values {
            match value.filter(|value| value.is_finite()) {
                Some(y) => runs.last_mut().into_iter().for_each(|run| run.push((x, y))),
                None if runs.last().is_some_and(Vec::is_empty) => {}
                None => runs.push(Vec::new()),
            }
        }
        runs.retain(|run| !run.is_empty());
        Self { name: name.to_owned(), colour, shape: Shape::Line, runs }
    }

    /// All y values.
    pub fn values(&self) -> impl Iterator<Item = f64> + '_ {
        self.runs.iter().flatten().map(|(_, y)| *y)
    }
}

impl Panel {
    /// A panel with curves only.
    pub fn new(height: u32, y: Axis, curves: Vec<Curve>) -> Self {
        Self { height, y, curves, levels: Vec::new(), marks: Vec::new(), bands: Vec::new() }
    }

    /// Number of dots beyond the scale, which are not drawn.
    pub fn beyond(&self) -> usize {
        let dots = self.curves.iter().filter(|curve| curve.shape == Shape::Dots);
        dots.flat_map(Curve::values).filter(|y| !self.y.holds(*y)).count()
    }

    /// Adds a level on both sides of zero; the legend has it once.
    #[must_use]
    pub fn with_bounds(mut self, name: &str, colour: RGBColor, value: f64) -> Self {
        for value in [value, -value] {
            self.levels.push(Level { name: name.to_owned(), colour, value });
        }
        self
    }
}

impl Figure {
    /// A figure with one panel.
    pub fn single(width: u32, x: Axis, panel: Panel) -> Self {
        Self { width, x, panels: vec![panel] }
    }

    /// Legend of the curves, levels, marks and bands, each name once, if they are drawn at all.
    pub fn legend(&self) -> Vec<Entry> {
        let mut entries: Vec<Entry> = Vec::new();
        let mut add = |name: &str, colour: RGBColor, sample: Sample| {
            let known = |entry: &Entry| entry.name == name && entry.colour == colour;
            if !name.is_empty() && !entries.iter().any(known) {
                entries.push(Entry { name: name.to_owned(), colour, sample });
            }
        };
        for curve in self.panels.iter().flat_map(|panel| &panel.curves) {
            let sample = match curve.shape {
                Shape::Line | Shape::Hairline | Shape::Steps => Sample::Line,
                Shape::Dots => Sample::Dot,
                Shape::Bars => Sample::Area,
            };
            if curve.runs.iter().any(|run| !run.is_empty()) {
                add(&curve.name, curve.colour, sample);
            }
        }
        for panel in &self.panels {
            panel.levels.iter().for_each(|level| add(&level.name, level.colour, Sample::Line));
            panel.marks.iter().for_each(|mark| add(&mark.name, mark.colour, Sample::Upright));
            panel.bands.iter().for_each(|band| add(&band.name, band.colour, Sample::Area));
        }
        entries
    }
}
