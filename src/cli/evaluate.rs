//! `tertius evaluate`: what the monitor finds, how fast, and how often it raises false alarms.

use super::Failure;
use super::files::{Inputs, Mark, Overwriting};
use super::machine::Machine;
use super::overriding::SetOptions;
use super::plant::{self, PlantOptions};
use super::progress::Bar;
use crate::config::Settings;
use crate::evaluate::weights;
use crate::evaluate::{
    Extent, Grade, Lessons, Plan, Stand, StandError, StudyName, Workers, study_names,
};
use crate::failure::print;
use crate::report::{evaluation, page};
use crate::simulator::Tables;
use crate::tune::Weights;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
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
    #[arg(long, value_name = "NAME,…", value_parser = studies(), value_delimiter = ',')]
    rows: Vec<&'static str>,
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

/// Names of studies as values of an option, with their help; what has no faults comes last.
fn studies() -> impl TypedValueParser<Value = &'static str> {
    let mut names: Vec<StudyName> = study_names().into_iter().map(|(study, _)| study).collect();
    names.sort_by_key(|study| study.name == "healthy");
    let values = names.clone().into_iter().map(|it| PossibleValue::new(it.name).help(it.about));
    PossibleValuesParser::new(values).map(move |given| {
        let own = names.iter().find(|study| study.name == given);
        own.expect("it is one of the possible values").name
    })
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
        let stand = Stand::new(&tables, settings, &machine.database, &machine.design);
        let wrong = |error: StandError| Failure::Wrong(error.to_string());
        // First whatever cannot be carried out.
        plan.check(&stand).map_err(wrong)?;
        // Then output that cannot be written, before minutes have been spent on it.
        let inputs = Inputs::new(machine.files(&self.config).chain(self.plant.files()));
        let wanted = [
            (self.output.as_deref(), Mark::Parts(&evaluation::JSON_PARTS)),
            (self.report.as_deref(), Mark::Page("evaluate")),
        ];
        let [output, report] = inputs.claim(wanted, self.overwriting)?;
        let threads = self.threads.or_else(|| std::thread::available_parallelism().ok());
        let threads = threads.map_or(1, NonZero::get);
        let campaign = plan.teach(&stand, &Threads { threads, bar: None }).map_err(wrong)?;
        let bar = Bar::counting(campaign.jobs());
        let evaluation = campaign.evaluate(&Threads { threads, bar: Some(&bar) });
        bar.finish();
        let evaluation = evaluation.map_err(wrong)?;
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
        let usual = || {
            let all = study_names().into_iter();
            let quick = all.filter(|(study, _)| !self.quick || study.is_quick);
            quick.filter(|(_, fits)| fits(settings)).map(|(study, _)| study.name).collect()
        };
        let studies = if self.rows.is_empty() { usual() } else { self.rows.clone() };
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
            hours,
            seas,
            weights: self.sets(settings)?,
            studies,
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
}

/// The diagonals of Q and R.
fn weights(text: &str) -> Result<Weights, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|word| word.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[q1, q2, q3, r1, r2]) => Ok(Weights { q: [q1, q2, q3], r: [r1, r2] }),
        _ => Err("expected five numbers, such as 1e-8,1e-3,100,1e-8,1e-2".to_owned()),
    }
}

/// Runs jobs on several threads.
struct Threads<'a> {
    threads: usize,
    /// Counts the jobs.
    bar: Option<&'a Bar>,
}

impl Workers for Threads<'_> {
    fn each<T: Send>(
        &self,
        count: usize,
        job: impl Fn(usize) -> Result<T, StandError> + Sync,
        mut take: impl FnMut(usize, T),
    ) -> Result<(), StandError> {
        let (next, job) = (&AtomicUsize::new(0), &job);
        std::thread::scope(|scope| {
            let (sender, receiver) = mpsc::sync_channel(WAITING);
            for _ in 0..self.threads.min(count) {
                let sender = sender.clone();
                scope.spawn(move || {
                    // Until no job is left, or one has failed and no result is received any more.
                    loop {
                        let index = next.fetch_add(1, Ordering::Relaxed);
                        if index >= count || sender.send((index, job(index))).is_err() {
                            return;
                        }
                    }
                });
            }
            drop(sender);
            for (index, result) in receiver {
                take(index, result?);
                self.bar.iter().for_each(|bar| bar.count());
            }
            Ok(())
        })
    }
}
