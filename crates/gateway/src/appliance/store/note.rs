//! What is noted in the store.

use super::act::ActRequest;
use super::hours::Part;
use super::plan::Plan;
use tertius_core::alarm::Warning;
use tertius_core::incident::Incident;
use tertius_core::monitor::Notice;
use tertius_core::sequential::Dwell;
use tertius_core::time::Timestamp;

/// Kinds of events.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// An incident; its event is revised along with it.
    Incident,
    /// An act of a person.
    Act,
    /// The program started.
    Start,
    /// The program was stopped.
    Stop,
    /// A new configuration is in force; the monitor restarted.
    Reload,
    /// A new configuration was refused.
    Refused,
    BusOpened,
    BusLost,
    /// State of the CAN controller.
    Controller,
    /// An NMT command that the gateway has followed.
    Nmt,
    /// C1 and C2 are not sampled together, or are again.
    Timing,
    /// What a CANopen device said that is no fault of its readings.
    Device,
    /// The clock of the time stamps was set.
    Clock,
    /// Frames that cannot be relied on, or can be again.
    Doubt,
    /// Events were lost before they could be written.
    Lost,
}

impl EventKind {
    pub const ALL: [Self; 15] = [
        Self::Incident,
        Self::Act,
        Self::Start,
        Self::Stop,
        Self::Reload,
        Self::Refused,
        Self::BusOpened,
        Self::BusLost,
        Self::Controller,
        Self::Nmt,
        Self::Timing,
        Self::Device,
        Self::Clock,
        Self::Doubt,
        Self::Lost,
    ];

    /// Name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Incident => "incident",
            Self::Act => "act",
            Self::Start => "start",
            Self::Stop => "stop",
            Self::Reload => "reload",
            Self::Refused => "refused",
            Self::BusOpened => "bus_opened",
            Self::BusLost => "bus_lost",
            Self::Controller => "controller",
            Self::Nmt => "nmt",
            Self::Timing => "timing",
            Self::Device => "device",
            Self::Clock => "clock",
            Self::Doubt => "doubt",
            Self::Lost => "lost",
        }
    }
}

/// Something that happened, in words.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    pub kind: EventKind,
    pub at: Timestamp,
    /// Cylinder number, counted from 1; `None` if it is about none.
    pub cylinder: Option<u8>,
    pub text: String,
}

/// Something for the store, as it goes from the data path to the writer. What comes with the frames allocates
/// nothing.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "a box would be an allocation on the data path")]
pub(super) enum Note {
    /// A monitor begins, with this plan; `None` for no store.
    Begin(Option<Box<Plan>>),
    Incident(Incident),
    Warning(Warning),
    Dwell(u8, Dwell),
    Notice(Notice),
    Hour(Part),
    Event(Box<Event>),
    Act(ActRequest),
    /// The program stops.
    End(Timestamp),
}

impl Note {
    /// Whether it gives way to others where there is no room.
    pub fn is_light(&self) -> bool {
        matches!(self, Self::Warning(_) | Self::Notice(_) | Self::Dwell(..) | Self::Event(_))
    }
}
