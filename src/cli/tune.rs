//! `tertius tune`: the observer's weights and the thresholds from a healthy recording.

use super::Failure;
use super::files::Overwriting;
use super::machine::Machine;
use super::survey::{Field, Surveyed};
use super::tables::{self, InPlace};
use crate::calibrate::watch::{Level, Sight, Watch};
use crate::config::Settings;
use crate::extremes::{HOURS_PER_YEAR, Tail, common_level, per_second};
use crate::monitor::MonitorDesign;
use crate::observe::model::Model;
use crate::report::{page, tuning};
use crate::tune::{
    Criterion, CylinderModel, Detector, Evidence, LEAST_HIGH, Search, Store, Thresholds, Tuning,
    Weights, designs, response, search, sensitivity,
};
use clap::Args;
use std::path::PathBuf;

/// Chooses the observer's weights and the thresholds of R1 and R2 on a healthy recording, and says
/// what they will find.
#[derive(Args, Debug)]
#[command(
    after_help = "Example:\n  tertius tune field.log.zst --config config/e-type.toml --output \
                  tuning.toml\n\nThe model has to be in the configuration before: see `tertius \
                  identify`."
)]
pub struct Tune {
    #[command(flatten)]
    field: Field,
    /// Writes the tables [observer] and [fde] for the configuration
    #[arg(long, value_name = "FILE.toml")]
    output: Option<PathBuf>,
    /// Writes a page with figures, in one file
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    #[command(flatten)]
    place: InPlace,
    #[command(flatten)]
    overwriting: Overwriting,
    /// False alarms of FDE1 and FDE2, all cylinders together, that a year of monitoring may bring
    #[arg(long, value_name = "N", default_value_t = 1.0, value_parser = tables::per_year)]
    false_alarms_per_year: f64,
    /// Keeps the configured weights, and takes the thresholds only
    #[arg(long)]
    keep_weights: bool,
    /// The standard deviation that noise (5-17) is counted in, m; 4 counts in the thesis
    #[arg(long, value_name = "METRES", default_value_t = 4.34e-4, value_parser = sigma)]
    sigma: f64,
}

/// A step has to be found within this time, s.
const IN_TIME: f64 = 0.1;

/// Noise has to be found within this time, s.
const NOISE_IN_TIME: f64 = 1.0;

/// Cycles of the response to a step that are shown.
const RESPONSE: usize = 25;

/// δ_l is at most this part of δ_h, as in section 5-4-1.
const HYSTERESIS: f64 = 0.75;

/// Other rates that are shown: one an hour, a day, a month, a year, false alarms a year.
const LADDER: [f64; 4] = [8766.0, 365.25, 12.0, 1.0];

fn sigma(text: &str) -> Result<f64, String> {
    let sound = text.parse().ok().filter(|sigma: &f64| sigma.is_finite() && *sigma > 0.0);
    sound.ok_or_else(|| "expected a length in metres, above 0".to_owned())
}

impl Tune {
    /// Tunes.
    ///
    /// # Errors
    /// What is wrong with the call or its files; a recording that says too little.
    pub fn run(self) -> Result<(), Failure> {
        // Weights are tuned for the model that is configured: it has to be one of this machine.
        Machine::load(&self.field.config)?;
        let surveyed = self.field.open()?;
        let outputs = [&self.output, &self.report];
        let [output, report] =
            tables::claim("tune", outputs, self.overwriting, &self.field, &surveyed, &self.place)?;
        let result = self.tuning(&surveyed)?;
        let usable = usable(&result, &surveyed.machine.loaded.settings);
        let written = usable.is_ok().then(|| tuning::tables(&result, env!("CARGO_PKG_VERSION")));
        tables::publish(&tuning::page(&result), output, written.as_deref())?;
        if let Some(tables) = written {
            self.place.put(&tables, &[], MonitorDesign::new)?;
        }
        if let Some(report) = report {
            report.write(&page::tuning::page(&result))?;
        }
        surveyed.damage()?;
        usable
    }

    /// Reads the recording twice: stretches for the search, and all of it for the thresholds.
    fn tuning(&self, surveyed: &Surveyed) -> Result<Tuning, Failure> {
        let settings = &surveyed.machine.loaded.settings;
        let cylinders: Vec<CylinderModel> =
            (1..=settings.machine.cylinders).map(|n| cylinder(settings, n)).collect();
        let sample_time = settings.machine.sample_time;
        let criterion = Criterion {
            rate: per_second(self.false_alarms_per_year),
            sample_time,
            block: settings.warning_cycles(),
            horizon: ((IN_TIME / sample_time) as usize).max(1),
            sharp: (settings.cycles(settings.alarm.coincidence) as usize).max(1),
            settle: settings.cycles(settings.observer.settle),
        };
        let mut store = Store::new(&cylinders);
        surveyed.read(surveyed.window, &mut store)?;
        store.finish();
        let search = self.search(&criterion, &cylinders, &store, settings)?;
        let designs = designs(&cylinders, search.weights, criterion.settle)
            .map_err(|(n, error)| Failure::Failed(format!("cylinder {n}: {error}")))?;
        let mut evidence = Evidence::new(&cylinders, &designs, criterion.block);
        let sequential = surveyed.machine.design.cylinders.iter().map(|c| c.sequential.as_ref());
        let mut watch = Watch::new(sequential, sample_time);
        surveyed.read(surveyed.window, (&mut evidence, &mut watch))?;
        let mut detectors = evidence.detectors(sample_time);
        let tails = tails(&detectors, criterion.block, sample_time)?;
        let thresholds = self.thresholds(&detectors, &tails);
        let noise_horizon = ((NOISE_IN_TIME / sample_time) as usize).max(1);
        for detector in &mut detectors {
            let (index, i) = (usize::from(detector.cylinder) - 1, detector.transducer);
            let (design, high) = (&designs[index][i], thresholds.high);
            detector.step = sensitivity::step(&store, index, i, design, high, criterion.horizon);
            detector.response = response::step(design, RESPONSE);
            detector.noise = sensitivity::noise(design, high, noise_horizon);
        }
        let level = |per_year: f64| (per_year, common_level(&tails, per_second(per_year)));
        let (remarks, critical) = (surveyed.remarks(), settings.comparator.critical);
        let mut result = Tuning {
            machine: settings.machine.name.clone(),
            inputs: surveyed.inputs(),
            first: surveyed.first,
            window: surveyed.window,
            sample_time,
            search,
            thresholds,
            detectors,
            sequential: None,
            ladder: LADDER.map(level).to_vec(),
            sigma: self.sigma,
            remarks,
        };
        result.remarks.extend(limits(&result, critical));
        let (level, told) = self::sequential(settings, &watch, self.false_alarms_per_year);
        result.sequential = level;
        result.remarks.extend(told);
        Ok(result)
    }

    fn search(
        &self,
        criterion: &Criterion,
        cylinders: &[CylinderModel],
        store: &Store,
        settings: &Settings,
    ) -> Result<Search, Failure> {
        let begun = Weights { q: settings.observer.q, r: settings.observer.r };
        let little = || {
            Failure::Failed(format!(
                "in no cylinder there is enough to judge: at least {:.0} s in monitored states with \
                 position and command are needed, without the times after gaps in which the \
                 observers settle",
                f64::from(criterion.block)
                    * criterion.sample_time
                    * crate::extremes::LEAST_BLOCKS as f64
            ))
        };
        if self.keep_weights {
            let score = criterion.score(cylinders, store, begun).ok_or_else(little)?;
            let cycles = store.cycles();
            return Ok(Search { weights: begun, score, begun, before: score, tried: 1, cycles });
        }
        search(criterion, cylinders, store, begun).ok_or_else(little)
    }

    fn thresholds(&self, detectors: &[Detector], tails: &[Tail]) -> Thresholds {
        let wanted = common_level(tails, per_second(self.false_alarms_per_year));
        let high = if wanted > 0.0 { wanted.max(LEAST_HIGH) } else { wanted };
        let calm = detectors.iter().map(|detector| detector.calm).fold(0.0, f64::max);
        Thresholds {
            high,
            low: calm.min(HYSTERESIS * high),
            per_year: self.false_alarms_per_year,
            hours: tails.iter().map(|tail| tail.seconds).fold(f64::INFINITY, f64::min) / 3600.0,
        }
    }
}

/// Of every detector, or which has too little.
fn tails(detectors: &[Detector], block: u32, sample_time: f64) -> Result<Vec<Tail>, Failure> {
    let least = f64::from(block) * sample_time * crate::extremes::LEAST_BLOCKS as f64;
    let tail = |detector: &Detector| {
        detector.tail.ok_or_else(|| {
            Failure::Failed(format!(
                "C{} of cylinder {} was judged in {:.1} s only, of {least:.0} s at least: the \
                 recording is too short, its readings or commands are missing, or the platform is \
                 in no monitored state",
                detector.transducer + 1,
                detector.cylinder,
                detector.residuals.count as f64 * sample_time
            ))
        })
    };
    detectors.iter().map(tail).collect()
}

fn cylinder(settings: &Settings, n: u8) -> CylinderModel {
    let (theta, gamma) = settings.model_of(n);
    let signals = &settings.signals.cylinder;
    let second = signals.c2.is_some();
    CylinderModel {
        number: n,
        model: Model::new(settings.machine.sample_time, theta, gamma),
        command_offset: settings.command_offset_of(n),
        transducers: [true, second],
        velocities: [signals.c1_velocity.is_some(), second && signals.c2_velocity.is_some()],
    }
}

/// What to think of before these thresholds are used.
fn limits(result: &Tuning, critical: f64) -> Vec<String> {
    let mut remarks = Vec::new();
    let heavy: Vec<&Detector> =
        result.detectors.iter().filter(|d| d.tail.is_some_and(|tail| tail.heavy)).collect();
    if !heavy.is_empty() {
        remarks.push(format!(
            "{} of {} residuals have bursts, a tail heavier than an exponential one: the model does \
             not follow the machine at times, and the threshold is that of the bursts",
            heavy.len(),
            result.detectors.len()
        ));
    }
    if result.thresholds.high >= critical {
        remarks.push(format!(
            "the threshold of {:.1} mm is not below comparator.critical, {:.1} mm, where the machine \
             itself trips: FDE1 and FDE2 then only tell which transducer it was",
            result.thresholds.high * 1e3,
            critical * 1e3
        ));
    }
    if result.search.score.times.is_infinite() {
        remarks.push(
            "with no weights the response to a step is over within alarm.coincidence: a fault may \
             be taken for two"
                .to_owned(),
        );
    }
    remarks
}

/// The level of the detectors that have none of their own, where the recording supports one, and what
/// is to be said of all of them.
fn sequential(settings: &Settings, watch: &Watch, per_year: f64) -> (Option<Level>, Vec<String>) {
    let own = |n| settings.sequential_of(n).is_some_and(|fitted| fitted.level.is_some());
    if !(1..=settings.machine.cylinders).any(own) {
        let level = watch.level(per_year);
        let refused = level.filter(|level| !level.sound).map(|level| {
            format!(
                "sequential detectors: {:.1} nats of evidence were seen, which no healthy machine has by \
                 what it was calibrated to; no level is written: calibrate anew",
                level.worst
            )
        });
        return (level.filter(|level| level.sound), refused.into_iter().collect());
    }
    let said = (1..).zip(watch.levels(per_year)).filter_map(|(n, level): (u8, _)| {
        let (sight, h) = (level?.worst?, settings.sequential_level_of(n));
        let beyond = if sight.nats > h { "; it would have warned: is that healthy?" } else { "" };
        let Sight { nats, t, .. } = sight;
        Some(format!(
            "sequential detector of cylinder {n}: {nats:.1} of {h:.1} nats at {t:.1} s{beyond}"
        ))
    });
    (None, said.collect())
}

/// A threshold is at most this part of the difference at which the machine itself trips, …
const LARGEST: f64 = 0.1;

/// … unless the recording itself shows what comes as often as is asked for, a little more or less.
const SHOWN: f64 = 1.05;

/// A threshold beyond reach, or of nothing, is none.
fn usable(result: &Tuning, settings: &Settings) -> Result<(), Failure> {
    let Thresholds { high, hours, per_year, .. } = result.thresholds;
    let [low_end, high_end] = settings.machine.stroke;
    if high <= 0.0 {
        return Err(Failure::Failed(
            "the residuals are zero throughout: this is no recording of a machine".to_owned(),
        ));
    }
    let critical = settings.comparator.critical;
    let farther = HOURS_PER_YEAR / per_year / hours;
    if high <= LARGEST * critical || (farther <= SHOWN && high < high_end - low_end) {
        return Ok(());
    }
    let tails: Vec<Tail> = result.detectors.iter().filter_map(|detector| detector.tail).collect();
    let at = |level: f64| {
        let rate = tails.iter().map(|tail| tail.rate(level)).sum::<f64>();
        (rate / per_second(1.0)).ceil()
    };
    Err(Failure::Failed(format!(
        "for {per_year} false alarms a year the threshold would be {:.1} mm, beyond {:.1} mm, a tenth of \
         comparator.critical: the observers would hardly find what they are for. Record for longer than \
         {hours:.3} h, find a better model (`tertius identify`), or ask for a rate that the recording can \
         speak of (--false-alarms-per-year): with {:.1} mm, the thesis's, it is about {:.0} a year, with \
         {:.1} mm about {:.0}, with the largest residual seen, {:.1} mm, about {:.0}",
        high * 1e3,
        LARGEST * critical * 1e3,
        LEAST_HIGH * 1e3,
        at(LEAST_HIGH),
        LARGEST * critical * 1e3,
        at(LARGEST * critical),
        worst(&tails) * 1e3,
        at(worst(&tails)),
    )))
}

fn worst(tails: &[Tail]) -> f64 {
    tails.iter().map(|tail| tail.worst).fold(0.0, f64::max)
}
