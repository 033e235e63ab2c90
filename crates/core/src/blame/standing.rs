//! Which reading stands, or does not come, while a detector is raised.
//!
//! That is a fact. Meanwhile the other reading moves on with the rod. If the model of the rod is not exact, or the machine's
//! controller uses the reading that stands, the observer of the healthy one disagrees first, and Figure 5-17 would blame that
//! one. Every detector that is raised while a reading stands therefore keeps which one it is, until its warning clears.

use super::parameters::BlameParameters;
use super::proposal::Accuser;
use crate::sample::Transducer;
use crate::state::{state, whole};
use crate::verdict::Fault;

const ACCUSERS: usize = Accuser::ALL.len();

/// How a transducer reads in a cycle.
#[derive(Clone, Copy, Debug, Default)]
pub struct ReadingState {
    /// Present finding of the plausibility checks.
    pub known: Option<Fault>,
    /// Whether its reading stands while the other one moves.
    pub alone: bool,
    /// Cycles without a new reading.
    pub idle: u32,
}

/// The transducer whose reading stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Culprit {
    transducer: Transducer,
    /// Whether the plausibility checks have also found it.
    known: bool,
}

whole! { Culprit { transducer, known } }

/// The reading that stands, for each detector.
#[derive(Clone, Copy, Debug)]
pub struct StandingReadings {
    /// Number of cycles before a reading stops in which a detector may already have seen the fault
    /// that a plausibility check finds later.
    before: u32,
    /// [`BlameParameters::stood`] and [`BlameParameters::awaited`] in cycles.
    stood: u32,
    awaited_for: u32,
    culprits: [Option<Culprit>; ACCUSERS],
    /// Cycles since each detector was raised.
    ages: [Option<u32>; ACCUSERS],
    /// The transducer that stood when FDE3 was raised, while its fault is not yet decided.
    awaited: Option<Transducer>,
}

state! {
    StandingReadings { culprits, ages, awaited }
    but { before, stood, awaited_for }
}

impl StandingReadings {
    /// Where findings within `coincidence` cycles of `sample_time` seconds are one event.
    pub fn new(coincidence: u32, parameters: &BlameParameters, sample_time: f64) -> Self {
        let [stood, awaited_for] = parameters.samples(sample_time);
        Self {
            before: coincidence,
            stood,
            awaited_for,
            culprits: Default::default(),
            ages: Default::default(),
            awaited: None,
        }
    }

    /// Takes a cycle in which no detector is raised.
    #[inline]
    pub fn rest(&mut self) {
        (self.ages, self.culprits, self.awaited) = Default::default();
    }

    /// Takes a cycle: the detectors that are raised, in the order of [`Accuser::ALL`], and how C1 and C2 read.
    pub fn follow(&mut self, raised: [bool; ACCUSERS], readings: [ReadingState; 2]) {
        for (k, raised) in raised.into_iter().enumerate() {
            if !raised {
                (self.culprits[k], self.ages[k]) = (None, None);
                continue;
            }
            let age = self.ages[k].map_or(0, |age| age.saturating_add(1));
            self.ages[k] = Some(age);
            let met = |one: &ReadingState| age <= one.idle.saturating_add(self.before);
            let newest = only(readings.map(|one| met(&one) && (one.known.is_some() || one.alone)));
            let newest = newest.map(|transducer| Culprit {
                transducer,
                known: readings[transducer as usize].known.is_some(),
            });
            self.culprits[k] = match (self.culprits[k], newest) {
                (Some(old), Some(new)) if new.known && !old.known => Some(new),
                (None, new) => new,
                (old, _) => old,
            };
        }
        self.awaited = self.ages[Accuser::Fde3 as usize].and_then(|age| {
            let since_before = |one: ReadingState| one.idle >= age.saturating_add(self.stood);
            let just = |one: ReadingState| age < self.awaited_for && one.idle >= self.stood;
            only(readings.map(since_before)).or_else(|| only(readings.map(just)))
        });
    }

    /// Forgets which reading stood after a time jump: as with R3, that does not outlast a time of which nothing is known.
    pub fn interrupt(&mut self) {
        self.culprits = Default::default();
        self.awaited = None;
    }

    /// The transducer whose reading stood, as the plausibility checks have found, while `accuser` was raised.
    pub fn known(&self, accuser: Accuser) -> Option<Transducer> {
        self.culprits[accuser as usize].filter(|it| it.known).map(|it| it.transducer)
    }

    /// The transducer whose reading stood while the other one moved, which the plausibility checks have not found.
    pub fn alone(&self, accuser: Accuser) -> Option<Transducer> {
        self.culprits[accuser as usize].filter(|it| !it.known).map(|it| it.transducer)
    }

    /// The transducer that had stood when the other one left it, while that may be a motion: only FDE3 has to wait for it.
    pub fn awaited(&self, accuser: Accuser) -> Option<Transducer> {
        self.awaited
            .filter(|_| accuser == Accuser::Fde3 && self.culprits[accuser as usize].is_none())
    }
}

/// The one of two that holds, if only one does.
const fn only(holds: [bool; 2]) -> Option<Transducer> {
    match holds {
        [true, false] => Some(Transducer::C1),
        [false, true] => Some(Transducer::C2),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Transducer::{C1, C2};

    const SOUND: ReadingState = ReadingState { known: None, alone: false, idle: 0 };
    const ALONE: ReadingState = ReadingState { known: None, alone: true, idle: 3 };
    const FROZEN: ReadingState = ReadingState { known: Some(Fault::Frozen), alone: true, idle: 5 };
    const ALL: [bool; 4] = [true; 4];

    fn nothing() -> StandingReadings {
        StandingReadings::new(10, &BlameParameters::DEFAULT, 0.02)
    }

    /// What is known of every detector: which reading stood, and whether the checks have found it.
    fn culprits(standing: &StandingReadings) -> [(Option<Transducer>, Option<Transducer>); 4] {
        Accuser::ALL.map(|it| (standing.known(it), standing.alone(it)))
    }

    #[test]
    fn what_stands_is_kept_until_the_detector_clears() {
        let mut standing = nothing();
        standing.follow(ALL, [SOUND; 2]);
        assert_eq!(culprits(&standing), [(None, None); 4]);
        standing.follow(ALL, [ALONE, SOUND]);
        assert_eq!(culprits(&standing), [(None, Some(C1)); 4]);
        standing.follow(ALL, [FROZEN, SOUND]);
        assert_eq!(culprits(&standing), [(Some(C1), None); 4]);
        standing.follow(ALL, [SOUND; 2]);
        assert_eq!(culprits(&standing), [(Some(C1), None); 4], "it reads again");
        standing.follow([false; 4], [SOUND; 2]);
        standing.follow(ALL, [SOUND; 2]);
        assert_eq!(culprits(&standing), [(None, None); 4], "that was another fault");
    }

    #[test]
    fn what_was_found_long_before_is_another_fault() {
        let mut standing = nothing();
        (0..100).for_each(|_| standing.follow(ALL, [SOUND; 2]));
        standing.follow(ALL, [FROZEN, SOUND]);
        assert_eq!(culprits(&standing), [(None, None); 4]);
    }

    /// A rod that starts to move looks like a reading that steps while the other one stands.
    #[test]
    fn what_one_leaves_while_the_other_stands_may_be_a_motion() {
        let mut standing = nothing();
        let fde3 = [false, false, true, false];
        for age in 0..15 {
            // It stands where it has gone to.
            let readings =
                [ReadingState { idle: 20 + age, ..SOUND }, ReadingState { idle: age, ..SOUND }];
            standing.follow(fde3, readings);
            assert_eq!(standing.awaited(Accuser::Fde3), Some(C1));
            assert_eq!(standing.awaited(Accuser::Fde2), None);
        }
        standing.follow(fde3, [SOUND; 2]);
        assert_eq!(standing.awaited(Accuser::Fde3), None, "it has stepped");
    }

    #[test]
    fn of_two_that_stand_neither_is_the_one() {
        let mut standing = nothing();
        standing.follow(ALL, [FROZEN; 2]);
        assert_eq!(culprits(&standing), [(None, None); 4]);
        standing.follow(ALL, [SOUND, FROZEN]);
        assert_eq!(standing.known(Accuser::Fde1), Some(C2));
    }
}
