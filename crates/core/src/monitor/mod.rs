//! The monitor: time-stamped frames in, records, warnings and the gateway's frames out.
//!
//! It has no clock. Time passes with the time stamps of the frames it uses and with
//! [`Monitor::advance`]; whatever falls due in between is done first, at the time at which it was
//! due. A gateway that advances by its clock, some guard time behind the bus, and a replay of the
//! same frames therefore agree.

mod accounts;
mod counts;
pub mod cylinder;
mod estimates;
mod explaining;
mod frames;
pub mod gate;
mod implausible;
mod intake;
mod machine;
mod page;
mod passage;
mod reporting;
mod saved;
mod silence;
pub mod sink;
pub mod subscriptions;

use crate::alarm::status::{MAX_CYLINDERS, Status};
use crate::alarm::{Detector, Encoder, Register};
use crate::error_frame::ErrorFrame;
use crate::frame::{Buses, Frame, Kind};
use crate::hexapod::{Tilt, TiltDesign};
use crate::incident::Incidents;
use crate::process::{SupplyDesign, SupplyWatch};
use crate::sample::cycle::{CycleClock, CycleTiming, Due, Opener};
use crate::sample::sync_watch::SyncWatch;
use crate::sequential::Sampling;
use crate::time::{Span, Timestamp};
use alloc::{boxed::Box, vec::Vec};
pub use counts::Counts;
use cylinder::{Cycle, Cylinder, CylinderDesign, Evaluation};
pub use estimates::Estimates;
pub use explaining::{Answer, Explained, Explanation};
use gate::{Gate, Opening};
use page::Station;
use passage::{LARGEST_PAUSE, SMALLEST_SETBACK};
pub use saved::{DesignChecksum, MAX_STATE, SavedState, StateRefusal};
use silence::Silence;
pub use sink::{Notice, Record, Sink};
use subscriptions::Subscriptions;

/// Everything a monitor is made from.
#[derive(Clone, Debug)]
pub struct MonitorDesign {
    pub subscriptions: Subscriptions,
    pub timing: CycleTiming,
    /// Most missing cycles over which observers predict; a longer silence is reported as a gap.
    pub gap_cycles: u64,
    pub gate: Gate,
    /// Designs of the cylinders, at most [`MAX_CYLINDERS`].
    pub cylinders: Vec<CylinderDesign>,
    /// Comparison of the deck's attitude with a sensor on it; only for a hexapod.
    pub tilt: Option<TiltDesign>,
    /// The supply of all cylinders, where it was taught.
    pub supply: Option<SupplyDesign>,
    pub estimates: Estimates,
    pub encoder: Encoder,
}

/// Location of a page: the index of its message, and its own among the pages of that message.
type Place = (usize, usize);

// `fill` has a bit for each cylinder.
const _: () = assert!(MAX_CYLINDERS <= u8::BITS as usize);

/// The monitor of one machine.
#[derive(Clone, Debug)]
pub struct Monitor {
    subscriptions: Subscriptions,
    /// The messages of `subscriptions`, in its order.
    stations: Vec<Station>,
    /// Whether any page keeps a frame.
    keeps: bool,
    /// Whether any device sends by a timer of its own.
    by_timers: bool,
    /// Whether any cylinder has a process detector.
    has_process: bool,
    /// `None` without a sensor on the deck.
    tilt: Option<Box<Tilt>>,
    /// `None` without a table of the supply.
    supply: Option<Box<SupplyWatch>>,
    clock: CycleClock,
    /// Unused on a machine without Sync.
    sync_watch: SyncWatch,
    gap_cycles: u64,
    gate: Gate,
    cylinders: Vec<Cylinder>,
    sampling: Sampling,
    /// Number of cylinders still to be evaluated in the open cycle.
    pending: usize,
    sends_estimates: bool,
    incomplete: bool,
    /// Number of missing cycles since the last real one.
    missing_run: u64,
    /// Buses from which anything that belongs to a cycle has arrived since the last cycle closed.
    heard: Buses,
    /// `None` if the machine has a single bus.
    silence: Option<Silence>,
    monitored_once: bool,
    /// Whether the platform was in a monitored state in some cycle.
    opened_once: bool,
    register: Register,
    incidents: Incidents,
    encoder: Encoder,
    counts: Counts,
    last: Option<Timestamp>,
    next_status: Timestamp,
    last_status: Option<(Timestamp, Status)>,
    /// Earliest time at which anything falls due, so that most frames need one comparison.
    next_due: Timestamp,
}

impl Monitor {
    pub fn new(design: MonitorDesign) -> Self {
        debug_assert!(design.cylinders.len() <= MAX_CYLINDERS);
        let silence = Silence::of(&design);
        let of_incidents = |it: &CylinderDesign| (it.limits(), it.event_timing());
        let sample_time = design.timing.sample_time;
        let incidents = Incidents::new(design.cylinders.iter().map(of_incidents), sample_time);
        let cylinders = design.cylinders.into_iter().map(Cylinder::new);
        let cylinders: Vec<Cylinder> = match design.estimates {
            Estimates::None => cylinders.collect(),
            Estimates::Computed | Estimates::Sent => cylinders.map(Cylinder::estimating).collect(),
        };
        Self {
            stations: design.subscriptions.all().iter().map(Station::new).collect(),
            by_timers: design.subscriptions.all().iter().any(|message| message.by_timer),
            subscriptions: design.subscriptions,
            keeps: false,
            clock: CycleClock::new(design.timing),
            sync_watch: SyncWatch::default(),
            gap_cycles: design.gap_cycles,
            gate: design.gate,
            register: Register::new(cylinders.len()),
            has_process: cylinders.iter().any(|cylinder| cylinder.process().is_some()),
            tilt: design.tilt.as_ref().map(|design| Box::new(Tilt::new(design))),
            supply: design.supply.map(|design| Box::new(SupplyWatch::new(design))),
            incidents,
            cylinders,
            sampling: Sampling::default(),
            pending: 0,
            sends_estimates: design.estimates == Estimates::Sent,
            incomplete: false,
            missing_run: 0,
            heard: Buses::NONE,
            silence,
            monitored_once: false,
            opened_once: false,
            encoder: design.encoder,
            counts: Counts::default(),
            last: None,
            next_status: Timestamp::default(),
            last_status: None,
            next_due: Timestamp::default(),
        }
    }

    /// Number of the platform's state, if it is known at the time of the newest frame.
    pub fn platform(&self) -> Option<i64> {
        self.gate.number(self.last?)
    }

    /// Takes a frame from the bus. A frame whose time stamp is earlier than that of a previous
    /// frame, by less than a cycle, is taken now, but classified by its time stamp.
    // Of the loop that calls it, where there is more than one for a sink, too: a call costs 15 instructions a frame.
    #[inline(always)]
    pub fn take(&mut self, frame: &Frame, sink: &mut impl Sink) {
        let place = match frame.kind {
            Kind::Data | Kind::Fd { .. } => self.subscriptions.find(frame.bus, frame.id),
            Kind::Remote { .. } => None,
            Kind::Error => {
                self.counts.errors += 1;
                if ErrorFrame::read(frame).is_some_and(|error| error.is_bus_off()) {
                    self.interrupt_bus(frame.bus, frame.timestamp, sink);
                }
                None
            }
        };
        let Some(place) = place else {
            self.counts.ignored += 1;
            return;
        };
        self.counts.used += 1;
        let now = self.follow_time(frame.timestamp, sink);
        if !self.take_next(place, now, frame, sink) {
            self.sort(place, now, frame, sink);
        }
    }

    /// Advances time to `now`; every frame before it must have been taken. A clock that was set
    /// back or far ahead is reported as a time jump, since on a quiet bus no frame would reveal it.
    pub fn advance(&mut self, now: Timestamp, sink: &mut impl Sink) {
        let Some(last) = self.last else { return };
        let step = now.since(last);
        if step < SMALLEST_SETBACK || step > LARGEST_PAUSE {
            return self.jump(now, step, sink);
        }
        if step <= Span::ZERO {
            return;
        }
        if self.next_due < now {
            self.do_due(now, sink);
        }
        self.last = Some(now);
    }

    /// Closes the open cycle at its deadline, because no frame follows, and reports the incidents that are not
    /// over.
    pub fn finish(&mut self, sink: &mut impl Sink) {
        if let Some(Due::Close(at)) = self.clock.due() {
            self.close_cycle(at, sink);
        }
        self.drop_set_aside();
        if let Some(last) = self.last {
            self.incidents.finish(last, |incident| sink.incident(incident));
        }
    }

    /// Takes any frame of the message at `place`.
    #[inline(never)]
    fn sort(&mut self, place: usize, now: Timestamp, frame: &Frame, sink: &mut impl Sink) {
        if self.take_unasked(place, now, frame, sink) {
            return;
        }
        if self.stations[place].is_sync() {
            self.synchronise(frame.timestamp, now, sink);
        }
        for index in 0..self.stations[place].pages.len() {
            let page = &self.stations[place].pages[index];
            match page.is_in(frame) {
                Some(true) if page.cyclic => self.admit((place, index), now, frame, sink),
                Some(true) => self.fill((place, index), now, frame, sink),
                Some(false) => {}
                None => self.counts.bad_signals += 1,
            }
        }
    }

    /// Opens a cycle with a frame of the kind `opener` that has the time stamp `stamp`.
    fn open_cycle(
        &mut self,
        stamp: Timestamp,
        now: Timestamp,
        opener: Opener,
        sink: &mut impl Sink,
    ) {
        if self.clock.is_open() {
            self.close_cycle(now, sink);
        }
        self.drop_set_aside();
        for _ in 0..self.clock.missing_before(stamp, opener) {
            self.miss_cycle(now, sink);
        }
        if self.missing_run > self.gap_cycles {
            let sample_time = self.clock.sample_time().as_nanos();
            let length = Span::from_nanos(sample_time.saturating_mul(self.missing_run as i64));
            sink.notice(&Notice::Gap { at: now, length });
            self.tilt.iter_mut().for_each(|tilt| tilt.lose());
        }
        self.missing_run = 0;
        self.clock.open(stamp, opener);
        self.counts.cycles += 1;
        self.pending = self.cylinders.len();
        self.incomplete = false;
        self.cylinders.iter_mut().for_each(Cylinder::open);
        self.reckon_due();
        self.take_newest(stamp, now, sink);
        if self.keeps {
            self.take_held(now, sink);
        }
    }

    /// Evaluates the cylinders that the open cycle has left.
    fn close_cycle(&mut self, at: Timestamp, sink: &mut impl Sink) {
        if self.keeps {
            self.take_waiting(at, sink);
        }
        let lacks = |cylinder: &Cylinder| cylinder.pending && !cylinder.is_complete();
        self.incomplete |= self.pending > 0 && self.cylinders.iter().any(lacks);
        for index in 0..self.cylinders.len() {
            if self.pending > 0 && self.cylinders[index].pending {
                self.evaluate(index, at, sink);
            }
        }
        self.counts.incomplete += u64::from(self.incomplete);
        self.follow_sampling(at, sink);
        if self.has_process {
            self.follow_supply(at);
        }
        self.follow_tilt(at);
        self.report_machine(at, sink);
        self.clock.close();
        self.follow_silence(at, sink);
    }

    /// Handles a cycle that did not open: the observers predict over it.
    fn miss_cycle(&mut self, at: Timestamp, sink: &mut impl Sink) {
        self.drop_set_aside();
        self.clock.skip(1);
        self.counts.missing += 1;
        self.missing_run += 1;
        self.lose_supply();
        // Beyond that the observers stand still and nothing is judged any more.
        if !self.heard.is_empty() || self.missing_run <= self.gap_cycles + 1 {
            for index in 0..self.cylinders.len() {
                self.evaluate(index, at, sink);
            }
        }
        self.report_machine(at, sink);
        self.follow_silence(at, sink);
    }

    fn evaluate(&mut self, index: usize, at: Timestamp, sink: &mut impl Sink) {
        let cylinder = &mut self.cylinders[index];
        self.pending -= usize::from(cylinder.pending);
        let (gate, at_stop) = self.gate.look(at);
        let now = Evaluation {
            at,
            cycle: self.clock.number(),
            opened: self.clock.opened().unwrap_or(at),
            heard: self.heard,
            gate,
            at_stop,
        };
        self.opened_once |= now.gate == Opening::Open;
        let number = index as u8 + 1;
        let mut cycle = Cycle::new(now);
        cylinder.evaluate(&mut cycle, |transducer, reason| {
            let detector = [Detector::Fde1, Detector::Fde2][transducer as usize];
            sink.notice(&Notice::Restart { at, cylinder: number, detector, reason });
        });
        if sink.wants_records() {
            sink.record(&cylinder.record(&cycle));
        }
        cylinder.inputs.clear();
        self.report_devices(index, at, sink);
        if self.cylinders[index].readings.has_unnamed() {
            self.report_status_bits(index, at, sink);
        }
        if let Some(dwell) = self.cylinders[index].take_dwell() {
            sink.dwell(number, &dwell);
            self.judge_stops(at);
        }
        if self.cylinders[index].is_busy() || self.register.any(index) {
            self.report(index, now, sink);
        }
        if let Some(estimate) = self.cylinders[index].estimated() {
            sink.estimate(now.opened, number, estimate);
            if self.sends_estimates {
                sink.transmit(&self.encoder.estimate(at, number, estimate));
            }
        }
    }
}
