//! A cylinder with one transducer is compared with what it read on its stop before, beside pairs and alone.

use std::path::Path;
use tertius::config::{self, Settings, design};
use tertius::dbc::{Database, text};
use tertius::monitor::{Monitor, MonitorDesign, SavedState, Sink};
use tertius::sequential::{Archive, Blame, Dwell, Judgement, stops};
use tertius_testing::process::{top, write};
use tertius_testing::support::{Scratch, changed, replay, tertius};
use tertius_testing::visits::{CONFIG, COUNT, DRIFTING, NAME, STEP, visits};

/// Visits after which the drift of 2 mm in a week is found, whatever the stops wear.
const DAYS: u16 = 15;

#[derive(Default)]
struct Dwells(Vec<(u8, Dwell)>);

impl Sink for Dwells {
    fn dwell(&mut self, cylinder: u8, dwell: &Dwell) {
        self.0.push((cylinder, *dwell));
    }
}

/// Takes C2 from cylinder `n`.
fn without_c2(settings: &mut Settings, n: u8) {
    let cylinder = &mut settings.cylinder[usize::from(n) - 1];
    (cylinder.c2, cylinder.sequential) = (false, None);
}

fn design_of(singles: &[u8]) -> MonitorDesign {
    let mut loaded = config::load(&top().join(CONFIG)).expect("it ships");
    singles.iter().for_each(|n| without_c2(&mut loaded.settings, *n));
    let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("it is sound");
    design::judging(&loaded.settings, &database).expect("they fit")
}

fn play(monitor: &mut Monitor, days: std::ops::Range<u16>) -> Dwells {
    let mut heard = Dwells::default();
    visits(days).iter().for_each(|frame| monitor.take(frame, &mut heard));
    monitor.finish(&mut heard);
    heard
}

fn kept(monitor: &Monitor) -> Archive {
    let mut archive = Archive::new(NAME, 6);
    monitor.save(&mut archive);
    archive
}

fn blames(monitor: &Monitor) -> Vec<Blame> {
    let judged = stops::judge(monitor.dwells().map(|(_, dwells)| dwells));
    let blame = |judged: Option<Judgement>| judged.expect("there is a history").blame;
    judged.into_iter().map(blame).collect()
}

/// Only the third cylinder is blamed.
fn only_the_third() -> [Blame; 6] {
    let mut blames = [Blame::Neither; 6];
    blames[usize::from(DRIFTING) - 1] = Blame::C1;
    blames
}

#[test]
fn an_only_transducer_that_drifts_is_named_beside_pairs_and_where_none_has_another() {
    let mut pairs = Monitor::new(design_of(&[]));
    let of_pairs = play(&mut pairs, 0..DAYS);
    for singles in [&[3][..], &[1, 2, 3, 4, 5, 6]] {
        let mut monitor = Monitor::new(design_of(singles));
        let heard = play(&mut monitor, 0..DAYS);
        assert_eq!(blames(&monitor), only_the_third(), "{singles:?}");
        assert_eq!(heard.0.len(), of_pairs.0.len());
        for ((n, dwell), (_, pair)) in heard.0.iter().zip(&of_pairs.0) {
            let c2 = pair.readings.c2.filter(|_| !singles.contains(n));
            assert_eq!((dwell.readings.c1, dwell.readings.c2), (pair.readings.c1, c2), "{n}");
        }
    }
}

#[test]
fn an_archive_and_a_state_go_on_where_the_last_one_ended() {
    let design = || design_of(&[1, 2, 3]);
    let mut whole = Monitor::new(design());
    play(&mut whole, 0..DAYS);
    let mut before = Monitor::new(design());
    play(&mut before, 0..DAYS - 2);
    let text = kept(&before).to_text();
    let mut after = Monitor::new(design());
    after.restore(&Archive::parse(text.as_bytes(), NAME, 6).expect("it was just written"));
    play(&mut after, DAYS - 2..DAYS);
    assert_eq!(kept(&after), kept(&whole));
    assert_eq!(blames(&after), only_the_third());

    let state = SavedState::of(&before, design().checksum(), before.newest().expect("frames"));
    let state = SavedState::from_bytes(&state.to_bytes()).expect("it was just written");
    let mut resumed = state.resume(design()).expect("it is of this design");
    play(&mut resumed, DAYS - 2..DAYS);
    assert_eq!(kept(&resumed), kept(&whole));
}

/// C1 is where it was, and nothing says how far apart from it the new C2 is.
#[test]
fn a_c2_that_is_taken_off_or_fitted_leaves_what_can_be_compared() {
    let mut pairs = Monitor::new(design_of(&[]));
    play(&mut pairs, 0..5);
    let mut single = Monitor::new(design_of(&[3]));
    single.restore(&kept(&pairs));
    play(&mut single, 5..DAYS);
    assert_eq!(blames(&single), only_the_third());
    let mut fitted = Monitor::new(design_of(&[]));
    fitted.restore(&kept(&single));
    play(&mut fitted, DAYS..DAYS + 1);
    let dwells: Vec<usize> = fitted.dwells().map(|(_, it)| it.dwells().len()).collect();
    let whole = usize::from(DAYS) + 1;
    assert_eq!(dwells, [whole, whole, 1, whole, whole, whole]);
}

/// The configuration in which cylinder 3 has C1 alone.
fn mixed(scratch: &Scratch) -> String {
    let text = std::fs::read_to_string(top().join(CONFIG)).expect("it ships");
    let (head, rest) = text.split_once("n = 3\n").expect("there is a third");
    let (_, rest) = rest.split_once("[[cylinder]]").expect("there is a fourth");
    let dbc = format!("{:?}", top().join("dbc/e-type.dbc"));
    let text = format!("{head}n = 3\nc2 = false\n\n[[cylinder]]{rest}");
    scratch.write("machine.toml", changed(&text, &[("\"../../dbc/e-type.dbc\"", &dbc)]))
}

#[test]
fn the_reports_name_c1_and_do_not_forget_its_stop() {
    let scratch = Scratch::new();
    let config = mixed(&scratch);
    let (log, history, page) =
        (scratch.path("days.log"), scratch.path("kept.dwells"), scratch.path("page.html"));
    write(Path::new(&log), "can0", &visits(0..DAYS));
    let parked = &["never in a monitored state"];
    let run = replay(&[&log], &config, &["--history", &history]).failed(1, parked);
    let warnings = run.warnings();
    let said: Vec<String> = warnings
        .iter()
        .map(|it| format!("{} {} {}", it["cylinder"], it["detector"], it["suspect"]))
        .collect();
    // It is C1 or its stop: the estimate and everything that supervises C1 go on.
    assert_eq!(said, ["3 \"sequential\" \"undecided\""], "{warnings:?}");
    assert_eq!(warnings[0]["level"], "yellow", "{warnings:?}");
    let summary = run.summary();
    let trends = summary["trends"].as_array().expect("trends");
    assert_eq!(trends.len(), 11, "C2 of cylinder 3 has none");
    for trend in trends {
        let drifts = (&trend["cylinder"], &trend["transducer"]) == (&3.into(), &"c1".into());
        assert_eq!(trend["months_until_maintenance"].is_object(), drifts, "{trend}");
        if drifts {
            let moved = trend["moved_mm"].as_f64().expect("a number");
            let by_now = 9e3 * f64::from(STEP) * COUNT;
            assert!((moved - by_now).abs() < 0.1, "{moved} of {by_now}");
        }
    }
    let kept = Archive::parse(scratch.read("kept.dwells").as_bytes(), NAME, 6).expect("an archive");
    let is_single = |it: &tertius::sequential::DwellHistory| it.dwells()[0].readings.c2.is_none();
    let singles: Vec<bool> = kept.cylinders.iter().map(is_single).collect();
    assert_eq!(singles, [false, false, true, false, false, false]);

    let told =
        tertius(&["replay", &log, "--config", &config, "--report", &page], b"").failed(1, parked);
    let page = scratch.read("page.html");
    let open = "a stop that has worn by more than usual, or is dented, looks the same";
    for text in [&told.stdout, &page] {
        assert!(
            text.contains("The stops show a drift: C1 of cylinder 3. Where C1 is the only"),
            "{text}"
        );
        assert!(text.contains(open), "{text}");
    }
    let text = told.stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(text.contains("On its stop C1 read"), "{text}");
    assert!(text.contains("so it is C1 or its stop: one that has worn"), "{text}");
    assert!(
        text.contains("Look at the cylinder's stop and what the rod stands on there"),
        "{text}"
    );
    assert_eq!(page.matches("readings on the stop</p>").count(), 6, "a figure for each cylinder");

    let text = tertius(&["check", &config], b"").ok().stdout;
    let line = "  stop      C1 is compared with what it read there before, day by day\n";
    assert_eq!(text.matches(line).count(), 1, "{text}");
}
