//! Messages that the machine sends, their order and contents.

use super::values::{Origin, Values};
use crate::controller::Heard;
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

/// Signals of the default layout that no configuration names; sent where the DBC has them.
const UNNAMED: [(&str, Origin); 8] = [
    ("Mru_Attitude.Roll", Origin::Attitude(0)),
    ("Mru_Attitude.Pitch", Origin::Attitude(1)),
    ("Mru_Attitude.Yaw", Origin::Attitude(2)),
    ("Mru_Translation.Surge", Origin::Translation(0)),
    ("Mru_Translation.Sway", Origin::Translation(1)),
    ("Mru_Translation.Heave", Origin::Translation(2)),
    ("Plc_State.SupplyPressure", Origin::Supply),
    ("Plc_State.Counter", Origin::Counter),
];

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
    /// Whether the speeds by C1 and C2 are on the bus; the controller has its own wire for those that are not.
    pub carries_speed: [bool; 2],
}

impl Layout {
    /// The messages that `settings` name in `database`: Sync, C1 and C2 of every cylinder, the
    /// motion sensor, the platform's state, the valves. Transducers round to `grid`.
    ///
    /// # Errors
    /// The machine is not a hexapod, or a signal is missing or is not where a controller
    /// could send it.
    pub fn new(settings: &Settings, database: &Database, grid: Grid) -> Result<Self, LayoutError> {
        let cylinders = settings.machine.cylinders;
        if usize::from(cylinders) != CYLINDERS {
            return Err(LayoutError::Cylinders(cylinders));
        }
        let mut builder = Builder { database, messages: Vec::new() };
        if let Some(name) = &settings.signals.sync {
            builder.sync(name)?;
        }
        for cylinder in 0..cylinders {
            builder.cylinder(&settings.signals.cylinder, cylinder, SendPhase::Sampled)?;
        }
        for (name, origin) in UNNAMED.iter().filter(|(_, origin)| *origin != Origin::Counter) {
            builder.unnamed(name, *origin)?;
        }
        for (key, name, axis) in tops(settings) {
            if let Some(name) = name {
                builder.add(key, name, Origin::Top(axis))?;
            }
        }
        if let Some(name) = &settings.signals.state {
            builder.add("signals.state", name, Origin::State)?;
        }
        for (name, origin) in UNNAMED.iter().filter(|(_, origin)| *origin == Origin::Counter) {
            builder.unnamed(name, *origin)?;
        }
        for cylinder in 0..cylinders {
            builder.cylinder(&settings.signals.cylinder, cylinder, SendPhase::Commanded)?;
            builder.unnamed(
                &CylinderSignals::of_cylinder("Cyl{n}_Valve.SpoolPosition", cylinder + 1),
                Origin::Spool(usize::from(cylinder)),
            )?;
        }
        let signals = &settings.signals.cylinder;
        let carries_speed = [&signals.c1_velocity, &signals.c2_velocity].map(Option::is_some);
        Ok(Self { messages: builder.messages, values: Values::new(grid), carries_speed })
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

/// The signals of the sensor on the deck: keys, names, and roll (0) or pitch (1).
fn tops(settings: &Settings) -> [(&'static str, Option<&str>, usize); 2] {
    let signals = &settings.signals;
    [
        ("signals.top_roll", signals.top_roll.as_deref(), 0),
        ("signals.top_pitch", signals.top_pitch.as_deref(), 1),
    ]
}

/// Whether the machine of `settings` has a sensor on its deck.
pub fn has_top(settings: &Settings) -> bool {
    tops(settings).iter().any(|(_, name, _)| name.is_some())
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
        signals: &CylinderSignals,
        cylinder: u8,
        phase: SendPhase,
    ) -> Result<(), LayoutError> {
        for (key, pattern) in signals.named() {
            let origin = origin(key, usize::from(cylinder));
            if origin.phase() == phase {
                let name = CylinderSignals::of_cylinder(pattern, cylinder + 1);
                self.add(&format!("signals.cylinder.{key}"), &name, origin)?;
            }
        }
        Ok(())
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
