//! The time scale of learning: the recordings' own time, with long pauses shortened.

use super::Window;
use super::ranking::{PAUSE, Ranking, Stretch};
use tertius_core::frame::Frame;
use tertius_core::time::{Span, Timestamp};

/// Length to which longer pauses are shortened: nothing is learnt from them, and alternating blocks
/// must not fall into them.
pub const LONGEST_PAUSE: Span = Span::from_nanos(LONGEST);
const LONGEST: i64 = 60_000_000_000;

/// Time stamps of frames, and their places on a time scale in which long pauses are shortened to a
/// minute. Without a long pause every place is the time stamp itself.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Timeline {
    /// The first time stamp and the latest.
    ends: Option<(Timestamp, Timestamp)>,
    /// Long pauses, in order.
    pauses: Vec<Pause>,
    /// Parts between the pauses, long or not, in order.
    stretches: Vec<Stretch>,
}

/// A long pause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Pause {
    /// Time stamp from which frames are behind the pause: frames may be slightly out of order, so
    /// this is half a minute after the latest frame before.
    from: Timestamp,
    /// Time subtracted before the pause, and behind it.
    off: [Span; 2],
}

impl Timeline {
    /// A timeline of frames between these time stamps, without a long pause.
    pub fn unbroken(first: Timestamp, last: Timestamp) -> Self {
        let mut timeline = Self::default();
        timeline.span(first, last);
        timeline
    }

    /// Adds frames between these time stamps, without a pause.
    pub fn span(&mut self, first: Timestamp, last: Timestamp) {
        self.take(first);
        self.ends = self.ends.map(|(begin, end)| (begin, end.max(last)));
        self.stretch(last);
    }

    /// Takes the time stamp of the next frame.
    pub fn take(&mut self, at: Timestamp) {
        let Some((first, last)) = self.ends else {
            self.ends = Some((at, at));
            self.stretches.push(Stretch::new(at));
            return;
        };
        let ahead = at.since(last).as_nanos();
        if Self::is_pause(at.since(last)) {
            self.stretches.push(Stretch::new(at));
        }
        self.stretch(at);
        if ahead > LONGEST {
            let before = self.off(last);
            let behind = before.as_nanos().saturating_add(ahead - LONGEST);
            let from = last.after(Span::from_nanos(LONGEST / 2));
            self.pauses.push(Pause { from, off: [before, Span::from_nanos(behind)] });
        }
        self.ends = Some((first, last.max(at)));
    }

    /// Takes the content of the newest frame, if the configuration reads it: the stretches of a
    /// recording are ranked by their contents.
    pub fn read(&mut self, frame: &Frame) {
        if let Some(newest) = self.stretches.last_mut() {
            newest.read(frame);
        }
    }

    /// Extends the newest stretch.
    fn stretch(&mut self, at: Timestamp) {
        if let Some(newest) = self.stretches.last_mut() {
            newest.ends[1] = newest.ends[1].max(at);
        }
    }

    /// Whether a place that is `ahead` of the latest frame's place is behind a pause: nothing is
    /// then known of the time before, however short a long pause has become.
    pub const fn is_pause(ahead: Span) -> bool {
        ahead.as_nanos() >= PAUSE.as_nanos()
    }

    /// The stretches between the pauses, ranked by their contents.
    pub fn ranking(&self) -> Ranking {
        let begin = |stretch: &Stretch| (self.seconds(stretch.ends[0]), *stretch);
        Ranking::new(&self.stretches.iter().map(begin).collect::<Vec<_>>())
    }

    /// The first time stamp and the latest; `None` before a frame.
    pub const fn ends(&self) -> Option<(Timestamp, Timestamp)> {
        self.ends
    }

    /// The place of a frame with this time stamp.
    pub fn place(&self, at: Timestamp) -> Timestamp {
        at.after(Span::from_nanos(-self.off(at).as_nanos()))
    }

    /// The place of a frame with this time stamp, seconds since the first frame.
    pub fn seconds(&self, at: Timestamp) -> f64 {
        self.place(at).since(self.first()).as_seconds()
    }

    /// The time stamp `t` seconds after the first frame.
    pub fn at(&self, t: f64) -> Timestamp {
        let placed = self.first().after(Span::from_seconds(t));
        let behind = |pause: &&Pause| placed.after(pause.off[0]) >= pause.from;
        placed.after(self.pauses.iter().rfind(behind).map_or(Span::ZERO, |pause| pause.off[1]))
    }

    /// Length from the first frame to the last, s.
    pub fn length(&self) -> f64 {
        self.ends.map_or(0.0, |(_, last)| self.seconds(last))
    }

    /// Recorded time within `window`, s: without the pauses of [`PAUSE`] or more, between which nothing was recorded.
    pub fn recorded(&self, window: Window) -> f64 {
        let within = |stretch: &Stretch| {
            let [from, to] = stretch.ends.map(|end| self.seconds(end));
            (to.min(window.to) - from.max(window.from)).max(0.0)
        };
        self.stretches.iter().map(within).sum()
    }

    /// Remarks on the pauses; empty without any.
    pub fn remarks(&self) -> Vec<String> {
        let told = self.pauses.iter().map(|Pause { from, off: [before, behind] }| {
            let taken = behind.as_nanos() - before.as_nanos();
            let last = from.after(Span::from_nanos(-LONGEST / 2 - before.as_nanos()));
            format!(
                "the pause of {:.1} h after {:.1} s counts as a minute in times since the first frame",
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
    fn pauses_are_no_recorded_time() {
        let mut timeline = of(&[0]);
        timeline.span(at(0), at(1200));
        timeline.span(at(86_400), at(87_600));
        assert_eq!(timeline.length(), 2460.0);
        assert_eq!(timeline.recorded(Window::ALL), 2400.0);
        assert_eq!(timeline.recorded(Window { from: 600.0, to: 1300.0 }), 640.0);
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
