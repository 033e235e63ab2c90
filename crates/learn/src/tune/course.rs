//! A tuning from beginning to end, on a recording that can be read repeatedly.

use super::joint::JointEvidence;
use super::usable::{limits, sequential};
use super::{
    Commands, Criterion, CylinderModel, Detector, Evidence, LEAST_HIGH, Search, Store, Thresholds,
    Tuning, Weights, designs, response, search, sensitivity,
};
use crate::calibrate::watch::Watch;
use crate::extremes::{LEAST_BLOCKS, Tail, common_level, per_second};
use crate::survey::{Origin, Recording};
use tertius_config::settings::Settings;
use tertius_core::monitor::MonitorDesign;
use tertius_core::observe::model::Model;

/// Time within which a step has to be found, s.
const IN_TIME: f64 = 0.1;

/// Time within which noise has to be found, s.
const NOISE_IN_TIME: f64 = 1.0;

/// Cycles of the response to a step that are shown.
const RESPONSE: usize = 25;

/// Largest δ_l, as a part of δ_h, as in section 5-4-1.
const HYSTERESIS: f64 = 0.75;

/// Further rates that are shown: one an hour, a day, a month, a year, in false alarms a year.
const LADDER: [f64; 4] = [8766.0, 365.25, 12.0, 1.0];

/// Default unit of noise amplitudes, m: four counts, as in the thesis.
pub const SIGMA: f64 = 4.34e-4;

/// Inputs of a tuning.
#[derive(Clone, Copy, Debug)]
pub struct TuningCourse<'a> {
    pub settings: &'a Settings,
    /// Monitor design of `settings`, whose sequential detectors are also tried.
    pub design: &'a MonitorDesign,
    pub origin: &'a Origin,
    /// Cylinders that are left out because no healthy data of them are known.
    pub without: &'a [u8],
    /// Wanted false alarms of the whole machine in a year.
    pub per_year: f64,
    /// Whether the configured weights are kept.
    pub keep_weights: bool,
    /// Standard deviation that is the unit of noise amplitudes, m.
    pub sigma: f64,
}

/// Why there is no tuning.
#[derive(Clone, Debug, PartialEq)]
pub enum Untuned<E> {
    /// The recording can no longer be read.
    Recording(E),
    /// The recording holds too little data, in words.
    TooLittle(String),
}

impl TuningCourse<'_> {
    /// Reads `recording` twice: stretches for the search, and everything for the thresholds.
    ///
    /// # Errors
    /// The recording's own, or a recording with too little data.
    pub fn run<R: Recording>(&self, recording: &R) -> Result<Tuning, Untuned<R::Error>> {
        let Self { settings, origin, per_year, .. } = *self;
        let cylinders: Vec<CylinderModel> =
            (1..=settings.machine.cylinders).map(|n| self.cylinder(n)).collect();
        let sample_time = settings.machine.sample_time;
        let criterion = self.criterion();
        let mut store = Store::new(&cylinders);
        let mut commands = Commands::new(&cylinders, criterion.block);
        let both = (&mut store, &mut commands);
        recording.read(origin.window, both).map_err(Untuned::Recording)?;
        store.finish();
        let commands = commands.taught();
        let search = self.search(&criterion, &cylinders, &store).map_err(Untuned::TooLittle)?;
        let designs = designs(&cylinders, search.weights, criterion.settle)
            .map_err(|(n, error)| Untuned::TooLittle(format!("cylinder {n}: {error}")))?;
        let mut evidence = Evidence::new(&cylinders, &designs, criterion.block, commands);
        let mut watch =
            Watch::new(self.design.cylinders.iter().map(|c| c.sequential.as_ref()), sample_time);
        let mut together = JointEvidence::new(&mut evidence, &mut watch);
        recording.read(origin.window, &mut together).map_err(Untuned::Recording)?;
        let joint = together.threshold();
        let mut detectors = evidence.detectors(sample_time);
        let tails = tails(&detectors, criterion.block, sample_time).map_err(Untuned::TooLittle)?;
        let thresholds = self.thresholds(&detectors, &tails);
        let joint = joint.filter(|joint| *joint < thresholds.high);
        let thresholds = Thresholds { commands, joint, ..thresholds };
        let noise_horizon = ((NOISE_IN_TIME / sample_time) as usize).max(1);
        for detector in &mut detectors {
            let (index, i) = (usize::from(detector.cylinder) - 1, detector.transducer);
            let (design, high) = (&designs[index][i], thresholds.high);
            detector.step = sensitivity::step(&store, index, i, design, high, criterion.horizon);
            detector.response = response::step(design, RESPONSE);
            detector.noise = sensitivity::noise(design, high, noise_horizon);
        }
        let level = |per_year: f64| (per_year, common_level(&tails, per_second(per_year)));
        let (level_of_all, told) = sequential(settings, &watch, per_year);
        let mut result = Tuning {
            machine: settings.machine.name.clone(),
            inputs: origin.inputs.clone(),
            timeline: origin.timeline.clone(),
            window: origin.window,
            sample_time,
            settle: settings.observer.settle,
            search,
            thresholds,
            detectors,
            sequential: level_of_all,
            ladder: LADDER.map(level).to_vec(),
            sigma: self.sigma,
            remarks: origin.remarks.clone(),
        };
        let limits = limits(&result, settings.comparator.critical);
        result.remarks.extend(limits.into_iter().chain(told));
        Ok(result)
    }

    fn criterion(&self) -> Criterion {
        let settings = self.settings;
        let sample_time = settings.machine.sample_time;
        Criterion {
            rate: per_second(self.per_year),
            sample_time,
            block: settings.warning_cycles(),
            horizon: ((IN_TIME / sample_time) as usize).max(1),
            sharp: (settings.cycles(settings.alarm.coincidence) as usize).max(1),
            settle: settings.cycles(settings.observer.settle),
        }
    }

    fn cylinder(&self, n: u8) -> CylinderModel {
        let settings = self.settings;
        let (theta, gamma) = settings.model_of(n);
        let signals = &settings.signals.cylinder;
        let first = !self.without.contains(&n);
        let second = first && settings.has_c2(n);
        CylinderModel {
            number: n,
            model: Model::new(settings.machine.sample_time, theta, gamma),
            command_offset: settings.command_offset_of(n),
            transducers: [first, second],
            velocities: [signals.c1_velocity.is_some(), second && signals.c2_velocity.is_some()],
            max_gap: settings.cycles(settings.machine.max_gap),
        }
    }

    fn search(
        &self,
        criterion: &Criterion,
        cylinders: &[CylinderModel],
        store: &Store,
    ) -> Result<Search, String> {
        let observer = &self.settings.observer;
        let begun = Weights { q: observer.q, r: observer.r };
        let little = || {
            format!(
                "no cylinder has enough data to judge: at least {:.0} s in monitored states with \
                 position and command are needed, not counting the times after longer gaps, in \
                which the observers settle",
                f64::from(criterion.block) * criterion.sample_time * LEAST_BLOCKS as f64
            )
        };
        if self.keep_weights {
            let score = criterion.score(cylinders, store, begun).ok_or_else(little)?;
            let cycles = store.cycles();
            return Ok(Search { weights: begun, score, begun, before: score, tried: 1, cycles });
        }
        search(criterion, cylinders, store, begun).ok_or_else(little)
    }

    fn thresholds(&self, detectors: &[Detector], tails: &[Tail]) -> Thresholds {
        let wanted = common_level(tails, per_second(self.per_year));
        let high = if wanted > 0.0 { wanted.max(LEAST_HIGH) } else { wanted };
        let calm = detectors.iter().map(|detector| detector.calm).fold(0.0, f64::max);
        Thresholds {
            high,
            low: calm.min(HYSTERESIS * high),
            joint: None,
            commands: None,
            per_year: self.per_year,
            hours: tails.iter().map(|tail| tail.seconds).fold(f64::INFINITY, f64::min) / 3600.0,
        }
    }
}

/// Tails of every detector, or the detector with too little data.
fn tails(detectors: &[Detector], block: u32, sample_time: f64) -> Result<Vec<Tail>, String> {
    let least = f64::from(block) * sample_time * LEAST_BLOCKS as f64;
    let tail = |detector: &Detector| {
        detector.tail.ok_or_else(|| {
            format!(
                "C{} of cylinder {} was judged for only {:.1} s, and at least {least:.0} s are \
                 needed: the recording is too short, its readings or commands are missing, or the \
                platform is \
                 in no monitored state",
                detector.transducer + 1,
                detector.cylinder,
                detector.residuals.count as f64 * sample_time
            )
        })
    };
    detectors.iter().map(tail).collect()
}
