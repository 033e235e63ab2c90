//! Monte Carlo: what a trial says of a fault, that it does not depend on who computes it, and what
//! the command makes of it.

use tertius::alarm::Detector;
use tertius::config::design;
use tertius::config::{self, Settings};
use tertius::dbc::{Database, text};
use tertius::evaluate::contest::{Contest, Rival};
use tertius::evaluate::rows::{Row, RowGroup, RowJob, RowStudy};
use tertius::evaluate::weights::{FAULTS, SETS, SetResult, Weighing};
use tertius::evaluate::{
    Blame, Cell, Extent, Grade, Lessons, Outcome, Plan, ProcessMachine, Serial, Stand, StandError,
    Study, TaughtStudy, Workers,
};
use tertius::inject::{Shape, Wanted};
use tertius::monitor::MonitorDesign;
use tertius::simulator::Tables;
use tertius::verdict::Fault;
use tertius_testing::page::{Figure, parse};
use tertius_testing::support::{self, Scratch};

const CONFIG: &str = "config/e-type-simulated.toml";
const SEA: [f64; 2] = [2.5, 8.0];
const SEED: u64 = 4;

struct Bench {
    settings: Settings,
    database: Database,
    design: MonitorDesign,
}

impl Bench {
    fn new() -> Self {
        let loaded = config::load(&support::top().join(CONFIG)).expect("it is sound");
        let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("it is sound");
        let design = design::judging(&loaded.settings, &database).expect("they fit");
        Self { settings: loaded.settings, database, design }
    }

    fn stand(&self) -> Stand<'_> {
        Stand::new(&Tables::default(), &self.settings, &self.database, &self.design)
    }

    /// The outcomes of so many machines of `row`.
    fn outcomes(&self, row: Row, machines: u32) -> Vec<Outcome> {
        let study =
            RowStudy { rows: vec![row], trials: 1, seed: SEED, cylinders: 6, taught: false };
        let run = |number| study.run(&self.stand(), &[], RowJob { row: 0, number });
        let products = (0..machines).map(|number| run(number).expect("it can be simulated"));
        products.flat_map(|product| product.outcomes).collect()
    }
}

fn extent(studies: &[&'static str], trials: u32, hours: f64) -> Extent {
    Extent {
        cylinders: 6,
        taught: None,
        lag: 0.06,
        trials,
        hours,
        seas: vec![SEA],
        studies: studies.to_vec(),
        lessons: Lessons { calibration: 1.0 / 6.0, level: 1.0 / 6.0 },
        weights: SETS.to_vec(),
    }
}

fn row(shape: Option<Shape>) -> Row {
    Row {
        group: RowGroup::Step,
        cell: Cell { grade: Grade::Fine, sea: SEA },
        in_loop: false,
        wanted: shape.map(Wanted::Shape),
        watch: 10.0,
        claim: None,
        stream: 5,
    }
}

#[test]
fn a_large_step_is_found_in_its_cycle_by_its_own_observer_and_blamed_right() {
    let bench = Bench::new();
    let outcomes = bench.outcomes(row(Some(Shape::Step { size: 0.01 })), 4);
    assert_eq!(outcomes.len(), 24);
    for outcome in &outcomes {
        let own = outcome.own().expect("found");
        assert!(own > 0.0 && own < bench.settings.machine.sample_time, "{outcome:?}");
        assert_eq!(outcome.delay(), Some(own), "nobody was earlier: {outcome:?}");
        assert_eq!(outcome.first_blame(), Some(Blame::Right), "{outcome:?}");
        assert_eq!(outcome.blame, Some(Blame::Right), "{outcome:?}");
        assert_eq!(outcome.kind, Some(Fault::Abrupt), "{outcome:?}");
        assert!(!outcome.spoilt, "{outcome:?}");
    }
    let of_c2 = outcomes.iter().filter(|outcome| outcome.delays[1] == outcome.own()).count();
    assert!((6..19).contains(&of_c2), "C1 and C2 take turns: {of_c2}");
}

#[test]
fn where_nothing_happens_nothing_is_found() {
    for outcome in Bench::new().outcomes(row(None), 2) {
        assert_eq!((outcome.delay(), outcome.blame, outcome.spoilt), (None, None, false));
        assert!(outcome.worst.iter().all(|worst| (1e-5..1e-3).contains(worst)), "{outcome:?}");
    }
}

/// The second recommendation of chapter 6: a controller that reads the drift keeps C1 on its
/// reference and moves the rod off by as much; beside the loop the rod goes on as before, and C1
/// drifts. What is found is the same: FDE3, and nobody is blamed.
#[test]
fn a_drift_in_the_loop_moves_the_rod_and_not_the_reading() {
    let bench = Bench::new();
    let drift =
        Row { group: RowGroup::Loop, watch: 12.0, ..row(Some(Shape::Drift { rate: 1e-3 })) };
    let (beside, within) = (drift, Row { in_loop: true, ..drift });
    for (open, closed) in bench.outcomes(beside, 6).iter().zip(bench.outcomes(within, 6)) {
        assert_eq!(open.rod, Some(0.0));
        let reading = open.reading.expect("it has a twin");
        assert!((0.0112..0.0118).contains(&reading), "{reading} m in the last of 12 s");
        let (rod, reading) = closed.rod.zip(closed.reading).expect("it has a twin");
        assert!((0.0100..0.0125).contains(&rod), "{rod} m");
        assert!(reading < 1.5e-3, "{reading} m");
        for outcome in [open, &closed] {
            let difference = outcome.delays[Detector::Fde3 as usize - 1].expect("found");
            assert!((1.0..2.0).contains(&difference), "{outcome:?}");
        }
    }
}

/// The figures of `study`, which does not depend on the order of its jobs, and the number of these.
fn figures<S: Study>(study: &S, stand: &Stand) -> (usize, S::Figures) {
    let course =
        TaughtStudy::new(study, stand, &Serial { reversed: true }).expect("it can be learnt");
    let evaluated = |reversed| course.figures(&Serial { reversed }).expect("it can be simulated");
    let forwards = evaluated(false);
    assert_eq!(forwards, evaluated(true));
    (course.jobs(), forwards)
}

#[test]
fn the_order_of_the_jobs_does_not_matter() {
    let bench = Bench::new();
    let extent = extent(&["chance", "noise", "healthy"], 12, 0.3);
    let plan = Plan::new(SEED, extent).expect("it is not too much");
    let stand = bench.stand();
    let campaign = plan.teach(&stand, &Serial::default()).expect("nothing is learnt");
    let jobs = campaign.jobs();
    assert_eq!(jobs, (2 * 7 + 2) * 2, "two machines each for 7 rows and a stretch, 2 grades");
    let evaluated =
        |reversed| campaign.evaluate(&Serial { reversed }).expect("it can be simulated");
    let forwards = evaluated(false);
    assert_eq!(forwards, evaluated(true));
    let (rows, healthy) = forwards.rows.zip(forwards.healthy).expect("they were asked for");
    assert_eq!((rows.len(), healthy.len()), (14, 2));
    for cell in &healthy {
        assert!((0.32..0.334).contains(&cell.hours), "two stretches: {} h", cell.hours);
    }
    assert_eq!((forwards.contest, forwards.process), (None, None));
}

/// Does all jobs but the first.
struct Lazy;

impl Workers for Lazy {
    fn each<T: Send>(
        &self,
        count: usize,
        job: impl Fn(usize) -> Result<T, StandError> + Sync,
        mut take: impl FnMut(usize, T),
    ) -> Result<(), StandError> {
        (1..count).try_for_each(|index| job(index).map(|it| take(index, it)))
    }
}

/// No figures are made of a part of the trials, as if it were all.
#[test]
fn a_trial_that_is_missing_is_an_error() {
    let bench = Bench::new();
    let plan = Plan::new(SEED, extent(&["chance"], 12, 0.0)).expect("it is not too much");
    let stand = bench.stand();
    let campaign = plan.teach(&stand, &Lazy).expect("nothing is learnt");
    let of = campaign.jobs();
    assert_eq!(campaign.evaluate(&Lazy), Err(StandError::Unfinished { done: of - 1, of }));
    let unknown = Plan::new(SEED, extent(&["guess"], 12, 0.0)).expect_err("it is none");
    assert_eq!(unknown.to_string(), "there is no study \"guess\"");
}

/// Weights for fine transducers ask for less at the same rate of false alarms than those of the thesis's design,
/// and weights for coarse ones seldom cross its threshold, as docs/EVALUATION.md has it on more machines.
#[test]
fn weights_are_compared_on_the_same_machines_each_with_its_own_threshold() {
    let bench = Bench::new();
    let weighing = Weighing::planned(SEED, &extent(&["weights"], 24, 0.5));
    let weighing = Weighing { seas: vec![SEA, [1.2, 6.5]], ..weighing.expect("it was asked for") };
    let (jobs, weights) = figures(&weighing, &bench.stand());
    assert_eq!(jobs, 3 * (3 + 4 * FAULTS.len()), "stretches, and machines of six faults");
    assert_eq!(weights.len(), 3 * SETS.len());
    let of = |kind: &str, set: usize| {
        let mut results = weights.iter().filter(|result| result.kind == kind);
        results.nth(set).expect("there is one for each set")
    };
    for result in &weights {
        let [hourly, daily, yearly] = result.levels.expect("half an hour is enough for a tail");
        assert!(3e-4 < hourly && hourly < daily && daily < yearly, "{result:?}");
        let [thesis, own] = &result.seen[..] else { panic!("{result:?}") };
        assert_eq!((thesis.high, own.high), (1e-3, daily));
        for seen in &result.seen {
            let found: Vec<u64> = seen.faults.iter().map(|fault| fault.found.count).collect();
            assert!(found[0] <= found[1] && found[1] <= found[2], "larger steps: {seen:?}");
            assert!(seen.faults.iter().all(|fault| fault.found.of == 24), "{seen:?}");
        }
    }
    let daily = |result: &SetResult| result.levels.expect("as above")[1];
    let (thesis, own) = (of("fine", 0), of("fine", 1));
    assert!(daily(own) < 0.98 * daily(thesis), "{own:?} {thesis:?}");
    let (thesis, own) = (of("coarse", 0), of("coarse", 2));
    assert!(thesis.crossings.events > 3 * own.crossings.events.max(1), "{own:?} {thesis:?}");
}

/// One grade, few rows, and an hour without a fault.
fn contest(bench: &Bench, labels: &[&str]) -> Contest {
    let contest = Contest::planned(SEED, &extent(&["contest"], 12, 0.0));
    let mut contest = contest.expect("it was asked for");
    contest.hours = 1.0;
    contest.grades = vec![Grade::Fine];
    contest.rows.retain(|row| row.grade == Grade::Fine && labels.contains(&&*row.label()));
    assert_eq!(contest.rows.len(), labels.len());
    assert!(bench.settings.cylinder.iter().all(|cylinder| cylinder.sequential.is_none()));
    contest
}

/// The figures of the contest are those of its own docs, on fewer faults.
#[test]
fn detectors_are_compared_on_the_same_faults_and_hours() {
    let bench = Bench::new();
    let labels =
        ["step 0.5 mm", "noise 2 σ", "drift 1 mm/s", "none", "drift 0.025 mm/s, then the stop"];
    let (jobs, grades) = figures(&contest(&bench, &labels), &bench.stand());
    assert_eq!(jobs, 5 * 6 + 1, "six machines a row, each with two faults, and an hour");
    let [result] = &grades[..] else { panic!("{} grades", grades.len()) };
    let hours = &result.hours;
    // Where ten minutes of calibration have not been, nothing is judged.
    assert!((0.9..1.0).contains(&hours.hours), "{} h", hours.hours);
    assert!((7e-5..1e-4).contains(&hours.deviation), "{} m", hours.deviation);
    assert_eq!(hours.detectors["sequential"].events, 0);
    let largest = hours.largest[Rival::Sequential as usize];
    assert!((4.0..result.level).contains(&largest), "{largest} of {} nats", result.level);
    let [step, noise, drift, none, stop] = &result.rows[..] else { panic!("rows") };
    let sequential = Rival::Sequential as usize;
    // No sample is more evidence than it is rare to be wild: of what is large it takes five or six.
    for (row, within, ratio) in [(step, 0.1, 5.0), (noise, 0.3, 15.0), (drift, 0.5, 3.0)] {
        let delay = row.found[sequential].delay;
        assert_eq!((row.faults, row.found[sequential].found.count), (12, 12), "{row:?}");
        assert!(delay.median.is_some_and(|delay| delay > 0.0 && delay < within), "{delay:?}");
        assert!(row.ratio.is_some_and(|of| (0.5..ratio).contains(&of)), "{:?}", row.ratio);
    }
    // Half a millimetre is below the thesis's thresholds.
    assert!(step.found[Rival::Comparator as usize].found.count == 0, "{step:?}");
    assert!(step.suspect.right >= 9 && step.suspect.wrong == 0, "{:?}", step.suspect);
    assert!(noise.suspect.right >= 11 && noise.suspect.wrong == 0, "{:?}", noise.suspect);
    assert_eq!((drift.suspect.undecided, drift.suspect.all()), (12, 12), "{:?}", drift.suspect);
    assert_eq!(none.found[sequential].found.count, 0);
    assert_eq!((stop.suspect.right, stop.suspect.all()), (12, 12), "{:?}", stop.suspect);
    // A higher level takes longer and is wrong less often.
    let points = &step.curves[sequential];
    assert!(points.is_sorted_by(|low, high| {
        low.false_alarms_per_year >= high.false_alarms_per_year && low.found >= high.found
    }));
    let delays: Vec<f64> = points.iter().filter_map(|point| point.median).collect();
    assert!(delays.len() > 10 && delays.is_sorted(), "{delays:?}");
}

/// Readings in steps of half a millimetre need higher thresholds than those of the configuration, which are for finer ones.
#[test]
fn a_machine_with_hydraulics_is_commissioned_with_thresholds_and_relations_of_its_own() {
    let bench = Bench::new();
    let plant = std::fs::read_to_string(support::top().join("config/e-type-hydraulic-plant.toml"));
    let tables = Tables::parse(&plant.expect("it ships")).expect("it is sound");
    let stand = Stand::new(&tables, &bench.settings, &bench.database, &bench.design);
    let machine = ProcessMachine { grade: Grade::Coarse, lag: 0.06 };
    let lessons = Lessons { calibration: 0.25, level: 0.25 };
    let learnt = stand.commission(machine, true, &[SEA], [1, 2], lessons).expect("it teaches");
    for (own, configured) in learnt.design.cylinders.iter().zip(&bench.design.cylinders) {
        let [own_high, high] = [own, configured].map(|it| it.bank.observer.high);
        assert!(own_high > 1.2 * high, "{own_high} {high}");
        assert!(
            own.commands.size.is_finite()
                && own.commands.change.is_finite()
                && own.sequential.is_some()
        );
        let process = own.process.as_ref().expect("it is learnt");
        assert!(process.spool.is_some() && process.chambers.is_some());
        assert!(process.flow.is_some() && process.friction.is_some());
    }
}

#[test]
fn what_was_not_learnt_is_told() {
    let bench = Bench::new();
    let contest = contest(&bench, &["none"]);
    let error = contest.run(&bench.stand(), &[], contest.jobs()[0]);
    let error = error.expect_err("nothing was learnt");
    assert!(error.to_string().contains("fine was not learnt"), "{error}");
}

fn evaluate(more: &[&str]) -> support::Run {
    let call = ["evaluate", "--config", CONFIG, "--rows", "step,healthy", "--sea", "2.5,8"];
    support::tertius(&[&call, more].concat(), b"")
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let scratch = Scratch::new();
    let (file, html) = (scratch.path("evaluation.json"), scratch.path("evaluation.html"));
    let run = |threads, seed, more: &[&str]| {
        let call = ["--trials", "6", "--hours", "0.1", "--threads", threads, "--seed", seed];
        evaluate(&[&call, more].concat()).ok()
    };
    let one = run("1", "3", &["--format", "json"]).stdout;
    let page = run("2", "3", &["--output", &file, "--report", &html]).stdout;
    assert_eq!(one, scratch.read("evaluation.json"));
    assert_ne!(one, run("2", "4", &["--format", "json"]).stdout);
    let result: serde_json::Value = serde_json::from_str(&one).expect("JSON");
    let with =
        [&result["configuration"], &result["calibration"]].map(|it| it.as_str().expect("text"));
    for identity in with {
        assert!(
            page.lines().next().is_some_and(|head| head.contains(identity)),
            "{with:?}\n{page}"
        );
    }
    let rows = result["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), 20);
    let largest = rows.iter().find(|row| row["size"] == 0.05).expect("50 mm");
    assert_eq!(largest["own"]["found"]["count"], 6);
    assert_eq!(largest["thesis"]["holds"], true);
    for word in ["step 1.25 mm", "found at once", "false alarms", "6 of 6"] {
        assert!(page.contains(word), "{word:?} is not in\n{page}");
    }
    let html = scratch.read("evaluation.html");
    let titles: Vec<String> = Figure::all(&parse(&html)).into_iter().map(|it| it.title).collect();
    assert_eq!(titles, ["Step, fine transducers", "Step, coarse transducers", "Step"]);
    assert!(html.contains("step 1.25 mm") && html.contains("False alarms of a machine"), "{html}");
}

#[test]
fn what_cannot_be_is_refused_before_anything_is_done() {
    evaluate(&["--trials", "0"]).failed(2, &["0 faults a row, expected 1 to"]);
    evaluate(&["--hours=-1"]).failed(2, &["-1 hours without a fault, expected 0 to"]);
    evaluate(&["--sea", "high"]).failed(2, &["--sea is \"high\", expected wave height"]);
    evaluate(&["--sea", "9,8"]).failed(2, &["take a calmer sea"]);
    evaluate(&["--report", "none/page.html"]).failed(2, &["none/page.html cannot be created"]);
    evaluate(&["--plant", "none.toml"]).failed(2, &["none.toml: cannot be read"]);
}

/// The simulated machine has six legs, of which a configuration may monitor one: here one of another layout.
#[test]
fn a_configuration_of_one_cylinder_is_evaluated_on_that_cylinder() {
    let rig = ["evaluate", "--config", support::HANGING_LOAD, "--quick", "--rows", "step"];
    let run = support::tertius(&[&rig[..], &["--trials", "2"]].concat(), b"").ok();
    let large = run.stdout.lines().find(|line| line.starts_with(" step 50 mm"));
    assert!(large.is_some_and(|line| line.contains("2 of 2")), "{}", run.stdout);
}
