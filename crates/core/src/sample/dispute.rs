//! Frames of one message that cannot all be its sender's.
//!
//! A sender sends one frame in a cycle. A second one with the same count and another payload, or one whose counter fits
//! nothing beside one that fits, is somebody else's, and nobody can tell which of them is right. A frame that is too short
//! for what is configured of it lacks what would prove it, such as its alive counter.

use super::parameters::ArrivalParameters;
use crate::state::{choice, whole};

const P: &ArrivalParameters = &ArrivalParameters::DEFAULT;

/// Why the frames of a message are in doubt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doubt {
    /// They contradict each other.
    Contradiction,
    /// They are too short for the signals that are configured.
    TooShort,
    /// Their alive counter does not count, so it proves nothing.
    Uncounted,
    /// Sync arrives more often than once per cycle.
    Flood,
    /// Sync is missing in more than half of the cycles, which readings open instead.
    Absent,
    /// Another device sends frames with one of the gateway's own identifiers.
    Imitation,
}

choice! { Doubt { Contradiction, TooShort, Uncounted, Flood, Absent, Imitation } }

impl Doubt {
    /// Those of a message that carries readings.
    const OF_READINGS: [Self; 3] = [Self::Contradiction, Self::TooShort, Self::Uncounted];
}

/// Whether the frames of a place are in doubt.
#[derive(Clone, Copy, Debug)]
pub struct Dispute {
    /// First cycle that is to be treated as usual.
    usual_from: u64,
    /// First cycle that is not in doubt, for each of [`Doubt::OF_READINGS`].
    until: [u64; 3],
    /// Whether it was reported.
    reported: [bool; 3],
    /// Cycle of the newest frame whose counter fitted nothing.
    strange_in: u64,
    /// Number of such frames beside frames that fitted, and cycle of the newest.
    strange: u32,
    beside_in: u64,
    /// Frames in a row that were taken although their counter is not believed, and cycle of the newest.
    uncounted: u32,
    uncounted_in: u64,
}

whole! { Dispute { usual_from, until, reported, strange_in, strange, beside_in, uncounted, uncounted_in } }

impl Dispute {
    /// Nothing was ever in doubt.
    pub const NONE: Self = Self {
        usual_from: 0,
        until: [0; 3],
        reported: [false; 3],
        strange_in: 0,
        strange: 0,
        beside_in: 0,
        uncounted: 0,
        uncounted_in: 0,
    };

    /// Whether `cycle` has to be looked at more closely than most.
    #[inline(always)]
    pub const fn is_open(&self, cycle: u64) -> bool {
        cycle < self.usual_from
    }

    /// Whether what the frames carry is unknown in `cycle`.
    pub const fn is_unknown(&self, cycle: u64) -> bool {
        cycle < self.until[Doubt::Contradiction as usize]
    }

    /// What frames lacked of their configuration in `cycle` or shortly before; a length comes before a count.
    pub fn lacks(&self, cycle: u64) -> Option<Doubt> {
        let is_lacking = |doubt: &Doubt| cycle < self.until[*doubt as usize];
        [Doubt::TooShort, Doubt::Uncounted].into_iter().find(is_lacking)
    }

    /// Takes a reason for doubt in `cycle`.
    pub fn doubt(&mut self, doubt: Doubt, cycle: u64) {
        let until = cycle.saturating_add(P.doubted);
        self.until[doubt as usize] = until;
        // One more, in which its end is reported.
        self.usual_from = self.usual_from.max(until.saturating_add(1));
    }

    /// Takes a frame in `cycle` whose counter fits no cycle nearby; `beside` one that was taken in it.
    pub fn note_strange(&mut self, cycle: u64, beside: bool) {
        if beside {
            return self.note_beside(cycle);
        }
        self.strange_in = cycle;
        self.usual_from = self.usual_from.max(cycle.saturating_add(1));
    }

    /// Takes that a frame was taken in `cycle`.
    pub fn note_taken(&mut self, cycle: u64) {
        if self.strange_in == cycle && cycle > 0 {
            self.note_beside(cycle);
        }
    }

    /// Takes that a frame was taken in `cycle` although its counter is not believed.
    #[cold]
    pub fn note_uncounted(&mut self, cycle: u64) {
        let goes_on = cycle.saturating_sub(self.uncounted_in) <= P.in_a_row;
        self.uncounted = if goes_on { self.uncounted.saturating_add(1) } else { 1 };
        self.uncounted_in = cycle;
        if self.uncounted >= P.uncounted {
            self.doubt(Doubt::Uncounted, cycle);
        }
    }

    fn note_beside(&mut self, cycle: u64) {
        let is_near = cycle.saturating_sub(self.beside_in) < P.doubted;
        self.strange = if is_near { self.strange.saturating_add(1) } else { 1 };
        self.beside_in = cycle;
        if self.strange >= P.strange {
            self.doubt(Doubt::Contradiction, cycle);
        }
    }

    /// A doubt that changed by `cycle` and was not reported yet, and whether it is over.
    pub fn take_news(&mut self, cycle: u64) -> Option<(Doubt, bool)> {
        Doubt::OF_READINGS.into_iter().find_map(|doubt| {
            let i = doubt as usize;
            let is_doubted = cycle < self.until[i];
            let is_news = is_doubted != self.reported[i];
            self.reported[i] = is_doubted;
            is_news.then_some((doubt, !is_doubted))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_doubt_is_told_once_and_is_over_a_second_after_its_last_reason() {
        let mut dispute = Dispute::NONE;
        assert!(!dispute.is_open(10) && dispute.take_news(10).is_none());
        for cycle in 10..20 {
            dispute.doubt(Doubt::Contradiction, cycle);
            let news = (cycle == 10).then_some((Doubt::Contradiction, false));
            assert_eq!(dispute.take_news(cycle), news, "{cycle}");
        }
        for cycle in 20..69 {
            assert!(dispute.is_unknown(cycle) && dispute.take_news(cycle).is_none(), "{cycle}");
        }
        assert!(dispute.is_open(69) && !dispute.is_unknown(69));
        assert_eq!(dispute.take_news(69), Some((Doubt::Contradiction, true)));
        assert!(!dispute.is_open(70) && dispute.take_news(70).is_none());
        dispute.doubt(Doubt::TooShort, 80);
        assert!(dispute.is_open(80) && !dispute.is_unknown(80), "whole frames are what they are");
        assert_eq!(dispute.take_news(80), Some((Doubt::TooShort, false)));
        assert_eq!([129, 130].map(|cycle| dispute.lacks(cycle)), [Some(Doubt::TooShort), None]);
    }

    #[test]
    fn a_counter_that_is_not_believed_for_a_second_is_told() {
        let mut dispute = Dispute::NONE;
        (100..149).for_each(|cycle| dispute.note_uncounted(cycle));
        assert!(dispute.take_news(148).is_none());
        dispute.note_uncounted(149);
        assert_eq!(dispute.take_news(149), Some((Doubt::Uncounted, false)));
        assert!(!dispute.is_unknown(149), "its time says of which cycle it is");
        assert_eq!([198, 199].map(|cycle| dispute.lacks(cycle)), [Some(Doubt::Uncounted), None]);
        dispute.doubt(Doubt::TooShort, 150);
        assert_eq!(dispute.lacks(198), Some(Doubt::TooShort), "what is left out comes first");
        // A sender that starts anew now and then.
        let mut dispute = Dispute::NONE;
        for cycle in (0..10_000).filter(|cycle| cycle % 100 < 16) {
            dispute.note_uncounted(cycle);
            assert!(dispute.take_news(cycle).is_none(), "{cycle}");
        }
    }

    #[test]
    fn counters_that_fit_nothing_are_no_accident_from_the_third_on() {
        let mut dispute = Dispute::NONE;
        for (cycle, unknown) in [(100, false), (101, false), (102, true)] {
            dispute.note_strange(cycle, false);
            assert!(dispute.is_open(cycle), "the next frame is looked at");
            dispute.note_taken(cycle);
            assert_eq!(dispute.is_unknown(cycle), unknown, "{cycle}");
        }
        // Alone in its cycle, or long after the one before, it is a sender that starts anew.
        let mut dispute = Dispute::NONE;
        for cycle in [100, 101, 102, 200, 300, 400] {
            dispute.note_strange(cycle, cycle >= 200);
            dispute.note_taken(cycle + 1);
            assert!(!dispute.is_unknown(cycle), "{cycle}");
        }
    }
}
