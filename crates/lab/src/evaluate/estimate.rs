//! How far the virtual sensor is from the rod, and how reliable its standard deviation is.

use super::extent::{Extent, StudyName};
use super::fault::SIGMA;
use super::grade::Cell;
use super::proportion::Proportion;
use super::random::random;
use super::stand::{Stand, StandError};
use super::study::Study;
use super::truth::Truth;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use std::collections::BTreeMap;
use tertius_core::estimate::Estimate;
use tertius_core::monitor::{Estimates, Monitor, MonitorDesign, Sink};
use tertius_core::time::{Span, Timestamp};
use tertius_machine::inject::{Fault, Placed, Shape, Wanted, Window, place};
use tertius_machine::plant::CYLINDERS;
use tertius_machine::simulator::Options;

/// Time from the start to the earliest fault, s: the accuracy of the model has to be measured
/// first.
const LEAD: f64 = 60.0;

/// Span of time within which all faults begin, s.
const SPREAD: f64 = 5.0;

/// Faults of the transducers of one cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    pub name: &'static str,
    /// Fault of C1, and of C2 where `both` is set.
    pub wanted: Option<Wanted>,
    /// Whether C2 has the fault, too.
    pub both: bool,
    /// The controller reads the fault.
    pub in_loop: bool,
    /// How long the fault lasts and is watched, s.
    pub lasting: f64,
}

/// Cases that are tried.
pub const CASES: [Case; 11] = {
    const NOTHING: Case =
        Case { name: "healthy", wanted: None, both: false, in_loop: false, lasting: 20.0 };
    const fn of_c1(name: &'static str, shape: Shape) -> Case {
        Case { name, wanted: Some(Wanted::Shape(shape)), lasting: 10.0, ..NOTHING }
    }
    const LOST: Shape = Shape::Loss { probability: 1.0 };
    const fn both_lost(name: &'static str, lasting: f64) -> Case {
        Case { both: true, lasting, ..of_c1(name, LOST) }
    }
    [
        NOTHING,
        of_c1("C1 steps by 10 mm", Shape::Step { size: 0.01 }),
        of_c1("C1 drifts by 1 mm/s", Shape::Drift { rate: 1e-3 }),
        Case {
            in_loop: true,
            ..of_c1("C1 drifts by 1 mm/s in the loop", Shape::Drift { rate: 1e-3 })
        },
        of_c1("C1 has noise of 4 σ", Shape::Noise { size: 4.0 * SIGMA }),
        of_c1("C1 is frozen", Shape::Freeze),
        of_c1("C1 is lost", LOST),
        both_lost("both are lost for 0.2 s", 0.2),
        both_lost("both are lost for 1 s", 1.0),
        both_lost("both are lost for 2 s", 2.0),
        both_lost("both are lost for 5 s", 5.0),
    ]
};

/// Errors of estimates, m, cycle by cycle while a case lasted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Errors {
    /// Number of cycles, with or without an estimate.
    pub cycles: u64,
    /// Sizes of the errors of valid estimates.
    pub sizes: Vec<f64>,
    /// Number of errors within two of the standard deviations that were sent.
    pub covered: u64,
}

/// A case on one grade of transducers in one sea.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EstimateResult {
    pub case: &'static str,
    pub grade: &'static str,
    /// Significant wave height, m, and peak period, s.
    pub sea: [f64; 2],
    /// Number of cylinders that were watched.
    pub cylinders: u64,
    /// Number of cycles that were watched.
    pub cycles: u64,
    /// Part of all cycles with a valid estimate.
    pub valid: f64,
    /// Root mean square of the errors of the valid estimates, m.
    pub rms: f64,
    /// 95th percentile of the errors of the valid estimates, m.
    pub p95: f64,
    /// Largest error of the valid estimates, m.
    pub largest: f64,
    /// Valid estimates within two standard deviations of the rod.
    pub within: Proportion,
}

impl Stand<'_> {
    /// Watches one machine whose cylinders all meet `case`.
    ///
    /// # Errors
    /// If there is no such machine, or no place for the fault on it.
    pub fn estimate(
        &self,
        cell: Cell,
        case: &Case,
        rng: &mut ChaCha8Rng,
    ) -> Result<Errors, StandError> {
        let seed = rng.random();
        let times: [f64; CYLINDERS] = std::array::from_fn(|_| LEAD + SPREAD * rng.random::<f64>());
        let faults = self.of_case(case, &times)?;
        let options = Options {
            seed,
            sea: Some(cell.sea),
            in_loop: case.in_loop,
            faults,
            ..Options::default()
        };
        let mut simulator = self.simulator(cell, &options)?;
        let design = MonitorDesign { estimates: Estimates::Computed, ..self.design.clone() };
        let mut monitor = Monitor::new(design);
        let begun = simulator.opening();
        let windows = times.map(|at| [at, at + case.lasting].map(Span::from_seconds));
        let mut watch = Watch {
            windows: windows.map(|window| window.map(|at| begun.after(at))),
            truth: Truth::new(&simulator, self.settings.machine.sample_time),
            errors: Errors::default(),
        };
        for _ in 0..self.cycles(LEAD + SPREAD + case.lasting + 1.0) {
            watch.truth.note(&simulator);
            simulator.step(&mut |frame| monitor.take(frame, &mut watch));
        }
        Ok(watch.errors)
    }

    fn of_case(&self, case: &Case, times: &[f64; CYLINDERS]) -> Result<Vec<Placed>, StandError> {
        let Some(wanted) = case.wanted else { return Ok(Vec::new()) };
        let sensors = if case.both { &["c1", "c2"][..] } else { &["c1"] };
        let each = (1..=self.settings.machine.cylinders)
            .zip(times)
            .flat_map(|(n, at)| sensors.iter().map(move |it| (n, it, at)));
        each.map(|(cylinder, sensor, at)| {
            let [from, until] = [*at, at + case.lasting].map(Span::from_seconds);
            let window = Window { from, until: Some(until) };
            Ok(place(&Fault { cylinder, sensor, wanted, window }, self.settings, self.database)?)
        })
        .collect()
    }
}

/// Compares the estimates with the truth.
struct Watch {
    windows: [[Timestamp; 2]; CYLINDERS],
    truth: Truth,
    errors: Errors,
}

impl Sink for Watch {
    fn estimate(&mut self, at: Timestamp, cylinder: u8, estimate: Option<&Estimate>) {
        let Some((opening, truth)) = self.truth.of(at, cylinder) else { return };
        let [from, until] = self.windows[usize::from(cylinder) - 1];
        if opening < from || opening >= until {
            return;
        }
        self.errors.cycles += 1;
        if let Some(estimate) = estimate.filter(|estimate| estimate.valid) {
            let error = (estimate.position - truth).abs();
            self.errors.sizes.push(error);
            self.errors.covered += u64::from(error <= 2.0 * estimate.sigma);
        }
    }
}

impl EstimateResult {
    /// The figures of `machines` of a case, each of so many `cylinders`.
    pub(super) fn new(cell: Cell, case: &Case, machines: &[Errors], cylinders: u8) -> Self {
        let sum = |count: fn(&Errors) -> u64| machines.iter().map(count).sum::<u64>();
        let mut sizes: Vec<f64> = machines.iter().flat_map(|it| &it.sizes).copied().collect();
        sizes.sort_unstable_by(f64::total_cmp);
        let (cycles, valid) = (sum(|it| it.cycles), sizes.len() as u64);
        let squares: f64 = sizes.iter().map(|size| size * size).sum();
        let rank = (0.95 * valid as f64).ceil().max(1.0) as usize - 1;
        Self {
            case: case.name,
            grade: cell.grade.name(),
            sea: cell.sea,
            cylinders: machines.len() as u64 * u64::from(cylinders),
            cycles,
            valid: valid as f64 / cycles.max(1) as f64,
            rms: (squares / valid.max(1) as f64).sqrt(),
            p95: sizes.get(rank).copied().unwrap_or(0.0),
            largest: sizes.last().copied().unwrap_or(0.0),
            within: Proportion::new(sum(|it| it.covered), valid),
        }
    }
}

/// First stream of estimates, above those of healthy machines. All cases of a cell are tried on the same machines at the
/// same times.
const STREAMS: u64 = 1 << 63;
const NUMBERS: u64 = 1 << 21;

/// The study of the estimates.
const ESTIMATE: StudyName = StudyName::slow("estimate", "The virtual third sensor");

/// Estimates in every case of [`CASES`].
#[derive(Clone, Debug, PartialEq)]
pub struct EstimateStudy {
    pub cells: Vec<Cell>,
    /// Machines of each case in each cell; each has its fault on every cylinder.
    pub machines: u32,
    pub seed: u64,
    /// Number of cylinders that are monitored.
    pub cylinders: u8,
}

/// The machine of this number in a cell and one of [`CASES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EstimateJob {
    pub cell: usize,
    pub case: usize,
    pub number: u32,
}

impl Study for EstimateStudy {
    const NAMES: &'static [StudyName] = &[ESTIMATE];
    type Job = EstimateJob;
    type Taught = ();
    type Product = (EstimateJob, Errors);
    /// By cell and case, and by the number of the machine.
    type Gathered = BTreeMap<(usize, usize), BTreeMap<u32, Errors>>;
    type Figures = Vec<EstimateResult>;

    /// An empty list of estimates stands in the result, too.
    fn planned(seed: u64, extent: &Extent) -> Option<Self> {
        let asked = extent.asks(ESTIMATE);
        let machines = if asked { extent.trials.div_ceil(u32::from(extent.cylinders)) } else { 0 };
        Some(Self { cells: extent.cells(), machines, seed, cylinders: extent.cylinders })
    }

    fn teach(&self, _: &Stand, _: usize) -> Result<(), StandError> {
        Ok(())
    }

    fn jobs(&self) -> Vec<EstimateJob> {
        let of_case =
            |cell, case| (0..self.machines).map(move |number| EstimateJob { cell, case, number });
        let of_cell = |cell| (0..CASES.len()).flat_map(move |case| of_case(cell, case));
        (0..self.cells.len()).flat_map(of_cell).collect()
    }

    fn run(&self, stand: &Stand, _: &[()], job: EstimateJob) -> Result<Self::Product, StandError> {
        let EstimateJob { cell, case, number } = job;
        let mut rng = random(self.seed, STREAMS + cell as u64 * NUMBERS + u64::from(number));
        Ok((job, stand.estimate(self.cells[cell], &CASES[case], &mut rng)?))
    }

    fn gather(&self, _: &Stand, gathered: &mut Self::Gathered, (job, errors): Self::Product) {
        gathered.entry((job.cell, job.case)).or_default().insert(job.number, errors);
    }

    fn figures(&self, _: &Stand, _: &[()], gathered: Self::Gathered) -> Vec<EstimateResult> {
        let result = |((cell, case), machines): ((usize, usize), BTreeMap<u32, Errors>)| {
            let machines: Vec<Errors> = machines.into_values().collect();
            EstimateResult::new(self.cells[cell], &CASES[case], &machines, self.cylinders)
        };
        gathered.into_iter().map(result).collect()
    }
}
