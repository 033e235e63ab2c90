//! The time that learning counts in: the recordings' own, with the long pauses between them shortened.

use tertius_core::time::{Span, Timestamp};

/// A pause that is longer counts as this long: nobody learns from it, and blocks that alternate must not fall
/// into it.
pub const LONGEST_PAUSE: Span = Span::from_nanos(LONGEST);
const LONGEST: i64 = 60_000_000_000;

/// The time stamps of frames, and where each is when long pauses are shortened to a minute. Without a long
/// pause every place is the time stamp itself.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Timeline {
    /// The first time stamp and the latest.
    ends: Option<(Timestamp, Timestamp)>,
    /// In order.
    pauses: Vec<Pause>,
}

/// A long pause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Pause {
    /// What is stamped later is behind it: frames may be a little out of order, so this is half a minute
    /// after the latest one before.
    from: Timestamp,
    /// What is taken off before it, and behind it.
    off: [Span; 2],
}

impl Timeline {
    /// Of frames between these time stamps, without a long pause.
    pub fn unbroken(first: Timestamp, last: Timestamp) -> Self {
        Self { ends: Some((first, last)), pauses: Vec::new() }
    }

    /// Takes frames between these time stamps, without a long pause.
    pub fn span(&mut self, first: Timestamp, last: Timestamp) {
        self.take(first);
        self.ends = self.ends.map(|(begin, end)| (begin, end.max(last)));
    }

    /// Takes the time stamp of the next frame.
    pub fn take(&mut self, at: Timestamp) {
        let Some((first, last)) = self.ends else {
            self.ends = Some((at, at));
            return;
        };
        let ahead = at.since(last).as_nanos();
        if ahead > LONGEST {
            let before = self.off(last);
            let behind = before.as_nanos().saturating_add(ahead - LONGEST);
            let from = last.after(Span::from_nanos(LONGEST / 2));
            self.pauses.push(Pause { from, off: [before, Span::from_nanos(behind)] });
        }
        self.ends = Some((first, last.max(at)));
    }

    /// Whether what is `ahead` of the latest frame, as both are placed, is behind a long pause: then
    /// nothing is known any more of what was before, however short the pause has become.
    pub const fn is_pause(ahead: Span) -> bool {
        ahead.as_nanos() >= LONGEST
    }

    /// The first time stamp and the latest; `None` before a frame.
    pub const fn ends(&self) -> Option<(Timestamp, Timestamp)> {
        self.ends
    }

    /// Where a frame of this time stamp is.
    pub fn place(&self, at: Timestamp) -> Timestamp {
        at.after(Span::from_nanos(-self.off(at).as_nanos()))
    }

    /// The same in seconds since the first frame.
    pub fn seconds(&self, at: Timestamp) -> f64 {
        self.place(at).since(self.first()).as_seconds()
    }

    /// The time stamp of what is `t` seconds after the first frame.
    pub fn at(&self, t: f64) -> Timestamp {
        let placed = self.first().after(Span::from_seconds(t));
        let behind = |pause: &&Pause| placed.after(pause.off[0]) >= pause.from;
        placed.after(self.pauses.iter().rfind(behind).map_or(Span::ZERO, |pause| pause.off[1]))
    }

    /// From the first frame to the last, s.
    pub fn length(&self) -> f64 {
        self.ends.map_or(0.0, |(_, last)| self.seconds(last))
    }

    /// What is to be said of the pauses, for people; empty without any.
    pub fn remarks(&self) -> Vec<String> {
        let told = self.pauses.iter().map(|Pause { from, off: [before, behind] }| {
            let taken = behind.as_nanos() - before.as_nanos();
            let last = from.after(Span::from_nanos(-LONGEST / 2 - before.as_nanos()));
            format!(
                "the pause of {:.1} h after {:.1} s counts as a minute in all times that are told here",
                Span::from_nanos(taken + LONGEST).as_seconds() / 3600.0,
                last.since(self.first()).as_seconds()
            )
        });
        told.collect()
    }

    /// The first time stamp; the epoch before a frame.
    pub fn first(&self) -> Timestamp {
        self.ends.map_or(Timestamp::default(), |(first, _)| first)
    }

    fn off(&self, at: Timestamp) -> Span {
        let behind = self.pauses.partition_point(|pause| pause.from <= at);
        behind.checked_sub(1).map_or(Span::ZERO, |pause| self.pauses[pause].off[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: i64) -> Timestamp {
        Timestamp::from_nanos(1_700_000_000_000_000_000 + seconds * 1_000_000_000)
    }

    fn of(stamps: &[i64]) -> Timeline {
        let mut timeline = Timeline::default();
        stamps.iter().for_each(|seconds| timeline.take(at(*seconds)));
        timeline
    }

    #[test]
    fn long_pauses_are_a_minute_and_short_ones_what_they_are() {
        let timeline = of(&[0, 50, 110, 86_400, 86_450, 200_000]);
        for (stamp, place) in [(0, 0), (110, 110), (86_400, 170), (86_450, 220), (200_000, 280)] {
            assert_eq!(timeline.place(at(stamp)), at(place), "{stamp}");
            assert_eq!(timeline.at(place as f64), at(stamp), "{place}");
        }
        // Out of order by a little, behind the pause.
        assert_eq!(timeline.place(at(86_399)), at(169));
        assert_eq!(timeline.length(), 280.0);
        let told = timeline.remarks();
        assert!(told[0].starts_with("the pause of 24.0 h after 110.0 s "), "{told:?}");
        assert!(told[1].contains("after 220.0 s "), "{told:?}");
    }

    #[test]
    fn days_without_a_pause_are_as_long_as_they_are() {
        let mut timeline = Timeline::unbroken(at(0), at(900));
        timeline.span(at(86_400), at(87_300));
        assert_eq!(timeline.seconds(at(87_300)), 1860.0);
        assert_eq!(timeline.length(), 1860.0);
    }

    #[test]
    fn without_a_long_pause_nothing_moves() {
        let timeline = of(&[0, 60, 120, 100, 150]);
        assert!((0..150).all(|t| timeline.place(at(t)) == at(t) && timeline.at(t as f64) == at(t)));
        assert!(timeline.remarks().is_empty());
    }
}
