//! The keys, and what the lamps mean.

use super::marks::{quiet, strong};
use super::sight::Sight;
use crate::appliance::telemetry::lamp::Lamp;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

/// Keys, and what they do.
const KEYS: [(&str, &str); 6] = [
    ("up, down", "selects a cylinder (also k and j)"),
    ("s", "sorts: by number, or the worst first"),
    ("space", "lets the picture stand still, and go on; nothing is missed meanwhile"),
    ("z, enter", "shows the selected cylinder alone, and all again"),
    ("?", "shows this; escape goes back"),
    ("q, Ctrl-C", "quits; the gateway does not notice"),
];

/// Categories of NAMUR NE 107, and what they mean here.
const LAMPS: [(Lamp, &str); 7] = [
    (Lamp::Good, "judged, and nothing found"),
    (Lamp::Failure, "a warning blames it"),
    (Lamp::OutOfSpecification, "it may be this one or the other"),
    (Lamp::CheckFunction, "its device is not operational, or its frames lack what is configured"),
    (Lamp::MaintenanceRequired, "its readings on the stops drift"),
    (Lamp::NotFitted, "this cylinder does not have it"),
    (Lamp::Unknown, "no evidence, neither good nor bad"),
];

/// The line of keys.
pub fn keys(sight: &Sight<'_>, area: Rect, buffer: &mut Buffer) {
    let order = if sight.viewer.worst_first { "by number" } else { "worst first" };
    let zoom = if sight.viewer.is_zoomed { "all" } else { "zoom" };
    let freeze = if sight.viewer.frozen_for(sight.now).is_some() { "go on" } else { "freeze" };
    let arrows = sight.marks.pick("↑↓", "up/down");
    let text = format!("{arrows} select  s {order}  space {freeze}  enter {zoom}  ? help  q quit");
    buffer.set_stringn(area.x, area.y, text, usize::from(area.width), quiet());
}

pub fn draw(sight: &Sight<'_>, area: Rect, buffer: &mut Buffer) {
    let mut lines = vec![Line::styled("Keys", strong())];
    lines.extend(KEYS.map(|(key, does)| Line::raw(format!("  {key:<10} {does}"))));
    lines.push(Line::default());
    lines.push(Line::styled("Lamps", strong()));
    for (lamp, means) in LAMPS {
        let (shape, style) = sight.marks.lamp(lamp);
        let words = Span::raw(format!(" {:<21}{means}", lamp.words()));
        lines.push(Line::from(vec![Span::raw("  "), Span::styled(shape, style), words]));
    }
    lines.push(Line::default());
    lines.push(Line::raw("Bars reach up to the limit, and ! is beyond it. A dot: not judged."));
    lines.push(Line::raw(format!("Watched: {}. Nothing is sent.", sight.viewer.source)));
    for (y, line) in (area.y..area.bottom()).zip(lines) {
        buffer.set_style(Rect { y, height: 1, ..area }, Style::new());
        buffer.set_line(area.x, y, &line, area.width);
    }
}
