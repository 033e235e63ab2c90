//! What a person sees, on the terminal that ratatui has for tests.

use super::samples::{self, viewer};
use super::*;
use crate::cli::monitor::news::{News, WatchedOverview};
use crate::cli::monitor::viewer::Wish;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::style::{Color, Modifier};

const NOW: Duration = Duration::from_secs(20);
const COLOURED: Marks = Marks { unicode: true, colours: true };

/// What `viewer` shows at `now`, on a terminal of this size.
fn drawn(viewer: &Viewer, now: Duration, marks: Marks, size: (u16, u16)) -> Buffer {
    let mut terminal = Terminal::new(TestBackend::new(size.0, size.1)).expect("it is in memory");
    let draw =
        |frame: &mut ratatui::Frame<'_>| draw(viewer, now, marks, frame.area(), frame.buffer_mut());
    terminal.draw(draw).expect("memory takes everything");
    terminal.backend().buffer().clone()
}

fn lines(buffer: &Buffer) -> Vec<String> {
    let rows = buffer.content.chunks(usize::from(buffer.area.width));
    let line =
        |row: &[ratatui::buffer::Cell]| row.iter().map(|cell| cell.symbol()).collect::<String>();
    rows.map(|row| line(row).trim_end().to_owned()).collect()
}

fn text(viewer: &Viewer, now: Duration) -> String {
    lines(&drawn(viewer, now, COLOURED, (80, 24))).join("\n")
}

/// The picture in the document is the one that is drawn.
#[test]
fn it_looks_as_the_document_says() {
    let mut viewer = viewer(NOW);
    (0..2).for_each(|_| viewer.wish(Wish::Down, NOW));
    let shown = text(&viewer, NOW);
    let document = include_str!("../../../../docs/PAGE.md");
    assert!(document.contains(&format!("```text\n{shown}\n```")), "docs/PAGE.md lacks\n{shown}");
}

#[test]
fn everything_is_unknown_when_the_gateway_is_lost() {
    let mut viewer = viewer(NOW);
    assert!(text(&viewer, NOW).contains("level  red "), "{}", text(&viewer, NOW));
    viewer.take(News::Lost("connection refused".to_owned()), NOW);
    let later = NOW + Duration::from_secs(12);
    let shown = text(&viewer, later);
    for words in [
        "level unknown (was red)",
        "newest frame 12 s ago",
        "unknown for 12 s, trying again: http://127.0.0.1:9481: connection refused",
        "C1 unknown; C2 unknown",
        "Incidents at 04:12:33; nothing is known since",
    ] {
        assert!(shown.contains(words), "{words}:\n{shown}");
    }
    for words in ["●", "⊗", "failure", "good", "3.98"] {
        assert!(!shown.contains(words), "{words}:\n{shown}");
    }
}

/// What a gateway, its machine's names or an error say reaches the terminal as text, not as what it would do there.
#[test]
fn nothing_that_is_told_acts_on_the_terminal() {
    const EVIL: &str = "x\u{1b}[2J\u{9b}1m\u{202e}\u{2066}";
    const SHOWN: &str = "x\\u001b[2J\\u009b1m\\u202e\\u2066";
    let mut viewer = Viewer::new(EVIL.to_owned());
    let evil = serde_json::to_string(EVIL).expect("a text");
    let machine = format!(
        "{{\"name\":{evil},\"limits_m\":[[0.001,0.001,0.001,0.05]],\"names\":[{{\"name\":{evil},\"c1_name\":{evil}}}]}}"
    );
    let words = format!(
        "{{\"lamp\":\"good\",\"words\":{evil},\"drift_mm_per_month\":null,\
                         \"error_mm_per_month\":null,\"months_left\":[null,null,null]}}"
    );
    let overview = format!(
        "{{\"time\":0.0,\"status\":{evil},\"reason\":{evil},\"mode\":{evil},\"platform\":{evil},\"bus\":{evil},\
          \"controller\":{evil},\"level\":{evil},\"seconds_since_frame\":0.0,\"incidents\":[{{\"number\":1,\
          \"level\":\"red\",\"begin\":0.0,\"summary\":{evil}}}],\"cylinders\":[{{\"number\":1,\"estimate_m\":null,\
          \"sigma_mm\":null,\"residuals_mm\":[null,null,null],\"transducers\":[{words},{words}]}}]}}"
    );
    for (name, data) in [("machine", machine), ("overview", overview)] {
        let news = News::event(name, &data).expect("it is what it should be");
        viewer.take(news.expect("it is known"), NOW);
    }
    let wide = |viewer: &Viewer| lines(&drawn(viewer, NOW, COLOURED, (300, 40))).join("\n");
    let shown = wide(&viewer);
    // Name, platform, level, mode, bus, controller, status, reason; cylinder, C1 and both words; the incident.
    assert_eq!(shown.matches(SHOWN).count(), 13, "{shown}");
    viewer.take(News::Lost(EVIL.to_owned()), NOW);
    let shown = wide(&viewer);
    assert!(shown.contains(&format!("{SHOWN}: {SHOWN}")), "{shown}");
}

#[test]
fn what_stands_still_says_so_and_since_when() {
    let mut viewer = viewer(NOW);
    viewer.wish(Wish::Freeze, NOW);
    viewer.take(News::Lost("refused".to_owned()), NOW);
    let shown = text(&viewer, NOW + Duration::from_secs(75));
    assert!(shown.contains("FROZEN since 04:12:33 UTC, 75 s ago"), "{shown}");
    assert!(shown.contains("failure") && shown.contains("space go on"), "{shown}");
}

/// Whatever the colours are, a lamp has a shape of its own and words, and no text is white on the terminal's ground.
#[test]
fn no_colour_is_needed_and_none_is_unreadable() {
    let viewer = viewer(NOW);
    let coloured = drawn(&viewer, NOW, COLOURED, (80, 24));
    assert!(coloured.content.iter().any(|cell| cell.bg == Color::Red));
    for cell in &coloured.content {
        let is_light = matches!(cell.fg, Color::White | Color::Gray | Color::Yellow);
        assert!(!(is_light && cell.bg == Color::Reset), "{cell:?}");
        assert!(!matches!(cell.fg, Color::Rgb(..) | Color::Indexed(_)), "{cell:?}");
    }
    let plain = drawn(&viewer, NOW, Marks { colours: false, ..COLOURED }, (80, 24));
    assert_eq!(lines(&plain), lines(&coloured));
    assert!(plain.content.iter().all(|cell| cell.fg == Color::Reset && cell.bg == Color::Reset));

    let ascii = drawn(&viewer, NOW, Marks { unicode: false, colours: true }, (80, 24));
    assert!(lines(&ascii).iter().all(|line| line.is_ascii()), "{:#?}", lines(&ascii));
    use crate::appliance::telemetry::lamp::Lamp;
    let lamps = [
        Lamp::Failure,
        Lamp::CheckFunction,
        Lamp::OutOfSpecification,
        Lamp::MaintenanceRequired,
        Lamp::Good,
        Lamp::NotFitted,
        Lamp::Unknown,
    ];
    for marks in [COLOURED, Marks { unicode: false, colours: true }] {
        let mut shapes = lamps.map(|lamp| marks.lamp(lamp).0).to_vec();
        shapes.sort_unstable();
        shapes.dedup();
        assert_eq!(shapes.len(), lamps.len(), "{shapes:?}");
    }
}

#[test]
fn a_residual_beyond_its_limit_has_a_sign_and_a_full_bar() {
    let viewer = viewer(NOW);
    let shown = text(&viewer, NOW);
    let row = |number: &str| shown.lines().find(|it| it[1..].starts_with(number)).expect("a row");
    assert!(row("3 ").contains(" 3.98!███"), "{}", row("3 "));
    assert!(row("1 ").contains(" 0.21 ▋"), "{}", row("1 "));
    assert!(row("6 ").contains("    – ···"), "{}", row("6 "));
}

#[test]
fn every_size_is_drawn_and_a_small_one_says_what_it_lacks() {
    let mut viewer = viewer(NOW);
    for wish in [None, Some(Wish::Zoom), Some(Wish::Help)] {
        wish.into_iter().for_each(|wish| viewer.wish(wish, NOW));
        for size in [(1, 1), (20, 3), (79, 24), (80, 21), (80, 22), (80, 24), (120, 40), (300, 90)]
        {
            let shown = lines(&drawn(&viewer, NOW, COLOURED, size)).join("\n");
            if size.1 > 5 && size.0 > 50 {
                let lacks = size.0 < 80 || size.1 < 22;
                assert_eq!(shown.contains("This terminal has"), lacks, "{size:?}\n{shown}");
            }
        }
    }
    let nothing = Viewer::new("can0".to_owned());
    assert!(text(&nothing, NOW).contains("can0"));
}

#[test]
fn the_zoom_shows_one_cylinder_and_the_help_all_keys_and_lamps() {
    let mut viewer = viewer(NOW);
    viewer.wish(Wish::Down, NOW);
    viewer.wish(Wish::Zoom, NOW);
    let shown = text(&viewer, NOW);
    let words = "C2 drifts by +0.31 ± 0.02 mm a month, maintenance in 4 months (3 to 6)";
    let said = shown.replace('\n', " ");
    assert!(said.contains(words) && said.contains("virtual sensor 0.213 m"), "{shown}");
    assert!(!shown.contains("Incidents"), "{shown}");
    viewer.wish(Wish::Help, NOW);
    let shown = text(&viewer, NOW);
    assert!(
        shown.contains("Ctrl-C") && shown.contains("no evidence, neither good nor bad"),
        "{shown}"
    );
    assert!(shown.contains("Nothing is sent."), "{shown}");
}

/// A machine's name or a reason cannot write to the terminal.
#[test]
fn control_characters_are_not_passed_on() {
    let mut viewer = viewer(NOW);
    let mut overview = samples::overview();
    overview.reason = "a\x1b[2Jb\u{7}c\u{9b}d".to_owned();
    viewer.take(News::Overview(overview), NOW);
    let buffer = drawn(&viewer, NOW, COLOURED, (80, 24));
    assert!(buffer.content.iter().all(|cell| !cell.symbol().contains(char::is_control)));
    assert!(lines(&buffer)[2].contains("[2J"), "{}", lines(&buffer)[2]);
}

#[test]
fn the_selected_row_is_marked() {
    let viewer = viewer(NOW);
    let buffer = drawn(&viewer, NOW, COLOURED, (80, 24));
    let row = lines(&buffer).iter().position(|line| line.starts_with(">1 ")).expect("a row") as u16;
    assert!(buffer[(1, row)].modifier.contains(Modifier::BOLD));
}

/// Without an incident it is only said that all is judged where the gateway says so itself.
#[test]
fn no_incident_is_good_news_only_with_judgement() {
    let told = |status: &str| {
        let mut viewer = viewer(NOW);
        let quiet = samples::overview();
        let status = status.to_owned();
        viewer.take(News::Overview(WatchedOverview { incidents: vec![], status, ..quiet }), NOW);
        text(&viewer, NOW)
    };
    assert!(told("ok").contains("None stands, and everything is judged."), "{}", told("ok"));
    // As when a transducer is unknown while the gateway monitors.
    for status in ["unknown", "degraded"] {
        assert!(
            told(status).contains("None stands, but not everything is judged now."),
            "{status}"
        );
    }
}
