//! The cylinders, a line each: two lamps, and three residuals against their limits.

use super::marks::{beyond, quiet, strong};
use super::sight::Sight;
use super::words::five_columns;
use crate::cli::monitor::news::{WatchedCylinder, WatchedTransducer};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};

/// Columns of the number with the mark of the selected one.
const NUMBER: usize = 3;

/// Columns of a lamp with the longest words.
const LAMP: usize = 22;

/// Columns of a residual: its number, the sign of one beyond its limit, and the space before it.
const VALUE: usize = 7;

pub fn draw(sight: &Sight<'_>, area: Rect, buffer: &mut Buffer) {
    let columns = usize::from(area.width).saturating_sub(NUMBER + 2 * (LAMP + 1)) / 3;
    let mut lines = vec![heading(sight, columns)];
    for number in sight.viewer.order(sight.now) {
        if let Some(cylinder) = sight.cylinders.iter().find(|it| it.number == number) {
            lines.push(row(sight, cylinder, columns));
        }
    }
    for (y, line) in (area.y..area.bottom()).zip(lines) {
        buffer.set_line(area.x, y, &line, area.width);
    }
}

fn heading<'a>(sight: &Sight<'_>, columns: usize) -> Line<'a> {
    let mut text = format!("{:NUMBER$}{:LAMP$} {:LAMP$} ", "", "C1", "C2");
    let limits = sight.picture.limits(sight.viewer.selected);
    for (name, limit) in ["R1", "R2", "R3"].into_iter().zip(limits) {
        let most = sight.marks.pick("≤", "<");
        let limit = limit.map_or(String::new(), |it| format!("{most}{}mm", five_columns(1e3 * it)));
        text += &format!(" {:<width$}", format!("{name}{limit}"), width = columns - 1);
    }
    Line::styled(text, quiet())
}

fn row<'a>(sight: &Sight<'_>, cylinder: &WatchedCylinder, columns: usize) -> Line<'a> {
    let selected = cylinder.number == sight.viewer.selected;
    let (mark, style) = if selected { (">", strong()) } else { (" ", Style::new()) };
    let mut spans = vec![Span::styled(format!("{mark}{} ", cylinder.number), style)];
    for transducer in &cylinder.transducers {
        spans.extend(lamp(sight, transducer, style));
    }
    let limits = sight.picture.limits(cylinder.number);
    for (size, limit) in cylinder.residuals_mm.into_iter().zip(limits) {
        spans.extend(residual(sight, size, limit, columns));
    }
    Line::from(spans)
}

/// A lamp in [`LAMP`] columns and a space.
fn lamp<'a>(sight: &Sight<'_>, transducer: &WatchedTransducer, text: Style) -> [Span<'a>; 2] {
    let (shape, style) = sight.marks.lamp(transducer.lamp);
    let width = LAMP - 1;
    [
        Span::styled(shape, style),
        Span::styled(format!(" {:<width$}", transducer.lamp.words()), text),
    ]
}

/// A residual, mm, in so many columns: number, sign if it is beyond its limit (m), and bar up to the limit.
fn residual<'a>(
    sight: &Sight<'_>,
    size: Option<f64>,
    limit: Option<f64>,
    columns: usize,
) -> [Span<'a>; 2] {
    let width = columns.saturating_sub(VALUE);
    let Some(size) = size else {
        let absent = sight.marks.pick("–", "-");
        let track = sight.marks.pick("·", ".").repeat(width);
        return [Span::raw(format!(" {absent:>5} ")), Span::styled(track, quiet())];
    };
    let share = limit.map_or(0.0, |limit| size / (1e3 * limit));
    let (sign, style) = if share > 1.0 { ("!", beyond()) } else { (" ", Style::new()) };
    let bar = sight.marks.bar(share, width);
    let track = style.add_modifier(Modifier::UNDERLINED);
    [Span::styled(format!(" {:>5}{sign}", five_columns(size)), style), Span::styled(bar, track)]
}
