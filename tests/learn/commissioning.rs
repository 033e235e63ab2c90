//! The way that every machine goes: healthy recordings in, tables out that can be used, or words. What is
//! learnt does not depend on which sea came first.

use std::fs;
use tempfile::TempDir;
use tertius_testing::support::{Run, merge, tertius, top};
use toml::{Table, Value};

const CONFIG: &str = "config/e-type-simulated.toml";

/// Seconds in each sea.
const HALF: i64 = 150;

const CALM: &str = "1.2,6.5";
const ROUGH: &str = "2.5,8";

struct Bench(TempDir);

impl Bench {
    fn new() -> Self {
        let bench = Self(tempfile::tempdir().expect("a folder"));
        let plant = fs::read_to_string(top().join("config/e-type-plant.toml")).expect("it is kept");
        // Readings that stand off for a while are what the sequential detectors find.
        let steady = plant.replace("probability = 5.0e-4", "probability = 0.0");
        assert_ne!(plant, steady);
        bench.write("plant.toml", &steady);
        bench.write("coarse.toml", &steady.replace("counts = 27648.0", "counts = 6912.0"));
        let harsh = fs::read_to_string(top().join("config/e-type-harsh-plant.toml"));
        let harsh = harsh.expect("it is kept").replace("probability = 5.0e-4", "probability = 0.0");
        let (bent, _) = harsh.split_once("\n[disturbance]\n").expect("it is harsh");
        bench.write("bent.toml", bent);
        bench.write("fluctuating.toml", &plant);
        let mut table: Table =
            fs::read_to_string(top().join(CONFIG)).expect("it is kept").parse().expect("TOML");
        let dbc = top().join("dbc/e-type.dbc").display().to_string();
        table["bus"]["dbc"] = Value::String(dbc);
        table.remove("cylinder");
        bench.write("config.toml", &table.to_string());
        bench
    }

    fn path(&self, name: &str) -> String {
        self.0.path().join(name).display().to_string()
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.0.path().join(name), text).expect("it can be written");
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).expect("it was written")
    }

    /// Half of a recording, which begins so many seconds later than a simulation does.
    fn record(&self, name: &str, plant: &str, sea: [&str; 2], later: i64) -> String {
        self.record_for(HALF, name, plant, sea, later)
    }

    fn record_for(
        &self,
        seconds: i64,
        name: &str,
        plant: &str,
        [sea, seed]: [&str; 2],
        later: i64,
    ) -> String {
        let [config, plant, first] = ["config.toml", plant, "first.log"].map(|it| self.path(it));
        let seconds = seconds.to_string();
        let call = ["simulate", "--config", &config, "--plant", &plant, "--duration", &seconds];
        let of = ["--sea", sea, "--seed", seed, "--output", &first, "--force"];
        tertius(&[&call[..], &of].concat(), b"").ok();
        let moved = |line: &str| {
            let (seconds, rest) = line[1..].split_once('.').expect("a time stamp");
            format!("({}.{rest}\n", seconds.parse::<i64>().expect("seconds") + later)
        };
        self.write(name, &self.read("first.log").lines().map(moved).collect::<String>());
        self.path(name)
    }

    /// Both seas, in this order, as recordings of a plant.
    fn both(&self, plant: &str, seas: [[&str; 2]; 2]) -> [String; 2] {
        let name = |which: usize| format!("{plant}-{}-{which}.log", seas[0][0]);
        [0, 1].map(|which| {
            let later = which as i64 * (HALF + 30);
            self.record(&name(which), plant, seas[which], later)
        })
    }

    fn learn(&self, command: &str, logs: &[&str], config: &str, output: &str) -> Run {
        let [config, output] = [config, output].map(|name| self.path(name));
        let call = [&[command], logs, &["--config", &config, "--output", &output]].concat();
        tertius(&call, b"")
    }

    /// What calibrate and tune make of the recordings, each with what the one before it came to.
    fn commission(&self, logs: &[&str], name: &str) -> Figures {
        let mut table: Table = self.read("config.toml").parse().expect("TOML");
        let config = format!("{name}.toml");
        for command in ["calibrate", "tune"] {
            self.write(&config, &table.to_string());
            let output = format!("{name}-{command}.toml");
            self.learn(command, logs, &config, &output).ok();
            merge(&mut table, &self.read(&output).parse().expect("TOML"));
        }
        self.write(&config, &table.to_string());
        tertius(&["check", &self.path(&config)], b"").ok();
        Figures::of(&table)
    }

    /// The configuration with what calibrate makes of the recordings.
    fn calibrated(&self, logs: &[&str]) -> Table {
        let mut table: Table = self.read("config.toml").parse().expect("TOML");
        self.learn("calibrate", logs, "config.toml", "calibrated.toml").ok();
        merge(&mut table, &self.read("calibrated.toml").parse().expect("TOML"));
        table
    }

    /// Cylinders that the sequential detectors of `table` warn of in a recording, and when.
    fn warned(&self, log: &str, table: &Table) -> Vec<(u64, f64)> {
        self.write("taught.toml", &table.to_string());
        let call = ["replay", log, "--config", &self.path("taught.toml"), "--format", "jsonl"];
        let warnings = tertius(&call, b"").warnings();
        let ours =
            |it: &&serde_json::Value| it["detector"] == "sequential" && it["state"] == "raised";
        let told = |it: &serde_json::Value| {
            (it["cylinder"].as_u64().expect("1 to 6"), it["t"].as_f64().expect("seconds"))
        };
        warnings.iter().filter(ours).map(told).collect()
    }
}

/// The same with profiles that take themselves for known.
fn without_doubt(table: &Table) -> Table {
    let mut sure = table.clone();
    for cylinder in sure["cylinder"].as_array_mut().expect("they are learnt") {
        let nodes = cylinder["sequential"]["node_deviations"].as_array_mut().expect("it is new");
        nodes.iter_mut().for_each(|node| *node = Value::Float(0.0));
    }
    sure
}

/// What a configuration ends with.
#[derive(Debug)]
struct Figures {
    bound: f64,
    high: f64,
    levels: Vec<f64>,
    /// How many each cylinder has of the errors of the command.
    correlations: Vec<usize>,
}

impl Figures {
    fn of(table: &Table) -> Self {
        let number = |value: &Value| value.as_float().expect("a number");
        let cylinders = table["cylinder"].as_array().expect("they are learnt").iter();
        Self {
            bound: number(&table["comparator"]["bound"]),
            high: number(&table["fde"]["high"]),
            levels: cylinders.clone().map(|one| number(&one["sequential"]["level"])).collect(),
            correlations: cylinders
                .map(|one| {
                    one["sequential"]["prediction_correlation"].as_array().map_or(0, Vec::len)
                })
                .collect(),
        }
    }

    fn assert_usable(&self, most: f64) {
        assert_eq!(self.levels.len(), 6, "{self:?}");
        assert_eq!(self.correlations, [6; 6], "{self:?}");
        assert!(self.levels.iter().all(|level| (19.3..=30.0).contains(level)), "{self:?}");
        assert!((1.5e-3..=most).contains(&self.bound), "{self:?}");
        assert!((1e-3..=2.5e-3).contains(&self.high), "{self:?}");
    }

    fn assert_alike(&self, other: &Self) {
        let apart = |one: f64, other: f64| (one / other - 1.0).abs();
        assert!(apart(self.bound, other.bound) < 0.05, "{self:?} {other:?}");
        assert!(apart(self.high, other.high) < 0.05, "{self:?} {other:?}");
        let means = [self, other].map(|it| it.levels.iter().sum::<f64>() / it.levels.len() as f64);
        assert!(apart(means[0], means[1]) < 0.05, "{self:?} {other:?}");
    }
}

fn either_order(plant: &str, most: f64) {
    let bench = Bench::new();
    let [calm, rough] = [[CALM, "31"], [ROUGH, "32"]];
    let [one, two] = bench.both(plant, [calm, rough]);
    let calm_first = bench.commission(&[&one, &two], "calm");
    calm_first.assert_usable(most);
    let [one, two] = bench.both(plant, [rough, calm]);
    let rough_first = bench.commission(&[&one, &two], "rough");
    rough_first.assert_usable(most);
    calm_first.assert_alike(&rough_first);
    println!("{plant}: {calm_first:?}\n{rough_first:?}");
}

#[test]
fn five_minutes_of_fine_transducers_are_usable_whichever_sea_came_first() {
    either_order("plant.toml", 3e-3);
}

#[test]
fn five_minutes_of_coarse_transducers_are_usable_whichever_sea_came_first() {
    either_order("coarse.toml", 5e-3);
}

/// Also of what is named in another order than it was recorded in, everything is used.
#[test]
fn how_recordings_are_named_does_not_matter() {
    let bench = Bench::new();
    let [one, two] = bench.both("plant.toml", [[CALM, "31"], [ROUGH, "32"]]);
    let run = bench.learn("calibrate", &[&one, &two], "config.toml", "right.toml").ok();
    let named = bench.learn("calibrate", &[&two, &one], "config.toml", "wrong.toml").ok();
    assert!(named.stdout.contains("in the order of their time stamps"), "{}", named.stdout);
    assert!(!run.stdout.contains("in the order of their time stamps"), "{}", run.stdout);
    let tables = |name: &str| {
        let text = bench.read(name);
        text.lines().filter(|line| !line.starts_with("# ")).collect::<Vec<_>>().join("\n")
    };
    assert_eq!(tables("right.toml"), tables("wrong.toml"));
}

/// A step on one reading, a few seconds long or again and again.
#[test]
fn a_fault_in_the_recording_is_left_out_or_refused_and_the_others_are_taught() {
    let bench = Bench::new();
    let logs: Vec<String> = ["33", "34", "35", "36"]
        .into_iter()
        .zip(0..)
        .map(|(seed, k)| {
            let name = format!("{seed}.log");
            bench.record(&name, "plant.toml", [ROUGH, seed], k * HALF)
        })
        .collect();
    let healthy: Vec<&str> = logs.iter().map(String::as_str).collect();
    let taught = |times: &[f64], size: f64| {
        let [config, faulty] = ["config.toml", "faulty.log"].map(|name| bench.path(name));
        let faults: Vec<String> = times
            .iter()
            .map(|at| format!("step,cylinder=3,sensor=c1,at={at},until={},size={size}", at + 4.0))
            .collect();
        let more = ["--config", &config, "--output", &faulty, "--force"];
        let mut call = [&["inject"], &healthy[..], &more].concat();
        faults.iter().for_each(|fault| call.extend(["--fault", fault]));
        let logs = if faults.is_empty() { &healthy[..] } else { &[faulty.as_str()] };
        if !faults.is_empty() {
            tertius(&call, b"").ok();
        }
        let run = bench.learn("calibrate", logs, "config.toml", "taught.toml");
        let tables: Table = bench.read("taught.toml").parse().expect("TOML");
        let cylinders = tables["cylinder"].as_array().expect("there are some").clone();
        let known = cylinders.iter().filter(|it| it.get("sequential").is_some()).count();
        (run, known, cylinders)
    };
    let (run, known, _) = taught(&[], 0.0);
    assert!(!run.ok().stdout.contains("were left out") && known == 6);
    let (run, known, cylinders) = taught(&[130.0], 1e-3);
    let run = run.ok();
    assert!(
        run.stdout.contains("cylinder 3: no healthy cylinder has such readings as those"),
        "{}",
        run.stdout
    );
    assert_eq!(known, 6);
    let level = |n: usize| cylinders[n - 1]["sequential"]["level"].as_float().expect("a number");
    assert!((19.3..20.0).contains(&level(1)) && (19.3..20.5).contains(&level(3)));
    // Again and again it cannot be left out: that cylinder is refused, and no other.
    let (run, known, cylinders) = taught(&[20.0, 70.0, 130.0, 190.0, 250.0], 1e-3);
    run.failed(
        1,
        &["cylinder 3: this is not a recording of a healthy cylinder", "nats of evidence at"],
    );
    assert_eq!(known, 5);
    assert!(cylinders[2].get("sequential").is_none() && cylinders[2].get("c2_gain").is_some());
}

/// What stays behind its beginning, which is left out, is no baseline.
#[test]
fn a_fault_that_stays_is_refused() {
    let bench = Bench::new();
    let before = bench.record_for(450, "before.log", "coarse.toml", [ROUGH, "51"], 0);
    let after = bench.record_for(450, "after.log", "coarse.toml", [CALM, "52"], 480);
    let [config, faulty] = ["config.toml", "faulty.log"].map(|name| bench.path(name));
    // Until the recording has a gap.
    let fault = "step,cylinder=3,sensor=c1,at=270,until=460,size=5e-4";
    let call = ["inject", &before, "--config", &config, "--output", &faulty, "--fault", fault];
    tertius(&call, b"").ok();
    bench
        .learn("calibrate", &[&faulty, &after], "config.toml", "taught.toml")
        .failed(1, &["cylinder 3: this is not a recording of a healthy cylinder"]);
    let tables: Table = bench.read("taught.toml").parse().expect("TOML");
    let cylinders = tables["cylinder"].as_array().expect("there are some");
    let known = |cylinder: &&Value| cylinder.get("sequential").is_some();
    assert_eq!(cylinders.iter().filter(known).count(), 5);
}

/// Three minutes of a calm sea and twenty seconds of a rough one, on transducers that bend along the stroke:
/// the ends of it were seen for a moment or not at all, and are not taken for known.
#[test]
fn what_was_seen_shortly_gives_no_false_alarms_and_costs_the_rest_nothing() {
    let bench = Bench::new();
    let calm = bench.record_for(180, "calm.log", "bent.toml", ["0.9,8", "41"], 0);
    let short = bench.record_for(20, "short.log", "bent.toml", [ROUGH, "42"], 210);
    let table = bench.calibrated(&[&calm, &short]);
    let sure = without_doubt(&table);
    let rough = bench.record_for(240, "rough.log", "bent.toml", [ROUGH, "43"], 0);
    assert_eq!(bench.warned(&rough, &table), []);
    let falsely = bench.warned(&rough, &sure).len();
    assert!(falsely > 5, "{falsely}");
    // Where the rods have been all the time 0.5 mm are found as soon as without any doubt.
    let healthy = bench.record_for(60, "healthy.log", "bent.toml", ["0.9,8", "44"], 0);
    let [config, faulty] = ["config.toml", "faulty.log"].map(|name| bench.path(name));
    let fault = |n: u8| format!("step,cylinder={n},sensor=c1,at={}.3,size=0.0005", 30 + n);
    let faults: Vec<String> = (1..=6).map(fault).collect();
    let mut call = vec!["inject", &healthy, "--config", &config, "--output", &faulty];
    faults.iter().for_each(|fault| call.extend(["--fault", fault]));
    tertius(&call, b"").ok();
    let first = |table: &Table| {
        let warned = bench.warned(&faulty, table);
        [1, 2, 3, 4, 5, 6].map(|n| {
            let mine = warned.iter().find(|(cylinder, _)| *cylinder == n);
            mine.map_or(f64::INFINITY, |(_, t)| t - (30.3 + n as f64))
        })
    };
    let (doubting, sure) = (first(&table), first(&sure));
    for (one, other) in doubting.into_iter().zip(sure) {
        assert!((0.0..0.15).contains(&one) && one - other < 0.045, "{doubting:?} {sure:?}");
    }
}

/// Each reading stands four counts off for 0.2 s every 40 s (Figure 5-9), and so two or three such stretches
/// come together now and then: what ten minutes show of one is enough to expect that.
#[test]
fn fluctuating_readings_are_learnt_for_what_they_are() {
    let bench = Bench::new();
    let calm = bench.record_for(360, "calm.log", "fluctuating.toml", [CALM, "31"], 0);
    let rough = bench.record_for(360, "rough.log", "fluctuating.toml", [ROUGH, "32"], 390);
    let table = bench.calibrated(&[&calm, &rough]);
    let figures = Figures::of(&table);
    assert!(figures.levels.len() == 6, "{figures:?}");
    let other = bench.record_for(900, "other.log", "fluctuating.toml", ["2.0,7.5", "33"], 0);
    assert_eq!(bench.warned(&other, &table), []);
    for cylinder in table["cylinder"].as_array().expect("they are learnt") {
        let excursions = &cylinder["sequential"]["excursions"];
        let number = |key: &str| excursions[key].as_float().expect("a number");
        // 0.05 a second, of four counts and ten readings; two one after the other are halved.
        assert!((0.02..0.1).contains(&number("rate")), "{excursions}");
        assert!((3.9e-4..5e-4).contains(&number("size")), "{excursions}");
        assert!((10..=22).contains(&excursions["longest"].as_integer().expect("samples")));
    }
    // A step of 1.25 mm is more than two excursions at once, and one of 0.5 mm outlasts two in a row.
    let steps =
        [(5e-4, 1.1), (-7.5e-4, 0.6), (1e-3, 0.4), (1.25e-3, 0.15), (-5e-4, 1.1), (-1.25e-3, 0.15)];
    let mut call =
        vec!["inject".to_owned(), other, "--config".to_owned(), bench.path("taught.toml")];
    for ((size, _), n) in steps.iter().zip(1..) {
        let (sensor, at) = (["c2", "c1"][n % 2], 100 * n + 17);
        let fault =
            format!("step,cylinder={n},sensor={sensor},at={at},until={},size={size}", at + 20);
        call.extend(["--fault".to_owned(), fault]);
    }
    call.extend(["--output".to_owned(), bench.path("steps.log")]);
    tertius(&call.iter().map(String::as_str).collect::<Vec<_>>(), b"").ok();
    let config = bench.path("taught.toml");
    let call = ["replay", &bench.path("steps.log"), "--config", &config, "--format", "jsonl"];
    let warnings = tertius(&call, b"").warnings();
    let mut named = 0;
    for ((size, within), n) in steps.into_iter().zip(1..) {
        let begun = (100 * n + 17) as f64;
        let own = |it: &&serde_json::Value| {
            it["detector"] == "sequential"
                && it["cylinder"] == n
                && it["t"].as_f64().is_some_and(|t| (begun..begun + 20.0).contains(&t))
        };
        let own: Vec<_> = warnings.iter().filter(own).collect();
        let delay = own.first().and_then(|it| it["t"].as_f64()).expect("it is found") - begun;
        assert!(delay < within, "{size} after {delay} s");
        let other = ["c1", "c2"][n % 2];
        assert!(own.iter().all(|it| it["suspect"] != other), "{size}: {own:?}");
        named += usize::from(own.iter().any(|it| it["suspect"] == ["c2", "c1"][n % 2]));
    }
    assert!(named >= 5, "{named} of 6 are named");
}
