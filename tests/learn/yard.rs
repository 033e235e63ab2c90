//! A machine that is to be commissioned: its configuration, and recordings of it.

use std::fs;
use tertius_testing::support::{self, Run, Scratch, changed, top};

/// The machine's folder.
pub struct Yard(pub Scratch);

pub fn tertius(arguments: &[&str]) -> Run {
    support::tertius(arguments, b"")
}

impl Yard {
    pub fn new() -> Self {
        let scratch = Scratch::new();
        let plant = fs::read_to_string(top().join("config/e-type-plant.toml")).expect("it ships");
        // Readings that stand off for a while are what the sequential detectors find.
        let plant = changed(&plant, &[("probability = 5.0e-4", "probability = 0.0")]);
        scratch.write("plant.toml", plant);
        scratch.write("e-type.dbc", fs::read(top().join("dbc/e-type.dbc")).expect("it ships"));
        let text = fs::read_to_string(top().join("config/e-type.toml")).expect("it ships");
        scratch.write("config.toml", changed(&text, &[("../dbc/e-type.dbc", "e-type.dbc")]));
        Self(scratch)
    }

    pub fn path(&self, name: &str) -> String {
        self.0.path(name)
    }

    pub fn read(&self, name: &str) -> String {
        self.0.read(name)
    }

    /// Records the machine in this sea, by this seed.
    pub fn simulate(
        &self,
        name: &str,
        [sea, seed]: [&str; 2],
        seconds: i64,
        more: &[&str],
    ) -> String {
        let [config, plant, log] = ["config.toml", "plant.toml", name].map(|it| self.path(it));
        let seconds = seconds.to_string();
        let call = ["simulate", "--config", &config, "--plant", &plant, "--duration", &seconds];
        let of = ["--sea", sea, "--seed", seed, "--output", &log];
        tertius(&[&call[..], &of, more].concat()).ok();
        log
    }

    /// Puts faults into a recording of it.
    pub fn inject(&self, log: &str, name: &str, faults: &[&str]) -> String {
        let [config, faulty] = ["config.toml", name].map(|it| self.path(it));
        let mut call = vec!["inject", log, "--config", &config, "--output", &faulty, "--force"];
        faults.iter().for_each(|fault| call.extend(["--fault", fault]));
        tertius(&call).ok();
        faulty
    }
}

/// Lines of a recording, so many seconds later.
pub fn moved(text: &str, later: i64) -> String {
    let line = |line: &str| {
        let (seconds, rest) = line[1..].split_once('.').expect("a time stamp");
        format!("({}.{rest}\n", seconds.parse::<i64>().expect("seconds") + later)
    };
    text.lines().map(line).collect()
}
