//! The incidents that are open, the worst first.

use super::marks::{Marks, quiet};
use super::sight::Sight;
use super::words::time_of_day;
use crate::cli::monitor::news::WatchedIncident;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

/// Columns of the longest level, with a space at each end.
const LEVEL: usize = 8;

pub fn draw(sight: &Sight<'_>, area: Rect, buffer: &mut Buffer) {
    let mut lines = vec![Line::styled(title(sight), quiet())];
    let incidents = sight.picture.overview().map_or(&[][..], |overview| &overview.incidents);
    let room = usize::from(area.height).saturating_sub(1);
    let shown = if incidents.len() > room { room.saturating_sub(1) } else { room };
    lines.extend(incidents.iter().take(shown).map(incident));
    if incidents.len() > shown {
        lines.push(Line::raw(format!(" and {} more", incidents.len() - shown)));
    }
    if incidents.is_empty() {
        lines.push(Line::raw(none(sight)));
    }
    for (y, line) in (area.y..area.bottom()).zip(lines) {
        buffer.set_line(area.x, y, &line, area.width);
    }
}

fn title(sight: &Sight<'_>) -> String {
    match sight.picture.overview().filter(|_| sight.picture.blindness(sight.of).is_some()) {
        Some(old) => format!("Incidents at {}; nothing is known since", time_of_day(old.time)),
        None => "Incidents".to_owned(),
    }
}

fn incident(incident: &WatchedIncident) -> Line<'_> {
    let level = format!("{:<LEVEL$}", format!(" {}", incident.level));
    let (number, begin) = (incident.number, time_of_day(incident.begin));
    Line::from(vec![
        Span::styled(level, Marks::level(&incident.level)),
        Span::raw(format!(" {}, since {begin}, incident {number}", incident.summary)),
    ])
}

/// Why there is no incident.
fn none(sight: &Sight<'_>) -> &'static str {
    let Some(overview) = sight.picture.overview() else { return "Nothing is known yet." };
    let silent = overview.seconds_since_frame.is_none_or(|time| time > 1.0);
    match overview.status.as_str() {
        _ if sight.picture.blindness(sight.of).is_some() => "Nothing is known of now.",
        "ok" => "None stands, and everything is judged.",
        _ if silent => "None stands. There are no frames of the machine: nothing is judged.",
        _ => "None stands, but not everything is judged now.",
    }
}
