//! One machine whose cylinders have one transducer left.

use super::cases::{LastGroup, Outage, STRETCH};
use super::outcome::{Heard, LastOutcome, LastQuiet, Pair, WATCH};
use crate::evaluate::stand::{Stand, StandError};
use crate::evaluate::tried::signed;
use crate::evaluate::truth::{Truth, WRONG};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use tertius_config::settings::Settings;
use tertius_core::alarm::Warning;
use tertius_core::estimate::Estimate;
use tertius_core::incident::Incident;
use tertius_core::monitor::{Estimates, Monitor, MonitorDesign, Sink};
use tertius_core::time::{Span, Timestamp};
use tertius_core::verdict::Suspect;
use tertius_machine::inject::{Fault, Placed, Wanted, Window, place};
use tertius_machine::plant::CYLINDERS;
use tertius_machine::simulator::{Options, Simulator};

/// Time before anything happens, s: the accuracy of the model has to be measured first.
const LEAD: f64 = 60.0;

/// Time until the earliest outage after that, and span within which the outages begin, s.
const READY: f64 = 0.5;
const SPREAD: f64 = 5.0;

/// Time from the outage to the earliest fault, and span within which the faults begin, s.
const APART: f64 = 10.0;
const FAULT_SPREAD: f64 = 1.0;

/// What is drawn of a cylinder. Times count from the end of [`LEAD`], s.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Leg {
    pair: Pair,
    outage: f64,
    at: f64,
    /// Signs of the outage and of the fault.
    signs: [f64; 2],
}

/// What is drawn of a machine.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Drawn {
    seed: u64,
    sea: [f64; 2],
    legs: Vec<Leg>,
}

impl Drawn {
    /// Draws machine `number` of `group`, of so many `cylinders`, in this `sea`.
    pub fn new(
        group: &LastGroup,
        number: u32,
        cylinders: u8,
        sea: [f64; 2],
        rng: &mut ChaCha8Rng,
    ) -> Self {
        let seed = rng.random();
        let legs = (1..=cylinders).map(|cylinder| {
            let outage = READY + SPREAD * rng.random::<f64>();
            let at = outage + APART + FAULT_SPREAD * rng.random::<f64>();
            let second = rng.random::<bool>() && !group.in_loop && !group.single;
            let pair = [Suspect::C1, Suspect::C2];
            let [last, other] = if second { [pair[1], pair[0]] } else { pair };
            let signs = [(); 2].map(|()| if rng.random::<bool>() { 1.0 } else { -1.0 });
            Leg { pair: Pair { cylinder, last, other }, outage, at, signs }
        });
        let mut legs: Vec<Leg> = legs.collect();
        legs.retain(|leg| {
            cylinders == 1 || (u32::from(leg.pair.cylinder) + number).is_multiple_of(2)
        });
        Self { seed, sea, legs }
    }
}

/// Hears the monitor.
#[derive(Clone)]
struct Listener {
    warnings: Vec<Warning>,
    incidents: Vec<Incident>,
    /// Cycles in which the estimate of a cylinder was valid and wrong.
    wrong: [Vec<Timestamp>; CYLINDERS],
    truth: Truth,
}

impl Sink for Listener {
    fn wants_records(&self) -> bool {
        false
    }

    fn warning(&mut self, warning: &Warning) {
        self.warnings.push(*warning);
    }

    fn incident(&mut self, incident: &Incident) {
        self.incidents.push(*incident);
    }

    fn estimate(&mut self, at: Timestamp, cylinder: u8, estimate: Option<&Estimate>) {
        let Some(estimate) = estimate.filter(|estimate| estimate.valid) else { return };
        let Some((opening, truth)) = self.truth.of(at, cylinder) else { return };
        if (estimate.position - truth).abs() > WRONG * estimate.sigma {
            self.wrong[usize::from(cylinder) - 1].push(opening);
        }
    }
}

/// A machine at work, and its monitor.
#[derive(Clone)]
struct Running {
    simulator: Simulator,
    monitor: Monitor,
    listener: Listener,
}

impl Running {
    fn step(&mut self) {
        let Self { simulator, monitor, listener } = self;
        listener.truth.note(simulator);
        simulator.step(&mut |frame| monitor.take(frame, listener));
    }
}

/// The machines of a group, with the configuration and the monitor that they have.
#[derive(Clone, Copy)]
pub(super) struct Machines<'a> {
    stand: &'a Stand<'a>,
    group: &'a LastGroup,
    settings: &'a Settings,
    design: &'a MonitorDesign,
}

impl<'a> Machines<'a> {
    /// Those of `group`; `single` is the configuration without C2, and its monitor.
    pub fn new(
        stand: &'a Stand<'a>,
        group: &'a LastGroup,
        single: Option<&'a (Settings, MonitorDesign)>,
    ) -> Result<Self, StandError> {
        let (settings, design) = if group.single {
            let single = single.map(|(settings, design)| (settings, design));
            single.ok_or_else(|| StandError::Untaught("no monitor without C2".to_owned()))?
        } else {
            (stand.settings, stand.design)
        };
        Ok(Self { stand, group, settings, design })
    }

    /// Plays the machine of `drawn` with every outage of the group, each with every one of `faults`.
    pub fn left_with(
        &self,
        faults: &[Option<Wanted>],
        drawn: &Drawn,
    ) -> Result<Vec<Vec<LastOutcome>>, StandError> {
        let ready = self.ready(drawn)?;
        let each =
            self.group.outages().iter().flat_map(|it| faults.iter().map(move |fault| (it, fault)));
        each.map(|(outage, wanted)| self.struck(&ready, drawn, (*outage, *wanted))).collect()
    }

    /// Plays the machine of `drawn` with that `outage` and no other fault.
    pub fn left_alone(&self, outage: Outage, drawn: &Drawn) -> Result<LastQuiet, StandError> {
        let mut running = self.ready(drawn)?;
        let begun = running.simulator.opening();
        let outages = self.placed_outages(outage, drawn)?;
        running.simulator.afflict(&outages, drawn.seed);
        for _ in 0..self.stand.cycles(STRETCH - LEAD) {
            running.step();
        }
        running.monitor.finish(&mut running.listener);
        let mut quiet = LastQuiet::default();
        for leg in &drawn.legs {
            let from = begun.after(Span::from_seconds(leg.outage));
            quiet.count(&running.listener.warnings, leg.pair, from);
            quiet.cycles += self.stand.cycles(STRETCH - LEAD - leg.outage);
        }
        Ok(quiet)
    }

    /// The machine of `drawn`, at work for [`LEAD`].
    fn ready(&self, drawn: &Drawn) -> Result<Running, StandError> {
        let Self { stand, group, settings, design } = *self;
        let (sea, in_loop) = (Some(drawn.sea), group.in_loop);
        let options = Options { seed: drawn.seed, sea, in_loop, ..Options::default() };
        let tables = stand.tables_of(group.grade);
        let simulator = Simulator::new(tables, settings, stand.database, &options)?;
        let design = MonitorDesign { estimates: Estimates::Computed, ..design.clone() };
        let listener = Listener {
            warnings: Vec::new(),
            incidents: Vec::new(),
            wrong: Default::default(),
            truth: Truth::new(&simulator, settings.machine.sample_time),
        };
        let mut running = Running { simulator, monitor: Monitor::new(design), listener };
        for _ in 0..self.stand.cycles(LEAD) {
            running.step();
        }
        Ok(running)
    }

    fn placed_outages(&self, outage: Outage, drawn: &Drawn) -> Result<Vec<Placed>, StandError> {
        let Some(shape) = outage.shape() else { return Ok(Vec::new()) };
        let wanted = |leg: &Leg| signed(Wanted::Shape(shape), leg.signs[0]);
        let place = |leg| self.placed_at(leg, leg.pair.other, (wanted(leg), leg.outage));
        drawn.legs.iter().map(place).collect()
    }

    fn placed_at(
        &self,
        leg: &Leg,
        transducer: Suspect,
        (wanted, at): (Wanted, f64),
    ) -> Result<Placed, StandError> {
        let window = Window { from: Span::from_seconds(at), until: None };
        let fault =
            Fault { cylinder: leg.pair.cylinder, sensor: transducer.name(), wanted, window };
        Ok(place(&fault, self.settings, self.stand.database)?)
    }

    /// Lets the machine that is `ready` have that outage and that fault.
    fn struck(
        &self,
        ready: &Running,
        drawn: &Drawn,
        (outage, wanted): (Outage, Option<Wanted>),
    ) -> Result<Vec<LastOutcome>, StandError> {
        let mut running = ready.clone();
        let mut faults = self.placed_outages(outage, drawn)?;
        let first = faults.len();
        if let Some(wanted) = wanted {
            for leg in &drawn.legs {
                let wanted = (signed(wanted, leg.signs[1]), leg.at);
                faults.push(self.placed_at(leg, leg.pair.last, wanted)?);
            }
        }
        running.simulator.afflict(&faults, drawn.seed);
        let begun = running.simulator.opening();
        let asked = |leg: &Leg| begun.after(Span::from_seconds(leg.at));
        // The Sync at which the first faulty reading was sampled.
        let mut onsets: Vec<Option<Timestamp>> = vec![None; drawn.legs.len()];
        let latest = drawn.legs.iter().map(|leg| leg.at).fold(0.0, f64::max);
        for _ in 0..self.stand.cycles(latest + WATCH + 1.0) {
            let opening = running.simulator.opening();
            running.step();
            let tallies = running.simulator.tallies().iter().skip(first);
            for (onset, tally) in onsets.iter_mut().zip(tallies) {
                if tally.altered > 0 {
                    onset.get_or_insert(opening);
                }
            }
        }
        running.monitor.finish(&mut running.listener);
        let sample_time = self.settings.machine.sample_time;
        let outcome = |(leg, onset): (&Leg, Option<Timestamp>)| {
            let Listener { warnings, incidents, wrong, .. } = &running.listener;
            let wrong = &wrong[usize::from(leg.pair.cylinder) - 1];
            let heard = Heard { warnings, incidents, wrong };
            LastOutcome::read(heard, leg.pair, onset.unwrap_or(asked(leg)), sample_time)
        };
        Ok(drawn.legs.iter().zip(onsets).map(outcome).collect())
    }
}
