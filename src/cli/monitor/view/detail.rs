//! The selected cylinder: words, drift, and the last minutes of its residuals.

use super::chart::{Chart, Scale};
use super::marks::{beyond, quiet, strong};
use super::sight::{Sight, below, split};
use super::words::{drift, estimate, five_columns};
use crate::cli::monitor::news::WatchedCylinder;
use crate::cli::monitor::picture::MINUTES;
use crate::report::capitalised;
use crate::sample::Transducer;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Widget, Wrap};

const RESIDUALS: [&str; 3] = ["R1", "R2", "R3"];

/// The cylinder below the others, with the charts beside each other.
pub fn beside(sight: &Sight<'_>, area: Rect, buffer: &mut Buffer) {
    let Some(cylinder) = sight.selected() else { return };
    let [text, charts] = split(area, 3.min(area.height / 2));
    said(sight, cylinder, text, buffer);
    let width = charts.width / 3;
    for which in 0..3 {
        let x = charts.x + which as u16 * width;
        chart(sight, cylinder, which, Rect { x, width: width - 1, ..charts }, buffer);
    }
}

/// The cylinder alone, with the charts below each other.
pub fn zoomed(sight: &Sight<'_>, area: Rect, buffer: &mut Buffer) {
    let Some(cylinder) = sight.selected() else { return };
    let [text, charts] = split(area, 4);
    said(sight, cylinder, text, buffer);
    let height = charts.height / 3;
    for which in 0..3 {
        let place = below(charts, which as u16 * height, height);
        chart(sight, cylinder, which, place, buffer);
    }
}

/// Words for the lamps, the drifts and the virtual sensor.
fn said(sight: &Sight<'_>, cylinder: &WatchedCylinder, area: Rect, buffer: &mut Buffer) {
    let [c1, c2] = &cylinder.transducers;
    let names = sight.picture.names();
    let [first, second] = Transducer::ALL.map(|it| names.transducer(cylinder.number, it));
    let title = Line::from(vec![
        Span::styled(capitalised(&names.cylinder(cylinder.number)), strong()),
        Span::raw(format!("  {first} {}; {second} {}", c1.words, c2.words)),
    ]);
    let parts = [drift("C1", c1), drift("C2", c2), estimate(cylinder)];
    let parts: Vec<String> = parts.into_iter().filter(|part| !part.is_empty()).collect();
    let more = parts.join("; ");
    let more =
        if sight.marks.unicode { more } else { more.replace('±', "+-").replace('σ', "sigma") };
    let text = vec![title, Line::raw(more)];
    Paragraph::new(text).wrap(Wrap { trim: true }).render(area, buffer);
}

/// The last minutes of one residual, with its name, size and limit above.
fn chart(
    sight: &Sight<'_>,
    cylinder: &WatchedCylinder,
    which: usize,
    area: Rect,
    buffer: &mut Buffer,
) {
    let limit = sight.picture.limits(cylinder.number)[which];
    let [title, area] = split(area, 1);
    let size = cylinder.residuals_mm[which];
    let is_beyond = size.zip(limit).is_some_and(|(size, limit)| size > 1e3 * limit);
    let size = size.map_or_else(|| sight.marks.pick("–", "-").to_owned(), five_columns);
    let of = limit.map_or(String::new(), |limit| format!(" of {}", five_columns(1e3 * limit)));
    let line = Line::from(vec![
        Span::styled(RESIDUALS[which], strong()),
        Span::styled(format!(" {size}"), if is_beyond { beyond() } else { Style::new() }),
        Span::raw(format!("{of} mm")),
        Span::styled(format!(", {:.0} min", MINUTES / 60.0), quiet()),
    ]);
    buffer.set_line(title.x, title.y, &line, title.width);
    let Some(trend) = sight.picture.trend(cylinder.number) else { return };
    let bins = trend.iter().map(|bin| (bin.time, bin.residuals[which]));
    let columns = super::chart::columns(bins, MINUTES, usize::from(area.width));
    let scale = Scale::new(&columns, limit);
    Chart { columns: &columns, scale, marks: sight.marks }.draw(area, buffer);
}
