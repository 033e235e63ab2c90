//! The head: which machine, how it is, and how old that is.

use super::marks::{Marks, strong};
use super::sight::Sight;
use super::words::{length, time_of_day};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};

/// Lines of the head.
pub const LINES: u16 = 3;

pub fn draw(sight: &Sight<'_>, area: Rect, buffer: &mut Buffer) {
    let machine = &sight.picture.machine.name;
    let name = if machine.is_empty() { &sight.viewer.source } else { machine };
    let lines = [
        (Line::from(vec![Span::styled(name.clone(), strong()), platform(sight)]), time(sight)),
        (state(sight), age(sight)),
        (Line::raw(reason(sight)), Line::default()),
    ];
    for (y, (left, right)) in (area.y..area.bottom()).zip(lines) {
        let room = area.width.saturating_sub(right.width() as u16);
        buffer.set_line(area.x, y, &left, room.saturating_sub(1).max(area.width / 2));
        buffer.set_line(area.x + room, y, &right, area.width - room);
    }
}

/// Says that not everything is shown.
pub fn too_small(least: (u16, u16), area: Rect, rest: Rect, buffer: &mut Buffer) {
    let told = [
        format!("This terminal has {} columns and {} lines;", area.width, area.height),
        format!("the cylinders need {} and {}. q quits.", least.0, least.1),
    ];
    for (y, line) in (rest.y..rest.bottom()).zip(told) {
        buffer.set_stringn(rest.x, y, line, usize::from(rest.width), Style::new());
    }
}

/// The platform's state, as long as anything is known.
fn platform<'a>(sight: &Sight<'_>) -> Span<'a> {
    let known = sight.picture.overview().filter(|_| sight.picture.blindness(sight.of).is_none());
    let state = known.and_then(|overview| overview.platform.as_ref());
    Span::raw(state.map_or(String::new(), |state| format!(", {state}")))
}

/// The time that the picture is of.
fn time<'a>(sight: &Sight<'_>) -> Line<'a> {
    let of = sight.picture.overview().map_or(String::new(), |it| time_of_day(it.time) + " UTC");
    let Some(time) = sight.viewer.frozen_for(sight.now) else { return Line::raw(of) };
    let frozen = Style::new().add_modifier(Modifier::REVERSED | Modifier::BOLD);
    Line::styled(format!(" FROZEN since {of}, {} ago ", length(time)), frozen)
}

fn state<'a>(sight: &Sight<'_>) -> Line<'a> {
    let Some(overview) = sight.picture.overview() else { return Line::raw("level unknown") };
    if sight.picture.blindness(sight.of).is_some() {
        return Line::raw(format!("level unknown (was {})", overview.level));
    }
    let controller = overview.controller.as_ref().map_or(String::new(), |it| format!(", {it}"));
    let mode = overview.mode.as_deref().unwrap_or("not monitoring");
    Line::from(vec![
        Span::raw("level "),
        Span::styled(format!(" {} ", overview.level), Marks::level(&overview.level)),
        Span::raw(format!("  {mode}  bus {}{controller}", overview.bus)),
    ])
}

fn age<'a>(sight: &Sight<'_>) -> Line<'a> {
    match sight.picture.age(sight.of) {
        Some(age) => Line::raw(format!("newest frame {} ago", length(age))),
        None => Line::raw("no frame yet"),
    }
}

fn reason(sight: &Sight<'_>) -> String {
    if let Some((reason, since)) = sight.picture.blindness(sight.of) {
        let source = &sight.viewer.source;
        return format!("unknown for {}, trying again: {source}: {reason}", length(since));
    }
    let Some(overview) = sight.picture.overview() else { return String::new() };
    format!("{}: {}", overview.status, overview.reason)
}
