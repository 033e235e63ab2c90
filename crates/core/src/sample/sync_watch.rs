//! Checks that Sync arrives once per cycle.
//!
//! Sync opens a cycle, so extra Syncs would move the cycles away from the readings. While it floods, readings open the
//! cycles, as they do when it is missing.

use super::dispute::Doubt;
use super::parameters::SyncParameters;
use crate::state::whole;
use crate::time::{Span, Timestamp};

const P: &SyncParameters = &SyncParameters::DEFAULT;

/// The cycles of a time, and those of them that had a Sync.
#[derive(Clone, Copy, Debug)]
struct SyncWindow {
    begun: Timestamp,
    /// Number of cycles that had opened when it began.
    cycles: u64,
    had: u64,
}

whole! { SyncWindow { begun, cycles, had } }

/// Follows how often Sync comes.
#[derive(Clone, Copy, Debug, Default)]
pub struct SyncWatch {
    /// Cycle of the newest Sync, and number of frames that were used up to it.
    cycle: u64,
    used: u64,
    /// Syncs of that cycle that followed another one.
    following: u32,
    /// Syncs too many lately, and the first cycle in which they are forgotten.
    extra: u32,
    forgotten_from: u64,
    window: Option<SyncWindow>,
    /// The doubt that was reported last.
    reported: Option<Doubt>,
}

whole! { SyncWatch { cycle, used, following, extra, forgotten_from, window, reported } }

/// What was found of Sync.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SyncJudgement {
    /// The doubt that is over, and the one that begins.
    pub over: Option<Doubt>,
    pub begins: Option<Doubt>,
    /// Whether a second has ended in which Sync was in doubt.
    pub was_doubted: bool,
}

impl SyncWatch {
    /// Takes a Sync in `cycle`, which is the frame of the number `used` of all that are used. Returns whether it may open
    /// a cycle.
    pub fn take(&mut self, cycle: u64, used: u64) -> bool {
        if cycle >= self.forgotten_from {
            self.extra = 0;
        }
        if cycle != self.cycle {
            self.following = 0;
            self.window.iter_mut().for_each(|it| it.had += 1);
        }
        let follows = used == self.used.saturating_add(1);
        (self.cycle, self.used) = (cycle, used);
        self.following += u32::from(follows);
        if follows && self.following > P.following {
            self.extra = self.extra.saturating_add(1);
            self.forgotten_from = cycle.saturating_add(P.remembered);
        }
        self.extra < P.flood
    }

    /// Judges at `at`, in `cycle`, up to which as many as `cycles` have opened.
    pub fn judge(&mut self, at: Timestamp, cycle: u64, cycles: u64) -> SyncJudgement {
        let fresh = SyncWindow { begun: at, cycles, had: 0 };
        let SyncWindow { begun, cycles: before, had } = *self.window.get_or_insert(fresh);
        let (has_ended, opened) =
            (at.since(begun) >= Span::from_seconds(P.window), cycles.saturating_sub(before));
        let floods = self.extra >= P.flood && cycle < self.forgotten_from;
        let doubt = match self.reported {
            _ if floods => Some(Doubt::Flood),
            Some(Doubt::Flood) => None,
            // A machine that is off has neither cycles nor Syncs.
            reported if !has_ended || opened == 0 => reported,
            _ => (2 * had < opened).then_some(Doubt::Absent),
        };
        if has_ended {
            self.window = Some(fresh);
        }
        let before = core::mem::replace(&mut self.reported, doubt);
        let [over, begins] = [before, doubt].map(|it| it.filter(|_| before != doubt));
        SyncJudgement { over, begins, was_doubted: has_ended && doubt.is_some() }
    }

    /// Forgets when what came, after a jump in time.
    pub const fn reset(&mut self) {
        (self.window, self.extra, self.following) = (None, 0, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEGINS: bool = false;
    const OVER: bool = true;

    /// Seconds of cycles with so many Syncs each behind the other frames.
    struct Bus {
        watch: SyncWatch,
        cycle: u64,
        used: u64,
        doubted_seconds: u32,
    }

    impl Bus {
        fn new() -> Self {
            Self { watch: SyncWatch::default(), cycle: 1, used: 0, doubted_seconds: 0 }
        }

        /// A second; returns what was told in it.
        fn second(&mut self, syncs: impl Fn(u64) -> u32) -> Vec<(Doubt, bool)> {
            let mut told = Vec::new();
            for _ in 0..50 {
                self.used += 21;
                for _ in 0..syncs(self.cycle) {
                    self.used += 1;
                    self.watch.take(self.cycle, self.used);
                }
                self.cycle += 1;
                if self.cycle.is_multiple_of(5) {
                    let at = Timestamp::from_nanos(self.cycle as i64 * 20_000_000);
                    let judged = self.watch.judge(at, self.cycle, self.cycle);
                    told.extend(judged.over.map(|doubt| (doubt, OVER)));
                    told.extend(judged.begins.map(|doubt| (doubt, BEGINS)));
                    self.doubted_seconds += u32::from(judged.was_doubted);
                }
            }
            told
        }
    }

    #[test]
    fn a_flood_is_told_at_once_and_is_over_a_second_after_its_end() {
        let mut bus = Bus::new();
        assert_eq!(bus.second(|_| 1), []);
        assert_eq!(bus.second(|_| 2), [], "recorded on two interfaces");
        assert_eq!(bus.second(|cycle| 1 + 18 * u32::from(cycle == 103)), [(Doubt::Flood, BEGINS)]);
        assert!(!bus.watch.take(151, bus.used), "none is believed");
        assert_eq!(bus.second(|_| 1), [(Doubt::Flood, OVER)]);
        assert!(bus.watch.take(201, bus.used));
    }

    #[test]
    fn three_in_each_cycle_are_a_flood_and_three_in_one_are_not() {
        let mut bus = Bus::new();
        assert_eq!(bus.second(|cycle| 1 + 2 * u32::from(cycle == 25)), []);
        assert_eq!(bus.second(|_| 3), [(Doubt::Flood, BEGINS)]);
    }

    /// Those of half a second at once, each with the other frames of its cycle.
    #[test]
    fn a_computer_that_stalled_is_no_flood() {
        let mut bus = Bus::new();
        bus.second(|_| 1);
        for _ in 0..25 {
            bus.used += 22;
            assert!(bus.watch.take(51, bus.used));
        }
        assert_eq!(bus.second(|_| 1), []);
    }

    #[test]
    fn cycles_without_sync_are_told_once_and_a_machine_that_is_off_is_not() {
        let mut bus = Bus::new();
        bus.second(|_| 1);
        let told: Vec<_> = (0..9).flat_map(|_| bus.second(|_| 0)).collect();
        assert_eq!(told, [(Doubt::Absent, BEGINS)]);
        assert_eq!(bus.doubted_seconds, 8);
        let told: Vec<_> = (0..2).flat_map(|_| bus.second(|_| 1)).collect();
        assert_eq!(told, [(Doubt::Absent, OVER)]);
        // No cycle opens: Sync is neither missing nor back.
        for _ in 0..3 {
            bus.second(|_| 0);
        }
        let at_rest = bus.cycle;
        for i in 0..100 {
            let at = Timestamp::from_nanos(20_000_000_000 + i * 100_000_000);
            let judged = bus.watch.judge(at, at_rest + i as u64, at_rest);
            assert_eq!((judged.over, judged.begins), (None, None));
        }
    }
}
