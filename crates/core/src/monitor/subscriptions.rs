//! Subscriptions: the messages and signals that the monitor uses, and their destinations.

use crate::decode::SignalPlan;
use crate::frame::{BusNumber, Id};
use crate::hexapod::Inclination;
use crate::sample::{DeviceRole, Field, Transducer};
use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

/// Destination of a decoded signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// State of the platform.
    State,
    /// An angle of the vessel or of the deck.
    Inclination(Inclination),
    /// Field of the cylinder with this index (from 0).
    Cylinder(u8, Field),
}

/// A signal and its destination.
#[derive(Clone, Debug)]
pub struct SubscribedSignal {
    pub plan: SignalPlan,
    pub target: Target,
}

/// Service by which a CANopen device reports on itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceService {
    /// EMCY.
    Emergency,
    /// Boot-up and heartbeat.
    Heartbeat,
}

/// A service of a device, which stands for one or, where it has several sensors, more devices of cylinders.
#[derive(Clone, Debug)]
pub struct SubscribedService {
    pub service: DeviceService,
    /// Cylinder indices, from 0, and roles.
    pub devices: Vec<(u8, DeviceRole)>,
}

/// A message that the monitor uses.
#[derive(Clone, Debug)]
pub struct Subscription {
    pub bus: BusNumber,
    pub id: Id,
    /// Whether the message opens a cycle.
    pub sync: bool,
    /// Whether the message carries a reading of a transducer.
    pub reading: bool,
    /// Whether the device sends it by a timer of its own, several times in a cycle: the newest frame before
    /// the Sync counts. Only for messages of readings alone, on a machine with Sync.
    pub by_timer: bool,
    /// Whether the message carries anything of a cylinder, and so belongs to a cycle.
    pub cyclic: bool,
    pub signals: Vec<SubscribedSignal>,
    /// The service of a device whose message it is; it has no signals then.
    pub service: Option<SubscribedService>,
}

impl SubscribedSignal {
    /// Whether the destination belongs to a cycle.
    pub fn is_cyclic(&self) -> bool {
        matches!(self.target, Target::Cylinder(..))
    }

    /// Whether the signal comes from a transducer.
    pub fn is_reading(&self) -> bool {
        matches!(self.target, Target::Cylinder(_, field) if field.is_reading())
    }

    pub fn is_counter(&self) -> bool {
        matches!(self.target, Target::Cylinder(_, Field::Counter(_)))
    }

    /// Whether the signal may also be `target`'s: one status or counter for all readings in a
    /// frame.
    pub fn shares_with(&self, target: Target) -> bool {
        use Field::{Counter, Status};
        let (Target::Cylinder(_, own), Target::Cylinder(_, other)) = (self.target, target) else {
            return false;
        };
        matches!((own, other), (Counter(_), Counter(_)) | (Status(_), Status(_)))
    }
}

impl Target {
    /// Cylinder index and transducer that the signal comes from.
    fn transducer(self) -> Option<(u8, Transducer)> {
        match self {
            Self::Cylinder(index, field) => field.transducer().map(|which| (index, which)),
            Self::State | Self::Inclination(_) => None,
        }
    }
}

impl Subscription {
    /// The alive counter that counts what `signal` carries, if the frames that carry it have one.
    pub fn counter_of(&self, signal: &SubscribedSignal) -> Option<&SubscribedSignal> {
        let own = signal.target.transducer()?;
        let counter = self
            .signals
            .iter()
            .find(|one| one.is_counter() && one.target.transducer() == Some(own));
        counter.filter(|counter| counter.plan.accompanies(&self.anchor_of(signal).plan))
    }

    /// The signal whose frames are those in which `signal` matters. A signal in every frame of the
    /// message, or on several pages, belongs to the position of its transducer where that is in the
    /// same frame.
    pub fn anchor_of<'a>(&'a self, signal: &'a SubscribedSignal) -> &'a SubscribedSignal {
        let Some(own) = signal.target.transducer() else { return signal };
        let is_position = |one: &&SubscribedSignal| {
            matches!(one.target, Target::Cylinder(_, Field::Position(_)))
                && one.target.transducer() == Some(own)
                && signal.plan.accompanies(&one.plan)
        };
        self.signals.iter().find(is_position).unwrap_or(signal)
    }

    /// Whether the message carries the position of the transducer of `target`.
    pub fn has_position_of(&self, target: Target) -> bool {
        let is_position = |signal: &SubscribedSignal| {
            matches!(signal.target, Target::Cylinder(_, Field::Position(_)))
        };
        let same = |signal: &&SubscribedSignal| signal.target.transducer() == target.transducer();
        self.signals.iter().filter(same).any(is_position)
    }

    /// Number of frames of the message that make a cycle complete, one for each page.
    pub fn pages(&self) -> usize {
        let mut anchors: Vec<&SubscribedSignal> = Vec::new();
        for signal in self.signals.iter().filter(|signal| signal.is_cyclic()) {
            let anchor = self.anchor_of(signal);
            if anchors.iter().all(|known| !known.plan.is_on_page_of(&anchor.plan)) {
                anchors.push(anchor);
            }
        }
        // What every frame carries needs no frame of its own.
        let paged = anchors.iter().filter(|signal| signal.plan.is_multiplexed()).count();
        if paged > 0 { paged } else { anchors.len() }
    }
}

const NONE: u16 = u16::MAX;

/// Number of standard identifiers of a bus.
const IDENTIFIERS: usize = Id::STANDARD_MAX as usize + 1;

/// All messages that the monitor uses; standard identifiers are found without a search. Each bus has identifiers of its
/// own.
#[derive(Clone, Debug)]
pub struct Subscriptions {
    all: Vec<Subscription>,
    /// Places of the standard identifiers of each bus: all of them, so that none has to be looked for, nor a length
    /// compared.
    standard: Box<[[u16; IDENTIFIERS]; BusNumber::ALL.len()]>,
    extended: Vec<((BusNumber, Id), u16)>,
}

impl Subscriptions {
    pub fn new() -> Self {
        Self {
            all: Vec::new(),
            standard: Box::new([[NONE; IDENTIFIERS]; BusNumber::ALL.len()]),
            extended: vec![],
        }
    }

    /// The message `id` of `bus`, which is added if it is new.
    pub fn subscribe(&mut self, bus: BusNumber, id: Id) -> &mut Subscription {
        let place = self.find(bus, id).unwrap_or_else(|| self.add(bus, id));
        &mut self.all[place]
    }

    /// Index of the message `id` of `bus` among [`Self::all`].
    #[inline]
    pub fn find(&self, bus: BusNumber, id: Id) -> Option<usize> {
        let place = if id.is_extended() {
            let found = self.extended.binary_search_by_key(&(bus, id), |(key, _)| *key).ok()?;
            self.extended[found].1
        } else {
            self.standard[bus.index()][id.value() as usize % IDENTIFIERS]
        };
        (place != NONE).then_some(usize::from(place))
    }

    /// Marks the messages with signals that are `own` as sent by a timer; returns `false` if one of them has
    /// others than readings, too, or opens cycles.
    pub fn send_by_timer(&mut self, own: impl Fn(&SubscribedSignal) -> bool) -> bool {
        let mut alone = true;
        for message in self.all.iter_mut().filter(|message| message.signals.iter().any(&own)) {
            alone &= !message.sync && message.signals.iter().all(SubscribedSignal::is_reading);
            message.by_timer = true;
        }
        alone
    }

    pub fn all(&self) -> &[Subscription] {
        &self.all
    }

    fn add(&mut self, bus: BusNumber, id: Id) -> usize {
        let place = self.all.len();
        // A configuration names at most some dozen messages, far fewer than a u16 counts.
        let short = place as u16;
        if id.is_extended() {
            let at = self.extended.partition_point(|(known, _)| *known < (bus, id));
            self.extended.insert(at, ((bus, id), short));
        } else {
            self.standard[bus.index()][id.value() as usize] = short;
        }
        self.all.push(Subscription {
            bus,
            id,
            sync: false,
            reading: false,
            by_timer: false,
            cyclic: false,
            signals: Vec::new(),
            service: None,
        });
        place
    }
}

impl Default for Subscriptions {
    fn default() -> Self {
        Self::new()
    }
}
