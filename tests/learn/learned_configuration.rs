//! From the first half of a recording to a configuration, and what that does on the second half.
//! `--nocapture` prints the figures.

use std::fmt::Write as _;
use std::fs;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use tertius_testing::support::{self, E_TYPE, HANGING_LOAD, Run, merge, tertius, top};
use toml::{Table, Value};

const HOURS_PER_YEAR: f64 = 8766.0;

/// A recording, what was learnt from its first half, and its second half.
struct Learnt {
    folder: TempDir,
    /// Seconds of the second half.
    length: f64,
}

/// The text of a recording.
fn text_of(log: &str) -> String {
    let mut text = String::new();
    let file = fs::File::open(top().join(log)).expect("it is kept");
    if log.ends_with(".gz") {
        flate2::read::GzDecoder::new(file).read_to_string(&mut text).expect("gzip");
    } else {
        text = String::from_utf8(zstd::decode_all(file).expect("zstd")).expect("ASCII");
    }
    text
}

fn stamp(line: &str) -> f64 {
    let stamp = line.split(')').next().expect("it begins with (…)");
    stamp.trim_start_matches('(').parse().expect("seconds")
}

impl Learnt {
    /// Runs identify, calibrate and tune, each on what the ones before it came to.
    fn from(log: &str, config: &str, calibrated: &str, tuned: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let mut table: Table =
            fs::read_to_string(top().join(config)).expect("it is kept").parse().expect("TOML");
        let beside = top().join(config).parent().expect("a folder").to_owned();
        let dbc = beside.join(table["bus"]["dbc"].as_str().expect("a path"));
        table["bus"]["dbc"] = Value::String(dbc.display().to_string());
        // What is to be found must not be given.
        table.remove("cylinder");
        let learnt = Self { folder, length: 0.0 };
        learnt.write("config.toml", &table.to_string());
        for (command, options) in [
            ("identify", vec!["--held-back", "0"]),
            ("calibrate", vec!["--false-alarms-per-year", calibrated]),
            ("tune", vec!["--false-alarms-per-year", tuned]),
        ] {
            let (config, output) =
                (learnt.path("config.toml"), learnt.path(&format!("{command}.toml")));
            let mut call = vec![command, log, "--config", &config, "--to", "50%"];
            call.extend(["--output", &output]);
            call.extend(options);
            let run = tertius(&call, b"").ok();
            if command != "identify" {
                println!("{}", run.stdout);
            }
            let tables = fs::read_to_string(&output).expect("it was written");
            merge(&mut table, &tables.parse().expect("TOML"));
            learnt.write("config.toml", &table.to_string());
        }
        learnt.halve(log)
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).display().to_string()
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.folder.path().join(name), text).expect("it can be written");
    }

    fn halve(mut self, log: &str) -> Self {
        let text = text_of(log);
        let ends = [text.lines().next(), text.lines().last()].map(|line| stamp(line.expect("one")));
        let middle = f64::midpoint(ends[0], ends[1]);
        let path = self.folder.path().join("second.log");
        let mut half = std::io::BufWriter::new(fs::File::create(path).expect("a file"));
        for line in text.lines().filter(|line| stamp(line) >= middle) {
            writeln!(half, "{line}").expect("it can be written");
        }
        self.length = ends[1] - middle;
        self
    }

    fn replay(&self, log: &str) -> Run {
        let (log, config) = (self.path(log), self.path("config.toml"));
        support::replay(&[&log], &config, &[]).ok()
    }

    /// C1 of cylinder 1 at `at` seconds of the second half, m.
    fn position(&self, at: f64) -> f64 {
        let table = self.path("residuals.csv");
        if !Path::new(&table).exists() {
            let (log, config) = (self.path("second.log"), self.path("config.toml"));
            support::replay(&[&log], &config, &["--residuals", &table]).ok();
        }
        let table = fs::read_to_string(table).expect("it was written");
        let number = |text: &str| text.parse::<f64>().expect("a number");
        let row = |line: &str| {
            let mut fields = line.split(',');
            (number(fields.next().expect("t")), number(fields.nth(1).expect("c1")))
        };
        table.lines().skip(1).map(row).find(|(t, _)| *t >= at).expect("it is within").1
    }

    fn threshold(&self) -> f64 {
        let tuned: Table =
            fs::read_to_string(self.path("tune.toml")).expect("it is there").parse().expect("TOML");
        tuned["fde"]["high"].as_float().expect("a number")
    }

    /// The smallest step of C`transducer` of `cylinder` that tune names, m.
    fn smallest(&self, cylinder: usize, transducer: usize) -> f64 {
        let text = fs::read_to_string(self.path("tune.toml")).expect("it is there");
        let start = format!("# smallest step of C{transducer} of cylinder {cylinder}: ");
        let step = text.lines().find_map(|line| line.strip_prefix(&start)).expect("it is named");
        1e-3 * step.strip_suffix(" mm").expect("mm").parse::<f64>().expect("a number")
    }

    /// Warnings of FDE1 and FDE2 that were raised on the second half.
    fn false_alarms(&self) -> usize {
        let warnings = self.replay("second.log").warnings();
        let observed = |detector: &str| {
            let raised =
                |w: &&serde_json::Value| w["detector"] == detector && w["state"] == "raised";
            warnings.iter().filter(raised).count()
        };
        for detector in ["fde1", "fde2", "fde3", "plausibility"] {
            println!("{detector}: {} raised in {:.1} s", observed(detector), self.length);
        }
        observed("fde1") + observed("fde2")
    }

    /// Injects the steps (cylinder, transducer, at, size) and returns, of each, the time until its
    /// observer warned and whom it blamed within 0.2 s; `None` where it did not in a second.
    fn inject(&self, steps: &[(usize, usize, f64, f64)]) -> Vec<Option<(f64, String)>> {
        let mut csv = "cylinder,sensor,kind,t0,magnitude,parameter,t1\n".to_owned();
        for (cylinder, transducer, at, size) in steps {
            writeln!(csv, "{cylinder},c{transducer},step,{at},{size},,{}", at + 2.0).expect("text");
        }
        self.write("faults.csv", &csv);
        let names = ["second.log", "config.toml", "faulty.log", "faults.csv"].map(|n| self.path(n));
        let [log, config, output, table] = &names;
        tertius(&["inject", log, "--config", config, "--output", output, "--faults", table], b"")
            .ok();
        let warnings = self.replay("faulty.log").warnings();
        let found = |(cylinder, transducer, at, _): &(usize, usize, f64, f64)| {
            let mine = || {
                warnings.iter().filter(|w| {
                    w["cylinder"] == *cylinder as u64 && w["detector"] == format!("fde{transducer}")
                })
            };
            let t = |w: &serde_json::Value| w["t"].as_f64().expect("a time");
            let raised =
                mine().find(|w| w["state"] == "raised" && (0.0..1.0).contains(&(t(w) - at)))?;
            let newest =
                mine().rfind(|w| (0.0..0.2).contains(&(t(w) - t(raised)))).unwrap_or(raised);
            Some((t(raised) - at, newest["suspect"].as_str().expect("a name").to_owned()))
        };
        steps.iter().map(found).collect()
    }
}

/// Steps found within 0.1 s, and blamed right.
fn in_time(steps: &[(usize, usize, f64, f64)], found: &[Option<(f64, String)>]) -> (usize, usize) {
    let good =
        |found: &Option<(f64, String)>| found.as_ref().is_some_and(|(delay, _)| *delay < 0.1);
    let right = steps.iter().zip(found).filter(|((_, transducer, ..), found)| {
        good(found) && found.as_ref().is_some_and(|(_, s)| *s == format!("c{transducer}"))
    });
    for (step, found) in steps.iter().zip(found) {
        println!("{step:?}: {found:?}");
    }
    (found.iter().filter(|found| good(found)).count(), right.count())
}

/// The most alarms that a wanted rate explains, in all but one of a hundred cases (Poisson).
fn most(expected: f64) -> usize {
    let (mut term, mut sum, mut count) = ((-expected).exp(), (-expected).exp(), 0);
    while sum < 0.99 {
        count += 1;
        term *= expected / count as f64;
        sum += term;
    }
    count
}

#[test]
fn the_hanging_load() {
    // About one in each half: what the recording can speak of.
    let rate = "200000";
    let log = "tests/recordings/hanging-load.log.gz";
    let learnt = Learnt::from(log, HANGING_LOAD, "1", rate);
    let hours = learnt.length / 3600.0;
    let expected = rate.parse::<f64>().expect("a number") / HOURS_PER_YEAR * hours;
    let alarms = learnt.false_alarms();
    println!(
        "threshold {:.1} mm; {alarms} false alarms, {:.1} an hour of {:.1}",
        learnt.threshold() * 1e3,
        alarms as f64 / hours,
        expected / hours
    );
    assert!(alarms <= most(expected), "{alarms} of {expected}");
    let mut steps = Vec::new();
    for (place, at) in (0..20).map(|i| (i, 8.013 + 7.31 * f64::from(i))) {
        let transducer = 1 + place as usize % 2;
        let size = 1.5 * learnt.smallest(1, transducer);
        // Away from the middle such a step may leave the transducer's range, and is found as that.
        steps.push((1, transducer, at, -size.copysign(learnt.position(at))));
    }
    let found = learnt.inject(&steps);
    let (timely, right) = in_time(&steps, &found);
    println!("{timely} of {} within 0.1 s, {right} blamed right", steps.len());
    let other = |transducer: usize| format!("c{}", 3 - transducer);
    let wrong = steps.iter().zip(&found).filter(|((_, transducer, ..), found)| {
        found.as_ref().is_some_and(|(_, suspect)| *suspect == other(*transducer))
    });
    assert_eq!((timely, wrong.count()), (steps.len(), 0));
    // What leaves a reading that stands has no side.
    assert!(right + 1 >= steps.len(), "{right}");
}

#[test]
fn the_healthy_e_type() {
    let learnt = Learnt::from("tests/recordings/e-type-healthy.log.zst", E_TYPE, "1", "1");
    let alarms = learnt.false_alarms();
    println!("threshold {:.3} mm; {alarms} false alarms", learnt.threshold() * 1e3);
    assert_eq!(alarms, 0);
    assert!((1e-3..2e-3).contains(&learnt.threshold()), "about the 1 mm of the thesis");
    let mut steps = Vec::new();
    for i in 0..24_u32 {
        let (cylinder, transducer) = (1 + i as usize % 6, 1 + (i / 6) as usize % 2);
        let size = 1.5 * learnt.smallest(cylinder, transducer);
        let at = 20.007 + 5.003 * f64::from(i);
        steps.push((cylinder, transducer, at, if i % 4 < 2 { size } else { -size }));
    }
    let found = learnt.inject(&steps);
    let (timely, right) = in_time(&steps, &found);
    println!("{timely} of {} within 0.1 s, {right} blamed right", steps.len());
    assert_eq!((timely, right), (steps.len(), steps.len()));
}

/// A year of such bursts is nothing that minutes could tell: no table, but what can be asked for.
#[test]
fn a_rate_that_the_recording_does_not_carry_is_refused_with_one_that_it_does() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("tune.toml");
    let log = "tests/recordings/hanging-load.log.gz";
    let path = output.display().to_string();
    tertius(&["tune", log, "--config", HANGING_LOAD, "--output", &path], b"")
        .failed(1, &["a tenth of comparator.critical", "--false-alarms-per-year"]);
    assert!(!output.exists());
}

/// The rig goes to a place and rests there: a rate function is made of little, or of nothing, and it is
/// said. No command predicts it: its drive is none.
#[test]
fn a_recording_that_mostly_rests_calibrates_a_sequential_detector_of_little_or_none() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("calibrated.toml").display().to_string();
    let log = "tests/recordings/hanging-load.log.gz";
    let calibrate = ["calibrate", log, "--config", HANGING_LOAD, "--output", &output];
    let calibrated = |told: [&str; 2], more: &[&str]| {
        let run = tertius(&[&calibrate[..], more].concat(), b"").ok();
        assert!(told.iter().all(|told| run.stdout.contains(told)), "{}", run.stdout);
        let text = fs::read_to_string(&output).expect("it was written");
        text.parse::<Table>().expect("TOML")
    };
    let tables =
        calibrated(["too little for a reliable sequential detector", "is known to 2.3 %"], &[]);
    let fitted = tables["cylinder"][0]["sequential"].as_table().expect("there is one");
    assert!(fitted.contains_key("rate") && !fitted.contains_key("drive"), "{tables}");
    let told = ["no tables for the sequential detector", "it takes 200;"];
    let tables = calibrated(told, &["--held-back", "10"]);
    assert!(tables["cylinder"][0].get("sequential").is_none(), "{tables}");
    // The simulated machine moves all the time.
    let log = "tests/recordings/e-type-healthy.log.zst";
    let run = tertius(&["calibrate", log, "--config", E_TYPE], b"").ok();
    assert!(!run.stdout.contains("record more motion"), "{}", run.stdout);
}

#[test]
fn what_cannot_be_learnt_from_is_told() {
    let still = |seconds: f64| -> PathBuf {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("still-{seconds}.log"));
        let text = text_of("tests/recordings/hanging-load.log.gz");
        let first = stamp(text.lines().next().expect("a line"));
        let lines = text.lines().filter(|line| stamp(line) - first < seconds);
        fs::write(&path, lines.map(|line| format!("{line}\n")).collect::<String>())
            .expect("a file");
        path
    };
    let log = still(19.0).display().to_string();
    tertius(&["calibrate", &log, "--config", HANGING_LOAD, "--held-back", "5"], b"")
        .failed(1, &["cylinder 1: it moves over", "300 mm, a tenth of the stroke"]);
    tertius(&["tune", &log, "--config", HANGING_LOAD], b"").failed(1, &["at least 50 s"]);
    for command in ["calibrate", "tune"] {
        tertius(&[command, "-", "--config", HANGING_LOAD], b"").failed(2, &["standard input"]);
        let over = [command, &log, "--config", HANGING_LOAD, "--output", &log];
        tertius(&over, b"").failed(2, &["would be written over the input"]);
        let none = [command, &log, "--config", HANGING_LOAD, "--false-alarms-per-year", "0"];
        tertius(&none, b"").failed(2, &["above 0"]);
        assert!(tertius(&[command, "--help"], b"").ok().stdout.contains("Example:"));
    }
}
