//! The pages of calibrate, identify and tune: sound, saying what the text says, with its numbers
//! where they belong.

use tertius_testing::page::{Figure, Look, parse};
use tertius_testing::support::{E_TYPE, HANGING_LOAD, Scratch, recording, tertius};

/// Runs `command` on a recording, the healthy one unless another is named, with and without a page: the text, and the page.
fn learnt(command: &[&str], code: i32) -> (String, String) {
    learnt_on(&recording("e-type-healthy.log.zst"), E_TYPE, command, code)
}

fn learnt_on(log: &str, config: &str, command: &[&str], code: i32) -> (String, String) {
    let scratch = Scratch::new();
    let path = scratch.path("page.html");
    let plain = [command, &[log, "--config", config]].concat();
    let run = tertius(&plain, b"");
    assert_eq!(run.code, Some(code), "{}", run.stderr);
    // What is printed, and the exit code, are the same with a page.
    assert_eq!(run, tertius(&[&plain[..], &["--report", &path]].concat(), b""));
    let page = scratch.read("page.html");
    // Both say which configuration it was, as `check` does.
    let check = tertius(&["check", config], b"").ok().stdout;
    let identity = check.lines().find_map(|line| line.strip_prefix("judged by "));
    let with = format!("with {}", identity.expect("it has one"));
    assert!(run.stdout.contains(&with) && page.contains(&with), "{with}: {}", run.stdout);
    (run.stdout, page)
}

/// Every number of the text's tables is on the page.
#[track_caller]
fn assert_tables(text: &str, html: &str) {
    let mut compared = 0;
    for line in text.lines().filter(|line| line.starts_with(' ')) {
        // Cells are two blanks apart or more.
        for cell in line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()) {
            let escaped = cell.replace('<', "&lt;").replace('\'', "&#39;");
            assert!(html.contains(&escaped), "{cell:?} is not on the page");
            compared += 1;
        }
    }
    assert!(compared > 30, "{compared}");
}

/// The number behind `name` in `text`, up to ` mm`.
fn millimetres(text: &str, name: &str) -> f64 {
    let rest = text.split_once(name).unwrap_or_else(|| panic!("no {name} in {text}")).1;
    rest.split_once(" mm").expect("millimetres").0.trim().parse().expect("a number")
}

#[test]
fn a_calibration_shows_the_difference_before_and_after_with_its_bounds() {
    let (text, html) = learnt(&["calibrate"], 0);
    assert_tables(&text, &html);
    let document = parse(&html);
    let figures = Figure::all(&document);
    let (along, figures): (Vec<_>, Vec<_>) =
        figures.into_iter().partition(|figure| figure.title.contains("known along the stroke"));
    assert_eq!(figures.len(), 12, "by time and by position, six cylinders");
    assert_eq!(along.len(), 6);
    for figure in &along {
        let profile = &figure.panels()[0];
        let (band, middle) = (profile.runs(Look::SKY), profile.runs(Look::BLUE));
        let ([low, high], [middle]) = (&band[..], &middle[..]) else {
            panic!("{}: {band:?} {middle:?}", figure.title)
        };
        assert!(middle.len() > 3 && low.len() == middle.len() && high.len() == middle.len());
        for ((low, middle), high) in low.iter().zip(middle).zip(high) {
            assert!(low.1 <= middle.1 && middle.1 <= high.1, "{low:?} {middle:?} {high:?}");
            // Two thirds of what it may be off by, to either side, which is 0.2 mm at the most.
            assert!(high.1 - low.1 < 0.28, "{low:?} {high:?}");
        }
        assert!(high[0].1 - low[0].1 > 0.24, "at its ends it is known no better: {low:?} {high:?}");
    }
    let bound = millimetres(&text, "proposed bound of R3:");
    for figure in &figures {
        let [before, after] = &figure.panels()[..] else { panic!("{}", figure.title) };
        before.assert_levels(Look::RED, &[]);
        after.assert_levels(Look::RED, &[bound, -bound]);
        after.assert_levels(Look::ORANGE, &[1.5, -1.5]);
    }
    // The corrected difference of the first cylinder is that of the table, by a line through all of it.
    let after = &figures[0].panels()[1];
    let largest = after.curve(Look::BLUE).iter().fold(0.0, |most: f64, (_, r)| most.max(r.abs()));
    assert!((0.85..1.3).contains(&largest), "{largest}");
}

#[test]
fn an_identification_shows_what_the_text_says_and_its_curves() {
    let (text, html) = learnt(&["identify", "--nonlinear", "--supply", "200"], 0);
    let linear = text.split_once("\nflow curves").expect("they were asked for").0;
    assert_tables(linear, &html);
    let document = parse(&html);
    let figures = Figure::all(&document);
    let of = |part: &str| figures.iter().filter(|it| it.title.contains(part)).count();
    assert_eq!(of("position and velocity"), 6);
    assert_eq!(of("residuals with"), 12);
    assert_eq!(of("velocity, load pressure and command"), 6);
    // The curves: seven panels of simulation, correlations and data beside them, and one for flow.
    let flow = figures.iter().filter(|it| it.notes.iter().any(|note| note.contains("singletons")));
    assert_eq!(flow.count(), 6);
    // Without strokes at constant velocity there is no friction, and the page says why.
    assert_eq!(html.matches("no friction curve: the recording has 0 stretches").count(), 6);
}

#[test]
fn a_tuning_shows_the_tails_and_what_they_are_extrapolated_to() {
    let (text, html) = learnt(&["tune", "--keep-weights", "--false-alarms-per-year", "100000"], 0);
    assert_tables(&text, &html);
    let document = parse(&html);
    let figures = Figure::all(&document);
    let of = |part: &str| figures.iter().filter(|it| it.title.contains(part)).count();
    assert_eq!((of("healthy residuals"), of(": tail")), (12, 12));
    // δ_h is written on every figure that it is drawn in.
    let high = text.split_once("δ_h ").expect("a threshold").1;
    let high = high.split_once('\n').expect("a line").0;
    assert!(html.matches(&format!("δ_h: {high}")).count() >= 25, "{high}");
}

/// A recording that the wanted rate lies too far beyond has no thresholds, but it has a page.
#[test]
fn what_is_refused_still_has_its_page() {
    let log = recording("hanging-load.log.gz");
    let (text, html) = learnt_on(&log, HANGING_LOAD, &["tune", "--keep-weights"], 1);
    assert_tables(&text, &html);
    // However far away δ_h is, there are figures, and they say where it is.
    let document = parse(&html);
    assert_eq!(Figure::all(&document).len(), 6);
    let high = text.split_once("δ_h ").expect("a threshold").1;
    let high = high.split_once('\n').expect("a line").0;
    assert!(html.matches(&format!("δ_h: {high}")).count() >= 5, "{high}");
}
