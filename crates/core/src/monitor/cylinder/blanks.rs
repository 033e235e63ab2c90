//! When the observers of a cylinder did not judge, and why: no warning is good news only where there was
//! judgement.

use crate::sample::Transducer;
use crate::state::{choice, whole};
use crate::time::Timestamp;

/// Longest blanks that are kept of each transducer.
const KEPT: usize = 4;

/// Why the observer of a transducer did not judge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum NotJudged {
    /// The platform was in no monitored state.
    State,
    /// Its readings did not come.
    NoReadings,
    /// Its frames could not be relied on.
    Doubtful,
    /// Its readings did not pass the plausibility checks.
    Implausible,
    NoCommand,
    /// The observer had not settled, at the beginning or after a gap.
    Settling,
    /// The sequential detector, by which alone it is judged, had no baseline or not enough samples.
    NoBaseline,
}

choice! { NotJudged { State, NoReadings, Doubtful, Implausible, NoCommand, Settling, NoBaseline } }

/// A time in which the observer of a transducer did not judge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Blank {
    pub transducer: Transducer,
    /// Opening of the first cycle that it did not judge.
    pub from: Timestamp,
    /// Opening of the first cycle that it judged again, or the newest time.
    pub until: Timestamp,
    /// Why it stopped judging.
    pub reason: NotJudged,
}

whole! { Blank { transducer, from, until, reason } }

/// The longest blanks of a cylinder.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blanks {
    /// Whether each observer judged in the newest cycle. Before the first one it counts as if they did, so that a
    /// blank begins with it.
    judged: [bool; 2],
    open: [Option<Begun>; 2],
    longest: [[Option<Blank>; KEPT]; 2],
    /// Cycles in the blanks that are over.
    cycles: [u64; 2],
}

whole! { Blanks { judged, open, longest, cycles } }

/// A blank that lasts.
#[derive(Clone, Copy, Debug)]
struct Begun {
    from: Timestamp,
    /// Number of cycles of the cylinder before it.
    before: u64,
    reason: NotJudged,
}

whole! { Begun { from, before, reason } }

impl Default for Blanks {
    fn default() -> Self {
        Self { judged: [true; 2], open: [None; 2], longest: Default::default(), cycles: [0; 2] }
    }
}

impl Blanks {
    /// Ends the blank of the transducer of index `i` before the cycle that opens at `until`, the cylinder having
    /// had `cycles` before that.
    fn end(&mut self, i: usize, until: Timestamp, cycles: u64) {
        let Some(Begun { from, before, reason }) = self.open[i].take() else { return };
        self.cycles[i] += cycles - before;
        let blank = Blank { transducer: Transducer::ALL[i], from, until, reason };
        let length = |blank: &Option<Blank>| blank.map(|it| it.until.since(it.from));
        // The shortest gives way; a free place is shorter than any.
        let shortest = self.longest[i].iter_mut().min_by_key(|blank| length(blank));
        if let Some(place) = shortest.filter(|place| length(place) < length(&Some(blank))) {
            *place = Some(blank);
        }
    }

    /// Forgets those that are over; those that go on are counted from here.
    pub fn count_anew(&mut self) {
        (self.longest, self.cycles) = Default::default();
        self.open.iter_mut().flatten().for_each(|begun| begun.before = 0);
    }

    /// Whether each that is open began within the first `cycles` cycles.
    pub fn begin_before(&self, cycles: u64) -> bool {
        self.open.iter().flatten().all(|begun| begun.before <= cycles)
    }

    /// Whether the observers judge as in the cycle before.
    #[inline]
    pub fn goes_on(&self, judged: [bool; 2]) -> bool {
        self.judged == judged
    }

    /// Ends at `last` the blanks that are open, since time continues elsewhere.
    pub fn interrupt(&mut self, last: Timestamp, cycles: u64) {
        (0..2).for_each(|i| self.end(i, last, cycles));
        self.judged = [true; 2];
    }

    /// Takes that a transducer is judged again at `opened`, or no more, and then for which reason. The cylinder has had
    /// `before` cycles before this one.
    pub fn change(
        &mut self,
        judged: [bool; 2],
        opened: Timestamp,
        before: u64,
        reasons: [Option<NotJudged>; 2],
    ) {
        for (i, judged) in judged.into_iter().enumerate() {
            if judged {
                self.end(i, opened, before);
            } else if self.open[i].is_none() {
                let begin = |reason| Begun { from: opened, before, reason };
                self.open[i] = reasons[i].map(begin);
            }
        }
        self.judged = judged;
    }

    /// The longest ones, those that last until `newest` among them.
    pub fn longest(&self, newest: Timestamp) -> impl Iterator<Item = Blank> {
        let lasting =
            Transducer::ALL.into_iter().zip(&self.open).filter_map(move |(transducer, open)| {
                let Begun { from, reason, .. } = (*open)?;
                Some(Blank { transducer, from, until: newest, reason })
            });
        self.longest.iter().flatten().flatten().copied().chain(lasting)
    }

    /// Cycles in them of transducer `i`, the cylinder having had `cycles` of them.
    pub fn count(&self, i: usize, cycles: u64) -> u64 {
        self.cycles[i] + self.open[i].map_or(0, |open| cycles - open.before)
    }
}
