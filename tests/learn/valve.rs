//! Valves that were identified for a plant: against the plant's own, against NumPy, and refused.

use crate::identify_support::TS;
use crate::nonlinear::{SOURCES, friction, strokes, swung};
use serde_json::{Value, json};
use std::fs;
use std::process::{Command, Output};
use tempfile::TempDir;
use tertius::config;
use tertius::identify::nonlinear::Nonlinear;
use tertius::identify::valve::NoValve;
use tertius::plant::Cylinder;
use tertius::relate::{ProcessRows, flow};
use tertius::simulator::Tables;
use tertius::survey::{Row, Surveyor};
use tertius::tables::nonlinear;
use tertius_testing::oracle;

const CONFIG: &str = "config/e-type-simulated.toml";

struct Bench(TempDir);

impl Bench {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().expect("UTF-8").to_owned()
    }

    fn run(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_tertius"))
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .args(arguments)
            .output()
            .expect("it starts")
    }

    /// Simulates five minutes into the recording `log`.
    fn simulate(&self, log: &str, more: &[&str]) {
        let log = self.path(log);
        let call = ["simulate", "--config", CONFIG, "--duration", "300", "--seed", "3", "--output"];
        let done = self.run(&[&call[..], &[&log], more].concat());
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    }

    /// Identifies the recording `log` into the file `model`: exit code, page and message.
    fn identify(&self, log: &str, model: &str) -> (Option<i32>, String, String) {
        let [log, model] = [log, model].map(|name| self.path(name));
        let done =
            self.run(&["identify", &log, "--config", CONFIG, "--nonlinear", "--output", &model]);
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (done.status.code(), text(&done.stdout), text(&done.stderr))
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).expect("it was written")
    }
}

/// The worst position VAF of the model that was chosen, %.
fn worst(page: &str) -> f64 {
    let (_, after) = page.split_once("its worst is the best, ").expect("one is chosen");
    after.split_once(" %").expect("a percentage").0.parse().expect("a number")
}

/// The largest difference of two cylinders' flows over positions of the spool and load pressures, as a part of the
/// flow, where that moves the rod by 50 mm/s and more.
fn apart(one: &Cylinder, other: &Cylinder, [low, high]: [f64; 2]) -> f64 {
    let spools = (0..=400).map(|i| low + (high - low) * f64::from(i) / 400.0);
    let flows = spools.flat_map(|spool| [-20.0, 0.0, 30.0].map(|load| (spool, load)));
    flows
        .filter_map(|(spool, load)| {
            let [one, other] = [one, other].map(|it| it.passed(spool, load, 230.0));
            (one.abs() > 0.05).then(|| (other / one - 1.0).abs())
        })
        .fold(0.0, f64::max)
}

fn cylinders(tables: &Tables) -> [Cylinder; 6] {
    std::array::from_fn(|leg| Cylinder::new(&tables.plant(), leg, 2e-3))
}

/// Simulate a machine with other valves, identify, simulate the usual one with what was found, identify: the flow agrees
/// within 5 %, and the second machine is as linear as the first.
#[test]
fn a_machine_with_the_identified_valves_passes_the_same_flow() {
    let bench = Bench::new();
    let plant = fs::read_to_string(oracle::top().join("config/e-type-plant.toml")).expect("UTF-8");
    let plant = [
        ("progression = 0.6", "progression = 0.2"),
        ("extend_speed = 1.8", "extend_speed = 2.1"),
        ("pressure_rise = 7000.0", "pressure_rise = 9000.0"),
    ]
    .into_iter()
    .fold(plant, |plant, (from, to)| {
        assert!(plant.contains(from), "{from}");
        plant.replacen(from, to, 1)
    });
    fs::write(bench.path("other.toml"), &plant).expect("the folder is ours");
    bench.simulate("one.log", &["--plant", &bench.path("other.toml")]);
    let (code, page, error) = bench.identify("one.log", "one.toml");
    println!("{page}");
    assert_eq!(code, Some(0), "{error}");
    let model = bench.path("one.toml");
    bench.simulate("two.log", &["--plant", &model]);
    let (code, second, error) = bench.identify("two.log", "two.toml");
    assert_eq!(code, Some(0), "{error}");

    let own = Tables::parse(&plant).expect("sound");
    let [one, two] = ["one.toml", "two.toml"].map(|name| {
        let tables = Tables::default().identified_by(&bench.read(name)).expect("sound");
        assert_eq!(tables.identified.len(), 6);
        tables
    });
    let machines = [&own, &one, &two].map(cylinders);
    for (leg, identified) in one.identified.iter().enumerate() {
        let flow = identified.flow.as_ref().expect("it was identified");
        let reach = flow.valve.reach();
        let [first, again] =
            [(0, 1), (1, 2)].map(|(a, b)| apart(&machines[a][leg], &machines[b][leg], reach));
        println!("cylinder {}: {reach:?} {:.2} % {:.2} %", leg + 1, 1e2 * first, 1e2 * again);
        assert!(reach[0] < -0.2 && reach[1] > 0.2, "cylinder {}: {reach:?}", leg + 1);
        assert!(first < 0.05 && again < 0.05, "cylinder {}: {first} {again}", leg + 1);
        let usual =
            apart(&machines[0][leg], &Cylinder::new(&Tables::default().plant(), leg, 2e-3), reach);
        assert!(usual > 0.3, "the usual machine has other valves: {usual}");
    }
    let vafs = [&page, &second].map(|page| worst(page));
    assert!(vafs[1] > vafs[0] - 0.2 && vafs[0] > 90.0, "{vafs:?}");
}

/// f, c₁ and c₂ of cylinder 1, by the same data.
#[test]
fn the_relation_is_that_of_numpy() {
    let rows: Vec<Row> = swung(6000).into_iter().filter(|row| row.cylinder == 1).collect();
    let text = fs::read_to_string(oracle::top().join(CONFIG)).expect("UTF-8");
    let (settings, _) = config::parse("machine.toml", &text).expect("sound");
    let mut kept = ProcessRows::of_c1(&settings, None);
    rows.iter().for_each(|row| kept.row(row));
    let curve = flow::curve(kept.of(1), 1.0, TS, 60.0).expect("it moves");
    let signals: Vec<[f64; 4]> = rows[rows.len() - kept.of(1).len()..]
        .iter()
        .map(|row| {
            let load = row.load_pressure(settings.machine.area_ratio).expect("known");
            [row.c1, row.spool, Some(load), row.supply].map(|it| it.expect("known"))
        })
        .collect();
    let input = json!({"signals": signals, "limit": curve.limit, "between": curve.between,
        "sample_time": TS, "pieces": curve.samples.len()});
    let answer: Value = serde_json::from_str(&oracle::run("valve.py", &[], &input.to_string()))
        .expect("the oracle answers in JSON");
    let number = |value: &Value| value.as_f64().expect("a number");
    let (leakage, compression) = (number(&answer["leakage"]), number(&answer["compression"]));
    println!("{leakage:e} {compression:e} {curve:?}");
    assert!((curve.leakage - leakage).abs() < 0.01 * leakage.abs(), "{curve:?} {leakage}");
    assert!((curve.compression - compression).abs() < 0.01 * compression.abs(), "{compression}");
    let mut compared = 0;
    for (i, (value, theirs)) in
        curve.curve.iter().zip(answer["curve"].as_array().unwrap()).enumerate()
    {
        let samples = |i: Option<usize>| i.and_then(|i| curve.samples.get(i)).map_or(0, |it| *it);
        if samples(i.checked_sub(1)) + samples(Some(i)) >= 100 {
            assert!((value - number(theirs)).abs() < 1e-3, "{i}: {value} {theirs}");
            compared += 1;
        }
    }
    assert!(compared >= 30, "{compared} knots were compared");
}

/// Strokes of a plant at constant velocity give a plant with the same friction; its valve stays.
#[test]
fn friction_that_was_identified_is_the_plants() {
    let curve = friction(&strokes(0.0)).expect("there are strokes");
    let found = Nonlinear {
        sources: SOURCES,
        flow: Vec::new(),
        points: Vec::new(),
        valves: vec![Err(NoValve::NoSpool)],
        friction: vec![Ok(curve)],
    };
    let table = nonlinear::table(&found, 1).expect("there is friction");
    let own = Tables::default();
    let tables = Tables::default().identified_by(&format!("[[cylinder]]\nn = 1\n{table}"));
    let [own, other] = [&own, &tables.expect("sound")].map(cylinders);
    for speed in [-0.5, -0.1, -0.015, 0.012, 0.03, 0.2] {
        let [expected, found] = [&own, &other].map(|it| it[0].friction().force(speed));
        assert!((found - expected).abs() < 0.01 * expected.abs(), "{speed}: {found} {expected}");
    }
    assert_eq!(own[0].passed(0.3, 20.0, 230.0), other[0].passed(0.3, 20.0, 230.0));
    assert_eq!(nonlinear::table(&found, 2), None);
}

/// At rest there is nothing to learn; and nothing that is refused leaves with success.
#[test]
fn a_valve_that_was_not_excited_is_refused_in_words() {
    let bench = Bench::new();
    bench.simulate("calm.log", &["--sea", "0.3,8"]);
    let (code, page, error) = bench.identify("calm.log", "model.toml");
    println!("{page}\n{error}");
    assert_eq!(code, Some(1), "{error}");
    for words in ["the spool was not excited: ", "record the platform engaged in a sea"] {
        assert!(page.contains(words) && error.contains(words), "{error}");
    }
    assert!(!bench.read("model.toml").contains("nonlinear"), "{error}");
}

/// A plant says what it cannot use, and by which file.
#[test]
fn a_plant_refuses_curves_that_it_cannot_use() {
    let curve = |limit: &str, samples: &str, compression: &str| {
        format!(
            "[[cylinder]]\nn = 1\n[cylinder.nonlinear.flow]\nlimit = {limit}\n\
             curve = [-0.9, -0.4, 0.0, 0.4, 0.9]\nsamples = {samples}\nbetween = 0.5\n\
             leakage = -1e-4\ncompression = {compression}\n"
        )
    };
    let sound = curve("60.0", "[500, 500, 500, 500]", "-1e-4");
    let tables = Tables::default().identified_by(&sound).expect("sound");
    assert_eq!(tables.identified.len(), 1);
    for (text, words) in [
        (curve("0.6", "[500, 500, 500, 500]", "-1e-4"), "the simulated spool's full stroke"),
        (curve("60.0", "[500, 500, 500]", "-1e-4"), "3 counts of samples for 5 knots"),
        (curve("60.0", "[500, 500, 0, 0]", "-1e-4"), "not taught on both sides of rest"),
        (curve("60.0", "[500, 500, 500, 500]", "1e-4"), "expected -1 to -1e-5"),
        (sound.replace("[-0.9", "[0.9"), "does not rise"),
        (sound.replace("n = 1", "n = 7"), "has a cylinder 7"),
        (sound.replace("nonlinear", "sequential"), "has no [cylinder.nonlinear]"),
    ] {
        let why = Tables::default().identified_by(&text).expect_err(words).to_string();
        assert!(why.contains(words), "{words:?} is not in: {why}");
    }
    let bench = Bench::new();
    fs::write(bench.path("model.toml"), &sound).expect("the folder is ours");
    let model = bench.path("model.toml");
    let call = ["simulate", "--config", CONFIG, "--duration", "1", "--plant", &model];
    for (more, words) in [
        (["--plant", &model[..]], "give one of them"),
        (["--output", &model[..]], "would be written over the input"),
    ] {
        let done = bench.run(&[&call[..], &more].concat());
        let error = String::from_utf8_lossy(&done.stderr);
        assert!(done.status.code() == Some(2) && error.contains(words), "{error}");
    }
    assert_eq!(bench.read("model.toml"), sound);
}
