//! The incidents on the page of a replay: a table of all, and the story of each with the figures around its warnings.

use super::Page;
use super::escaping::escaped;
use super::figure::Figure;
use super::zoom::Zoom;
use crate::report::human::Heading;
use crate::report::{Summary, wording};
use crate::story;
use std::fmt::Write as _;
use tertius_config::MachineNames;
use tertius_core::alarm::Level;
use tertius_core::incident::Incident;

/// Adds the verdict: what a person wants to know first.
pub fn verdict(page: &mut Page, lines: &[String], summary: &Summary<'_>) {
    let text = lines.join("\n");
    if text.is_empty() {
        return;
    }
    match summary.incidents.count() {
        0 => page.good(&text),
        _ => page.alarm(&text),
    }
}

/// Adds the table and the stories; `figures` are those of the zooms.
pub fn section(
    page: &mut Page,
    heading: &Heading<'_>,
    summary: &Summary<'_>,
    figures: Vec<(&Zoom, Figure, String)>,
) {
    let all = summary.incidents.by_severity();
    if all.is_empty() {
        return;
    }
    page.heading("Incidents");
    table(page, heading, &all, summary.names);
    let left_out = summary.incidents.left_out();
    if left_out > 0 {
        page.paragraph(&format!("… and {left_out} milder ones; --format jsonl gives them all"));
    }
    let mut figures = figures;
    for incident in all {
        let shows =
            |zoom: &Zoom| zoom.warnings.iter().any(|(order, _)| is_of(incident, *order, summary));
        let (own, others) = figures.into_iter().partition(|(zoom, ..)| shows(zoom));
        figures = others;
        one(page, (heading, summary.names), incident, own);
    }
    if !figures.is_empty() {
        page.heading("Around other warnings");
        page.figures(figures.iter().map(|(_, figure, caption)| (figure, caption.as_str())));
    }
}

/// Whether the `order`-th warning belongs to `incident`.
fn is_of(incident: &Incident, order: usize, summary: &Summary<'_>) -> bool {
    let Some(episode) = summary.episodes.kept().get(order) else { return false };
    let until = incident.end.map(|(at, _)| at);
    incident.scope.has(episode.cylinder.into())
        && episode.raised >= incident.begin
        && until.is_none_or(|until| episode.raised <= until)
        && story::detectors(incident).contains(&episode.detector)
}

fn one(
    page: &mut Page,
    (heading, names): (&Heading<'_>, &MachineNames),
    incident: &Incident,
    figures: Vec<(&Zoom, Figure, String)>,
) {
    let title = wording::capitalised(&story::line(incident, names));
    let (number, badge) = (incident.number, badge(incident.level));
    page.raw(&format!(
        "<section class=\"incident\" id=\"incident-{number}\" aria-labelledby=\"title-{number}\">\n\
         <h3 id=\"title-{number}\">{badge} {}</h3>\n",
        escaped(&title)
    ));
    for sentence in wording::incident_story(heading.zone, incident, names) {
        page.paragraph(&sentence);
    }
    if !figures.is_empty() {
        page.figures(figures.iter().map(|(_, figure, caption)| (figure, caption.as_str())));
    }
    page.raw("<p class=\"back\"><a href=\"#incidents\">All incidents</a></p>\n</section>\n");
}

fn table(page: &mut Page, heading: &Heading<'_>, incidents: &[&Incident], names: &MachineNames) {
    let mut html =
        "<div class=\"scroll\" tabindex=\"0\" role=\"group\" aria-label=\"Incidents\">\n\
                    <table>\n<thead><tr>"
            .to_owned();
    for column in wording::INCIDENT_COLUMNS {
        _ = write!(html, "<th scope=\"col\">{column}</th>");
    }
    html += "</tr></thead>\n<tbody>\n";
    for incident in incidents {
        let [at, cylinder, suspect, _, what, largest, lasted] =
            wording::incident_row(heading.zone, incident, names).map(|cell| escaped(&cell));
        let (number, badge) = (incident.number, badge(incident.level));
        _ = writeln!(
            html,
            "<tr><td>{at}</td><td class=\"n\">{cylinder}</td><td>{suspect}</td><td>{badge}</td>\
             <td><a href=\"#incident-{number}\">{what}</a></td><td class=\"n\">{largest}</td>\
             <td class=\"n\">{lasted}</td></tr>"
        );
    }
    page.raw(&(html + "</tbody>\n</table>\n</div>\n"));
}

/// A level as colour, shape and word.
fn badge(level: Level) -> String {
    let shape = match level {
        Level::None => "○",
        Level::Yellow => "◆",
        Level::Orange => "▲",
        Level::Red => "●",
        Level::Black => "■",
    };
    let name = level.name();
    format!("<span class=\"level {name}\"><span aria-hidden=\"true\">{shape}</span> {name}</span>")
}
