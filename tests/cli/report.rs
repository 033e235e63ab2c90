//! The page of a replay: sound, bounded, saying the same as the summary, and written whole or not
//! at all. How it looks is tried by `tests/rendering`, in a browser.

use std::fs;
use tertius_testing::page::{Figure, Look, parse};
use tertius_testing::support::{
    self, E_TYPE, HANGING_LOAD, Run, Scratch, between, recorded, recording, replay, tertius,
};

const FAULTS: &str = "e-type-faults.log.zst";
const HEALTHY: &str = "e-type-healthy.log.zst";

/// Replays `log` in lines of JSON, with a page.
fn page(scratch: &Scratch, log: &str, config: &str) -> (Run, String) {
    let path = scratch.path("page.html");
    let run = replay(&[log], config, &["--report", &path]).ok();
    (run, scratch.read("page.html"))
}

/// The rows of the table under `heading`.
fn table(html: &str, heading: &str) -> Vec<Vec<String>> {
    let document = parse(html);
    let title =
        document.descendants().find(|it| it.has_tag_name("h2") && it.text() == Some(heading));
    let title = title.unwrap_or_else(|| panic!("no {heading}"));
    // It may be folded away.
    let mut tables = title.next_siblings().flat_map(|it| it.descendants());
    let table = tables.find(|it| it.attribute("class") == Some("scroll"));
    let rows = table.expect("a table").descendants().filter(|it| it.has_tag_name("tr")).skip(1);
    rows.map(|row| row.children().map(|cell| cell.text().unwrap_or_default().to_owned()).collect())
        .collect()
}

/// Number of incidents of a cylinder that were opened.
fn of_cylinder(run: &Run, cylinder: u64) -> usize {
    let opened = run.incidents().into_iter().filter(|it| it["state"] == "opened");
    opened.filter(|it| it["cylinder"] == cylinder).count()
}

#[test]
fn the_tables_say_what_the_summary_says() {
    let scratch = Scratch::new();
    let (run, html) = page(&scratch, &recording(FAULTS), E_TYPE);
    let summary = run.summary();
    let rows = table(&html, "Cylinders");
    assert_eq!(rows.len(), 6);
    for (row, cylinder) in rows.iter().zip(summary["cylinders"].as_array().expect("six")) {
        let number = |key: &str| cylinder[key].as_u64().expect("a count").to_string();
        let implausible: u64 = cylinder["implausible"]
            .as_array()
            .expect("two")
            .iter()
            .filter_map(|n| n.as_u64())
            .sum();
        let worst = |key: &str| format!("{:.2} mm", 1e3 * cylinder[key].as_f64().expect("judged"));
        let expected = [
            number("cylinder"),
            number("gated"),
            number("incomplete"),
            implausible.to_string(),
            worst("worst_r1"),
            worst("worst_r2"),
            worst("worst_r3"),
            of_cylinder(&run, cylinder["cylinder"].as_u64().expect("a number")).to_string(),
        ];
        assert_eq!(row[..], expected);
    }
    let raised: Vec<_> = run.warnings().into_iter().filter(|it| it["state"] == "raised").collect();
    let warnings = table(&html, "Warnings");
    assert_eq!(warnings.len(), raised.len());
    for (row, warning) in warnings.iter().zip(&raised) {
        assert_eq!(row[2], warning["cylinder"].to_string());
        assert_eq!(row[3].to_lowercase(), warning["detector"].as_str().expect("a name"));
        let size =
            warning["residual"].as_f64().map_or("–".to_owned(), |r| format!("{:.2} mm", 1e3 * r));
        assert_eq!(row[7], size);
    }
    assert!(html.contains("528000 frames") && html.contains("39 warnings: FDE1 13, FDE2 10"));
}

/// The page changes nothing of what is printed, and the text's head is all there.
#[test]
fn what_is_printed_is_the_same_with_a_page() {
    let scratch = Scratch::new();
    let log = recording(FAULTS);
    for format in ["human", "jsonl"] {
        let plain = ["replay", &log, "--config", E_TYPE, "--format", format];
        let path = scratch.path(&format!("{format}.html"));
        let with_page = [&plain[..], &["--report", &path]].concat();
        assert_eq!(tertius(&plain, b""), tertius(&with_page, b""));
    }
    assert_eq!(scratch.read("human.html"), scratch.read("jsonl.html"));
    let text = tertius(&["replay", &log, "--config", E_TYPE], b"").ok().stdout;
    let html = scratch.read("human.html");
    let said: String = parse(&html)
        .descendants()
        .filter_map(|node| node.text())
        .flat_map(str::split_whitespace)
        .collect();
    let head = text.lines().skip(1).take_while(|line| !line.contains("worst R1"));
    // The verdict and the stories are folded, and a cell of the table is a piece of its own.
    for paragraph in head.collect::<Vec<_>>().split(|line| line.is_empty()) {
        let is_table = paragraph.first().is_some_and(|line| line.contains("lasted"));
        for line in paragraph.iter().filter(|_| !is_table) {
            let line: String = line.split_whitespace().collect();
            assert!(said.contains(&line), "{line:?} is not on the page");
        }
    }
}

/// Each panel has its residual's own thresholds where they belong: those of R3 are not those of R1.
#[test]
fn thresholds_are_drawn_where_they_belong() {
    let scratch = Scratch::new();
    let (_, html) = page(&scratch, &recording(FAULTS), E_TYPE);
    let document = parse(&html);
    let figures = Figure::all(&document);
    let over_time: Vec<&Figure> =
        figures.iter().filter(|it| it.title.contains(": residuals")).collect();
    assert_eq!(over_time.len(), 6);
    for figure in over_time {
        let panels = figure.panels();
        assert_eq!(panels.len(), 3);
        for (panel, high) in panels.iter().zip([1.0, 1.0, 1.5]) {
            panel.assert_levels(Look::RED, &[high, -high]);
            panel.assert_levels(Look::ORANGE, &[0.75 * high, -0.75 * high]);
        }
    }
}

/// A zoom shows the residuals of the detectors that warned, each with its own thresholds.
#[test]
fn zooms_have_the_bounds_of_their_detectors() {
    let scratch = Scratch::new();
    let (run, html) = page(&scratch, &recording(FAULTS), E_TYPE);
    let document = parse(&html);
    let figures = Figure::all(&document);
    let zooms: Vec<&Figure> = figures.iter().filter(|it| it.title.contains(" at ")).collect();
    let listed: usize = zooms.iter().map(|zoom| zoom.notes.len()).sum();
    let raised = run.warnings().iter().filter(|it| it["state"] == "raised").count();
    assert_eq!(listed, raised, "every warning is in the caption of one zoom");
    let mut seen = [0; 3];
    for zoom in zooms {
        let warned =
            |name: &str| zoom.notes.iter().any(|note| note.contains(&format!(" ({name}): ")));
        let residuals: Vec<f64> = [("FDE1", 1.0), ("FDE2", 1.0), ("FDE3", 1.5)]
            .into_iter()
            .enumerate()
            .filter(|(_, (name, _))| warned(name))
            .map(|(i, (_, bound))| {
                seen[i] += 1;
                bound
            })
            .collect();
        let panels = zoom.panels();
        assert_eq!(panels.len(), 1 + residuals.len(), "{}", zoom.title);
        for (panel, bound) in panels[1..].iter().zip(residuals) {
            panel.assert_levels(Look::RED, &[bound, -bound]);
        }
    }
    assert!(seen.iter().all(|count| *count > 3), "{seen:?}");
}

#[test]
fn a_healthy_replay_says_so_and_has_no_empty_sections() {
    let scratch = Scratch::new();
    let (run, html) = page(&scratch, &recording(HEALTHY), E_TYPE);
    assert!(
        html.contains("<p>No warnings.</p>") && html.contains("<li>No incident in 10 min.</li>")
    );
    let document = parse(&html);
    let headings = document.descendants().filter(|it| it.has_tag_name("h2"));
    let headings: Vec<&str> = headings.filter_map(|it| it.text()).collect();
    assert_eq!(headings, ["Cylinders", "Residuals over time", "How large the residuals were"]);
    // Of every residual, all judged values: 6 cylinders, R1 and R2 once they have settled.
    let figures = Figure::all(&document);
    let of = |name: &str| figures.iter().find(|it| it.title.starts_with(name)).expect("a figure");
    let gated: usize =
        table(&html, "Cylinders").iter().map(|row| row[1].parse::<usize>().expect("a count")).sum();
    let cylinders = run.summary()["cylinders"].as_array().cloned().expect("six");
    let samples: u64 = cylinders.iter().filter_map(|cylinder| cylinder["samples"].as_u64()).sum();
    let samples = samples as usize;
    assert!(of("R1: ").title.starts_with(&format!("R1: {} values", samples - gated)));
    assert!(of("R3: ").title.starts_with(&format!("R3: {samples} values")));
}

/// A machine with one cylinder, whose model does not fit and that warns all the time.
#[test]
fn another_machine_has_a_page_too() {
    let scratch = Scratch::new();
    let (_, html) = page(&scratch, &recording("hanging-load.log.gz"), HANGING_LOAD);
    let document = parse(&html);
    let figures = Figure::all(&document);
    let zooms = figures.iter().filter(|it| it.title.contains(" at ")).count();
    assert!((1..=40).contains(&zooms), "{zooms}");
    assert_eq!(figures.iter().filter(|it| it.title.ends_with(": residuals")).count(), 1);
}

#[test]
fn names_cannot_become_markup() {
    let scratch = Scratch::new();
    let evil = "<script>alert(1)</script> & \\\"Söhne\\\"";
    let config = scratch.config(&[("\"Ampelmann E-type, simulated\"", &format!("\"{evil}\""))]);
    let log = scratch.write("<b>.log", between(&recorded(FAULTS), 0.0, 3.0));
    let (_, html) = page(&scratch, &log, &config);
    assert!(!html.contains("<script") && !html.contains("<b>"));
    let document = parse(&html);
    let title = document.descendants().find(|it| it.has_tag_name("h1")).expect("a title");
    assert_eq!(title.text(), Some("Replay: <script>alert(1)</script> & \"Söhne\""));
    // Nothing refers to anything outside.
    for node in document.descendants() {
        for attribute in node.attributes() {
            let is_inside = attribute.name() == "href" && attribute.value().starts_with('#');
            let refers = ["src", "href", "onload"].contains(&attribute.name());
            assert!(is_inside || !refers, "{attribute:?}");
        }
    }
}

/// Five hours, of which each minute has faults: the page is no larger than that of minutes.
#[test]
fn a_long_recording_has_a_page_of_bounded_size() {
    let scratch = Scratch::new();
    let minute = between(&recorded(FAULTS), 60.0, 100.0);
    // Only one cylinder, so that the recording can be made and read in seconds.
    let one: Vec<&str> = minute
        .lines()
        .filter(|it| ["181#", "191#", "1A1#", "080#", "1C1#"].iter().any(|id| it.contains(id)))
        .collect();
    let mut log = String::new();
    for repeat in 0..450_i64 {
        for line in &one {
            let at = 1_700_000_000 + support::seconds(line) as i64 + 40 * repeat;
            log += &format!("({at}{}\n", &line[11..]);
        }
    }
    let log = scratch.write("long.log", log);
    let (run, html) = page(&scratch, &log, E_TYPE);
    assert!(run.summary()["duration"].as_f64().is_some_and(|duration| duration > 17_900.0));
    assert!(html.len() < 5_000_000, "{} bytes", html.len());
    let raised = run.warnings().iter().filter(|it| it["state"] == "raised").count();
    assert!(raised > 1000, "{raised}");
    let document = parse(&html);
    let figures = Figure::all(&document);
    let zooms: Vec<&Figure> = figures.iter().filter(|it| it.title.contains(" at ")).collect();
    assert_eq!(zooms.len(), 40);
    let listed: usize = zooms.iter().map(|zoom| zoom.notes.len()).sum();
    assert!(html.contains(&format!(
        "The first 40 places are drawn; {} warnings elsewhere are not.",
        raised - listed
    )));
}

/// Where the clock of the recording is set back the figures go on, and say so.
#[test]
fn a_jump_in_time_is_told_and_loses_nothing() {
    let scratch = Scratch::new();
    let all = recorded(FAULTS);
    // First what happens at 75 s, then what happened at 60 s.
    let log = scratch.write("jump.log", between(&all, 74.0, 78.0) + &between(&all, 58.0, 62.0));
    let (run, html) = page(&scratch, &log, E_TYPE);
    assert_eq!(run.summary()["time_jumps"], 1);
    assert!(html.contains("The time stamps jumped once."));
    let document = parse(&html);
    let figures = Figure::all(&document);
    let first = figures.iter().find(|it| it.title == "Cylinder 1: residuals").expect("there");
    // 2.6 mm before the jump and 1.1 mm behind it, eight seconds in all, both in the figure.
    let r1 = &first.panels()[0];
    let (left, right): (Vec<_>, Vec<_>) =
        r1.curve(Look::BLUE).into_iter().partition(|(t, _)| *t < 0.5);
    let largest = |points: &[(f64, f64)]| points.iter().fold(0.0, |most: f64, (_, r)| most.max(*r));
    assert!((2.4..2.8).contains(&largest(&left)), "{}", largest(&left));
    assert!((1.0..1.3).contains(&largest(&right)), "{}", largest(&right));
}

#[test]
fn a_page_is_written_whole_or_not_at_all() {
    let scratch = Scratch::new();
    let kept = scratch.write("kept.html", "what was there");
    let bad = scratch.write("no.toml", "[machine]\n");
    let log = recording(FAULTS);
    let run = tertius(&["replay", &log, "--config", &bad, "--report", &kept], b"");
    assert_eq!((run.code, scratch.read("kept.html").as_str()), (Some(2), "what was there"));
    // A folder that is not there, the input, another output, a folder.
    let nowhere = scratch.path("no/page.html");
    let run = tertius(&["replay", &log, "--config", E_TYPE, "--report", &nowhere], b"");
    run.failed(2, &[&nowhere, "cannot be created"]);
    assert!(!fs::exists(scratch.path("no")).expect("it can be asked"));
    let copy = scratch.write("copy.log", between(&recorded(FAULTS), 0.0, 3.0));
    let run = tertius(&["replay", &copy, "--config", E_TYPE, "--report", &copy], b"");
    run.failed(2, &["would be written over the input"]);
    let both = ["replay", &copy, "--config", E_TYPE, "--report", &kept, "--warnings", &kept];
    tertius(&both, b"").failed(2, &["is to hold two outputs"]);
    assert_eq!(scratch.read("kept.html"), "what was there");
    // Then the real one takes its place, and nothing is left beside it.
    let replaced = ["replay", &copy, "--config", E_TYPE, "--report", &kept];
    tertius(&replaced, b"").failed(2, &[&kept, "this command did not write it", "--force"]);
    assert_eq!(scratch.read("kept.html"), "what was there");
    tertius(&[&replaced[..], &["--force"]].concat(), b"").ok();
    assert!(scratch.read("kept.html").contains("content=\"tertius 0.1.0 replay\""));
    // Its own page is written over without being asked.
    tertius(&replaced, b"").ok();
    assert!(scratch.read("kept.html").ends_with("</html>\n"));
    let folder = std::path::Path::new(&kept).parent().expect("a folder");
    let left = fs::read_dir(folder).expect("it can be read").filter(|entry| {
        entry.as_ref().is_ok_and(|entry| entry.file_name().to_string_lossy().ends_with(".part"))
    });
    assert_eq!(left.count(), 0);
}
