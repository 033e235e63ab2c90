//! Messages that the machine sends, their order and contents.

use super::beside::SignalTable;
use super::values::{Origin, Scales, Values};
use crate::controller::{Heard, State};
use crate::inject::Unrounded;
use crate::plant::CYLINDERS;
use crate::transducer::Grid;
use tertius_config::settings::{CylinderSignals, Settings, bus_of};
use tertius_core::decode::{Inserted, Raw, SignalPlan};
use tertius_core::frame::{BusNumber, Frame, Kind};
use tertius_core::time::Timestamp;
use tertius_dbc::{Database, LookupError, Message};

/// Why the machine of a configuration cannot be simulated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LayoutError {
    #[error("machine.cylinders is {0}; the simulated machine is a hexapod with {CYLINDERS}")]
    Cylinders(u8),
    #[error("{key}: {error}")]
    Lookup {
        key: String,
        #[source]
        error: LookupError,
    },
    #[error("{signal} is multiplexed; the simulated machine sends every signal in every cycle")]
    Multiplexed { signal: String },
    #[error(
        "{message} carries both a transducer's reading and a command; the command answers the \
         reading, so the simulated machine needs two messages"
    )]
    Mixed { message: String },
}

/// Time within the cycle at which a message is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SendPhase {
    /// Right after Sync.
    Sampled,
    /// When the controller has its answer.
    Commanded,
}

impl Origin {
    fn phase(self) -> SendPhase {
        match self {
            Self::Command(_)
            | Self::Spool(_)
            | Self::Bottom(_)
            | Self::Rod(_)
            | Self::LoadPressure(_) => SendPhase::Commanded,
            _ => SendPhase::Sampled,
        }
    }
}

/// A message with the frame that is sent for it.
#[derive(Clone, Debug)]
pub struct Planned {
    pub frame: Frame,
    pub phase: SendPhase,
    /// Whether it is sent before the Sync, by a transducer with a timer of its own.
    pub early: bool,
    fields: Vec<(SignalPlan, Origin)>,
}

impl Planned {
    /// Writes the values into the frame.
    pub fn fill(&mut self, values: &Values) {
        let payload = self.frame.buffer_mut();
        for (plan, origin) in &self.fields {
            let raw = match origin {
                // The payload is made of zeros.
                Origin::Status => continue,
                Origin::Counter => {
                    Raw::Unsigned(values.cycle & (u64::MAX >> (64 - plan.bits().clamp(1, 64))))
                }
                _ if plan.is_float() => Raw::Float(plan.unscaled(values.of(*origin))),
                // Rounded here: the doubles at hand are far from what needs 128 bits.
                _ => {
                    let count = plan.unscaled(values.of(*origin));
                    Raw::Signed((count + 0.5_f64.copysign(count)) as i64)
                }
            };
            // What a signal cannot hold is sent as the nearest that it can, as a real device does.
            let _: Inserted = plan.insert(raw, payload);
        }
    }

    /// The transducer's length before it was rounded for the signal of `plan`.
    pub fn unrounded(&self, plan: &SignalPlan, values: &Values) -> Option<Unrounded> {
        let (_, origin) = self.fields.iter().find(|(known, _)| known == plan)?;
        values.unrounded(*origin)
    }

    /// What the controller hears in `frame`, a frame of this message.
    pub fn read_back(&self, frame: &Frame, heard: &mut Heard) {
        for (plan, origin) in &self.fields {
            let place = match origin {
                Origin::Length(cylinder, which) => &mut heard.lengths[*cylinder][*which],
                Origin::Speed(cylinder, which) => &mut heard.speeds[*cylinder][*which],
                _ => continue,
            };
            if let Some(value) = plan.decode(frame).value().filter(|v| v.physical.is_finite()) {
                *place = value.physical;
            }
        }
    }
}

/// All messages of a cycle, in the order of the bus.
#[derive(Clone, Debug)]
pub struct Layout {
    pub messages: Vec<Planned>,
    pub values: Values,
    /// For each cylinder whose readings are on the bus: whether the bus has the lengths by C1 and C2, and the speeds.
    carries: Vec<[[bool; 2]; 2]>,
}

impl Layout {
    /// The messages that `settings` name in `database`, and those of `beside`: Sync, C1 and C2 of every monitored
    /// cylinder, the motion sensor, the platform's state, the valves. Transducers round to `grid`, and a spool's signal
    /// at full stroke is `spool_full`.
    ///
    /// # Errors
    /// There are more cylinders than the machine has, or a signal is missing or is not where a controller
    /// could send it.
    pub fn new(
        settings: &Settings,
        database: &Database,
        beside: &SignalTable,
        (grid, spool_full): (Grid, f64),
    ) -> Result<Self, LayoutError> {
        let (cylinders, signals) = (settings.machine.cylinders, &settings.signals);
        if usize::from(cylinders) > CYLINDERS {
            return Err(LayoutError::Cylinders(cylinders));
        }
        let mut builder = Builder { database, messages: Vec::new() };
        if let Some(name) = &signals.sync {
            builder.sync(name)?;
        }
        for cylinder in 0..cylinders {
            builder.cylinder(settings, cylinder, SendPhase::Sampled)?;
        }
        for (name, origin) in unnamed(beside) {
            builder.unnamed(name, origin)?;
        }
        for (key, name, origin) in named(settings) {
            if let Some(name) = name {
                builder.add(key, name, origin)?;
            }
        }
        for name in &beside.counters {
            builder.unnamed(name, Origin::Counter)?;
        }
        for cylinder in 0..cylinders {
            builder.cylinder(settings, cylinder, SendPhase::Commanded)?;
            if let Some(pattern) = &beside.spool {
                let name = CylinderSignals::of_cylinder(pattern, cylinder + 1);
                builder.unnamed(&name, Origin::Spool(usize::from(cylinder)))?;
            }
        }
        let scales = Scales { grid, spool_full, states: builder.states(signals.state.as_deref()) };
        let carries = |n: u8| {
            let has = |key: &str| settings.signals_of(n).any(|(known, _)| known == key);
            [["c1", "c2"], ["c1_velocity", "c2_velocity"]].map(|keys| keys.map(has))
        };
        Ok(Self {
            messages: builder.messages,
            values: Values::new(scales),
            carries: (1..=cylinders).map(carries).collect(),
        })
    }

    /// Whether the length, and the speed, by C1 (0) or C2 (1) of the cylinder `leg`, from 0, is on the bus; the controller
    /// has its own wire for what is not.
    pub fn carries(&self, leg: usize, which: usize) -> [bool; 2] {
        self.carries.get(leg).map_or([false; 2], |carries| carries.map(|of| of[which]))
    }
}

impl Layout {
    /// Sends the messages of transducers with a time in `timers` before the Sync.
    pub fn send_early(&mut self, timers: &[[f64; 2]; CYLINDERS]) {
        for message in &mut self.messages {
            let is_early = |origin: Origin| match origin {
                Origin::Length(leg, which) => timers[leg][which] > 0.0,
                _ => false,
            };
            message.early = message.fields.iter().any(|(_, origin)| is_early(*origin));
        }
    }

    /// Place of the message that has the length by C1 (0) or C2 (1) of the cylinder `leg`, from 0, if it is
    /// sent before the Sync.
    pub fn early(&self, leg: usize, which: usize) -> Option<usize> {
        let has = |planned: &Planned| {
            planned.early && planned.fields.iter().any(|(_, it)| *it == Origin::Length(leg, which))
        };
        self.messages.iter().position(has)
    }
}

/// The signals of `beside` that are no cylinder's, without the counters.
fn unnamed(beside: &SignalTable) -> impl Iterator<Item = (&str, Origin)> {
    let signals = [
        (&beside.roll, Origin::Attitude(0)),
        (&beside.pitch, Origin::Attitude(1)),
        (&beside.yaw, Origin::Attitude(2)),
        (&beside.surge, Origin::Translation(0)),
        (&beside.sway, Origin::Translation(1)),
        (&beside.heave, Origin::Translation(2)),
        (&beside.supply, Origin::Supply),
    ];
    signals.into_iter().filter_map(|(name, origin)| Some((name.as_deref()?, origin)))
}

/// The signals of a configuration that are no cylinder's: keys, names and what they are.
fn named(settings: &Settings) -> [(&'static str, Option<&str>, Origin); 6] {
    let signals = &settings.signals;
    let [roll, pitch] = tops(settings);
    [
        ("signals.vessel_roll", signals.vessel_roll.as_deref(), Origin::Attitude(0)),
        ("signals.vessel_pitch", signals.vessel_pitch.as_deref(), Origin::Attitude(1)),
        ("signals.supply", signals.supply.as_deref(), Origin::Supply),
        ("signals.top_roll", roll, Origin::Top(0)),
        ("signals.top_pitch", pitch, Origin::Top(1)),
        ("signals.state", signals.state.as_deref(), Origin::State),
    ]
}

/// The names of roll and pitch of the sensor on the deck.
fn tops(settings: &Settings) -> [Option<&str>; 2] {
    [&settings.signals.top_roll, &settings.signals.top_pitch].map(|name| name.as_deref())
}

/// Whether the machine of `settings` has a sensor on its deck.
pub fn has_top(settings: &Settings) -> bool {
    tops(settings).iter().any(Option::is_some)
}

/// The origin of a key of `[signals.cylinder]`.
fn origin(key: &str, cylinder: usize) -> Origin {
    match key {
        "c1" => Origin::Length(cylinder, 0),
        "c2" => Origin::Length(cylinder, 1),
        "c1_velocity" => Origin::Speed(cylinder, 0),
        "c2_velocity" => Origin::Speed(cylinder, 1),
        "c1_counter" | "c2_counter" => Origin::Counter,
        "control_speed" => Origin::Command(cylinder),
        "pressure_bottom" => Origin::Bottom(cylinder),
        "pressure_rod" => Origin::Rod(cylinder),
        "load_pressure" => Origin::LoadPressure(cylinder),
        "spool" => Origin::Spool(cylinder),
        // "c1_status", "c2_status".
        _ => Origin::Status,
    }
}

struct Builder<'a> {
    database: &'a Database,
    messages: Vec<Planned>,
}

impl Builder<'_> {
    fn sync(&mut self, name: &str) -> Result<(), LayoutError> {
        let lookup = |error| LayoutError::Lookup { key: "signals.sync".to_owned(), error };
        let (bus, name) = bus_of(name).unwrap_or((BusNumber::First, name));
        let message = self.database.message(name).map_err(lookup)?;
        let counter = message.signal("Counter").filter(|signal| !signal.plan.is_multiplexed());
        let planned = self.message(bus, message, SendPhase::Sampled)?;
        planned.fields.extend(counter.map(|signal| (signal.plan.clone(), Origin::Counter)));
        Ok(())
    }

    /// The signals of one cylinder that are sent in `phase`.
    fn cylinder(
        &mut self,
        settings: &Settings,
        cylinder: u8,
        phase: SendPhase,
    ) -> Result<(), LayoutError> {
        for (key, pattern) in settings.signals_of(cylinder + 1) {
            let origin = origin(key, usize::from(cylinder));
            if origin.phase() == phase {
                let name = CylinderSignals::of_cylinder(pattern, cylinder + 1);
                self.add(&format!("signals.cylinder.{key}"), &name, origin)?;
            }
        }
        Ok(())
    }

    /// The numbers of the platform's states by their names in the DBC; one without a name has its own number.
    fn states(&self, name: Option<&str>) -> [f64; 4] {
        let name = name.map(|name| bus_of(name).map_or(name, |(_, name)| name));
        let signal = name.and_then(|name| self.database.signal(name).ok()).map(|(_, it)| it);
        State::ALL.map(|state| {
            let number = signal.and_then(|signal| signal.numbers_named(state.name()).next());
            number.map_or(f64::from(state as u8), |number| number as f64)
        })
    }

    fn unnamed(&mut self, name: &str, origin: Origin) -> Result<(), LayoutError> {
        if self.database.signal(name).is_ok() { self.add(name, name, origin) } else { Ok(()) }
    }

    fn add(&mut self, key: &str, name: &str, origin: Origin) -> Result<(), LayoutError> {
        let lookup = |error| LayoutError::Lookup { key: key.to_owned(), error };
        let (bus, name) = bus_of(name).unwrap_or((BusNumber::First, name));
        let (message, signal) = self.database.signal(name).map_err(lookup)?;
        if signal.plan.is_multiplexed() {
            return Err(LayoutError::Multiplexed { signal: name.to_owned() });
        }
        let plan = signal.plan.clone();
        let planned = self.message(bus, message, origin.phase())?;
        // A counter that the configuration names, too.
        if planned.fields.iter().all(|(known, _)| *known != plan) {
            planned.fields.push((plan, origin));
        }
        Ok(())
    }

    /// The planned message, which is created if it is new.
    fn message(
        &mut self,
        bus: BusNumber,
        message: &Message,
        phase: SendPhase,
    ) -> Result<&mut Planned, LayoutError> {
        let is_it = |frame: &Frame| (frame.bus, frame.id) == (bus, message.id);
        let known = self.messages.iter().position(|planned| is_it(&planned.frame));
        let place = known.unwrap_or_else(|| {
            let kind = if message.length > 8 { Kind::Fd { flags: 0 } } else { Kind::Data };
            let zeros = vec![0; message.length];
            let frame = Frame::new(Timestamp::default(), message.id, kind, &zeros);
            let frame = frame.on(bus);
            self.messages.push(Planned { frame, phase, early: false, fields: Vec::new() });
            self.messages.len() - 1
        });
        let planned = &mut self.messages[place];
        if planned.phase != phase {
            return Err(LayoutError::Mixed { message: message.name.clone() });
        }
        Ok(planned)
    }
}
