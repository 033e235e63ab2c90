//! Reads figures back out of a page.

use roxmltree::{Document, Node, ParsingOptions};

/// Colours of curves and levels, as they stand in the SVG.
pub struct Look;

impl Look {
    pub const RED: &str = "#C8102E";
    pub const ORANGE: &str = "#E69F00";
    pub const BLUE: &str = "#005B9E";
    pub const SKY: &str = "#56A0D3";
    const FRAME: &str = "#6E6E6E";
}

/// A page is sound as XML, too.
pub fn parse(html: &str) -> Document<'_> {
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    Document::parse_with_options(html, options).expect("a page is sound XML")
}

/// A figure of a page.
pub struct Figure<'a> {
    pub title: String,
    pub notes: Vec<String>,
    svg: Node<'a, 'a>,
}

/// A panel of a figure: the frame, and where its ticks are.
pub struct Panel<'a> {
    svg: Node<'a, 'a>,
    /// Left, top, right, bottom, units of the SVG.
    frame: [f64; 4],
    /// y of the SVG, and the value that stands there.
    ticks: Vec<(f64, f64)>,
}

fn number(node: Node<'_, '_>, name: &str) -> f64 {
    let text = node.attribute(name).unwrap_or_else(|| panic!("{node:?} has no {name}"));
    text.parse().unwrap_or_else(|_| panic!("{text}"))
}

fn points(polyline: Node<'_, '_>) -> Vec<(f64, f64)> {
    let text = polyline.attribute("points").expect("a polyline has points");
    let point = |pair: &str| {
        let (x, y) = pair.split_once(',').expect("two numbers");
        (x.parse().expect("a number"), y.parse().expect("a number"))
    };
    text.split_whitespace().map(point).collect()
}

impl<'a> Figure<'a> {
    pub fn all(document: &'a Document<'a>) -> Vec<Self> {
        let figures = document.descendants().filter(|it| it.has_tag_name("figure"));
        let text = |node: Node<'_, '_>| node.text().unwrap_or_default().trim().to_owned();
        let one = |figure: Node<'a, 'a>| {
            let svg =
                figure.children().find(|it| it.tag_name().name() == "svg").expect("a drawing");
            let caption = figure.children().find(|it| it.has_tag_name("figcaption"));
            let notes = caption.into_iter().flat_map(|it| it.children());
            Self {
                title: text(figure.children().find(|it| it.is_element()).expect("a title")),
                notes: notes.filter(|it| it.is_element()).map(text).collect(),
                svg,
            }
        };
        figures.map(one).collect()
    }

    /// From top to bottom.
    pub fn panels(&self) -> Vec<Panel<'a>> {
        let frames = self.svg.children().filter(|it| {
            it.tag_name().name() == "rect" && it.attribute("stroke") == Some(Look::FRAME)
        });
        let ticks: Vec<(f64, f64, f64)> = self
            .svg
            .children()
            .filter(|it| it.attribute("text-anchor") == Some("end"))
            .filter_map(|it| {
                let value = it.text()?.trim().replace('−', "-").parse().ok()?;
                Some((number(it, "x"), number(it, "y"), value))
            })
            .collect();
        let panel = |rect: Node<'a, 'a>| {
            let [x, y, width, height] =
                ["x", "y", "width", "height"].map(|name| number(rect, name));
            let frame = [x, y, x + width, y + height];
            let own =
                |(_, at, _): &&(f64, f64, f64)| (frame[1] - 1.0..=frame[3] + 1.0).contains(at);
            let ticks = ticks.iter().filter(own).map(|(_, at, value)| (*at, *value)).collect();
            Panel { svg: self.svg, frame, ticks }
        };
        frames.map(panel).collect()
    }
}

impl Panel<'_> {
    /// The value at `y` of the SVG, by the ticks.
    fn value(&self, y: f64) -> f64 {
        let [first, .., last] = self.ticks[..] else { panic!("{:?}", self.ticks) };
        first.1 + (y - first.0) * (last.1 - first.1) / (last.0 - first.0)
    }

    fn lines(&self, colour: &str) -> Vec<Vec<(f64, f64)>> {
        let [left, top, right, bottom] = self.frame;
        let inside = |(x, y): &(f64, f64)| {
            (left - 1.0..=right + 1.0).contains(x) && (top - 1.0..=bottom + 1.0).contains(y)
        };
        let lines = self.svg.children().filter(|it| it.tag_name().name() == "polyline");
        let lines = lines.filter(|it| it.attribute("stroke") == Some(colour)).map(points);
        lines.filter(|line| line.iter().all(inside)).collect()
    }

    /// There are lines of `colour` all through the panel at `values`, and at no others.
    #[track_caller]
    pub fn assert_levels(&self, colour: &str, values: &[f64]) {
        let [left, _, right, _] = self.frame;
        let level = |line: &Vec<(f64, f64)>| {
            let whole =
                (line[0].0 - left).abs() < 2.0 && (line[line.len() - 1].0 - right).abs() < 2.0;
            (line.len() == 2 && line[0].1 == line[1].1 && whole).then(|| self.value(line[0].1))
        };
        let mut found: Vec<f64> = self.lines(colour).iter().filter_map(level).collect();
        let mut values = values.to_vec();
        found.sort_by(f64::total_cmp);
        values.sort_by(f64::total_cmp);
        // A unit of the SVG is so much.
        let unit = (self.value(0.0) - self.value(1.0)).abs();
        let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1.5 * unit;
        assert!(
            found.len() == values.len() && found.iter().zip(&values).all(near),
            "{found:?} instead of {values:?}"
        );
    }

    /// The lines of `colour`, each for itself, as [`Self::curve`] has them.
    pub fn runs(&self, colour: &str) -> Vec<Vec<(f64, f64)>> {
        let [left, _, right, _] = self.frame;
        let point = |(x, y): (f64, f64)| ((x - left) / (right - left), self.value(y));
        let lines = self.lines(colour).into_iter();
        lines.map(|line| line.into_iter().map(point).collect()).collect()
    }

    /// The curve of `colour`: x as a part of the panel's width, and the values.
    pub fn curve(&self, colour: &str) -> Vec<(f64, f64)> {
        let [left, _, right, _] = self.frame;
        let lines = self.lines(colour).into_iter().flatten();
        lines.map(|(x, y)| ((x - left) / (right - left), self.value(y))).collect()
    }
}
