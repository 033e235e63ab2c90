//! Frames that a logger wrote late, in the order of their time stamps.
//!
//! A logger that fills a buffer for each interface or identifier, and writes a buffer when it is full, writes frames with
//! the right time stamps in the wrong order. A clock that was set back looks the same for one frame. But then the time
//! stamps of each identifier go back, while in a buffer they are in order.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use crate::frame::Frame;
use crate::time::{Span, Timestamp};

/// Lateness from which on frames are sorted. What is out of order by less is what several interfaces and clocks do, which
/// the monitor copes with.
pub const LATE: Span = Span::from_nanos(20_000_000);
/// Late frames after which a recording is known to be out of order.
const EVIDENCE: u32 = 2;
/// Most lateness that is sorted.
pub const WINDOW: Span = Span::from_nanos(10_000_000_000);
/// Most frames that are held back: what a full bus of 1 Mbit/s carries in the window, about 14 MB.
const MOST_HELD: usize = 1 << 17;
/// Frames that are watched after one that may be late.
const WATCHED: u32 = 8192;
/// Time, and most frames, that are looked at before the first one is given, of what is no file.
const LOOKED: Span = Span::from_nanos(5_000_000_000);
const MOST_LOOKED: usize = 4096;
/// Most identifiers whose newest time stamps are kept, and most interfaces.
const MOST_IDS: usize = 4096;
const MOST_NAMES: usize = 256;

/// Where a frame is in the order of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    Sorted,
    /// By so much it is late.
    Late(Span),
    /// The clock behind the stamps was set back.
    SetBack,
}

/// Tells late frames from a clock that was set back.
#[derive(Debug, Default)]
pub struct Watch {
    newest: Option<Timestamp>,
    /// Newest time stamp of each identifier on each interface, by its number.
    by_id: BTreeMap<(usize, u32, bool), Timestamp>,
    names: Vec<Arc<[u8]>>,
    /// Late frames since the clock was set back.
    late: u32,
}

impl Watch {
    /// Takes a frame; returns whether enough frames were late.
    pub fn finds_late(&mut self, frame: &Frame, interface: &[u8]) -> bool {
        let (place, _) = self.name(interface);
        self.take(frame, place);
        self.late >= EVIDENCE
    }

    fn take(&mut self, frame: &Frame, interface: usize) -> Order {
        let at = frame.timestamp;
        let behind = self.newest.map_or(Span::ZERO, |newest| newest.since(at));
        let key = (interface, frame.id.value(), frame.id.is_extended());
        let before = self.by_id.get(&key).copied();
        let order = match before {
            Some(before) if before.since(at) > LATE => Order::SetBack,
            Some(_) if behind > LATE => Order::Late(behind),
            _ => Order::Sorted,
        };
        match order {
            Order::SetBack => {
                self.by_id.clear();
                (self.newest, self.late) = (Some(at), 0);
            }
            Order::Late(_) => self.late = self.late.saturating_add(1),
            Order::Sorted => self.newest = self.newest.max(Some(at)),
        }
        if before.is_some() || self.by_id.len() < MOST_IDS {
            self.by_id.insert(key, at);
        }
        order
    }

    /// The number of an interface, and its name.
    fn name(&mut self, interface: &[u8]) -> (usize, Arc<[u8]>) {
        if let Some(place) = self.names.iter().position(|name| **name == *interface) {
            return (place, Arc::clone(&self.names[place]));
        }
        if self.names.len() == MOST_NAMES {
            self.names.clear();
        }
        self.names.push(interface.into());
        let place = self.names.len() - 1;
        (place, Arc::clone(&self.names[place]))
    }
}

/// A frame, and the name of its interface.
type Named = (Frame, Arc<[u8]>);

/// What is done with the frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// They are held back as they come, until it is known whether they are out of order.
    Looking,
    /// They are given as they come, and so many are still to be watched.
    Watching(u32),
    /// They are sorted.
    Sorting,
}

/// Sorts the frames of a recording that is out of order, and watches whether it is.
#[derive(Debug)]
pub struct Sorting {
    watch: Watch,
    stage: Stage,
    /// Frames that are looked at, as they came.
    looked: VecDeque<Named>,
    /// Frames by their time stamps, equal ones as they came.
    held: BTreeMap<(Timestamp, u64), Named>,
    count: u64,
    /// The first frame after the clock was set back, before which everything held back is given.
    set_back: Option<Named>,
    /// Time stamp of the newest frame that was given.
    given: Option<Timestamp>,
    /// Whether the current input has a frame.
    has_frame: bool,
    pub lateness: Lateness,
}

/// What was late in a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Lateness {
    /// Frames that were written late and sorted.
    pub sorted: u64,
    /// By so much the latest one was late.
    pub most: Span,
    /// Frames that were too late to be sorted.
    pub lost: u64,
}

impl Lateness {
    /// That of two recordings.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            sorted: self.sorted + other.sorted,
            most: self.most.max(other.most),
            lost: self.lost + other.lost,
        }
    }
}

impl Sorting {
    /// Watches the next frames, which are given as they come.
    pub fn watching() -> Self {
        Self::at(Stage::Watching(WATCHED))
    }

    /// Looks at the next frames before the first one is given.
    pub fn looking() -> Self {
        Self::at(Stage::Looking)
    }

    /// Sorts from the beginning.
    pub fn on() -> Self {
        Self::at(Stage::Sorting)
    }

    fn at(stage: Stage) -> Self {
        Self {
            watch: Watch::default(),
            stage,
            looked: VecDeque::new(),
            held: BTreeMap::new(),
            count: 0,
            set_back: None,
            given: None,
            has_frame: false,
            lateness: Lateness::default(),
        }
    }

    pub fn is_on(&self) -> bool {
        self.stage == Stage::Sorting
    }

    /// Passes the next frame to the `sorting`, if there is one, which ends once enough frames are in order; returns whether
    /// the frame is held back.
    pub fn holds(sorting: &mut Option<Box<Self>>, frame: &Frame, interface: &[u8]) -> bool {
        let Some(it) = sorting else { return false };
        let holds = it.put(frame, interface);
        if it.stage == Stage::Watching(0) {
            *sorting = None;
        }
        holds
    }

    /// Ends an input; returns whether it had a frame.
    pub fn end_input(&mut self) -> bool {
        std::mem::take(&mut self.has_frame)
    }

    /// Takes the next frame; returns whether it is held back.
    fn put(&mut self, frame: &Frame, interface: &[u8]) -> bool {
        self.has_frame = true;
        let (place, name) = self.watch.name(interface);
        let order = self.watch.take(frame, place);
        let is_late = self.watch.late >= EVIDENCE;
        match &mut self.stage {
            Stage::Watching(left) if !is_late => {
                *left = left.saturating_sub(1);
                self.given = Some(frame.timestamp);
                return false;
            }
            Stage::Looking if !is_late => {
                self.looked.push_back((frame.clone(), name));
                self.look();
                return true;
            }
            stage => *stage = Stage::Sorting,
        }
        // What was looked at is sorted, too, once it shows that frames are late.
        for (frame, name) in std::mem::take(&mut self.looked) {
            self.hold(frame, name);
        }
        match order {
            Order::SetBack => {
                self.set_back = Some((frame.clone(), name));
                return true;
            }
            Order::Late(span) => {
                let is_lost = self.given.is_some_and(|given| frame.timestamp < given);
                self.lateness.sorted += u64::from(!is_lost);
                self.lateness.lost += u64::from(is_lost);
                self.lateness.most = self.lateness.most.max(span);
            }
            Order::Sorted => {}
        }
        self.hold(frame.clone(), name);
        true
    }

    /// Ends the look at the first frames once there are enough in order.
    fn look(&mut self) {
        let ends = [self.looked.front(), self.looked.back()];
        let [Some((first, _)), Some((last, _))] = ends else { return };
        if last.timestamp.since(first.timestamp) > LOOKED || self.looked.len() >= MOST_LOOKED {
            self.stage = Stage::Watching(WATCHED);
        }
    }

    fn hold(&mut self, frame: Frame, name: Arc<[u8]>) {
        self.count += 1;
        self.held.insert((frame.timestamp, self.count), (frame, name));
    }

    /// The next frame, if none that is still to come should be before it.
    pub fn take(&mut self) -> Option<Named> {
        if !self.looked.is_empty() {
            let is_over = self.stage != Stage::Looking;
            return if is_over { self.take_any() } else { None };
        }
        if self.set_back.is_some() {
            if !self.held.is_empty() {
                return self.take_any();
            }
            self.go_on_behind();
        }
        let ((first, _), _) = self.held.first_key_value()?;
        let waited = self.watch.newest.map_or(Span::ZERO, |newest| newest.since(*first));
        let is_due = waited > WINDOW || self.held.len() > MOST_HELD;
        if is_due { self.take_any() } else { None }
    }

    /// The next frame, since none comes that should be before it.
    pub fn take_any(&mut self) -> Option<Named> {
        if self.looked.is_empty() && self.held.is_empty() {
            self.go_on_behind();
        }
        let held = || self.held.pop_first().map(|(_, next)| next);
        let next = self.looked.pop_front().or_else(held)?;
        self.given = Some(next.0.timestamp);
        Some(next)
    }

    /// Goes on behind the place at which the clock was set back.
    fn go_on_behind(&mut self) {
        if let Some((frame, name)) = self.set_back.take() {
            self.given = None;
            self.hold(frame, name);
        }
    }
}
