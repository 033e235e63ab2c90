//! A census of commissionings: many simulated machines, recordings and mishaps, each commissioned
//! by the program itself and then watched with the resulting configuration. See scripts/census.

mod held_out;
mod line;
mod machine;
mod one;
mod plan;
mod recording;
mod summary;

use line::Line;
use plan::{Plan, Task};
use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Options of the census.
struct Asked {
    commissionings: usize,
    seed: u64,
    jobs: usize,
    file: PathBuf,
    summary_only: bool,
    /// The longest recording, s.
    longest: f64,
    /// Fault-free hours for each commissioning.
    hours: f64,
    /// Number of faults of each kind for each commissioning.
    faults: usize,
    /// Numbers of the commissionings to run; empty for all.
    only: Vec<usize>,
}

const USAGE: &str = "census [--commissionings N (240)] [--seed N (1)] [--jobs N (1)] [--file LINES.jsonl \
                     (census.jsonl)] [--longest S (10800)] [--hours H (4)] [--faults N (10) of each kind] \
                     [--only N,N,…]\n\
                     census --summary LINES.jsonl";

impl Asked {
    fn read(mut words: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut asked = Self {
            commissionings: 240,
            seed: 1,
            jobs: 1,
            file: PathBuf::from("census.jsonl"),
            summary_only: false,
            longest: 10_800.0,
            hours: 4.0,
            faults: 10,
            only: Vec::new(),
        };
        while let Some(word) = words.next() {
            let value = words.next().ok_or_else(|| format!("{word} wants a value\n{USAGE}"))?;
            let number = || {
                value
                    .parse::<f64>()
                    .map_err(|_| format!("{word} {value}: expected a number\n{USAGE}"))
            };
            match word.as_str() {
                "--commissionings" => asked.commissionings = number()? as usize,
                "--seed" => asked.seed = number()? as u64,
                "--jobs" => asked.jobs = (number()? as usize).max(1),
                "--file" => asked.file = PathBuf::from(value),
                "--longest" => asked.longest = number()?,
                "--hours" => asked.hours = number()?,
                "--faults" => asked.faults = number()? as usize,
                "--only" => {
                    let each = value.split(',').map(str::parse);
                    let numbers: Result<_, _> = each.collect();
                    asked.only =
                        numbers.map_err(|_| format!("--only {value} is no list of numbers"))?;
                }
                "--summary" => {
                    asked.file = PathBuf::from(value);
                    asked.summary_only = true;
                }
                _ => return Err(format!("{word} is not known\n{USAGE}")),
            }
        }
        Ok(asked)
    }

    fn wants(&self, number: usize) -> bool {
        self.only.is_empty() || self.only.contains(&number)
    }
}

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(why) => {
            eprintln!("census: {why}");
            ExitCode::from(2)
        }
    }
}

/// Runs the census; returns whether everything met the targets.
fn run() -> Result<bool, String> {
    let asked = Asked::read(std::env::args().skip(1))?;
    if !asked.summary_only {
        commission(&asked)?;
    }
    let lines = read(&asked.file)?;
    let (text, good) = summary::of(&lines);
    print!("{text}");
    Ok(good)
}

fn commission(asked: &Asked) -> Result<(), String> {
    let plan = Plan::new(asked.commissionings, asked.seed, asked.longest);
    let done: BTreeSet<usize> = if asked.file.exists() {
        let lines = read(&asked.file)?;
        if lines.iter().any(|line| line.seed != asked.seed) {
            return Err(format!("{} is of another seed; name another file", asked.file.display()));
        }
        lines.iter().map(|line| line.number).collect()
    } else {
        BTreeSet::new()
    };
    let open = |it: &&Task| asked.wants(it.number) && !done.contains(&it.number);
    let tasks: Vec<&Task> = plan.tasks.iter().filter(open).collect();
    let file = OpenOptions::new().create(true).append(true).open(&asked.file);
    let file = Mutex::new(file.map_err(|error| format!("{}: {error}", asked.file.display()))?);
    let world = one::World::load(&top())?;
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..asked.jobs {
            scope.spawn(|| {
                while let Some(task) = tasks.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let line = one::commission(&world, task, asked.hours, asked.faults);
                    append(&file, &line);
                    eprintln!("{} of {}: {}", line.number, plan.tasks.len(), line.sentence);
                }
            });
        }
    });
    Ok(())
}

fn top() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn append(file: &Mutex<File>, line: &Line) {
    let text = serde_json::to_string(line).expect("numbers and texts") + "\n";
    let mut file = file.lock().expect("nobody panics with it");
    // In one piece, so that a census that is stopped leaves whole lines.
    file.write_all(text.as_bytes()).expect("the file can be written");
}

fn read(path: &Path) -> Result<Vec<Line>, String> {
    let wrong = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let file = fs::File::open(path).map_err(|error| wrong(&error))?;
    let mut lines = Vec::new();
    for line in BufReader::new(file).lines() {
        let line = line.map_err(|error| wrong(&error))?;
        lines.push(serde_json::from_str(&line).map_err(|error| wrong(&error))?);
    }
    Ok(lines)
}
