//! Which transducer has drifted, told by a year on the stops: right, early, and hardly ever wrong.

use crate::year::{CYLINDERS, Grade, Machine, Outcome, Temperature, year};
use std::fmt::Write as _;
use std::sync::Mutex;
use tertius::sequential::{Blame, Gauging};

/// Days from visit to visit.
const DAILY: f64 = 1.0;
const WEEKLY: f64 = 7.0;
const MONTHLY: f64 = 30.4375;

/// Years of the same kind.
fn years(
    series: u64,
    grade: Grade,
    temperature: Temperature,
    days: f64,
    rate: f64,
) -> Vec<Outcome> {
    (0..series).map(|seed| year(grade, temperature, days, rate, seed)).collect()
}

/// How far those had drifted that were named, in order; the rest is infinitely far.
fn named(outcomes: &[Outcome]) -> Vec<f64> {
    let mut named: Vec<f64> =
        outcomes.iter().map(|it| it.right.filter(|_| !it.wrong).unwrap_or(f64::INFINITY)).collect();
    named.sort_by(f64::total_cmp);
    named
}

#[test]
fn a_drift_is_named_before_it_is_a_millimetre() {
    use Grade::{Coarse, Fine};
    for (grade, days, rate, most) in [
        (Fine, WEEKLY, 1.0, 1.0),
        (Fine, WEEKLY, 3.0, 1.0),
        (Fine, WEEKLY, 10.0, 1.2),
        (Coarse, WEEKLY, 3.0, 1.5),
        (Fine, MONTHLY, 3.0, 1.7),
        (Fine, MONTHLY, 10.0, 1.7),
        (Fine, DAILY, 10.0, 0.7),
    ] {
        let series = if days == DAILY { 2 } else { 20 };
        let outcomes = years(series, grade, Temperature::Common, days, rate);
        let what = format!("{grade:?}, every {days} days, {rate} mm a year");
        assert!(outcomes.iter().all(|it| !it.wrong && it.false_blames == 0), "{what}");
        let named = named(&outcomes);
        // Nine of ten, and all of those that have the time.
        assert!(named[named.len() * 9 / 10 - 1] <= most, "{what}: {named:?}");
        assert!(rate < 3.0 || named[named.len() - 1].is_finite(), "{what}: {named:?}");
    }
}

/// Towards the end of a first year, half of a drift and a season that no difference has look nearly like all of it,
/// and seem to move the other transducer, too. The days up to then are only read.
#[test]
fn a_drift_of_a_year_is_not_taken_for_half_a_year_and_a_season() {
    for seed in 0..40 {
        let mut machine = fine(seed);
        for day in 0..365 {
            let years = f64::from(day) / 365.25;
            machine.visit(
                years,
                years,
                |n, which| {
                    if (n, which) == (0, 1) { 3.0 * years } else { 0.0 }
                },
            );
            assert!(day < 340 || machine.blames() == only(0, Blame::C2), "{seed}, day {day}");
        }
    }
}

/// What no thermometer takes away delays the answer, and does not make it wrong.
#[test]
fn temperatures_that_differ_between_the_cylinders_blame_nobody() {
    for (grade, rate) in [(Grade::Fine, 0.0), (Grade::Fine, 3.0), (Grade::Coarse, 3.0)] {
        let outcomes = years(20, grade, Temperature::Each, WEEKLY, rate);
        let wrong = outcomes.iter().filter(|it| it.wrong).count();
        let healthy: usize = outcomes.iter().map(|it| it.false_blames).sum();
        assert_eq!((wrong, healthy), (0, 0), "{grade:?} {rate} mm a year");
        let named = named(&outcomes);
        assert!(rate == 0.0 || named[18] < 3.0, "{named:?}");
    }
}

/// Visits of `machine` each week from the first to the last; whom they blame in the end.
fn weeks(
    machine: &mut Machine,
    weeks: std::ops::Range<i32>,
    moved: impl Fn(f64, usize, usize) -> f64,
) -> Vec<Blame> {
    for week in weeks {
        let years = f64::from(week) * WEEKLY / 365.25;
        machine.visit(years, years, |n, which| moved(years, n, which));
    }
    machine.blames()
}

fn fine(seed: u64) -> Machine {
    Machine::new(Grade::Fine, Temperature::Common, seed)
}

/// C2 of the third cylinder drifts by 3 mm a year from the tenth week on.
fn drifts(years: f64, n: usize, which: usize) -> f64 {
    if (n, which) == (2, 1) { 3.0 * (years - 10.0 * WEEKLY / 365.25).max(0.0) } else { 0.0 }
}

fn only(cylinder: usize, blame: Blame) -> Vec<Blame> {
    let mut blames = vec![Blame::Neither; CYLINDERS];
    blames[cylinder] = blame;
    blames
}

#[test]
fn months_without_a_visit_cost_no_side() {
    for seed in 0..10 {
        let mut machine = fine(seed);
        assert_eq!(weeks(&mut machine, 0..12, drifts), vec![Blame::Neither; CYLINDERS]);
        assert_eq!(weeks(&mut machine, 38..44, drifts), only(2, Blame::C2), "{seed}");
    }
}

/// Its battery was flat: 1970 until it is set right after ten weeks.
#[test]
fn a_clock_that_was_set_costs_no_side() {
    for (seed, wrong) in (0..10).flat_map(|seed| [(seed, -54.75), (seed, -0.9), (seed, 9.0)]) {
        let mut machine = fine(seed);
        weeks(&mut machine, 0..15, drifts);
        for week in 15..25 {
            let years = f64::from(week) * WEEKLY / 365.25;
            machine.visit(years, years + wrong, |n, which| drifts(years, n, which));
        }
        let dwells = |machine: &Machine| machine.histories[0].dwells().len();
        assert_eq!(dwells(&machine), 25, "each is kept: {wrong}");
        // What seems to have taken a year longer is clear a little later, and less clear of the other.
        let end = if wrong == -0.9 { 60 } else { 40 };
        let mut blames = weeks(&mut machine, 25..end, drifts);
        if wrong == -0.9 && blames[2] == Blame::Both {
            blames[2] = Blame::C2;
        }
        assert_eq!(blames, only(2, Blame::C2), "{seed} {wrong}");
        assert_eq!(dwells(&machine), usize::try_from(end).expect("some"), "{wrong}");
    }
}

#[test]
fn a_transducer_that_was_replaced_begins_anew_with_its_calibration() {
    for seed in 0..10 {
        let moved = |years: f64, n, which| match (n, which) {
            (2, 1) if years > 0.5 => -3.0,
            _ => drifts(years, n, which),
        };
        let mut machine = fine(seed);
        assert_eq!(weeks(&mut machine, 0..26, moved), only(2, Blame::C2), "{seed}");
        // The new one reads 3 mm less, which its calibration knows.
        let gauging = Gauging { count: 1e-4, corrected: Some([1.0, 3e-3]) };
        machine.histories[2].gauge(gauging);
        assert_eq!(weeks(&mut machine, 27..60, moved), vec![Blame::Neither; CYLINDERS], "{seed}");
        // One that was adjusted and not calibrated has stepped.
        let stepped = |years, n, which| {
            if (n, which) == (4, 0) && years > 1.2 { 2.0 } else { moved(years, n, which) }
        };
        assert_eq!(weeks(&mut machine, 60..66, stepped), only(4, Blame::C1), "{seed}");
    }
}

#[test]
fn a_jump_is_named_at_the_next_visit() {
    for seed in 0..10 {
        let mut machine = fine(seed);
        let jumps = |years, n, which| if (n, which) == (1, 0) && years > 0.2 { -2.0 } else { 0.0 };
        weeks(&mut machine, 0..10, jumps);
        assert_eq!(weeks(&mut machine, 11..12, jumps), only(1, Blame::C1), "{seed}");
    }
}

#[test]
fn both_that_drift_apart_are_both_blamed() {
    for seed in 0..10 {
        let mut machine = fine(seed);
        let both = |years, n, which| if n == 3 { [4.0, -4.0][which] * years } else { 0.0 };
        assert_eq!(weeks(&mut machine, 0..40, both), only(3, Blame::Both), "{seed}");
    }
}

/// Few cylinders are no thermometer: then only what temperature cannot be is told.
#[test]
fn a_machine_of_two_cylinders_names_large_drifts_only() {
    let judge = |moved: &dyn Fn(f64, usize, usize) -> f64, until: i32| {
        let mut machine = fine(1);
        machine.histories.truncate(2);
        weeks(&mut machine, 0..until, moved)
    };
    let large = |years, n, which| if (n, which) == (0, 0) { 10.0 * years } else { 0.0 };
    assert_eq!(judge(&large, 30), [Blame::C1, Blame::Neither]);
    let small = |years, n, which| if (n, which) == (0, 0) { 1.0 * years } else { 0.0 };
    assert_eq!(judge(&small, 30)[1], Blame::Neither);
    assert!(matches!(judge(&small, 30)[0], Blame::Neither | Blame::Undecided));
}

/// Prints the tables of docs/EVALUATION.md where `TERTIUS_SERIES` says how many years a cell; a few
/// otherwise.
#[test]
fn hardly_anyone_is_blamed_wrongly_in_years_of_every_kind() {
    let asked = std::env::var("TERTIUS_SERIES").ok().and_then(|text| text.parse().ok());
    let series: u64 = asked.unwrap_or(2);
    let mut cells = Vec::new();
    for grade in [Grade::Fine, Grade::Coarse] {
        for temperature in [Temperature::Common, Temperature::Each] {
            for days in [DAILY, WEEKLY, MONTHLY] {
                // A year of daily visits takes a second.
                if asked.is_some() || days > DAILY {
                    cells
                        .extend([0.0, 1.0, 3.0, 10.0].map(|rate| (grade, temperature, days, rate)));
                }
            }
        }
    }
    let next = Mutex::new(cells.into_iter().enumerate());
    let found = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                loop {
                    let cell = next.lock().expect("no one panics").next();
                    let Some((place, (grade, temperature, days, rate))) = cell else { break };
                    let outcomes = years(series, grade, temperature, days, rate);
                    let row = row(&outcomes, &format!("{grade:?}, {temperature:?}"), days, rate);
                    found.lock().expect("no one panics").push((place, row, outcomes));
                }
            });
        }
    });
    let mut found = found.into_inner().expect("no one panics");
    found.sort_by_key(|(place, ..)| *place);
    println!(
        "| transducers, temperature | days | mm a year | right | wrong | never | mm when named (95 %) | healthy blamed |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
    found.iter().for_each(|(_, row, _)| print!("{row}"));
    let outcomes = || found.iter().flat_map(|(.., outcomes)| outcomes);
    let wrong = outcomes().filter(|it| it.wrong).count();
    let healthy: usize = outcomes().map(|it| it.false_blames).sum();
    let (all, pairs) = (outcomes().count(), outcomes().map(|it| it.healthy).sum::<usize>());
    println!("{wrong} wrong in {all} machine-years; {healthy} of {pairs} healthy pairs blamed");
    assert!((wrong + healthy) * 100 <= all, "{wrong} and {healthy} of {all}");
}

fn row(outcomes: &[Outcome], what: &str, days: f64, rate: f64) -> String {
    let wrong = outcomes.iter().filter(|it| it.wrong).count();
    let named: Vec<f64> = named(outcomes).into_iter().filter(|mm| mm.is_finite()).collect();
    let never = outcomes.len() - wrong - named.len();
    let at = |part: f64| named.get((part * named.len() as f64) as usize).or(named.last());
    let far = match (at(0.5), at(0.95)) {
        (Some(median), Some(most)) => format!("{median:.2} ({most:.2})"),
        _ => "–".to_owned(),
    };
    let blamed: usize = outcomes.iter().map(|it| it.false_blames).sum();
    let healthy: usize = outcomes.iter().map(|it| it.healthy).sum();
    let mut row = String::new();
    let right = if rate > 0.0 { named.len().to_string() } else { "–".to_owned() };
    // Writing to a string cannot fail.
    _ = writeln!(
        row,
        "| {what} | {days:.0} | {rate} | {right} | {wrong} | {never} | {far} | {blamed} of {healthy} |"
    );
    row
}
