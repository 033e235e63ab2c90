//! Pages: signals of a message that come together, and the state of their arrival.

use super::intake::{Counting, Intake};
use super::subscriptions::{SubscribedService, SubscribedSignal, Subscription, Target};
use crate::decode::{Decoded, SignalPlan};
use crate::frame::Frame;
use crate::hexapod::Inclination;
use crate::sample::arrival::Slot;
use crate::sample::counter::AliveCounter;
use crate::sample::{Field, Transducer};
use crate::state::{StateError, StateReader, StateWriter, Stateful, state, whole};
use crate::time::{Span, Timestamp};
use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

/// What the frames of a message are.
#[derive(Clone, Debug)]
pub(super) enum StationKind {
    /// They come once in a cycle.
    Usual,
    /// They open a cycle.
    Sync,
    /// Their device sends them by a timer of its own; the newest one.
    Timed(Box<Newest>),
    /// A service of a device, without pages.
    Service(Box<SubscribedService>),
}

/// A message as its frames are received.
#[derive(Clone, Debug)]
pub(super) struct Station {
    pub kind: StationKind,
    pub pages: Box<[Page]>,
}

state! {
    Station { kind }
    parts { pages }
}

/// The newest frame of a message, until a cycle takes it.
#[derive(Clone, Debug, Default)]
pub(super) struct Newest {
    frame: Option<Frame>,
}

whole! { Newest { frame } }

impl Newest {
    /// Keeps `frame` instead of an older one.
    pub fn keep(&mut self, frame: &Frame) {
        match &mut self.frame {
            Some(known) => known.clone_from(frame),
            None => self.frame = Some(frame.clone()),
        }
    }

    /// The frame for a cycle that opens at `opening`, unless it is older than a cycle of `sample_time`.
    pub fn take(&mut self, opening: Timestamp, sample_time: Span) -> Option<Frame> {
        let frame = self.frame.take()?;
        (opening.since(frame.timestamp) < sample_time).then_some(frame)
    }

    pub fn forget(&mut self) {
        self.frame = None;
    }
}

/// Signals of a message that come together: carried by the same frames and counted by the same
/// alive counter. A message without a multiplexor is one page if all of its signals share a
/// counter.
#[derive(Clone, Debug)]
pub(super) struct Page {
    /// Whether the page carries a reading of a transducer.
    pub reading: bool,
    /// Whether the page belongs to a cycle; the platform's state does not.
    pub cyclic: bool,
    /// Signals of the page except its counter.
    pub signals: Box<[PageSignal]>,
    /// Short path of the signals.
    pub intake: Option<Intake>,
    counter: Option<SignalPlan>,
    /// Least length of a frame that has all of it, bytes.
    needs: usize,
    /// Readings that the counter counts.
    pub counted: Box<[(u8, Transducer)]>,
    pub slot: Slot,
    /// A signal in the same frames as the page; `None` where every frame carries the page.
    carried_with: Option<SignalPlan>,
}

state! {
    Page { slot }
    but { reading, cyclic, signals, intake, counter, needs, counted, carried_with }
}

/// A signal of a page, and where it goes.
#[derive(Clone, Debug)]
pub(super) struct PageSignal {
    pub plan: SignalPlan,
    pub destination: Destination,
}

/// Where a signal goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Destination {
    State,
    Inclination(Inclination),
    /// The same field of one cylinder or several, as of the supply's pressure: a bit for each.
    Cylinders(u8, Field),
}

impl Destination {
    /// How many values a signal is that goes there.
    pub fn count(self) -> u64 {
        match self {
            Self::State | Self::Inclination(_) => 1,
            Self::Cylinders(bits, _) => bits.count_ones().into(),
        }
    }
}

impl PageSignal {
    fn of(signal: &SubscribedSignal) -> Self {
        let destination = match signal.target {
            Target::State => Destination::State,
            Target::Inclination(which) => Destination::Inclination(which),
            Target::Cylinder(index, field) => Destination::Cylinders(1 << index, field),
        };
        Self { plan: signal.plan.clone(), destination }
    }

    /// The bits of its cylinders, if `other` is the same value for the same field.
    fn joined(&mut self, other: &Self) -> Option<&mut u8> {
        match (&mut self.destination, other.destination) {
            (Destination::Cylinders(bits, own), Destination::Cylinders(_, field)) => {
                (*own == field && self.plan == other.plan).then_some(bits)
            }
            _ => None,
        }
    }

    /// `signals`, of which those that only differ in their cylinder are one.
    fn all(signals: &[SubscribedSignal]) -> Box<[Self]> {
        let mut all: Vec<Self> = Vec::new();
        for signal in signals {
            let own = Self::of(signal);
            let joined = all.iter_mut().find_map(|known| known.joined(&own));
            match (joined, own.destination) {
                (Some(bits), Destination::Cylinders(more, _)) => *bits |= more,
                _ => all.push(own),
            }
        }
        all.into()
    }
}

impl Stateful for StationKind {
    const SHAPE: u64 = Newest::SHAPE;

    fn save(&self, into: &mut StateWriter) {
        match self {
            Self::Timed(newest) => newest.save(into),
            Self::Usual | Self::Sync | Self::Service(_) => {}
        }
    }

    fn resume(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        match self {
            Self::Timed(newest) => newest.resume(from),
            Self::Usual | Self::Sync | Self::Service(_) => Ok(()),
        }
    }
}

impl Station {
    /// Whether the message opens a cycle.
    pub const fn is_sync(&self) -> bool {
        matches!(self.kind, StationKind::Sync)
    }

    /// The newest frame, if the device sends by a timer of its own.
    pub fn newest(&mut self) -> Option<&mut Newest> {
        match &mut self.kind {
            StationKind::Timed(newest) => Some(newest),
            StationKind::Usual | StationKind::Sync | StationKind::Service(_) => None,
        }
    }

    /// Forgets the arrivals, because the frames so far say nothing about the next ones.
    pub fn forget(&mut self) {
        if let Some(newest) = self.newest() {
            newest.forget();
        }
        self.pages.iter_mut().for_each(|page| page.slot.reset());
    }

    pub fn new(message: &Subscription) -> Self {
        let mut drafts: Vec<Draft<'_>> = Vec::new();
        for signal in &message.signals {
            let counter = message.counter_of(signal);
            let anchor = message.anchor_of(signal);
            let belongs = |draft: &&mut Draft<'_>| {
                draft.cyclic == signal.is_cyclic()
                    && draft.counter.map(|known| &known.plan) == counter.map(|signal| &signal.plan)
                    && draft.anchor.plan.is_on_page_of(&anchor.plan)
            };
            match drafts.iter_mut().find(belongs) {
                Some(draft) => draft.signals.push(signal),
                None => drafts.push(Draft {
                    cyclic: signal.is_cyclic(),
                    anchor,
                    counter,
                    signals: vec![signal],
                }),
            }
        }
        let pages = drafts.iter().map(|draft| {
            let sharing = drafts.iter().filter(|other| {
                let plans = other.counter.zip(draft.counter);
                plans.is_some_and(|(other, own)| other.plan == own.plan)
            });
            // Where a page is in every frame, a cycle has one frame as far as one can tell.
            let each_has_its_frame =
                sharing.clone().all(|other| other.anchor.plan.is_multiplexed());
            draft.page(if each_has_its_frame { sharing.count() as u64 } else { 1 })
        });
        let kind = match &message.service {
            _ if message.sync => StationKind::Sync,
            _ if message.by_timer => StationKind::Timed(Box::default()),
            Some(service) => StationKind::Service(Box::new(service.clone())),
            None => StationKind::Usual,
        };
        Self { kind, pages: pages.collect() }
    }
}

/// A page that is being put together.
struct Draft<'a> {
    cyclic: bool,
    /// The signal that determines which frames carry the page.
    anchor: &'a SubscribedSignal,
    counter: Option<&'a SubscribedSignal>,
    signals: Vec<&'a SubscribedSignal>,
}

impl Draft<'_> {
    /// The page; `sharing` pages have the same counter.
    fn page(&self, sharing: u64) -> Page {
        let counted = self.signals.iter().filter_map(|signal| match signal.target {
            Target::Cylinder(index, Field::Counter(transducer)) => Some((index, transducer)),
            _ => None,
        });
        let others = self.signals.iter().filter(|signal| !signal.is_counter());
        let signals: Box<[SubscribedSignal]> = others.map(|signal| (*signal).clone()).collect();
        let counted: Box<[(u8, Transducer)]> = counted.collect();
        let plan = self.counter.map(|signal| signal.plan.clone());
        let counting = plan.as_ref().map(|plan| Counting { plan, counted: &counted });
        let plans = self.signals.iter().map(|signal| &signal.plan).chain(&plan);
        let needs = plans.map(SignalPlan::needed_length).max().unwrap_or_default();
        let alive = plan.as_ref().map(|plan| AliveCounter::new(plan.bits(), sharing));
        Page {
            reading: self.signals.iter().any(|signal| signal.is_reading()),
            cyclic: self.cyclic,
            intake: Intake::of(&signals, counting),
            signals: PageSignal::all(&signals),
            counter: plan,
            needs,
            counted,
            slot: Slot::new(alive),
            carried_with: { self.anchor.plan.is_multiplexed() }.then(|| self.anchor.plan.clone()),
        }
    }
}

impl Page {
    /// Whether `frame` carries this page; `None` if it is too short to tell.
    #[inline]
    pub fn is_in(&self, frame: &Frame) -> Option<bool> {
        self.carried_with.as_ref().map_or(Some(true), |plan| plan.is_carried_by(frame))
    }

    /// Whether `frame`, which carries this page, is too short for some of it.
    #[inline]
    pub fn is_too_short(&self, frame: &Frame) -> bool {
        frame.length() < self.needs
    }

    /// The transducers that the page carries signals of, each with a bit for each of its cylinders.
    pub fn transducers(&self) -> impl Iterator<Item = (u8, Transducer)> {
        self.signals.iter().filter_map(|signal| match signal.destination {
            Destination::Cylinders(bits, field) => Some((bits, field.transducer()?)),
            Destination::State | Destination::Inclination(_) => None,
        })
    }

    /// Value of the alive counter in `frame`, which is counted in `bad` where the frame is too short for it or the value
    /// is not finite.
    #[inline]
    pub fn count(&self, frame: &Frame, bad: &mut u64) -> Option<u64> {
        let count = match self.counter.as_ref()?.decode(frame) {
            Decoded::Value(value) => value.raw.bits(),
            Decoded::Absent => return None,
            Decoded::Short => None,
        };
        *bad += u64::from(count.is_none());
        count
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decode::{BitField, NumberForm};
    use crate::sample::Pressure;

    fn plan(start: u64) -> SignalPlan {
        let field = BitField::new(start, 16, false, false).expect("it is within a frame");
        SignalPlan::new(field, NumberForm::Integer, 0.01, 0.0, Box::new([]))
    }

    /// Where the signals at these bits, for these fields of cylinders, go.
    fn destinations(signals: &[(u64, u8, Field)]) -> Vec<Destination> {
        let subscribed = |&(start, index, field): &(u64, u8, Field)| SubscribedSignal {
            plan: plan(start),
            target: Target::Cylinder(index, field),
        };
        let signals: Vec<SubscribedSignal> = signals.iter().map(subscribed).collect();
        PageSignal::all(&signals).iter().map(|signal| signal.destination).collect()
    }

    #[test]
    fn one_value_for_the_same_field_of_several_cylinders_is_read_once() {
        const SUPPLY: Field = Field::Pressure(Pressure::Supply);
        let shared = destinations(&[(8, 0, SUPPLY), (8, 3, SUPPLY), (8, 5, SUPPLY)]);
        assert_eq!(shared, [Destination::Cylinders(0b10_1001, SUPPLY)]);
        assert_eq!(shared[0].count(), 3);
    }

    #[test]
    fn values_of_their_own_and_other_fields_stay_apart() {
        let [c1, c2] = [Transducer::C1, Transducer::C2];
        let of = |bits, field| Destination::Cylinders(bits, field);
        let positions = [(0, 0, Field::Position(c1)), (16, 1, Field::Position(c1))];
        assert_eq!(
            destinations(&positions),
            [of(1, Field::Position(c1)), of(2, Field::Position(c1))]
        );
        // One status for both readings of two cylinders.
        let status = [c1, c2].map(Field::Status);
        let found = destinations(&[(0, 0, status[0]), (0, 0, status[1]), (0, 1, status[1])]);
        assert_eq!(found, [of(1, status[0]), of(3, status[1])]);
    }
}
