//! `tertius evaluate`: what the monitor finds, how fast, and how often it raises false alarms.

use super::Failure;
use super::files::{Inputs, Mark, Overwriting};
use super::machine::Machine;
use super::overriding::SetOptions;
use super::plant::{self, PlantOptions};
use super::progress::Bar;
use crate::config::Settings;
use crate::evaluate::contest::Contest;
use crate::evaluate::weights::{self, Weighing};
use crate::evaluate::{
    Evaluation, Extent, Gathering, Grade, Job, Learnt, Lessons, Plan, Product, Stand, StandError,
    Study,
};
use crate::failure::print;
use crate::monitor::MonitorDesign;
use crate::report::{evaluation, page};
use crate::simulator::{Options, Tables};
use crate::tune::Weights;
use clap::{Args, ValueEnum};
use std::num::NonZero;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

/// Evaluates the monitor on a simulated machine: with faults of every kind and size, and without
#[derive(Args, Debug)]
#[command(
    after_help = "Example:\n  tertius evaluate --config config/e-type-simulated.toml --seed 1 \
                  --output evaluation.json\n\nEach row of the result is one kind of fault of one \
                  size, on fine transducers (one count) or\ncoarse ones (steps of four counts), in \
                  one sea. The same seed gives the same result on any number\nof cores. The \
                  configuration has to know the simulated machine's C2 corrections, as\n\
                  config/e-type-simulated.toml does."
)]
pub struct Evaluate {
    /// The configuration of the monitor, and of the simulated machine's bus
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    #[command(flatten)]
    set: SetOptions,
    #[command(flatten)]
    plant: PlantOptions,
    /// Seed of everything random: the same seed gives the same bytes
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Number of faults in a row; a quarter of it in the rows of the loop and of the hand-over [default: 600; --quick:
    /// 12]
    #[arg(long, value_name = "N")]
    trials: Option<u32>,
    /// Fault-free hours, for each grade in each sea [default: 10; --quick: 0.1]
    #[arg(long, value_name = "H")]
    hours: Option<f64>,
    /// Takes only seconds: few faults, one sea; the contest and the estimates, which take longer,
    /// only where --rows names them
    #[arg(long)]
    quick: bool,
    /// Runs only these studies
    #[arg(long, value_name = "NAME,…", value_enum, value_delimiter = ',')]
    rows: Vec<Studied>,
    /// Significant wave height, m, and peak period, s; may be repeated [default: the plant's, a calmer
    /// and a rougher one, 2.5,8 and 1.5,7 and 3,10 of the built-in plant; --quick: the plant's]
    #[arg(long = "sea", value_name = "HS,TP")]
    seas: Vec<String>,
    /// Weights of the observers for --rows weights: the diagonals of Q and R; may be repeated
    /// [default: those of the configuration, and four sets of docs/EVALUATION.md]
    #[arg(long, value_name = "Q1,Q2,Q3,R1,R2", value_parser = weights)]
    weights: Vec<Weights>,
    /// Number of machines simulated at once [default: the number of cores]
    #[arg(long, value_name = "N")]
    threads: Option<NonZero<usize>>,
    /// Format of standard output
    #[arg(long, value_enum, default_value_t = Format::Human)]
    format: Format,
    /// Writes the result as JSON
    #[arg(long, value_name = "FILE.json")]
    output: Option<PathBuf>,
    /// Writes a page with figures, in one file
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    #[command(flatten)]
    overwriting: Overwriting,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    Human,
    Json,
}

/// Studies that can be selected by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Studied {
    /// Type I (5-15), (5-16)
    Step,
    /// Type II (5-17)
    Noise,
    /// Type III (5-18)
    Incipient,
    /// A constant rate
    Drift,
    /// A gain error
    Scale,
    /// Frozen, stale, lost, out of range, broken wire, spikes
    Data,
    /// No fault: what is found by chance
    Chance,
    /// Faults of C1 that the controller reads, beside those that it does not
    Loop,
    /// Thresholds and sequential detectors on the same faults and hours
    Contest,
    /// The virtual third sensor
    Estimate,
    /// Weights of the observers, each with its own thresholds
    Weights,
    /// Faults of valves, pressures and commands, which are no transducer's
    Process,
    /// A machine whose controller hears who is blamed: code blacks with and without
    Handover,
    /// Drifts of C1 and of C2 that the controller reads: which of them is named, and how soon
    Side,
    /// The same by the attitude of the deck, which takes a sensor there
    Hexapod,
    /// Faults of the transducer that is left after the other one was lost, froze or stepped by 10 mm
    Last,
    /// The same on cylinders that have no C2
    Single,
    /// The estimate by a transducer less its step, once the other one is lost
    Accommodate,
    /// False alarms
    Healthy,
}

impl Studied {
    /// Whether it takes seconds with few faults; studies that learn first, or simulate long, do
    /// not.
    const fn is_quick(self) -> bool {
        !matches!(
            self,
            Self::Contest
                | Self::Estimate
                | Self::Weights
                | Self::Process
                | Self::Handover
                | Self::Side
                | Self::Hexapod
                | Self::Last
                | Self::Single
                | Self::Accommodate
        )
    }

    const fn study(self) -> Option<Study> {
        Some(match self {
            Self::Step => Study::Step,
            Self::Noise => Study::Noise,
            Self::Incipient => Study::Incipient,
            Self::Drift => Study::Drift,
            Self::Scale => Study::Scale,
            Self::Data => Study::Data,
            Self::Chance => Study::Chance,
            Self::Loop => Study::Loop,
            Self::Contest => Study::Contest,
            Self::Estimate => Study::Estimate,
            Self::Weights => Study::Weights,
            Self::Process => Study::Process,
            Self::Handover => Study::Handover,
            Self::Side => Study::Side,
            Self::Hexapod => Study::Hexapod,
            Self::Last => Study::Last,
            Self::Single => Study::Single,
            Self::Accommodate => Study::Accommodate,
            Self::Healthy => return None,
        })
    }
}

/// Default seas: heights and periods by those of the plant's table.
const SEAS: [[f64; 2]; 3] = [[1.0, 1.0], [0.6, 0.875], [1.2, 1.25]];

/// Hours in each sea that the detectors of the contest learn from.
const LESSONS: Lessons = Lessons { calibration: 1.0, level: 20.0 };
const QUICK_LESSONS: Lessons = Lessons { calibration: 1.0 / 6.0, level: 1.0 / 6.0 };

/// Number of results that wait to be gathered.
const WAITING: usize = 64;

impl Evaluate {
    /// Runs the command.
    ///
    /// # Errors
    /// A wrong call or file, or output that cannot be written.
    pub fn run(self) -> Result<(), Failure> {
        let tables = self.plant.tables()?;
        let machine = Machine::load(&self.config, &self.set.overrides()?)?;
        let settings = &machine.loaded.settings;
        PlantOptions::compare(&tables, settings);
        let plan = Plan::new(self.seed, self.extent(settings, &tables)?)
            .map_err(|error| Failure::Wrong(error.to_string()))?;
        let mut stand = Stand::new(&tables, settings, &machine.database, &machine.design);
        // Whatever the call asks for that cannot be, before anything is done.
        for cell in &plan.cells {
            let options = Options { sea: Some(cell.sea), ..Options::default() };
            stand.simulator(*cell, &options).map_err(|error| Failure::Wrong(error.to_string()))?;
        }
        if let Some(weighing) = &plan.weighing {
            stand.weighed = weighed(weighing, &machine)?;
        }
        // And where it cannot be written, before minutes have been spent on it.
        let inputs = Inputs::new(machine.files(&self.config).chain(self.plant.files()));
        let wanted = [
            (self.output.as_deref(), Mark::Parts(&evaluation::JSON_PARTS)),
            (self.report.as_deref(), Mark::Page("evaluate")),
        ];
        let [output, report] = inputs.claim(wanted, self.overwriting)?;
        if let Some(contest) = &plan.contest {
            stand.monitors = learn(contest, &stand, plan.extent.lessons)?;
        }
        if let Some(process) = &plan.process {
            stand.taught =
                process.designs(&stand).map_err(|error| Failure::Wrong(error.to_string()))?;
        }
        if let Some(handover) = &plan.handover {
            stand.handing =
                of_grades(&handover.grades, |grade| Ok((grade, handover.design(&stand, grade)?)))?;
        }
        if let Some(side) = &plan.side {
            stand.sided =
                side.designs(&stand).map_err(|error| Failure::Wrong(error.to_string()))?;
        }
        if let Some(hexapod) = &plan.hexapod {
            stand.decked =
                hexapod.designs(&stand).map_err(|error| Failure::Wrong(error.to_string()))?;
        }
        if let Some(last) = &plan.last {
            stand.single =
                last.without_c2(&stand).map_err(|error| Failure::Wrong(error.to_string()))?;
        }
        let evaluation = self.evaluate(&plan, &stand)?;
        let with = machine.loaded.fingerprints();
        let json = evaluation::json(&evaluation, &with);
        if let Some(file) = output {
            file.write(&json)?;
        }
        if let Some(file) = report {
            file.write(&page::evaluation::page(&plan, &evaluation, &with))?;
        }
        let shown = match self.format {
            Format::Json => json,
            Format::Human => evaluation::text(&plan, &evaluation, &with),
        };
        print(&shown)
    }

    fn extent(&self, settings: &Settings, tables: &Tables) -> Result<Extent, Failure> {
        let asked: Vec<Studied> = if self.rows.is_empty() {
            let all = Studied::value_variants().iter().copied();
            let has_top = settings.signals.top_roll.is_some();
            all.filter(|studied| !self.quick || studied.is_quick())
                .filter(|studied| *studied != Studied::Hexapod || has_top)
                .collect()
        } else {
            self.rows.clone()
        };
        let healthy = asked.contains(&Studied::Healthy);
        let hours = self.hours.unwrap_or(if self.quick { 0.1 } else { 10.0 });
        let given = self.seas.iter().map(|text| plant::sea(text)).collect::<Result<Vec<_>, _>>()?;
        let usual =
            SEAS.map(|[height, period]| [height * tables.sea.height, period * tables.sea.period]);
        let seas = match (given.is_empty(), self.quick) {
            (false, _) => given,
            (true, true) => usual[..1].to_vec(),
            (true, false) => usual.to_vec(),
        };
        Ok(Extent {
            trials: self.trials.unwrap_or(if self.quick { 12 } else { 600 }),
            hours: if healthy { hours } else { 0.0 },
            seas,
            weights_hours: if asked.contains(&Studied::Weights) { hours } else { 0.0 },
            weights: self.sets(settings)?,
            process_hours: if asked.contains(&Studied::Process) { hours } else { 0.0 },
            hexapod_hours: if asked.contains(&Studied::Hexapod) { hours } else { 0.0 },
            last_hours: if [Studied::Last, Studied::Single].iter().any(|it| asked.contains(it)) {
                hours
            } else {
                0.0
            },
            side_hours: if asked.contains(&Studied::Side) { hours } else { 0.0 },
            contest_hours: if asked.contains(&Studied::Contest) { hours } else { 0.0 },
            studies: asked.into_iter().filter_map(Studied::study).collect(),
            lessons: if self.quick { QUICK_LESSONS } else { LESSONS },
            cylinders: settings.machine.cylinders,
            taught: Grade::taught(settings, tables),
            lag: tables.valve.lag,
        })
    }

    /// The weights that are compared.
    fn sets(&self, settings: &Settings) -> Result<Vec<Weights>, Failure> {
        let most = weights::MOST;
        if self.weights.len() > most {
            let given = self.weights.len();
            return Err(Failure::Wrong(format!(
                "--weights: {given} sets, expected {most} at most"
            )));
        }
        if !self.weights.is_empty() {
            return Ok(self.weights.clone());
        }
        let configured = Weights { q: settings.observer.q, r: settings.observer.r };
        let own = Some(configured).filter(|own| !weights::SETS.contains(own));
        Ok(own.into_iter().chain(weights::SETS).collect())
    }

    /// Does the jobs on all cores, and gathers their results.
    fn evaluate(&self, plan: &Plan, stand: &Stand) -> Result<Evaluation, Failure> {
        let settings = stand.settings;
        let sample_time = settings.machine.sample_time;
        let block = f64::from(settings.warning_cycles()) * sample_time;
        let jobs = plan.jobs();
        let threads = self.threads.or_else(|| std::thread::available_parallelism().ok());
        let (next, bar) = (AtomicUsize::new(0), Bar::counting(jobs.len()));
        let mut gathering = Gathering::new(plan, sample_time);
        let gathered = std::thread::scope(|scope| {
            let (sender, receiver) = mpsc::sync_channel(WAITING);
            for _ in 0..threads.map_or(1, NonZero::get).min(jobs.len().max(1)) {
                let (sender, next, jobs) = (sender.clone(), &next, &jobs);
                scope.spawn(move || work(plan, stand, jobs, next, &sender));
            }
            drop(sender);
            for (job, product) in receiver {
                let product = product.map_err(|error| Failure::Wrong(error.to_string()))?;
                gathering.take(job, product);
                bar.count();
            }
            Ok(())
        });
        bar.finish();
        gathered.map(|()| gathering.finish(&settings.machine.name, &stand.monitors, block))
    }
}

/// The diagonals of Q and R.
fn weights(text: &str) -> Result<Weights, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|word| word.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[q1, q2, q3, r1, r2]) => Ok(Weights { q: [q1, q2, q3], r: [r1, r2] }),
        _ => Err("expected five numbers, such as 1e-8,1e-3,100,1e-8,1e-2".to_owned()),
    }
}

/// The monitors by the sets of weights.
fn weighed(weighing: &Weighing, machine: &Machine) -> Result<Vec<MonitorDesign>, Failure> {
    weighing.designs(&machine.loaded.settings, &machine.database).map_err(|flaws| {
        let told: Vec<String> =
            flaws.iter().map(|flaw| format!("{}: {}", flaw.key, flaw.message)).collect();
        Failure::Wrong(format!("--weights: {}", told.join("; ")))
    })
}

/// Teaches the detectors of all grades, each grade on a core of its own.
fn learn(contest: &Contest, stand: &Stand, lessons: Lessons) -> Result<Vec<Learnt>, Failure> {
    of_grades(&contest.grades, |grade| {
        stand.learn(grade, &contest.seas, contest.lessons(), lessons)
    })
}

/// What is learnt of each grade, each on a core of its own.
fn of_grades<T: Send>(
    grades: &[Grade],
    learn: impl Fn(Grade) -> Result<T, StandError> + Sync,
) -> Result<Vec<T>, Failure> {
    let learn = &learn;
    let learnt: Vec<_> = std::thread::scope(|scope| {
        let started: Vec<_> =
            grades.iter().map(|grade| scope.spawn(move || learn(*grade))).collect();
        started.into_iter().map(|it| it.join().expect("learning does not panic")).collect()
    });
    let wrong = |error: StandError| Failure::Wrong(error.to_string());
    learnt.into_iter().map(|learnt| learnt.map_err(wrong)).collect()
}

type Brought = (Job, Result<Product, StandError>);

/// Does jobs until there are none, or nobody takes the results.
fn work(
    plan: &Plan,
    stand: &Stand,
    jobs: &[Job],
    next: &AtomicUsize,
    sender: &mpsc::SyncSender<Brought>,
) {
    while let Some(job) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
        if sender.send((*job, plan.run(stand, *job))).is_err() {
            return;
        }
    }
}
