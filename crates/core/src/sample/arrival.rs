//! Assignment of the frames of a place to cycles.
//!
//! A place stands for signals that come together: those of one page of one message that share an alive counter. In each
//! cycle it takes one frame. The counter decides where there is one ([`AliveCounter`]); without it the usual time of the
//! frames decides, and a frame after a lost one waits, since it may be the lost one, late.

use super::counter::{AliveCounter, Count};
use super::cycle::When;
use super::dispute::{Dispute, Doubt};
use super::fate::Fate;
use super::parameters::ArrivalParameters;
use super::phase::{Phases, Usual};
use crate::frame::Frame;
use crate::state::{state, whole};
use crate::time::Timestamp;

const P: &ArrivalParameters = &ArrivalParameters::DEFAULT;

/// A frame that waits for its cycle to open, or to close.
#[derive(Clone, Debug)]
struct Kept {
    frame: Frame,
    counter: Option<u64>,
    cycle: u64,
    /// Whether nothing better is expected.
    sure: bool,
    /// Number of frames that waited for the same cycle before it, each of which was late.
    before: u64,
}

whole! {
    Kept { frame, cycle, sure, before }
    bits { counter }
}

/// Arrivals at one place.
#[derive(Clone, Debug)]
pub struct Slot {
    counter: Option<AliveCounter>,
    /// Newest cycle for which the place has a frame.
    filled: Option<u64>,
    /// Digest of that frame's payload, used where no counter is trusted.
    digest: u64,
    phases: Phases,
    /// Usual phase from `phases`, once computed.
    usual: Option<Option<Usual>>,
    kept: Option<Kept>,
    /// Number of consecutive cycles with frames, none in time.
    starved: u32,
    starved_in: u64,
    pub dispute: Dispute,
}

state! {
    Slot { filled, phases, usual, kept, starved, starved_in, dispute }
    parts { counter }
    bits { digest }
    sound |it| it.usual.is_none_or(|usual| usual == it.phases.usual())
}

impl Slot {
    /// A place whose frames have this alive counter.
    pub const fn new(counter: Option<AliveCounter>) -> Self {
        Self {
            counter,
            filled: None,
            digest: 0,
            phases: Phases::new(),
            usual: None,
            kept: None,
            starved: 0,
            starved_in: 0,
            dispute: Dispute::NONE,
        }
    }

    /// Number of times that the alive counter fitted no cycle.
    pub fn jumps(&self) -> u64 {
        self.counter.as_ref().map_or(0, AliveCounter::jumps)
    }

    /// Whether it has a frame of `cycle`.
    pub fn has(&self, cycle: u64) -> bool {
        self.filled == Some(cycle)
    }

    /// Whether `frame`, which comes about when a cycle could open, belongs to none of the earlier cycles. Where the newest
    /// one `is_empty`, a counter that is behind is no proof: the clock may have been set forward.
    pub fn may_open(
        &mut self,
        frame: &Frame,
        counter: Option<u64>,
        when: &When,
        is_empty: bool,
    ) -> bool {
        let count = self.counter.as_ref().zip(counter);
        match count.map_or(Count::Silent, |(alive, value)| alive.read(when.cycle, value)) {
            Count::Same => return false,
            Count::Off(..=0) => return is_empty,
            Count::Off(_) | Count::Jumped => return true,
            Count::Silent => {}
        }
        let usual = self.usual_phase();
        let copied = self.has(when.cycle) && frame.digest() == self.digest;
        // A rod at rest sends the same again, so a copy is told by its time alone.
        let least = if copied { when.half() / 2 * 3 } else { when.half() };
        let opens = !self.has(when.cycle) || when.phase(frame.timestamp) >= usual + least;
        if opens {
            // Whoever sends freely has sent something newer than what was held for that cycle.
            self.kept = None;
        }
        opens
    }

    /// Whether `frame` is one cycle on from the frame that the place has of the newest cycle, and therefore of the one
    /// that the Sync with the time stamp `sync` opens, which was taken for a repetition.
    pub fn follows(
        &mut self,
        frame: &Frame,
        counter: Option<u64>,
        when: &When,
        sync: Timestamp,
    ) -> bool {
        if !self.has(when.cycle) {
            return false;
        }
        let phase = frame.timestamp.since(sync).as_nanos();
        let count = self.counter.as_ref().zip(counter);
        match count.map_or(Count::Silent, |(alive, value)| alive.read(when.cycle, value)) {
            Count::Off(1) => (0..when.half()).contains(&phase),
            Count::Silent => {
                let beside = phase - self.usual_phase();
                frame.digest() != self.digest && beside.abs() < when.half() / 2
            }
            _ => false,
        }
    }

    /// Takes `frame`, with this `counter` where it could be read, if it is exactly what the open
    /// cycle lacks: one count on, or, without a counter, one cycle on. Nearly every frame is, so
    /// this is checked first.
    #[inline(always)]
    pub fn take_next(&mut self, frame: &Frame, counter: Option<u64>, when: &When) -> bool {
        if !when.open || self.has(when.cycle) {
            return false;
        }
        if let (Some(alive), Some(value)) = (&mut self.counter, counter) {
            if !alive.is_due(when.cycle, value) {
                return false;
            }
            alive.accept(when.cycle, value);
            self.filled = Some(when.cycle);
            self.digest = frame.digest();
        } else {
            let phase = when.phase(frame.timestamp);
            let in_time = phase >= 0 || !when.by_sync;
            if !in_time || self.filled.is_none_or(|filled| filled + 1 != when.cycle) {
                return false;
            }
            self.take(frame, counter, when.cycle, phase);
        }
        self.starved = 0;
        true
    }

    /// What becomes of `frame` with this `counter`, where it could be read. A frame that is to be
    /// kept must be passed to [`Self::keep`].
    pub fn judge(&mut self, frame: &Frame, counter: Option<u64>, when: &When) -> Fate {
        let fate = self.judge_each(frame, counter, when);
        match fate {
            Fate::Taken | Fate::Replaces => self.dispute.note_taken(when.cycle),
            Fate::Contradicts => self.dispute.doubt(Doubt::Contradiction, when.cycle),
            Fate::Jumped => self.dispute.note_strange(when.cycle, self.has(when.cycle)),
            _ => {}
        }
        let is_taken = matches!(fate, Fate::Taken | Fate::Replaces);
        if is_taken && self.counter.as_ref().zip(counter).is_some_and(|(it, _)| !it.is_believed()) {
            self.dispute.note_uncounted(when.cycle);
        }
        fate
    }

    fn judge_each(&mut self, frame: &Frame, counter: Option<u64>, when: &When) -> Fate {
        if self.take_next(frame, counter, when) {
            return Fate::Taken;
        }
        if let (Some(alive), Some(value)) = (&self.counter, counter) {
            let count = alive.read(when.cycle, value);
            if let Some(fate) = self.judge_misfit(count, frame, value, when) {
                return fate;
            }
        }
        self.judge_by_phase(frame, counter, when)
    }

    /// Judges a counter that is not exactly one on; `None` if it says nothing.
    fn judge_misfit(
        &mut self,
        count: Count,
        frame: &Frame,
        value: u64,
        when: &When,
    ) -> Option<Fate> {
        let phase = when.phase(frame.timestamp);
        let lacks = self.filled != Some(when.cycle);
        let fate = match count {
            Count::Silent => return None,
            Count::Same if !lacks && frame.digest() != self.digest => {
                return Some(Fate::Contradicts);
            }
            Count::Same => return Some(Fate::Repeated),
            Count::Off(1) if phase >= when.half() => return Some(Fate::Held),
            Count::Off(0) if !lacks && frame.digest() != self.digest => {
                return Some(Fate::Contradicts);
            }
            Count::Off(0) if !lacks => return Some(Fate::Repeated),
            Count::Off(..=0) => Fate::Late,
            Count::Off(_) | Count::Jumped => Fate::Jumped,
        };
        let empty = lacks && when.open;
        if count != Count::Off(0)
            && let Some(alive) = &mut self.counter
            && alive.reject(when.cycle, value, empty, fate == Fate::Late)
        {
            self.take(frame, Some(value), when.cycle, phase);
            self.starved = 0;
            return Some(Fate::Taken);
        }
        (!lacks || !self.starves(when.cycle)).then_some(fate)
    }

    fn judge_by_phase(&mut self, frame: &Frame, counter: Option<u64>, when: &When) -> Fate {
        let (cycle, phase) = (when.cycle, when.phase(frame.timestamp));
        let usual = self.usual_phase();
        let copied = frame.digest() == self.digest;
        if phase < 0 && when.by_sync {
            // By its stamp it is of the cycle before, unless that has its own.
            let early = self.filled.is_some_and(|filled| filled + 1 == cycle)
                && !copied
                && phase + when.half() >= usual;
            return if early && when.open { self.taken(frame, counter, when) } else { Fate::Late };
        }
        let for_next = phase >= usual + when.half();
        if self.has(cycle) {
            if !copied && let Some(alive) = &mut self.counter {
                alive.surplus();
            }
            return if for_next && !copied { Fate::Held } else { Fate::Repeated };
        }
        if !when.open {
            let out_of_time = self.starves(cycle);
            return if out_of_time { Fate::Held } else { Fate::Late };
        }
        // As many frames as cycles without one may come at once, and the last of them is the newest.
        let lost = self.filled.map_or(0, |filled| cycle - filled - 1);
        let waiting = self.kept.as_ref().filter(|kept| kept.cycle == cycle);
        let waiting = waiting.map(|kept| (when.phase(kept.frame.timestamp), kept.before));
        let Some((waiting, before)) = waiting else {
            let may_be_late = (1..=P.latest as u64).contains(&lost) && self.usual().is_some();
            return if may_be_late { Fate::Waits } else { self.taken(frame, counter, when) };
        };
        let tolerance = self.usual().map_or(0, |usual| usual.tolerance);
        if (phase - usual).abs() <= (waiting - usual).abs() + tolerance {
            if before + 1 < lost {
                return Fate::Waits;
            }
            self.kept = None;
            self.taken(frame, counter, when);
            Fate::Replaces
        } else if for_next && !copied {
            Fate::Held
        } else {
            Fate::Settles
        }
    }

    fn taken(&mut self, frame: &Frame, counter: Option<u64>, when: &When) -> Fate {
        self.take(frame, counter, when.cycle, when.phase(frame.timestamp));
        self.starved = 0;
        Fate::Taken
    }

    fn take(&mut self, frame: &Frame, counter: Option<u64>, cycle: u64, phase: i64) {
        self.filled = Some(cycle);
        if let (Some(alive), Some(value)) = (&mut self.counter, counter) {
            alive.accept(cycle, value);
        }
        self.digest = frame.digest();
        self.phases.push(phase);
        self.usual = None;
    }

    /// Keeps a frame that waits in the newest cycle, or is held for the next.
    pub fn keep(&mut self, fate: Fate, frame: &Frame, counter: Option<u64>, when: &When) {
        let held = fate == Fate::Held;
        let sure = held && self.has(when.cycle) || self.is_next(counter, when.cycle);
        let cycle = when.cycle + u64::from(held);
        let before = self.kept.as_ref().filter(|kept| kept.cycle == cycle);
        let before = before.map_or(0, |kept| kept.before + 1);
        self.kept = Some(Kept { frame: frame.clone(), counter, cycle, sure, before });
    }

    /// Whether `counter` is that of the frame one cycle on from `cycle`.
    pub fn is_next(&self, counter: Option<u64>, cycle: u64) -> bool {
        let count = self.counter.as_ref().zip(counter);
        count.is_some_and(|(alive, value)| alive.read(cycle, value) == Count::Off(1))
    }

    /// The kept frame of the newest cycle, which is taken now; `None` if it is of another cycle, or
    /// if a better one may come while the cycle is `open`.
    pub fn settle(&mut self, when: &When, open: bool) -> Option<Frame> {
        let empty = !self.has(when.cycle);
        let due = |kept: &Kept| empty && kept.cycle == when.cycle && (kept.sure || !open);
        if !self.kept.as_ref().is_some_and(due) {
            return None;
        }
        let kept = self.kept.take()?;
        self.take(&kept.frame, kept.counter, when.cycle, when.phase(kept.frame.timestamp));
        Some(kept.frame)
    }

    /// Counts anew.
    pub fn count_anew(&mut self) {
        if let Some(alive) = &mut self.counter {
            alive.count_anew();
        }
    }

    /// Time stamp of the frame that is kept.
    pub fn kept_since(&self) -> Option<Timestamp> {
        self.kept.as_ref().map(|kept| kept.frame.timestamp)
    }

    /// Whether nothing was taken for a cycle after that of this `number`, and nothing is kept for one after the next.
    pub fn is_of_cycles_until(&self, number: u64) -> bool {
        let is_kept = |kept: &Kept| kept.cycle <= number + 1;
        self.filled.is_none_or(|cycle| cycle <= number) && self.kept.as_ref().is_none_or(is_kept)
    }

    /// Cycle of the frame that is kept.
    pub fn kept(&self) -> Option<u64> {
        self.kept.as_ref().map(|kept| kept.cycle)
    }

    /// Arrival time of the frame that surely belongs to the cycle after `cycle`.
    pub fn held_after(&self, cycle: u64) -> Option<Timestamp> {
        let held = |kept: &&Kept| kept.sure && kept.cycle == cycle + 1;
        self.kept.as_ref().filter(held).map(|kept| kept.frame.timestamp)
    }

    /// Drops the frame that is kept.
    pub fn drop_kept(&mut self) {
        self.kept = None;
    }

    /// Forgets cycles and counts, after a time jump or lost frames.
    pub fn reset(&mut self) {
        self.filled = None;
        self.kept = None;
        self.starved = 0;
        if let Some(alive) = &mut self.counter {
            alive.forget();
        }
    }

    /// Notes that nothing came in time in `cycle`; returns whether that has been so for too long.
    fn starves(&mut self, cycle: u64) -> bool {
        if self.starved == 0 || self.starved_in != cycle {
            self.starved = self.starved.saturating_add(1);
            self.starved_in = cycle;
        }
        let too_long = self.starved >= P.starved;
        if too_long && let Some(alive) = &mut self.counter {
            alive.disbelieve();
        }
        too_long
    }

    fn usual(&mut self) -> Option<Usual> {
        *self.usual.get_or_insert_with(|| self.phases.usual())
    }

    /// Usual phase, ns; the opening while it is not known.
    fn usual_phase(&mut self) -> i64 {
        self.usual().map_or(0, |usual| usual.phase)
    }
}
