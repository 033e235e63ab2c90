//! Machines that the project was not made on, each in a layout of its own: faults of every kind on both
//! transducers, and whom they are blamed on. cantools and NumPy write them (tests/oracle/machines.py).
//! `--nocapture` prints every fault with what was said of it; `scripts/sweep-machines` tries more seeds.

use serde_json::Value;
use std::env;
use std::fmt;
use std::fs;
use std::ops::RangeInclusive;
use tertius_testing::oracle;
use tertius_testing::support::{HANGING_LOAD, Scratch, merge, recording, replay, tertius, top};

/// A warning belongs to a fault for so long after it: it clears, and the fault's going is a step, s.
const AFTERMATH: f64 = 5.0;

/// `alarm.coincidence`, s: FDEs that rise within it saw the same event.
const COINCIDENCE: f64 = 0.2;

/// Seconds of a recording: those at its beginning, without a fault, from which is learnt, and all.
#[derive(Clone, Copy)]
struct Lasting {
    learnt: u32,
    whole: u32,
}

/// A little of a cylinder, and of six.
const ONE: Lasting = Lasting { learnt: 80, whole: 280 };
const SIX: Lasting = Lasting { learnt: 80, whole: 200 };

/// The seeds to try, and for how long each: one as long as `usually` in a test, many and longer in a
/// sweep.
fn tries(usually: Lasting) -> (RangeInclusive<u64>, Lasting) {
    match env::var("TERTIUS_SEEDS") {
        Ok(seeds) => {
            let count = seeds.parse().expect("TERTIUS_SEEDS is a number of seeds");
            (1..=count, Lasting { learnt: 200, whole: 700 })
        }
        Err(_) => (1..=1, usually),
    }
}

/// A row of `faults.csv`.
#[derive(Clone, Debug)]
struct Fault {
    cylinder: u64,
    sensor: String,
    kind: String,
    begin: f64,
    end: f64,
    /// m, m/s, or nothing that counts.
    size: f64,
}

impl Fault {
    fn read(table: &str) -> Vec<Self> {
        let row = |line: &str| {
            let fields: Vec<&str> = line.split(',').collect();
            let number = |i: usize| fields[i].parse::<f64>().expect("a number");
            let [begin, end, size] = [3, 4, 5].map(number);
            let [sensor, kind] = [fields[1], fields[2]].map(str::to_owned);
            Self { cylinder: number(0) as u64, sensor, kind, begin, end, size }
        };
        table.lines().skip(1).map(row).collect()
    }

    /// No monitor that is worth its name misses it. A frozen reading is not seen at rest.
    fn is_gross(&self) -> bool {
        match &*self.kind {
            "stale" | "loss" | "out_of_range" | "broken_wire" => true,
            "step" => self.size.abs() >= 3e-3,
            "noise" => self.size.abs() >= 2e-3,
            _ => false,
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { cylinder, sensor, kind, begin, end, size } = self;
        write!(f, "cylinder {cylinder}, {sensor}, {kind} {size:.6}, {begin:.3} s to {end:.3} s")
    }
}

/// What was said about a fault in the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Blame {
    Right,
    Undecided,
    Missed,
    /// The other transducer was named, or while the fault was there the process.
    Wrong,
}

fn time(warning: &Value) -> f64 {
    warning["t"].as_f64().expect("a number")
}

/// The worst of what `warnings`, those of the fault's cylinder and time, say of it.
fn blame(fault: &Fault, warnings: &[&Value]) -> Blame {
    let standing = |w: &&&Value| w["state"] != "cleared" && time(w) < fault.end + COINCIDENCE;
    let mut blame = Blame::Missed;
    for warning in warnings.iter().filter(standing) {
        let suspect = warning["suspect"].as_str().expect("a word");
        blame = match (suspect, blame) {
            (_, Blame::Wrong) => Blame::Wrong,
            (suspect, _) if suspect == fault.sensor => Blame::Right,
            ("undecided", Blame::Missed) => Blame::Undecided,
            ("undecided", _) => blame,
            // What its going does to the motion in the controller's loop is the process.
            ("process", _) if time(warning) >= fault.end => blame,
            _ => Blame::Wrong,
        };
    }
    blame
}

/// What came of all faults of some recordings.
#[derive(Default)]
struct Judged {
    /// Of faults, by [`Blame`].
    counts: [usize; 4],
    /// Faults that the sequential detector found.
    sequential: usize,
    complaints: Vec<String>,
}

impl Judged {
    /// Judges `warnings` by the faults that are in their recording.
    fn judge(&mut self, name: &str, faults: &[Fault], warnings: &[Value]) {
        let mut left: Vec<&Value> = warnings.iter().collect();
        for fault in faults {
            let belongs = |w: &&Value| {
                w["cylinder"] == fault.cylinder
                    && (fault.begin..fault.end + AFTERMATH).contains(&time(w))
            };
            let (its, others): (Vec<_>, Vec<_>) = left.into_iter().partition(belongs);
            left = others;
            let blame = blame(fault, &its);
            println!("{name}: {fault}: {blame:?}");
            self.counts[blame as usize] += 1;
            self.sequential += usize::from(its.iter().any(|w| w["detector"] == "sequential"));
            if blame == Blame::Wrong || blame == Blame::Missed && fault.is_gross() {
                self.complain(format!("{name}: {fault}: {blame:?}"), &its);
            }
        }
        // One that clears was raised, and judged by that; so was one that changes and suspects whom it did.
        let goes_on = |w: &Value| {
            let own = |it: &&Value| {
                [&it["cylinder"], &it["detector"]] == [&w["cylinder"], &w["detector"]]
            };
            let before = warnings.iter().filter(own).take_while(|it| time(it) < time(w)).last();
            w["state"] == "changed" && before.is_some_and(|it| it["suspect"] == w["suspect"])
        };
        left.retain(|w| w["state"] != "cleared" && !goes_on(w));
        if !left.is_empty() {
            self.complain(format!("{name}: warnings that belong to no fault"), &left);
        }
    }

    fn complain(&mut self, what: String, warnings: &[&Value]) {
        let lines = warnings.iter().map(|w| {
            let word = |key: &str| w[key].as_str().unwrap_or("–").to_owned();
            let words = ["detector", "state", "fault", "suspect"].map(word).join(" ");
            format!("\n    {:.3} s, cylinder {}: {words}", time(w), w["cylinder"])
        });
        self.complaints.push(what + &lines.collect::<String>());
    }

    #[track_caller]
    fn assert_none_is_wrong(&self) {
        let [right, undecided, missed, wrong] = self.counts;
        println!(
            "{} faults: {right} blamed right, {undecided} undecided, {missed} missed, {wrong} wrong; \
             {} found by the sequential detector",
            self.counts.iter().sum::<usize>(),
            self.sequential
        );
        assert!(self.complaints.is_empty(), "{}", self.complaints.join("\n"));
    }
}

/// A machine with its recordings, in a folder of its own.
struct Machine {
    name: &'static str,
    folder: Scratch,
    learnt: u32,
}

impl Machine {
    /// What machines.py writes of `name`; what it is made of comes from the simulator where `simulated`.
    fn write(name: &'static str, seed: u64, lasting: Lasting, simulated: bool) -> Self {
        let folder = Scratch::new();
        let place = folder.path("");
        let [seed, learnt, whole] =
            [seed.to_string(), lasting.learnt.to_string(), lasting.whole.to_string()];
        let truth = folder.path("truth.log");
        let mut call = vec![name, &place, &seed, &learnt, &whole];
        if simulated {
            oracle::run("machines.py", &["truth", &place], "");
            let [config, plant] = ["truth.toml", "truth-plant.toml"].map(|name| folder.path(name));
            let machine = ["simulate", "--config", &config, "--plant", &plant];
            let extent = ["--seed", &seed, "--duration", &whole, "--output", &truth];
            tertius(&[machine.as_slice(), &extent].concat(), b"").ok();
            call.push(&truth);
        }
        oracle::run("machines.py", &call, "");
        Self { name, folder, learnt: lasting.learnt }
    }

    fn config(&self) -> String {
        self.folder.path(&format!("{}.toml", self.name))
    }

    /// Runs `command` on the part that has no fault, and takes the tables `wanted` of what it wrote.
    fn learn(self, command: &str, wanted: &[&str]) -> Self {
        let (log, config) = (self.folder.path("healthy.log"), self.config());
        let (to, output) = (self.learnt.to_string(), self.folder.path("tables.toml"));
        let part = ["--to", &to, "--held-back", "30", "--output", &output];
        tertius(&[&[command, &log, "--config", &config][..], &part].concat(), b"").ok();
        let tables = self.folder.read("tables.toml");
        fs::remove_file(output).expect("it can be removed");
        let mut tables: toml::Table = tables.parse().expect("TOML");
        tables.retain(|key, _| wanted.contains(&key));
        let mut table: toml::Table =
            self.folder.read(&format!("{}.toml", self.name)).parse().expect("TOML");
        merge(&mut table, &tables);
        fs::write(config, table.to_string()).expect("it can be written");
        self
    }

    fn warnings(&self, log: &str) -> Vec<Value> {
        replay(&[&self.folder.path(log)], &self.config(), &[]).ok().warnings()
    }
}

/// A rig's own model, and both transducers against each other.
fn commissioned(name: &'static str, seed: u64, lasting: Lasting) -> Machine {
    let machine = Machine::write(name, seed, lasting, false);
    machine.learn("identify", &["model", "cylinder"]).learn("calibrate", &["cylinder"])
}

/// The simulator's machine has the model of Table 4-1.
fn calibrated(name: &'static str, seed: u64, lasting: Lasting) -> Machine {
    Machine::write(name, seed, lasting, true).learn("calibrate", &["cylinder"])
}

/// Tries the machine that `make` makes of each seed. Where it `is_quiet`, nothing is said of it without
/// a fault.
fn try_all(usually: Lasting, is_quiet: bool, make: impl Fn(u64, Lasting) -> Machine) -> Judged {
    let (seeds, lasting) = tries(usually);
    let mut judged = Judged::default();
    for seed in seeds {
        let machine = make(seed, lasting);
        if is_quiet {
            let healthy = machine.warnings("healthy.log");
            judged.judge(&format!("{} {seed}, healthy", machine.name), &[], &healthy);
        }
        let faults = Fault::read(&machine.folder.read("faults.csv"));
        let warnings = machine.warnings("faulty.log");
        judged.judge(&format!("{} {seed}", machine.name), &faults, &warnings);
    }
    judged.assert_none_is_wrong();
    judged
}

/// Neither Sync nor speeds, 20 bits of C1 beside a float of C2.
#[test]
fn a_rig_at_7_ms() {
    let judged = try_all(ONE, true, |seed, lasting| commissioned("rig7", seed, lasting));
    // All that its readings ever differ by when healthy is less than the detector's dead band of 0.1 mm.
    assert!(judged.sequential > 0, "the sequential detector is silent");
}

/// The rod goes where C1 says, and at times to the cylinder's end: its healthy readings are those of a
/// machine that does what no model says.
#[test]
fn a_rig_whose_controller_reads_the_faults() {
    _ = try_all(ONE, false, |seed, lasting| commissioned("loop7", seed, lasting));
}

/// Both readings pass raw 32767, which is no code of a transducer of 24 bits.
#[test]
fn a_rig_with_readings_of_24_bits() {
    _ = try_all(ONE, true, |seed, lasting| calibrated("rig24", seed, lasting));
}

/// The first page in each cycle is one that nobody wants; and a page of a message is no repetition of
/// another.
#[test]
fn six_cylinders_in_pages_on_can_fd() {
    _ = try_all(SIX, true, |seed, lasting| calibrated("paged", seed, lasting));
}

/// A measured rig, each of its faults alone. Its observers have another machine's model, and say so of
/// the healthy recording: FDE1 and FDE2 are no evidence there.
#[test]
fn a_measured_rig() {
    let scratch = Scratch::new();
    let table = fs::read_to_string(top().join(recording("hanging-load.faults.csv"))).expect("it");
    let heading = table.lines().next().expect("a heading");
    let mut judged = Judged::default();
    for row in table.lines().skip(1) {
        let fields: Vec<&str> = row.split(',').collect();
        let [cylinder, sensor, kind, begin, size, _, end] = fields[..] else { panic!("{row}") };
        let sensor = sensor.to_lowercase();
        let fault = Fault::read(&format!("\n{cylinder},{sensor},{kind},{begin},{end},{size}"));
        let (log, faulty) = (recording("hanging-load.log.gz"), scratch.path("faulty.log"));
        let csv = scratch.write("fault.csv", format!("{heading}\n{row}\n"));
        let rig = ["inject", &log, "--config", HANGING_LOAD, "--faults", &csv, "--output", &faulty];
        tertius(&rig, b"").ok();
        let config = recording("hanging-load-sequential.toml");
        let mut warnings = replay(&[&faulty], &config, &[]).ok().warnings();
        warnings.retain(|w| w["detector"] != "fde1" && w["detector"] != "fde2");
        judged.judge("hanging load", &fault, &warnings);
        fs::remove_file(&faulty).expect("it can be removed");
    }
    assert_eq!(judged.counts.iter().sum::<usize>(), 10);
    judged.assert_none_is_wrong();
}
