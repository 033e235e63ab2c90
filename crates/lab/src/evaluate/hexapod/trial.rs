//! One machine with a sensor on its deck: a transducer drifts, or nothing is wrong.

use super::cases::{DeckWitness, STRETCH};
use crate::evaluate::grade::Grade;
use crate::evaluate::machines::varied;
use crate::evaluate::side::cases::{IN_TIME, SideCase};
use crate::evaluate::stand::{Stand, StandError};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tertius_config::settings::bus_of;
use tertius_core::alarm::{Detector, State, Warning};
use tertius_core::blame::Rule;
use tertius_core::decode::{Inserted, SignalPlan};
use tertius_core::frame::{BusNumber, Frame, Id};
use tertius_core::hexapod::LEGS;
use tertius_core::monitor::{Monitor, MonitorDesign};
use tertius_core::time::{Span, Timestamp};
use tertius_core::verdict::Suspect;
use tertius_machine::inject::{Fault, Placed, Shape, Wanted, Window, place};
use tertius_machine::simulator::{Change, EPOCH, Options, Simulator};

/// Time before the earliest drift, s: minutes at work, and within which they all begin.
const LEAD: f64 = 180.0;
const SPREAD: f64 = 10.0;

/// Largest noise of a deck that is taken to stand level, rad, so that it is not taken for a frozen sensor.
const PRESUMED_NOISE: f64 = 1.75e-4;

/// What was said of one drift.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HexapodOutcome {
    /// How far it had drifted when it was first found, and when the deck's attitude first named the right transducer, m.
    pub found: Option<f64>,
    pub named: Option<f64>,
    /// Whether the deck's attitude ever named another transducer, of this cylinder or of any.
    pub wrong: bool,
    /// Whether any other detector named the right one before, or the wrong one at any time.
    pub others: [bool; 2],
    /// Whether the cylinder had a warning when it began.
    pub spoilt: bool,
}

/// What was said of a healthy machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HexapodQuiet {
    /// Warnings of the sequential detectors, and of the deck's attitude.
    pub raises: [u64; 2],
}

/// The deck, taken to stand level by whoever has no sensor on it.
struct Presumed {
    place: (BusNumber, Id),
    plans: [SignalPlan; 2],
    rng: ChaCha8Rng,
}

impl Presumed {
    fn new(stand: &Stand, seed: u64) -> Option<Self> {
        let signals = &stand.settings.signals;
        let find = |name: &Option<String>| {
            let (bus, name) = bus_of(name.as_deref()?)?;
            let (message, signal) = stand.database.signal(name).ok()?;
            Some(((bus, message.id), signal.plan.clone()))
        };
        let ((place, roll), (_, pitch)) = find(&signals.top_roll).zip(find(&signals.top_pitch))?;
        Some(Self { place, plans: [roll, pitch], rng: ChaCha8Rng::seed_from_u64(seed) })
    }

    fn replace(&mut self, frame: &Frame) -> Frame {
        let mut frame = frame.clone();
        if (frame.bus, frame.id) == self.place {
            for plan in &self.plans {
                let noise = self.rng.random_range(-PRESUMED_NOISE..PRESUMED_NOISE);
                let _: Inserted = plan.insert_physical(noise, frame.buffer_mut());
            }
        }
        frame
    }
}

impl Stand<'_> {
    /// The machine with transducers of `grade` that do not fluctuate, and with a sensor on its deck of this `witness`.
    fn decked(
        &self,
        grade: Grade,
        witness: DeckWitness,
        changed: Option<(Change, f64)>,
        options: &Options,
    ) -> Result<Simulator, StandError> {
        let mut tables = self.steady_tables_of(grade).clone();
        if let DeckWitness::Sensor(accuracy) = witness {
            let top = &mut tables.sensors.top;
            (top.noise, top.wander) = (accuracy, accuracy);
            top.wander_time = if top.wander_time > 0.0 { top.wander_time } else { 60.0 };
        }
        self.simulate_changed(tables, None, changed, options)
    }

    /// Plays a machine on which one transducer of one cylinder drifts in the loop.
    pub(super) fn tilting(
        &self,
        (grade, witness): (Grade, DeckWitness),
        design: &MonitorDesign,
        sea: [f64; 2],
        case: &SideCase,
        number: u32,
        rng: &mut ChaCha8Rng,
    ) -> Result<HexapodOutcome, StandError> {
        let seed: u64 = rng.random();
        let at = LEAD + SPREAD * rng.random::<f64>();
        let rate = if rng.random::<bool>() { case.rate } else { -case.rate };
        let cylinder = (number % u32::from(self.settings.machine.cylinders)) as u8 + 1;
        let window = Window { from: Span::from_seconds(at), until: None };
        let wanted = Wanted::Shape(Shape::Drift { rate });
        let fault = Fault { cylinder, sensor: case.transducer.name(), wanted, window };
        let faults: Vec<Placed> = vec![place(&fault, self.settings, self.database)?];
        let options = Options { seed, sea: Some(sea), faults, in_loop: true, ..Options::default() };
        let mut simulator = self.decked(grade, witness, None, &options)?;
        let mut presumed = match witness {
            DeckWitness::VesselAlone => Presumed::new(self, seed),
            DeckWitness::Sensor(_) => None,
        };
        let seconds = at + IN_TIME / case.rate;
        let warnings = self.told(&mut simulator, design, presumed.as_mut(), seconds);
        Ok(outcome(case, &warnings, cylinder, at))
    }

    /// Plays a healthy machine with another load and friction.
    pub(super) fn level(
        &self,
        (grade, witness): (Grade, DeckWitness),
        design: &MonitorDesign,
        sea: [f64; 2],
        rng: &mut ChaCha8Rng,
    ) -> Result<HexapodQuiet, StandError> {
        let options = Options { seed: rng.random(), sea: Some(sea), ..Options::default() };
        let mut simulator = self.decked(grade, witness, Some(varied(rng)), &options)?;
        let warnings = self.told(&mut simulator, design, None, STRETCH);
        let sequential = || warnings.iter().filter(|it| it.detector == Detector::Sequential);
        let raised = sequential().filter(|it| it.state == State::Raised).count() as u64;
        let mut is_named = [false; LEGS];
        let mut named = 0;
        for warning in sequential() {
            let by_deck = warning.state != State::Cleared && is_by_deck(warning);
            let before = &mut is_named[usize::from(warning.cylinder) - 1];
            named += u64::from(by_deck && !*before);
            *before = by_deck;
        }
        Ok(HexapodQuiet { raises: [raised, named] })
    }

    fn told(
        &self,
        simulator: &mut Simulator,
        design: &MonitorDesign,
        mut presumed: Option<&mut Presumed>,
        seconds: f64,
    ) -> Vec<Warning> {
        let mut monitor = Monitor::new(design.clone());
        let mut warnings: Vec<Warning> = Vec::new();
        for _ in 0..self.cycles(seconds) {
            simulator.step(&mut |frame| match &mut presumed {
                Some(presumed) => monitor.take(&presumed.replace(frame), &mut warnings),
                None => monitor.take(frame, &mut warnings),
            });
        }
        monitor.finish(&mut warnings);
        warnings
    }
}

/// Whether the deck's attitude has named the suspect.
fn is_by_deck(warning: &Warning) -> bool {
    warning.finding.rule == Rule::DeckAttitude
}

/// What `warnings` say of the drift of `cylinder` that began `at` seconds after the first frame.
fn outcome(case: &SideCase, warnings: &[Warning], cylinder: u8, at: f64) -> HexapodOutcome {
    let onset: Timestamp = EPOCH.after(Span::from_seconds(at));
    let drifted = |it: &Warning| case.rate * it.timestamp.since(onset).as_seconds();
    let innocent = if case.transducer == Suspect::C1 { Suspect::C2 } else { Suspect::C1 };
    let said = || warnings.iter().filter(|it| it.timestamp >= onset && it.state != State::Cleared);
    let own = || said().filter(|it| it.cylinder == cylinder);
    let by_deck = |it: &&Warning| is_by_deck(it);
    let blames = |suspect| move |it: &&Warning| it.finding.suspect == suspect;
    let named = own().filter(by_deck).find(blames(case.transducer));
    let is_other = |it: &&Warning| match it.finding.suspect {
        Suspect::C1 | Suspect::C2 => {
            it.cylinder != cylinder || it.finding.suspect != case.transducer
        }
        Suspect::Undecided | Suspect::Process => false,
    };
    let of_others =
        || own().filter(|it| matches!(it.detector, Detector::Sequential | Detector::Fde3));
    let before = |it: &&Warning| named.is_none_or(|named| it.timestamp < named.timestamp);
    let standing = warnings.iter().filter(|it| it.cylinder == cylinder && it.timestamp < onset);
    let standing = standing.fold(0_i32, |standing, it| match it.state {
        State::Raised => standing + 1,
        State::Changed => standing,
        State::Cleared => standing - 1,
    });
    HexapodOutcome {
        found: own().next().map(drifted),
        named: named.map(drifted),
        wrong: said().filter(by_deck).any(|it| is_other(&it)),
        others: [
            of_others().filter(before).any(|it| blames(case.transducer)(&it)),
            of_others().any(|it| blames(innocent)(&it)),
        ],
        spoilt: standing > 0,
    }
}
