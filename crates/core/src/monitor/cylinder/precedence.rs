//! Facts about a reading take precedence over the conclusions from a model or a difference.
//!
//! That a reading stands still, or is missing, is a fact. Meanwhile the other reading moves on with
//! the rod. If the model of the rod is not exact, or the machine's controller uses the reading that
//! stands, the observer of the healthy one disagrees first, and Figure 5-17 would blame that one.
//! Every detector that warns while a reading stands is therefore told which one it is, until its
//! warning clears.

use crate::state::{state, whole};
use crate::verdict::{Fault, Suspect};

/// Number of detectors: FDE1, FDE2, FDE3 and the sequential detector.
pub const DETECTORS: usize = 4;

/// Number of cycles for which one reading has stood when the other one leaves it; [`AWAITED`] more
/// cycles show whether this is a motion, which begins like a fault. While the reading keeps
/// standing, it remains open.
const STOOD: u32 = 3;
/// Number of further cycles that show whether the other reading's step is a motion.
const AWAITED: u32 = 5;

const FDE3: usize = 2;

const BLAMED: [Suspect; 2] = [Suspect::C1, Suspect::C2];

/// State of a transducer in a cycle.
#[derive(Clone, Copy, Debug, Default)]
pub struct Standing {
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
    transducer: usize,
    /// Whether the plausibility checks have also found it.
    known: bool,
}

whole! {
    Culprit { transducer, known }
    sound |it| it.transducer < 2
}

/// Precedence for each detector.
#[derive(Clone, Copy, Debug)]
pub struct Precedence {
    /// Number of cycles before a reading stops in which a detector may already have seen the fault
    /// that a plausibility check finds later.
    before: u32,
    culprits: [Option<Culprit>; DETECTORS],
    /// Cycles since each detector was raised.
    ages: [Option<u32>; DETECTORS],
    /// The transducer that stood when FDE3 was raised, while its fault is not yet decided.
    awaited: Option<usize>,
}

state! {
    Precedence { culprits, ages, awaited }
    but { before }
    sound |it| it.awaited.is_none_or(|transducer| transducer < 2)
}

impl Precedence {
    /// Precedence in which findings within `coincidence` cycles of each other are one event.
    pub fn new(coincidence: u32) -> Self {
        Self {
            before: coincidence,
            culprits: Default::default(),
            ages: Default::default(),
            awaited: None,
        }
    }

    /// Takes a cycle in which no detector is raised.
    #[inline]
    pub fn rest(&mut self) {
        *self = Self::new(self.before);
    }

    /// Takes a cycle: the detectors that are raised, and the states of the transducers.
    pub fn judge(&mut self, raised: [bool; DETECTORS], standing: [Standing; 2]) {
        for (k, raised) in raised.into_iter().enumerate() {
            if !raised {
                (self.culprits[k], self.ages[k]) = (None, None);
                continue;
            }
            let age = self.ages[k].map_or(0, |age| age.saturating_add(1));
            self.ages[k] = Some(age);
            let met = |one: &Standing| age <= one.idle.saturating_add(self.before);
            let newest = only(standing.map(|one| met(&one) && (one.known.is_some() || one.alone)));
            let newest = newest.map(|transducer| Culprit {
                transducer,
                known: standing[transducer].known.is_some(),
            });
            self.culprits[k] = match (self.culprits[k], newest) {
                (Some(old), Some(new)) if new.known && !old.known => Some(new),
                (None, new) => new,
                (old, _) => old,
            };
        }
        self.awaited = self.ages[FDE3].and_then(|age| {
            let since_before = |one: Standing| one.idle >= age.saturating_add(STOOD);
            let just = |one: Standing| age < AWAITED && one.idle >= STOOD;
            only(standing.map(since_before)).or_else(|| only(standing.map(just)))
        });
    }

    /// Forgets a decided side after a time jump: as with R3, it does not outlast a time of which
    /// nothing is known.
    pub fn interrupt(&mut self) {
        self.culprits = Default::default();
        self.awaited = None;
    }

    /// The same where the oil or the deck's attitude has told whose reading has moved: they see the rod itself, and are
    /// not misled by a reading that stands for a moment, as all do where the rod turns round.
    pub fn suspect_by_the_rod(&self, k: usize, suspect: Suspect) -> Suspect {
        match self.culprits[k] {
            Some(Culprit { transducer, known: true }) => BLAMED[transducer],
            _ => suspect,
        }
    }

    /// The transducer that detector `k` of [`DETECTORS`] may suspect, if it suspects `suspect`
    /// itself.
    pub fn suspect(&self, k: usize, suspect: Suspect) -> Suspect {
        let Some(Culprit { transducer, known }) = self.culprits[k] else {
            let awaited = self.awaited.filter(|_| k == FDE3);
            let waits = awaited.is_some_and(|i| suspect == BLAMED[1 - i]);
            return if waits { Suspect::Undecided } else { suspect };
        };
        let other = 1 - transducer;
        match known {
            // The observer of the other one says nothing of the one that stands. Perhaps it is the
            // machine that follows that; perhaps it has a fault of its own.
            true if k == other => match suspect {
                Suspect::Process => Suspect::Undecided,
                suspect if suspect == BLAMED[other] => Suspect::Undecided,
                suspect => suspect,
            },
            true => BLAMED[transducer],
            false if suspect == BLAMED[other] => Suspect::Undecided,
            false => suspect,
        }
    }
}

/// The one of two that holds, if only one does.
const fn only(holds: [bool; 2]) -> Option<usize> {
    match holds {
        [true, false] => Some(0),
        [false, true] => Some(1),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOUND: Standing = Standing { known: None, alone: false, idle: 0 };
    const ALONE: Standing = Standing { known: None, alone: true, idle: 3 };
    const FROZEN: Standing = Standing { known: Some(Fault::Frozen), alone: true, idle: 5 };
    const ALL: [bool; 4] = [true; 4];

    fn of_c2(precedence: &Precedence) -> [Suspect; 4] {
        std::array::from_fn(|k| precedence.suspect(k, Suspect::C2))
    }

    #[test]
    fn who_stands_goes_before_who_goes_on_then_and_afterwards() {
        use Suspect::{C1, C2, Undecided};
        let mut precedence = Precedence::new(10);
        precedence.judge(ALL, [SOUND; 2]);
        assert_eq!(of_c2(&precedence), [C2; 4]);
        precedence.judge(ALL, [ALONE, SOUND]);
        assert_eq!(of_c2(&precedence), [Undecided; 4]);
        precedence.judge(ALL, [FROZEN, SOUND]);
        assert_eq!(of_c2(&precedence), [C1, Undecided, C1, C1]);
        assert_eq!(precedence.suspect(1, Suspect::Process), Undecided, "what C1 made of the rod");
        precedence.judge(ALL, [SOUND; 2]);
        assert_eq!(of_c2(&precedence), [C1, Undecided, C1, C1], "it reads again");
        precedence.judge([false; 4], [SOUND; 2]);
        precedence.judge(ALL, [SOUND; 2]);
        assert_eq!(of_c2(&precedence), [C2; 4], "that was another fault");
    }

    /// C2 drifts while the rod turns round, where C1 stands for a moment.
    #[test]
    fn what_stands_for_a_moment_does_not_overrule_the_oil_and_what_is_frozen_does() {
        let mut precedence = Precedence::new(10);
        precedence.judge(ALL, [ALONE, SOUND]);
        precedence.judge(ALL, [SOUND; 2]);
        assert_eq!(precedence.suspect(3, Suspect::C2), Suspect::Undecided);
        assert_eq!(precedence.suspect_by_the_rod(3, Suspect::C2), Suspect::C2);
        precedence.judge(ALL, [FROZEN, SOUND]);
        assert_eq!(precedence.suspect_by_the_rod(3, Suspect::C2), Suspect::C1);
    }

    #[test]
    fn what_was_found_long_before_is_another_fault() {
        let mut precedence = Precedence::new(10);
        (0..100).for_each(|_| precedence.judge(ALL, [SOUND; 2]));
        precedence.judge(ALL, [FROZEN, SOUND]);
        assert_eq!(of_c2(&precedence), [Suspect::C2; 4]);
    }

    /// A rod that starts to move looks like a reading that steps while the other one stands.
    #[test]
    fn fde3_does_not_blame_one_that_leaves_another_that_stands() {
        let mut precedence = Precedence::new(10);
        let fde3 = [false, false, true, false];
        for age in 0..3 * AWAITED {
            // It stands where it has gone to.
            let standing = [Standing { idle: 20 + age, ..SOUND }, Standing { idle: age, ..SOUND }];
            precedence.judge(fde3, standing);
            assert_eq!(precedence.suspect(FDE3, Suspect::C2), Suspect::Undecided);
            assert_eq!(precedence.suspect(FDE3, Suspect::C1), Suspect::C1);
        }
        precedence.judge(fde3, [SOUND; 2]);
        assert_eq!(precedence.suspect(FDE3, Suspect::C2), Suspect::C2, "it has stepped");
    }

    #[test]
    fn of_two_that_stand_neither_is_blamed_for_the_other() {
        let mut precedence = Precedence::new(10);
        precedence.judge(ALL, [FROZEN; 2]);
        assert_eq!(of_c2(&precedence), [Suspect::C2; 4]);
    }
}
