//! The picture as cells of a terminal: a function of what is known, of the time and of the area alone.

mod chart;
mod detail;
mod header;
mod help;
mod incidents;
mod marks;
#[cfg(test)]
pub mod samples;
mod sight;
mod table;
#[cfg(test)]
mod tests;
mod words;

use super::viewer::Viewer;
pub use marks::Marks;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Color;
use sight::{Sight, below, split};
use std::time::Duration;

/// Least width and height for everything; on less there is the head alone.
const LEAST: (u16, u16) = (80, 22);

/// Draws what `viewer` shows at `now` into `area`.
pub fn draw(viewer: &Viewer, now: Duration, marks: Marks, area: Rect, buffer: &mut Buffer) {
    let (picture, of) = viewer.shown(now);
    let sight = Sight { viewer, picture, of, now, cylinders: picture.cylinders(of), marks };
    let [head, rest] = split(area, header::LINES);
    header::draw(&sight, head, buffer);
    if area.width < LEAST.0 || area.height < LEAST.1 {
        return header::too_small(LEAST, area, rest, buffer);
    }
    let (body, foot) = (below(rest, 0, rest.height - 1), below(rest, rest.height - 1, 1));
    help::keys(&sight, foot, buffer);
    if viewer.is_helped {
        help::draw(&sight, body, buffer);
    } else if viewer.is_zoomed {
        detail::zoomed(&sight, body, buffer);
    } else {
        overview(&sight, body, buffer);
    }
    if !marks.colours {
        buffer.content.iter_mut().for_each(|cell| {
            cell.set_fg(Color::Reset).set_bg(Color::Reset);
        });
    }
}

/// Cylinders, incidents, and the selected cylinder, which share the height that the first ones leave.
fn overview(sight: &Sight<'_>, body: Rect, buffer: &mut Buffer) {
    let cylinders = sight.cylinders.len() as u16 + 1;
    let [table, rest] = split(body, cylinders.min(body.height / 2));
    table::draw(sight, table, buffer);
    let standing = sight.picture.overview().map_or(0, |it| it.incidents.len()) as u16;
    let [incidents, detail] = split(rest, (rest.height / 3).max(standing.min(rest.height / 2) + 1));
    incidents::draw(sight, incidents, buffer);
    detail::beside(sight, detail, buffer);
}
