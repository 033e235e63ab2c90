//! What FDE1, FDE2 and FDE3 propose together (Figure 5-17), and until when they may still change it.
//!
//! Detectors that are raised within a fraction of a second see one event. The proposal follows from those that are, and then
//! stays: an observer follows a fault within a few samples, so that what it shows later says nothing of this one.

use super::proposal::{Accuser, Blamed, suspect_of};
use super::rule::Rule;
use crate::sample::Transducer;
use crate::state::state;
use crate::time::{Span, Timestamp};
use crate::verdict::{FDE3, FDES, FdeState, Raise, Raised, Suspect, Verdict};

/// Proposals of the raised FDEs of one cylinder.
#[derive(Clone, Copy, Debug)]
pub struct Pattern {
    proposals: [Option<Blamed>; FDES],
    coincidence: Span,
}

state! {
    Pattern { proposals }
    but { coincidence }
}

impl Pattern {
    /// In which findings within `coincidence` of each other are one event.
    pub const fn new(coincidence: Span) -> Self {
        Self { proposals: [None; FDES], coincidence }
    }

    /// Whether any FDE had found a fault when it was last followed.
    pub fn is_any(&self) -> bool {
        self.proposals.iter().any(Option::is_some)
    }

    /// What the accuser proposes, where it is an FDE that has found a fault.
    pub fn proposal(&self, accuser: Accuser) -> Option<Blamed> {
        self.proposals.get(accuser as usize).copied().flatten()
    }

    /// Takes what the FDEs have found in the cycle at `at`.
    pub fn follow(&mut self, at: Timestamp, raised: &Raised) {
        let not_calibrated = Blamed::new(Suspect::Undecided, Rule::NotCalibrated);
        for i in 0..FDES {
            let stands = self.proposals[i].filter(|it| *it != not_calibrated);
            self.proposals[i] = match raised.found[i] {
                None => None,
                Some(_) if i == FDE3 && raised.is_not_calibrated => Some(not_calibrated),
                Some(own) if at.since(own.at) > self.coincidence && stands.is_some() => stands,
                Some(own) => Some(propose(i, own, &raised.fdes, self.coincidence)),
            };
        }
    }

    /// Forgets the side of R3 after a time of which nothing is known, in which one transducer may have been repaired and the
    /// other one have failed.
    pub fn interrupt(&mut self) {
        if let Some(difference) = &mut self.proposals[FDE3] {
            *difference = Blamed::new(Suspect::Undecided, Rule::Interrupted);
        }
    }
}

fn propose(i: usize, own: Raise, fdes: &[FdeState; FDES], coincidence: Span) -> Blamed {
    let [fde1, fde2, difference] = *fdes;
    let of = |transducer, other| {
        of_observer(&ObserverCase { own, other, difference, coincidence }, transducer)
    };
    match i {
        0 => of(Transducer::C1, fde2),
        1 => of(Transducer::C2, fde1),
        _ => of_difference(own, fde1, fde2, coincidence),
    }
}

/// The warning of an observer: its own raise, the other observer and FDE3.
struct ObserverCase {
    own: Raise,
    other: FdeState,
    difference: FdeState,
    coincidence: Span,
}

/// What the warning of the observer of `transducer` proposes.
///
/// With FDE3, or alone while the other observer is healthy, an observer blames its own transducer. Both observers without FDE3
/// blame the process: the readings agree with each other and not with the model. All three leave it undecided, unless the
/// other observer followed only after FDE3, because it sees the reaction of the machine's controller to the faulty reading.
fn of_observer(case: &ObserverCase, transducer: Transducer) -> Blamed {
    let ObserverCase { own, other, difference, coincidence } = *case;
    let same_onset = |raise: Raise| within(raise.at.since(own.at), coincidence);
    let is_joint = other.raised.is_some_and(same_onset);
    let own_suspect = suspect_of(transducer);
    match (is_joint, difference.raised) {
        (true, Some(raise)) if same_onset(raise) && was_alone(own, other, raise) => {
            Blamed::new(own_suspect, Rule::FirstObserver)
        }
        (true, Some(_)) => Blamed::new(Suspect::Undecided, Rule::AllThree),
        (true, None) => Blamed::new(Suspect::Process, Rule::BothObservers),
        (false, Some(raise)) if same_onset(raise) => {
            Blamed::new(own_suspect, Rule::ObserverWithDifference)
        }
        (false, _) if other.verdict == Verdict::Healthy => {
            Blamed::new(own_suspect, Rule::OneObserver)
        }
        (false, _) => Blamed::new(Suspect::Undecided, Rule::NoSecondObserver),
    }
}

/// Whether `own` was the only observer raised when FDE3 was.
fn was_alone(own: Raise, other: FdeState, difference: Raise) -> bool {
    own.at <= difference.at && other.raised.is_none_or(|raise| raise.at > difference.at)
}

/// What FDE3's warning `own` proposes: the transducer whose observer, and only whose, exceeded its threshold when FDE3 was
/// raised, or soon after; otherwise undecided, since C1 − Ĉ2 alone has no side.
fn of_difference(own: Raise, fde1: FdeState, fde2: FdeState, coincidence: Span) -> Blamed {
    let before = |seen: FdeState| {
        seen.raised.is_some_and(|raise| {
            raise.at <= own.at && own.at.since(raise.last_exceeded) <= coincidence
        })
    };
    let after = |seen: FdeState| {
        seen.raised.is_some_and(|raise| raise.at > own.at && raise.at.since(own.at) <= coincidence)
    };
    let side = match (before(fde1), before(fde2), after(fde1), after(fde2)) {
        (true, false, ..) | (false, false, true, false) => Suspect::C1,
        (false, true, ..) | (false, false, false, true) => Suspect::C2,
        _ => return Blamed::new(Suspect::Undecided, Rule::DifferenceAlone),
    };
    Blamed::new(side, Rule::ObserverWithDifference)
}

fn within(span: Span, limit: Span) -> bool {
    span.as_nanos().unsigned_abs() <= limit.as_nanos().unsigned_abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    const COINCIDENCE: Span = Span::from_nanos(200);

    fn raise(at: i64, last_exceeded: i64) -> Raise {
        Raise { at: Timestamp::from_nanos(at), last_exceeded: Timestamp::from_nanos(last_exceeded) }
    }

    fn faulty(at: i64, last: i64) -> FdeState {
        FdeState { verdict: Verdict::Faulty, raised: Some(raise(at, last)) }
    }

    const HEALTHY: FdeState = FdeState { verdict: Verdict::Healthy, raised: None };
    const UNKNOWN: FdeState = FdeState { verdict: Verdict::Unknown, raised: None };

    #[test]
    fn the_pattern_of_figure_5_17() {
        let of = |other, difference| {
            let own = raise(1000, 1000);
            let case = ObserverCase { own, other, difference, coincidence: COINCIDENCE };
            Transducer::ALL.map(|it| of_observer(&case, it))
        };
        let own = |rule| [Suspect::C1, Suspect::C2].map(|it| Blamed::new(it, rule));
        let nobodys = |suspect, rule| [Blamed::new(suspect, rule); 2];
        use Rule::{AllThree, BothObservers, FirstObserver, NoSecondObserver, OneObserver};
        use Suspect::{Process, Undecided};
        let with_difference = own(Rule::ObserverWithDifference);
        assert_eq!(of(HEALTHY, faulty(1000, 1000)), with_difference);
        assert_eq!(of(HEALTHY, HEALTHY), own(OneObserver));
        assert_eq!(of(UNKNOWN, HEALTHY), nobodys(Undecided, NoSecondObserver));
        assert_eq!(of(UNKNOWN, faulty(1100, 1100)), with_difference, "FDE3 a little later");
        assert_eq!(of(faulty(900, 900), HEALTHY), nobodys(Process, BothObservers));
        assert_eq!(of(faulty(900, 900), faulty(1000, 1000)), nobodys(Undecided, AllThree));
        assert_eq!(of(faulty(1060, 1060), faulty(1000, 1000)), own(FirstObserver));
        let of_another_fault = nobodys(Undecided, NoSecondObserver);
        assert_eq!(of(faulty(100, 100), HEALTHY), of_another_fault, "the other one's own");
    }

    #[test]
    fn fde3_takes_the_side_of_the_observer_that_exceeds_with_it() {
        let of = |fde1, fde2| of_difference(raise(1000, 1000), fde1, fde2, COINCIDENCE).suspect;
        assert_eq!(of(HEALTHY, HEALTHY), Suspect::Undecided, "FDE3 alone");
        assert_eq!(of(faulty(1000, 1000), HEALTHY), Suspect::C1);
        assert_eq!(of(HEALTHY, faulty(900, 900)), Suspect::C2);
        assert_eq!(of(faulty(1150, 1150), HEALTHY), Suspect::C1, "the observer follows");
        assert_eq!(of(faulty(1000, 1000), faulty(1000, 1000)), Suspect::Undecided);
        assert_eq!(of(faulty(1000, 1000), faulty(1060, 1060)), Suspect::C1, "FDE2 only follows");
        assert_eq!(of(faulty(10, 950), HEALTHY), Suspect::C1, "noise that goes on");
    }

    #[test]
    fn an_observer_that_crosses_long_before_or_after_a_drift_does_not_decide_it() {
        let of = |fde1| of_difference(raise(1000, 9000), fde1, HEALTHY, COINCIDENCE);
        let nobody = Blamed::new(Suspect::Undecided, Rule::DifferenceAlone);
        assert_eq!(of(faulty(100, 100)), nobody);
        assert_eq!(of(faulty(5000, 5000)), nobody);
    }

    /// C1 was faulty when the bus was lost; when it came back C2 was, with the same difference.
    #[test]
    fn the_side_of_a_difference_does_not_outlast_a_lost_bus() {
        let own = raise(1000, 1000);
        let raised = |fde1| Raised {
            fdes: [fde1, HEALTHY, faulty(1000, 1000)],
            found: [None, None, Some(own)],
            is_not_calibrated: false,
        };
        let mut pattern = Pattern::new(COINCIDENCE);
        let suspect = |pattern: &mut Pattern, at: i64, fde1| {
            pattern.follow(Timestamp::from_nanos(at), &raised(fde1));
            pattern.proposal(Accuser::Fde3).map(|it| it.suspect)
        };
        assert_eq!(suspect(&mut pattern, 1000, faulty(1000, 1000)), Some(Suspect::C1));
        assert_eq!(suspect(&mut pattern, 9000, HEALTHY), Some(Suspect::C1), "it stays");
        pattern.interrupt();
        assert_eq!(suspect(&mut pattern, 9900, HEALTHY), Some(Suspect::Undecided));
    }

    /// C1 and C2 had differed since the start, and then C1 stepped.
    #[test]
    fn what_is_not_calibrated_has_no_side_until_it_grows() {
        let mut pattern = Pattern::new(COINCIDENCE);
        let mut raised = Raised {
            fdes: [HEALTHY, HEALTHY, UNKNOWN],
            found: [None, None, Some(raise(0, 0))],
            is_not_calibrated: true,
        };
        pattern.follow(Timestamp::from_nanos(5000), &raised);
        let proposed = pattern.proposal(Accuser::Fde3);
        assert_eq!(proposed, Some(Blamed::new(Suspect::Undecided, Rule::NotCalibrated)));
        raised.fdes = [faulty(9000, 9000), HEALTHY, faulty(9000, 9000)];
        (raised.found[2], raised.is_not_calibrated) = (Some(raise(9000, 9000)), false);
        pattern.follow(Timestamp::from_nanos(9300), &raised);
        let proposed = pattern.proposal(Accuser::Fde3);
        assert_eq!(proposed, Some(Blamed::new(Suspect::C1, Rule::ObserverWithDifference)));
    }
}
