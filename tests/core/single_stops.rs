//! What the stop tells of an only transducer in a year: a drift or a step of it, or of the stop itself, which look the same.

use crate::year::{Grade, Machine, Temperature};
use std::fmt::Write as _;
use std::sync::Mutex;
use tertius::sequential::Blame;

const DAILY: f64 = 1.0;
const WEEKLY: f64 = 7.0;
const MONTHLY: f64 = 30.4375;

const DAYS: f64 = 365.25;

/// What happens to C1 of the first cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Course {
    Nothing,
    /// It drifts from the first visit on, mm a year.
    Drift(f64),
    /// It drifts after half a year, mm a year.
    LateDrift(f64),
    /// It steps after half a year, mm.
    Step(f64),
}

impl Course {
    /// By how much it has moved after so many years, mm.
    fn moved(self, years: f64) -> f64 {
        match self {
            Self::Nothing => 0.0,
            Self::Drift(rate) => rate * years,
            Self::LateDrift(rate) => rate * (years - 0.5).max(0.0),
            Self::Step(size) => {
                if years > 0.5 {
                    size
                } else {
                    0.0
                }
            }
        }
    }

    fn words(self) -> String {
        match self {
            Self::Nothing => "nothing".to_owned(),
            Self::Drift(rate) => format!("{rate} mm a year"),
            Self::LateDrift(rate) => format!("{rate} mm a year, late"),
            Self::Step(size) => format!("step of {size} mm"),
        }
    }
}

/// A kind of year.
#[derive(Clone, Copy, Debug)]
struct Kind {
    cylinders: usize,
    /// So many of them have C1 alone.
    singles: usize,
    grade: Grade,
    temperature: Temperature,
    /// From visit to visit.
    days: f64,
    course: Course,
}

/// Six cylinders with fine transducers of which none has a C2, a common temperature, and a visit a week.
const SIX: Kind = Kind {
    cylinders: 6,
    singles: 6,
    grade: Grade::Fine,
    temperature: Temperature::Common,
    days: WEEKLY,
    course: Course::Nothing,
};

/// What came of a year.
#[derive(Clone, Copy, Debug, Default)]
struct Told {
    /// C1 was named, and how far it had moved then, mm.
    named: Option<f64>,
    /// It was named before anything happened.
    early: bool,
    /// It is named at the end of the year.
    stays: bool,
    /// Healthy cylinders with one transducer and with two of which anything was ever named.
    false_blames: [usize; 2],
}

impl Kind {
    fn year(self, seed: u64) -> Told {
        let machine = Machine::new(self.grade, self.temperature, seed);
        let mut machine = machine.of(self.cylinders, self.singles);
        let sign = if machine.toss() { 1.0 } else { -1.0 };
        let (mut told, mut blamed) = (Told::default(), vec![false; self.cylinders]);
        for k in 0..(DAYS / self.days) as usize {
            let years = k as f64 * self.days / DAYS;
            let moved = sign * self.course.moved(years);
            machine.visit(years, years, |n, which| if (n, which) == (0, 0) { moved } else { 0.0 });
            let blames = machine.blames();
            for (blamed, blame) in blamed.iter_mut().zip(&blames) {
                *blamed |= matches!(blame, Blame::C1 | Blame::C2 | Blame::Both);
            }
            if self.course != Course::Nothing {
                told.stays = blames[0] == Blame::C1;
                if told.stays && moved == 0.0 {
                    told.early = true;
                } else if told.stays {
                    told.named.get_or_insert(moved.abs());
                }
            }
        }
        let healthy = usize::from(self.course != Course::Nothing);
        let count = |of: &[bool]| of.iter().filter(|it| **it).count();
        told.false_blames = [count(&blamed[healthy..self.singles]), count(&blamed[self.singles..])];
        told
    }

    fn years(self, series: u64) -> Vec<Told> {
        (0..series).map(|seed| self.year(seed)).collect()
    }

    /// Healthy cylinders with one transducer and with two.
    fn healthy(self) -> [usize; 2] {
        [self.singles - usize::from(self.course != Course::Nothing), self.cylinders - self.singles]
    }
}

/// How far those had moved that were named, in order, mm; the rest is infinitely far.
fn sizes(told: &[Told]) -> Vec<f64> {
    let mut sizes: Vec<f64> = told.iter().map(|it| it.named.unwrap_or(f64::INFINITY)).collect();
    sizes.sort_by(f64::total_cmp);
    sizes
}

fn false_blames(told: &[Told]) -> [usize; 2] {
    [0, 1].map(|i| told.iter().map(|it| it.false_blames[i]).sum())
}

/// Nothing but what stops wear and weather moves is told of healthy ones, whoever has a second transducer.
#[test]
fn healthy_cylinders_are_left_alone_on_every_machine() {
    for (cylinders, singles) in [(6, 6), (6, 3), (2, 2), (1, 1)] {
        for (temperature, days) in [
            (Temperature::Common, WEEKLY),
            (Temperature::Each, WEEKLY),
            (Temperature::Each, MONTHLY),
        ] {
            let kind = Kind { cylinders, singles, temperature, days, ..SIX };
            assert_eq!(false_blames(&kind.years(20)), [0, 0], "{kind:?}");
        }
    }
}

#[test]
fn a_drift_that_no_stop_wears_is_named_and_stays_so() {
    for (kind, rate, most) in [
        (SIX, 3.0, 1.8),
        (SIX, 10.0, 2.4),
        (Kind { singles: 3, ..SIX }, 3.0, 1.8),
        (Kind { grade: Grade::Coarse, ..SIX }, 3.0, 2.1),
        (Kind { days: MONTHLY, ..SIX }, 3.0, 2.6),
        (Kind { days: DAILY, ..SIX }, 30.0, 1.6),
        // Two cylinders are no thermometer.
        (Kind { cylinders: 2, singles: 2, ..SIX }, 10.0, 6.0),
    ] {
        let told = Kind { course: Course::Drift(rate), ..kind }.years(20);
        let sizes = sizes(&told);
        assert!(sizes[17] <= most, "{kind:?}, {rate} mm a year: {sizes:?}");
        let stay = told.iter().filter(|it| it.stays).count();
        assert!(stay >= 18 && false_blames(&told) == [0, 0], "{kind:?}, {rate} mm a year: {stay}");
    }
}

/// Half a year later no ramp shows it any more, and it is as wrong as before.
#[test]
fn a_step_is_named_at_the_next_visit_and_not_forgotten() {
    for singles in [6, 3] {
        let kind = Kind { singles, course: Course::Step(2.0), ..SIX };
        let told = kind.years(20);
        let stay = told.iter().filter(|it| it.named.is_some() && it.stays && !it.early).count();
        assert!(stay >= 19, "{singles}: {stay}");
        assert_eq!(false_blames(&told), [0, 0], "{singles}");
    }
}

/// That is what stops do.
#[test]
fn what_a_stop_usually_wears_is_nobodys_drift() {
    let told = Kind { course: Course::Drift(0.3), ..SIX }.years(20);
    assert!(told.iter().all(|it| it.named.is_none()), "{told:?}");
}

/// All that a machine with one transducer on each cylinder has in common is its temperature.
#[test]
fn what_all_move_by_is_the_temperature() {
    let mut machine = Machine::new(Grade::Fine, Temperature::Common, 3).of(6, 6);
    for week in 0..52 {
        let years = f64::from(week) * WEEKLY / DAYS;
        machine.visit(years, years, |_, _| 6.0 * years);
        assert!(machine.blames().iter().all(|it| *it == Blame::Neither), "{week}");
    }
}

/// Prints the table of docs/EVALUATION.md where `TERTIUS_SERIES` says how many years a cell; a few otherwise.
#[test]
fn hardly_any_healthy_one_is_named_in_years_of_every_kind() {
    let asked = std::env::var("TERTIUS_SERIES").ok().and_then(|text| text.parse().ok());
    let series: u64 = asked.unwrap_or(2);
    let mut kinds = Vec::new();
    for (cylinders, singles) in [(6, 6), (6, 3), (2, 2)] {
        for temperature in [Temperature::Common, Temperature::Each] {
            for days in [DAILY, WEEKLY, MONTHLY] {
                if asked.is_some() || days > DAILY {
                    kinds.extend(
                        [
                            Course::Nothing,
                            Course::Drift(1.0),
                            Course::Drift(3.0),
                            Course::Drift(10.0),
                            Course::LateDrift(10.0),
                            Course::Step(1.0),
                            Course::Step(2.0),
                        ]
                        .map(|course| Kind {
                            cylinders,
                            singles,
                            temperature,
                            days,
                            course,
                            ..SIX
                        }),
                    );
                }
            }
        }
    }
    let next = Mutex::new(kinds.iter().enumerate());
    let found = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                loop {
                    let kind = next.lock().expect("no one panics").next();
                    let Some((place, kind)) = kind else { break };
                    let told = kind.years(series);
                    found.lock().expect("no one panics").push((place, *kind, told));
                }
            });
        }
    });
    let mut found = found.into_inner().expect("no one panics");
    found.sort_by_key(|(place, ..)| *place);
    println!(
        "| cylinders, with C1 alone | temperature | days | what | named | at the end | mm when named (95 %) | healthy named |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
    found.iter().for_each(|(_, kind, told)| print!("{}", row(*kind, told)));
    let mut sums = [[0; 2]; 2];
    for (_, kind, told) in &found {
        for i in [0, 1] {
            sums[i][0] += false_blames(told)[i];
            sums[i][1] += kind.healthy()[i] * told.len();
        }
    }
    let [[singles, of_singles], [pairs, of_pairs]] = sums;
    println!(
        "{singles} of {of_singles} healthy single transducers named; {pairs} of {of_pairs} healthy pairs"
    );
    assert!(singles * 200 <= of_singles && pairs * 1000 <= of_pairs, "{sums:?}");
}

fn row(kind: Kind, told: &[Told]) -> String {
    let sizes: Vec<f64> = sizes(told).into_iter().filter(|mm| mm.is_finite()).collect();
    let at = |part: f64| sizes.get((part * sizes.len() as f64) as usize).or(sizes.last());
    let far = match (at(0.5), at(0.95)) {
        (Some(median), Some(most)) => format!("{median:.2} ({most:.2})"),
        _ => "–".to_owned(),
    };
    let [named, stay] = match kind.course {
        Course::Nothing => ["–", "–"].map(str::to_owned),
        _ => [sizes.len(), told.iter().filter(|it| it.stays).count()].map(|it| it.to_string()),
    };
    let Kind { cylinders, singles, temperature, days, course, .. } = kind;
    let [blamed, healthy] = [false_blames(told), kind.healthy()].map(|it| it[0] + it[1]);
    let (what, healthy) = (course.words(), healthy * told.len());
    let mut row = String::new();
    // Writing to a string cannot fail.
    _ = writeln!(
        row,
        "| {cylinders}, {singles} | {temperature:?} | {days:.0} | {what} | {named} | {stay} | {far} | {blamed} of {healthy} |"
    );
    row
}
