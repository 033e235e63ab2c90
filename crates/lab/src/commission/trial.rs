//! The monitor on blocks that its tables do not know, first healthy and then with faults put into
//! them.
//!
//! One monitor reads the whole recording, so that it is warm where a block begins. Where a fault
//! begins the monitor is copied. The copy continues with the fault and the original without it, so
//! faults do not disturb each other and nothing has to recover from one.

use super::faults::{self, FaultKind, Planned};
use super::holding::Blocks;
use super::task::Task;
use super::taught::Taught;
use crate::evaluate::{Blame, Outcome};
use crate::flaws::listed;
use tertius_config as config;
use tertius_config::design;
use tertius_core::alarm::{Detector, State, Warning};
use tertius_core::frame::Frame;
use tertius_core::monitor::{Monitor, Record, Sink};
use tertius_core::time::{Span, Timestamp};
use tertius_core::verdict::{Fault, Verdict};
use tertius_learn::calibrate::Cuts;
use tertius_learn::survey::{Frames, Timeline};
use tertius_machine::inject::{Injector, place};

/// Detectors that find a fault in a reading that looks plausible.
pub const DETECTORS: [Detector; Detector::BY_CHANCE.len()] = Detector::BY_CHANCE;

/// A warning on a machine that is taken for healthy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FalseAlarm {
    /// Time since the first frame, s.
    pub t: f64,
    /// Cylinder number, counted from 1.
    pub cylinder: u8,
    pub detector: Detector,
    pub fault: Fault,
    /// Whether it was raised before the block that is held back, and stands there.
    pub stands: bool,
}

impl FalseAlarm {
    /// Whether a reading counts as frozen, which of all plausibility checks alone depends on how the machine is driven.
    pub fn is_frozen(&self) -> bool {
        self.detector == Detector::Plausibility && self.fault == Fault::Frozen
    }
}

/// Time for which a warning stands in blocks that are held back, s, from which on it counts there, wherever it was raised: a
/// fault that begins in a block of the lesson does not end with it.
const LASTING: f64 = 10.0;

/// What became of the faults of one kind.
#[derive(Clone, Debug, PartialEq)]
pub struct KindResult {
    pub kind: FaultKind,
    /// Faults that were begun: nothing was wrong at that place before.
    pub tried: usize,
    /// Faults that could not be placed, because the sequential detector knew nothing there or a
    /// warning stood.
    pub unplaced: usize,
    /// Delays of the faults that were found, from the first frame with the fault to the first
    /// warning, s, ascending.
    pub delays: Vec<f64>,
    pub right: usize,
    pub undecided: usize,
    pub wrong: usize,
}

impl KindResult {
    /// Median delay, s; `None` where fewer than half were found.
    pub fn median(&self) -> Option<f64> {
        self.delays.get(self.tried.saturating_sub(1) / 2).copied()
    }
}

/// Result of a trial.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Time that was held back, s.
    pub held: f64,
    pub false_alarms: Vec<FalseAlarm>,
    /// Those of the process detectors, which are left out instead.
    pub of_process: Vec<FalseAlarm>,
    /// Time since the first frame at which the supply first fell short, s.
    pub of_supply: Option<f64>,
    /// For each cylinder with a sequential detector, the part of the time held back in which it
    /// judged.
    pub known: Vec<(u8, f64)>,
    pub kinds: Vec<KindResult>,
}

/// Inputs of a trial.
#[derive(Clone, Copy, Debug)]
pub(super) struct Course<'a> {
    pub task: &'a Task<'a>,
    pub rehearsal: &'a Taught,
    pub blocks: &'a Blocks,
    /// Cylinders that commissioning from the whole recording refuses.
    pub refused: &'a [u8],
    pub cuts: &'a Cuts,
}

/// Collects the warnings and notes which cylinders had a cycle.
#[derive(Clone, Debug, Default)]
struct Heard {
    warnings: Vec<Warning>,
    recorded: Vec<(u8, Timestamp)>,
}

impl Sink for Heard {
    fn warning(&mut self, warning: &Warning) {
        self.warnings.push(*warning);
    }

    fn record(&mut self, record: &Record) {
        self.recorded.push((record.cylinder, record.timestamp));
    }
}

/// A fault at work in its own copy of the monitor.
struct Attempt {
    planned: Planned,
    monitor: Monitor,
    injector: Injector,
    heard: Vec<Warning>,
    /// Time of the first frame with the fault.
    onset: Option<Timestamp>,
    begun: Timestamp,
}

impl Course<'_> {
    /// Runs the trial in one pass over `frames`; `None` where no monitor can be made from the
    /// tables.
    ///
    /// # Errors
    /// The frames' own.
    pub fn run<F: Frames>(&self, frames: &F) -> Result<Option<Trial>, F::Error> {
        let Some(mut trying) = self.begin() else { return Ok(None) };
        frames.frames(self.task.origin.window, |frame| trying.take(frame))?;
        Ok(Some(trying.finish()))
    }

    fn begin(&self) -> Option<Trying<'_>> {
        let Task { name, database, origin, .. } = *self.task;
        let (settings, _) = config::parse(name, &self.rehearsal.text).ok()?;
        let design = design::judging(&settings, database);
        debug_assert!(design.is_ok(), "{}", listed(&design.clone().err().unwrap_or_default()));
        let refused = self.rehearsal.refused_cylinders();
        let sound = |n: &u8| !refused.contains(n) && !self.refused.contains(n);
        let cylinders: Vec<u8> = (1..=settings.machine.cylinders).filter(sound).collect();
        let planned = faults::plan(self.blocks, &cylinders, |n| settings.has_c2(n));
        let injectors = planned.iter().map(|one| {
            let placed = place(&one.fault(), &settings, database).ok()?;
            Some((*one, Injector::new(&[placed], one.number as u64)))
        });
        let mut waiting: Vec<(Planned, Injector)> = injectors.flatten().collect();
        waiting.reverse();
        let monitor = Monitor::new(design.ok()?);
        let own = monitor.sequential().map(|(number, _)| (number, [0, 0]));
        let known = own.filter(|(number, _)| cylinders.contains(number)).collect();
        Some(Trying {
            course: self,
            first: origin.timeline.first(),
            newest: origin.timeline.first(),
            cylinders,
            monitor,
            heard: Heard::default(),
            known,
            of_supply: None,
            waiting,
            attempts: Vec::new(),
            entries: Vec::new(),
        })
    }
}

/// A trial in progress.
struct Trying<'a> {
    course: &'a Course<'a>,
    first: Timestamp,
    /// Time of the latest frame.
    newest: Timestamp,
    /// Cylinders that are tried.
    cylinders: Vec<u8>,
    monitor: Monitor,
    heard: Heard,
    /// For each cylinder with a sequential detector: cycles in which it judged, and all cycles.
    known: Vec<(u8, [u64; 2])>,
    of_supply: Option<f64>,
    /// Faults still to begin, the next one last.
    waiting: Vec<(Planned, Injector)>,
    attempts: Vec<Attempt>,
    /// Outcomes of the faults that have ended; `None` for those that could not be placed.
    entries: Vec<(FaultKind, Option<Outcome>)>,
}

impl Trying<'_> {
    fn take(&mut self, frame: &Frame) {
        let t = frame.timestamp.since(self.first).as_seconds();
        self.start(t, frame.timestamp);
        if Timeline::is_pause(frame.timestamp.since(self.newest)) {
            self.monitor.interrupt(frame.timestamp, &mut self.heard);
        }
        self.newest = self.newest.max(frame.timestamp);
        self.monitor.take(frame, &mut self.heard);
        self.judge();
        for attempt in &mut self.attempts {
            attempt.take(frame);
        }
        let ended = |attempt: &mut Attempt| attempt.ended(frame.timestamp);
        for attempt in self.attempts.extract_if(.., ended) {
            self.entries.push((attempt.planned.kind, Some(attempt.finish())));
        }
    }

    /// Begins the faults that are due at `t`, s, where they can be placed.
    fn start(&mut self, t: f64, now: Timestamp) {
        if self.waiting.last().is_none_or(|(planned, _)| planned.begin[0] > t) {
            return;
        }
        let due = self.waiting.partition_point(|(planned, _)| planned.begin[0] > t);
        for (planned, injector) in self.waiting.split_off(due) {
            let [_, latest] = planned.begin;
            if self.has_place(planned.cylinder, t) {
                let (monitor, heard) = (self.monitor.clone(), Vec::new());
                let attempt =
                    Attempt { planned, monitor, injector, heard, onset: None, begun: now };
                self.attempts.push(attempt);
            } else if t < latest {
                // A little later.
                let begin = [t + 1.0, latest];
                self.waiting.push((Planned { begin, ..planned }, injector));
            } else {
                self.entries.push((planned.kind, None));
            }
        }
        self.waiting.sort_by(|(one, _), (other, _)| other.begin[0].total_cmp(&one.begin[0]));
    }

    /// Whether a fault can be placed: nothing is wrong with the cylinder, and its sequential
    /// detector, if any, judges.
    fn has_place(&self, cylinder: u8, t: f64) -> bool {
        let judges = |number: u8| {
            let mut detectors = self.monitor.sequential();
            let own = detectors.find(|(known, _)| *known == number);
            own.is_none_or(|(_, detector)| detector.verdict() == Verdict::Healthy)
        };
        let newest = |detector: Detector| {
            let mut warnings = self.heard.warnings.iter().rev();
            warnings.find(|it| it.cylinder == cylinder && it.detector == detector)
        };
        let standing = Detector::ALL
            .into_iter()
            .any(|detector| newest(detector).is_some_and(|it| it.state != State::Cleared));
        !standing && judges(cylinder) && !self.course.cuts.hold(cylinder, t)
    }

    /// Counts which detectors judged in the cycles that have come.
    fn judge(&mut self) {
        for (cylinder, at) in self.heard.recorded.drain(..) {
            let t = at.since(self.first).as_seconds();
            if !self.course.blocks.hold(t) {
                continue;
            }
            if self.monitor.supply().is_some_and(|it| it.alarm().is_some()) {
                self.of_supply = self.of_supply.or(Some(t));
            }
            let detector = self.monitor.sequential().find(|(number, _)| *number == cylinder);
            let own = self.known.iter_mut().find(|(number, _)| *number == cylinder);
            if let Some(((_, detector), (_, [judged, all]))) = detector.zip(own) {
                *all += 1;
                *judged += u64::from(detector.verdict() != Verdict::Unknown);
            }
        }
    }

    fn finish(mut self) -> Trial {
        let attempts = std::mem::take(&mut self.attempts).into_iter();
        let ended = attempts.map(|attempt| (attempt.planned.kind, Some(attempt.finish())));
        let unplaced = self.waiting.iter().map(|(planned, _)| (planned.kind, None));
        let entries: Vec<_> = self.entries.iter().cloned().chain(ended).chain(unplaced).collect();
        let part = |[judged, all]: [u64; 2]| judged as f64 / all.max(1) as f64;
        let (of_process, false_alarms) =
            self.false_alarms().into_iter().partition(|it| it.detector == Detector::Process);
        Trial {
            held: self.course.blocks.spans().iter().map(|[from, to]| to - from).sum(),
            false_alarms,
            of_process,
            of_supply: self.of_supply,
            known: self.known.iter().map(|(number, known)| (*number, part(*known))).collect(),
            kinds: faults::KINDS.map(|kind| result(kind, &entries)).to_vec(),
        }
    }

    fn false_alarms(&self) -> Vec<FalseAlarm> {
        let counts = |it: &FalseAlarm| {
            (DETECTORS.contains(&it.detector) || it.is_frozen())
                && self.cylinders.contains(&it.cylinder)
                && !self.course.cuts.hold(it.cylinder, it.t)
        };
        let seconds = |at: Timestamp| at.since(self.first).as_seconds();
        let alarms =
            alarms_in(self.course.blocks, &self.heard.warnings, seconds(self.newest), seconds);
        alarms.into_iter().filter(counts).collect()
    }
}

/// The warnings that are raised in the `blocks`, or stand there for long; `seconds` gives the time of the trial, which ends at
/// `end`, s.
fn alarms_in(
    blocks: &Blocks,
    warnings: &[Warning],
    end: f64,
    seconds: impl Fn(Timestamp) -> f64,
) -> Vec<FalseAlarm> {
    let spans = blocks.spans();
    let alarm = |(i, warning): (usize, &Warning)| {
        let Warning { cylinder, detector, place, .. } = *warning;
        let is_its = |it: &&Warning| {
            it.state == State::Cleared && (it.cylinder, it.place) == (cylinder, place)
        };
        let t = seconds(warning.timestamp);
        let until = warnings[i..].iter().find(is_its).map_or(end, |it| seconds(it.timestamp));
        let stands_in = spans.iter().map(|[from, to]| (from.max(t), to.min(until)));
        let stands_in = stands_in.filter(|(from, to)| to > from);
        let alarm =
            FalseAlarm { t, cylinder, detector, fault: warning.finding.fault, stands: false };
        if blocks.hold(t) {
            return Some(alarm);
        }
        let (first, _) = stands_in.clone().next()?;
        let lasts: f64 = stands_in.map(|(from, to)| to - from).sum();
        (lasts >= LASTING).then_some(FalseAlarm { t: first, stands: true, ..alarm })
    };
    let all = warnings.iter().enumerate();
    all.filter(|(_, it)| it.state == State::Raised).filter_map(alarm).collect()
}

fn result(kind: FaultKind, entries: &[(FaultKind, Option<Outcome>)]) -> KindResult {
    let own: Vec<_> = entries.iter().filter(|(of, _)| *of == kind).map(|(_, it)| it).collect();
    let outcomes: Vec<&Outcome> = own.iter().filter_map(|it| it.as_ref()).collect();
    let delay = |outcome: &Outcome| {
        let delays = DETECTORS.map(|detector| outcome.delays[detector as usize - 1]);
        delays.into_iter().flatten().reduce(f64::min)
    };
    let mut delays: Vec<f64> = outcomes.iter().filter_map(|it| delay(it)).collect();
    delays.sort_unstable_by(f64::total_cmp);
    let found = |it: &&&Outcome| delay(it).is_some();
    let blamed = |blame: fn(&Blame) -> bool| {
        let own = outcomes.iter().filter(found).filter(|it| it.blame.as_ref().is_some_and(blame));
        own.count()
    };
    KindResult {
        kind,
        tried: outcomes.len(),
        unplaced: own.len() - outcomes.len(),
        right: blamed(|blame| *blame == Blame::Right),
        undecided: blamed(|blame| matches!(blame, Blame::Undecided | Blame::Process)),
        wrong: blamed(|blame| *blame == Blame::Wrong),
        delays,
    }
}

impl Attempt {
    fn take(&mut self, frame: &Frame) {
        let Some(passed) = self.injector.take(frame) else { return };
        self.monitor.take(passed, &mut self.heard);
        if self.onset.is_none() && self.injector.tallies()[0].altered > 0 {
            self.onset = Some(frame.timestamp);
        }
    }

    fn end(&self) -> Timestamp {
        self.onset.unwrap_or(self.begun).after(Span::from_seconds(self.planned.watch))
    }

    fn ended(&self, now: Timestamp) -> bool {
        now > self.end()
    }

    fn finish(self) -> Outcome {
        let onset = self.onset.unwrap_or(self.begun);
        let Planned { cylinder, transducer, .. } = self.planned;
        let end = self.end();
        Outcome::read(&self.heard, cylinder, transducer, onset, end)
    }
}
