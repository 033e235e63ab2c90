//! Opening and closing of cycles, by time stamps, and by alive counters where these disagree.
//!
//! Sync opens a cycle where it is configured and comes; otherwise the first transducer frame about a sample
//! time after the last opening does. Readings come first and the command that answers them follows,
//! so a valve frame never opens a cycle. It closes a deadline after its opening. When the deadline
//! of the next cycle passes without an opening, that cycle is missing. Where nothing opens a cycle from the beginning,
//! commands show that the machine runs: after some of them cycles are missing, too.
//!
//! Cycles are numbered on a grid of sample times that follows the openings slowly. An early or late
//! opening, as on a computer that stalls and then receives all waiting frames at once, neither
//! counts twice nor hides the next one. With Sync, a cycle opens when Sync came; without it, the
//! grid determines the time.

use super::parameters::SyncParameters;
pub use super::when::When;
use crate::state::state;
use crate::time::{Span, Timestamp};

const P: &SyncParameters = &SyncParameters::DEFAULT;

/// Sample time and deadline of the cycles.
#[derive(Clone, Copy, Debug)]
pub struct CycleTiming {
    /// Sample time Ts.
    pub sample_time: Span,
    /// Time from the opening to the closing, less than Ts.
    pub deadline: Span,
    /// Whether a Sync message opens cycles.
    pub synchronised: bool,
}

/// What opens a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opener {
    Sync,
    /// A reading, by its time.
    Reading,
    /// A reading whose alive counter says that it is one cycle on from the newest, whatever its time says.
    NextReading,
}

/// Time at which the cycle changes without a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Due {
    /// The open cycle closes.
    Close(Timestamp),
    /// A whole cycle has passed without an opening.
    Missing(Timestamp),
}

impl Due {
    pub const fn at(self) -> Timestamp {
        match self {
            Self::Close(at) | Self::Missing(at) => at,
        }
    }
}

/// The clock of the machine's cycles.
#[derive(Clone, Debug)]
pub struct CycleClock {
    timing: CycleTiming,
    /// Opening of the newest cycle, real or missing.
    opened: Option<Timestamp>,
    /// Place of the opening on the grid; equal to `opened` without Sync.
    nominal: Option<Timestamp>,
    open: bool,
    /// Whether the newest cycle may have been opened by something other than its Sync, although
    /// Sync is configured: by a reading, or by an early Sync, which may be a late one of the
    /// previous cycle.
    provisional: bool,
    number: u64,
    /// Number of openings that the grid has followed, up to [`SyncParameters::slowness`].
    followed: i64,
    /// Sync of the newest cycle's time that came after readings of that cycle.
    set_aside: Option<Timestamp>,
    /// Number of cycles that opened since the newest Sync, up to [`SyncParameters::absent`].
    without_sync: u32,
    /// The first command for which there is no cycle, since none has opened yet.
    awaited: Option<Timestamp>,
    /// Whether the next cycle may open at once, since the time stamps are behind the frames: those of several cycles
    /// come together, or the clock was set back.
    at_once: bool,
}

state! {
    CycleClock { opened, nominal, open, provisional, number, followed, set_aside, without_sync, awaited, at_once }
    but { timing }
    sound |it| (0..=P.slowness).contains(&it.followed) && it.without_sync <= P.absent
}

impl CycleClock {
    pub fn new(timing: CycleTiming) -> Self {
        Self {
            timing,
            opened: None,
            nominal: None,
            open: false,
            provisional: false,
            number: 0,
            followed: 0,
            set_aside: None,
            without_sync: 0,
            awaited: None,
            at_once: false,
        }
    }

    /// Sample time Ts.
    pub const fn sample_time(&self) -> Span {
        self.timing.sample_time
    }

    /// Number of the newest cycle, counting missing ones.
    pub const fn number(&self) -> u64 {
        self.number
    }

    /// Opening of the newest cycle.
    pub const fn opened(&self) -> Option<Timestamp> {
        self.opened
    }

    /// Times that it knows: of the newest opening, by its frame and on the grid, of a Sync that may open the next one, and
    /// of a command that waits for the first one.
    pub fn times(&self) -> impl Iterator<Item = Timestamp> {
        [self.opened, self.nominal, self.set_aside, self.awaited].into_iter().flatten()
    }

    pub const fn is_open(&self) -> bool {
        self.open
    }

    /// The next change that time alone causes; `None` before the first cycle.
    pub fn due(&self) -> Option<Due> {
        let opened = self.opened?;
        let closing = opened.after(self.timing.deadline);
        Some(if self.open {
            Due::Close(closing)
        } else {
            Due::Missing(closing.after(self.timing.sample_time))
        })
    }

    /// Number of consecutive cycles missing before `now`, if nothing opens.
    pub fn missing_until(&self, now: Timestamp) -> u64 {
        let Some(Due::Missing(first)) = self.due() else { return 0 };
        let beyond = now.since(first).as_nanos();
        let more = beyond.saturating_sub(1) / self.timing.sample_time.as_nanos();
        if beyond > 0 { more as u64 + 1 } else { 0 }
    }

    /// Notes that the open cycle has closed.
    pub fn close(&mut self) {
        self.open = false;
    }

    /// Skips `count` cycles in which nothing opened.
    pub fn skip(&mut self, count: u64) {
        let nanos = self.timing.sample_time.as_nanos().saturating_mul(count as i64);
        let later = |at: Timestamp| at.after(Span::from_nanos(nanos));
        self.opened = self.opened.map(later);
        self.nominal = self.nominal.map(later);
        self.number += count;
        self.open = false;
    }

    /// Whether a Sync at `at` belongs to a cycle that something else has opened in its place. The
    /// cycle then begins with the Sync.
    pub fn confirms(&mut self, at: Timestamp) -> bool {
        let (Some(opened), Some(beside)) = (self.since_opening(at), self.beyond_nominal(at)) else {
            return false;
        };
        let near = opened.as_nanos().abs() < self.half().as_nanos() && beside >= -self.early();
        let confirms = self.provisional && near;
        if confirms {
            self.provisional = false;
            self.without_sync = 0;
            self.opened = Some(at);
            self.follow(beside);
        }
        confirms
    }

    /// Whether a Sync at `at` that confirms nothing repeats that of the newest cycle, as where a
    /// bus is recorded on two interfaces, or is late: the next one comes no earlier than three
    /// quarters of a sample time after the place of this one on the grid.
    pub fn has_had_sync(&self, at: Timestamp) -> bool {
        let soon = self.timing.sample_time.as_nanos() - self.quarter();
        self.beyond_nominal(at).is_some_and(|elapsed| elapsed < soon)
    }

    /// Sets a Sync at `at` aside that [was had](Self::has_had_sync) by its time, but came after readings of the newest
    /// cycle: where the clock behind the stamps was set back, or a delay has ended, it is the next one. Another one that was
    /// set aside must have been [taken](Self::take_set_aside) before.
    pub const fn set_aside(&mut self, at: Timestamp) {
        self.set_aside = Some(at);
    }

    /// The Sync that was [set aside](Self::set_aside) in the newest cycle.
    #[inline]
    pub const fn sync_set_aside(&self) -> Option<Timestamp> {
        self.set_aside
    }

    /// The same, which is set aside no longer.
    #[inline]
    pub const fn take_set_aside(&mut self) -> Option<Timestamp> {
        self.set_aside.take()
    }

    /// The newest cycle, as frames find it; `None` before the first one.
    #[inline]
    pub fn when(&self) -> Option<When> {
        Some(When {
            cycle: self.number,
            opened: self.opened?,
            open: self.open,
            by_sync: self.timing.synchronised && !self.provisional,
            sample_time: self.timing.sample_time,
        })
    }

    /// Whether a transducer frame at `at` could open the next cycle by its time; `has` if its place
    /// has had a frame in the newest one.
    #[inline]
    pub fn could_open(&self, at: Timestamp, has: bool) -> bool {
        let Some(elapsed) = self.beyond_nominal(at) else { return true };
        if self.is_synchronised() {
            // Sync was lost: only a reading about one sample time later may stand in for it.
            (has || !self.open) && elapsed >= self.earliest_without_sync()
        } else {
            !self.open && elapsed >= self.half().as_nanos()
        }
    }

    /// Takes a command at `at` that finds no cycle; returns whether cycles are missing from here on, since the first one has
    /// not opened for [`SyncParameters::awaited`].
    pub fn wait(&mut self, at: Timestamp) -> bool {
        let awaited = *self.awaited.get_or_insert(at);
        let patience = self.timing.sample_time.as_nanos().saturating_mul(P.awaited.into());
        let is_missing = self.opened.is_none() && at.since(awaited).as_nanos() >= patience;
        if is_missing {
            (self.opened, self.nominal) = (Some(at), Some(at));
        }
        is_missing
    }

    /// Whether readings open cycles, so that an early one opens its cycle when the previous one has
    /// closed.
    pub const fn is_opened_by_readings(&self) -> bool {
        !self.is_synchronised()
    }

    /// Whether Sync opens cycles: it is configured, and comes.
    const fn is_synchronised(&self) -> bool {
        self.timing.synchronised && self.without_sync < P.absent
    }

    /// Takes that no Sync can be relied on: readings open cycles until one comes that can.
    pub const fn lose_sync(&mut self) {
        self.without_sync = P.absent;
    }

    /// Notes that a time stamp is before that of the frame before it: the clock was set back by that and the time between
    /// the two, or the frames are out of order.
    pub const fn step_back(&mut self) {
        self.at_once = true;
    }

    /// Whether a reading that is one cycle on opens that cycle, whatever its time says.
    pub const fn may_open_at_once(&self) -> bool {
        self.at_once && self.is_opened_by_readings()
    }

    /// Number of cycles missing between the newest one and an opening at `at`.
    pub fn missing_before(&self, at: Timestamp, opener: Opener) -> u64 {
        if opener == Opener::NextReading { 0 } else { self.passed_before(at) }
    }

    /// Number of cycles that have passed since the newest one by the time `at`.
    fn passed_before(&self, at: Timestamp) -> u64 {
        let Some(elapsed) = self.beyond_nominal(at) else { return 0 };
        let period = self.timing.sample_time.as_nanos();
        // Sync comes late more often than it is lost, and hardly early.
        let early = if self.is_synchronised() { self.quarter() } else { period / 2 };
        let cycles = elapsed.saturating_add(early) / period;
        (cycles.max(1) - 1) as u64
    }

    /// Opens the next cycle for a frame at `at`, after [`Self::skip`] of those missing.
    pub fn open(&mut self, at: Timestamp, opener: Opener) {
        let by_sync = opener == Opener::Sync;
        self.at_once = opener == Opener::NextReading && self.passed_before(at) > 0;
        let beside = self.beside(at);
        let early = beside.is_some_and(|beside| beside < -self.early());
        self.without_sync = if by_sync { 0 } else { (self.without_sync + 1).min(P.absent) };
        self.provisional = self.timing.synchronised && (!by_sync || early);
        match (self.nominal, beside) {
            (Some(nominal), Some(beside)) => {
                self.nominal = Some(nominal.after(self.timing.sample_time));
                self.follow(beside);
            }
            _ => {
                self.followed = 0;
                self.nominal = Some(at);
            }
        }
        self.opened = if by_sync { Some(at) } else { self.nominal };
        self.open = true;
        self.number += 1;
    }

    /// Deviation of an opening at `at` from the grid, ns; `None` if it begins a new grid.
    fn beside(&self, at: Timestamp) -> Option<i64> {
        let beside = self.beyond_nominal(at)? - self.timing.sample_time.as_nanos();
        (beside.abs() <= self.farthest()).then_some(beside)
    }

    /// Moves the grid towards an opening that deviates by `beside`, ns.
    fn follow(&mut self, beside: i64) {
        self.followed = (self.followed + 1).min(P.slowness);
        let slowness = if self.is_opened_by_readings() {
            self.followed
        } else if self.provisional {
            // It tells nothing of where Sync would have been.
            P.slowness
        } else if beside < 0 {
            // What holds a Sync up makes it late, never early.
            1
        } else {
            self.followed
        };
        self.nominal =
            self.nominal.map(|nominal| nominal.after(Span::from_nanos(beside / slowness)));
    }

    /// Forgets the phase, after a jump in time.
    pub fn reset(&mut self) {
        self.opened = None;
        self.nominal = None;
        self.open = false;
        self.provisional = false;
        self.followed = 0;
        self.set_aside = None;
        self.awaited = None;
        self.at_once = false;
    }

    fn since_opening(&self, at: Timestamp) -> Option<Span> {
        self.opened.map(|opened| at.since(opened))
    }

    /// Time since the place on the grid, ns.
    fn beyond_nominal(&self, at: Timestamp) -> Option<i64> {
        self.nominal.map(|nominal| at.since(nominal).as_nanos())
    }

    /// Deviation from the grid beyond which an opening begins a new one, ns.
    const fn farthest(&self) -> i64 {
        let period = self.timing.sample_time.as_nanos();
        if self.is_synchronised() { period - self.quarter() } else { period / 2 }
    }

    /// Earliness beyond which a frame may be something else, ns.
    const fn early(&self) -> i64 {
        self.timing.sample_time.as_nanos() / 20
    }

    const fn quarter(&self) -> i64 {
        self.timing.sample_time.as_nanos() / 4
    }

    fn half(&self) -> Span {
        Span::from_nanos(self.timing.sample_time.as_nanos() / 2)
    }

    /// Earliness beyond which a reading cannot stand in for Sync, ns: readings follow Sync, so an
    /// earlier one is a late one of the previous cycle, apart from some jitter.
    const fn earliest_without_sync(&self) -> i64 {
        self.timing.sample_time.as_nanos() - self.early()
    }
}
