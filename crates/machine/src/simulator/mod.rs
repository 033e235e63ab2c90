//! A whole machine in software: sea, hexapod, controller, plant and transducers, on a bus.
//!
//! ```text
//! sea ─ vessel ─→ controller ─ spools ─→ plant ─ lengths ─→ transducers ─→ frames ─→ faults ─→
//!                     ↑────────────────── C1 ───────────────────┘ (with faults: in the loop)
//! ```
//!
//! The controller can be told to take C2, or a length that another node tells, for single cylinders
//! ([`Simulator::measure`]), and can supervise the difference of C1 and C2 ([`Simulator::supervise`]).
//!
//! A fault of a transducer is added to its length before it is rounded to counts.
//!
//! [`Simulator::step`] makes the frames of one cycle and passes them to a sink, in the order of the
//! bus. It is pure and allocates nothing: time is counted in cycles and randomness comes from the
//! seed, so that the same seed gives the same bytes. The simulator uses the program's configuration
//! and DBC readers, but nothing of the monitor.

mod ailing;
mod arrivals;
mod beside;
mod check;
mod disturbance;
mod layout;
mod load_steps;
mod machine;
mod options;
mod parsing;
mod services;
mod tables;
mod top;
mod trail;
pub mod truth;
mod values;

pub use beside::SignalTable;
pub use disturbance::{Change, Disturbance, Misread, Sampling, Spikes, Sticking};
pub use layout::LayoutError;
pub use load_steps::LoadSteps;
pub use machine::{Machine, MachineError, Sample};
pub use options::{EPOCH, Options, SUB_STEPS};
pub use tables::{Gangway, SeaTable, SensorTable, TableError, Tables, Thermal};
pub use top::TopTable;

use crate::controller::{Heard, Measurement, Readings, State, Supervision};
use crate::inject::{Injector, Placed, Tally};
use crate::plant::CYLINDERS;
use arrivals::Arrivals;
use layout::{Layout, SendPhase};
use services::Services;
use tertius_config::settings::{Role, Settings};
use tertius_core::decode::SignalPlan;
use tertius_core::frame::Frame;
use tertius_core::time::{Span, Timestamp};
use tertius_dbc::Database;

/// Times between the readings of the transducers of `settings` that send by timers of their own, s.
fn timers(settings: &Settings, database: &Database) -> [[f64; 2]; CYLINDERS] {
    let mut timers = [[0.0; 2]; CYLINDERS];
    for device in settings.devices() {
        let services = database.device_services(&device.name());
        let timer = device.event_timer.or(services.and_then(|services| services.event_timer));
        let which = device.role.map(|role| usize::from(role == Role::C2));
        let place = timers.get_mut(usize::from(device.cylinder).wrapping_sub(1));
        if let (Some(place), Some(which), Some(timer)) = (place, which, timer) {
            place[which] = timer;
        }
    }
    timers
}

/// Why a simulation cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimulatorError {
    #[error(transparent)]
    Layout(#[from] LayoutError),
    #[error(transparent)]
    Machine(#[from] MachineError),
}

/// A simulated machine that sends frames.
#[derive(Clone, Debug)]
pub struct Simulator {
    machine: Machine,
    layout: Layout,
    arrivals: Arrivals,
    services: Services,
    injector: Injector,
    in_loop: bool,
    /// What the controller has heard; lengths that did not arrive are those of the previous cycle.
    heard: Heard,
    measurements: [Measurement; CYLINDERS],
    supervision: Option<Supervision>,
    readings: Readings,
    cycle: u64,
    epoch: Timestamp,
    sample_time: Span,
}

impl Simulator {
    /// A machine of `tables` that sends the frames which `settings` and `database` describe.
    ///
    /// # Errors
    /// The machine of `settings` cannot be simulated, or the sea is too rough for it.
    pub fn new(
        tables: &Tables,
        settings: &Settings,
        database: &Database,
        options: &Options,
    ) -> Result<Self, SimulatorError> {
        let scales = (tables.transducer.grid(), tables.sensors.spool_full);
        let mut layout = Layout::new(settings, database, &tables.signals, scales)?;
        let timers = timers(settings, database);
        layout.send_early(&timers);
        let sample_time = settings.machine.sample_time;
        let machine = Machine::new(tables, sample_time, options)?.with_timers(timers);
        Ok(Self {
            machine: if layout::has_top(settings) { machine.with_top(options) } else { machine },
            arrivals: Arrivals::new(settings.bus.bitrate, tables.controller.latency, options.seed),
            layout,
            services: Services::new(settings, database, &options.faults, options.epoch),
            injector: Injector::new(&options.faults, options.seed),
            in_loop: options.in_loop,
            heard: Heard::default(),
            measurements: [Measurement::C1; CYLINDERS],
            supervision: None,
            readings: Readings::default(),
            cycle: 0,
            epoch: options.epoch,
            sample_time: Span::from_seconds(sample_time),
        })
    }

    /// Requests `state`; the platform passes through those in between.
    pub fn request(&mut self, state: State) {
        self.machine.request(state);
    }

    /// Lets the controller take `measurement` for the length of the cylinder `leg`, from 0, from the next cycle on.
    pub fn measure(&mut self, leg: usize, measurement: Measurement) {
        self.measurements[leg] = measurement;
    }

    /// Lengths that another node tells of the newest cycle, m.
    pub fn tell(&mut self, lengths: [Option<f64>; CYLINDERS]) {
        self.heard.told = lengths;
    }

    /// Lets the machine supervise its transducers: a code black releases the valves, and stays.
    pub fn supervise(&mut self, supervision: Supervision) {
        self.supervision = Some(supervision);
    }

    /// The machine's supervision of its transducers, if there is one.
    pub fn supervision(&mut self) -> Option<&mut Supervision> {
        self.supervision.as_mut()
    }

    /// Whether a code black stands.
    pub fn is_black(&self) -> bool {
        self.supervision.as_ref().is_some_and(Supervision::has_tripped)
    }

    /// Replaces the faults of readings, except those of devices' services, from the next cycle on; their times count
    /// from there.
    pub fn afflict(&mut self, faults: &[Placed], seed: u64) {
        self.injector = Injector::new(faults, seed);
    }

    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// Readings of the controller in the newest cycle.
    pub fn readings(&self) -> &Readings {
        &self.readings
    }

    /// What the controller has heard up to the newest cycle.
    pub fn heard(&self) -> &Heard {
        &self.heard
    }

    /// Opening of the next cycle, without the jitter of its Sync.
    pub fn opening(&self) -> Timestamp {
        let nanos = self.sample_time.as_nanos().saturating_mul(self.cycle as i64);
        self.epoch.after(Span::from_nanos(nanos))
    }

    /// Tallies of all faults so far, in the order in which the faults were given.
    pub fn tallies(&self) -> &[Tally] {
        self.injector.tallies()
    }

    /// Makes the frames of one cycle, passes them to `sink` in the order of the bus, and advances
    /// the machine to the next cycle. Of transducers that send by timers of their own these are the newest
    /// frames before the Sync.
    pub fn step(&mut self, sink: &mut impl FnMut(&Frame)) {
        let sample = self.machine.sample();
        self.layout.values.sampled(&sample, self.machine.state(), self.cycle);
        self.readings.pressures = sample.load_pressures;
        self.readings.pose = sample.motion.pose;
        self.readings.rate = sample.motion.rate;
        self.hear_by_wire(&sample);
        self.send_early(&sample, sink);
        self.arrivals.open(self.opening());
        self.send(SendPhase::Sampled, sink);
        let Self { heard, measurements, readings, supervision, .. } = self;
        heard.measure(measurements, self.sample_time.as_seconds(), readings);
        if supervision.as_mut().is_some_and(|it| it.step(&heard.lengths)) {
            self.machine.request(State::Safe);
        }
        let commands = self.machine.command(&self.readings);
        self.layout.values.commanded(&commands);
        self.arrivals.answer();
        self.send(SendPhase::Commanded, sink);
        let end = self.opening().after(self.sample_time);
        self.services.send(end, &mut self.arrivals, &mut self.injector, sink);
        self.machine.advance();
        self.cycle += 1;
    }

    /// The readings that are not on the bus: speeds that it does not carry, and cylinders that are not monitored.
    fn hear_by_wire(&mut self, sample: &Sample) {
        for (leg, pair) in sample.transducers.iter().enumerate() {
            for (which, reading) in pair.iter().enumerate() {
                let [length, speed] = self.layout.carries(leg, which);
                if !length {
                    self.heard.lengths[leg][which] = reading.length;
                }
                if !speed {
                    self.heard.speeds[leg][which] = reading.speed;
                }
            }
        }
    }

    /// Sends the readings that were sampled before the Sync, the oldest first.
    fn send_early(&mut self, sample: &Sample, sink: &mut impl FnMut(&Frame)) {
        let oldest_first = |one: &[usize; 2], other: &[usize; 2]| {
            let [one, other] = [one, other].map(|place| sample.ages[place[0]][place[1]]);
            other.total_cmp(&one)
        };
        let mut places: [[usize; 2]; 2 * CYLINDERS] = std::array::from_fn(|i| [i / 2, i % 2]);
        places.sort_unstable_by(oldest_first);
        let opening = self.opening();
        for [leg, which] in places {
            let age = sample.ages[leg][which];
            let Some(place) = self.layout.early(leg, which).filter(|_| age > 0.0) else { continue };
            self.arrivals.wait_until(opening.after(Span::from_seconds(-age)));
            self.put(place, sink);
        }
    }

    fn send(&mut self, phase: SendPhase, sink: &mut impl FnMut(&Frame)) {
        for place in 0..self.layout.messages.len() {
            let message = &self.layout.messages[place];
            if message.phase == phase && !message.early {
                self.put(place, sink);
            }
        }
    }

    /// Sends the message at `place` of the layout.
    fn put(&mut self, place: usize, sink: &mut impl FnMut(&Frame)) {
        let Self { layout, arrivals, injector, heard, in_loop, .. } = self;
        let message = &mut layout.messages[place];
        message.fill(&layout.values);
        message.frame.timestamp = arrivals.next(message.frame.length());
        if !*in_loop {
            message.read_back(&message.frame, heard);
        }
        let unrounded = |plan: &SignalPlan| message.unrounded(plan, &layout.values);
        if let Some(frame) = injector.take_measured(&message.frame, unrounded) {
            if *in_loop {
                message.read_back(frame, heard);
            }
            sink(frame);
        }
    }
}
