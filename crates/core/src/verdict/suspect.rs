//! The suspect, from the pattern of the three FDEs (Figure 5-17).

use super::{Verdict, trigger::Raise};
use crate::state::choice;
use crate::time::Span;

/// Suspect of a warning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Suspect {
    #[default]
    Undecided,
    C1,
    C2,
    /// Neither transducer: the cylinder, its valve or the model.
    Process,
}

choice! { Suspect { Undecided, C1, C2, Process } }

impl Suspect {
    /// All suspects, in the order of their numbers.
    pub const ALL: [Self; 4] = [Self::Undecided, Self::C1, Self::C2, Self::Process];

    /// Name in files and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Undecided => "undecided",
            Self::C1 => "c1",
            Self::C2 => "c2",
            Self::Process => "process",
        }
    }
}

/// What has told whose reading it is that has moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Testimony {
    /// The readings beside the command.
    Innovations,
    /// The mechanical stop.
    Stop,
    /// The oil that passes the valve.
    Flow,
    /// The attitude of the deck.
    Attitude,
    /// The rod's way by dead reckoning.
    Way,
}

choice! { Testimony { Innovations, Stop, Flow, Attitude, Way } }

impl Testimony {
    /// Whether it knows how the rod itself has moved, which the difference of the readings does not.
    pub const fn is_of_the_rod(self) -> bool {
        matches!(self, Self::Flow | Self::Attitude)
    }
}

/// State of one FDE in the pattern.
#[derive(Clone, Copy, Debug)]
pub struct FdeState {
    pub verdict: Verdict,
    pub raised: Option<Raise>,
}

/// The suspect of an observer's warning: `own` blames `transducer`, `other` is the observer on the
/// other transducer, `difference` is FDE3.
///
/// With FDE3, or alone while the other observer is healthy, an observer blames its own transducer.
/// Both observers without FDE3 blame the process: the readings agree with each other and not with
/// the model. All three leave it undecided, unless the other observer followed only after FDE3,
/// because it sees the reaction of the machine's controller to the faulty reading.
pub fn of_observer(
    transducer: Suspect,
    own: Raise,
    other: FdeState,
    difference: FdeState,
    coincidence: Span,
) -> Suspect {
    let same_onset = |raise: Raise| within(raise.at.since(own.at), coincidence);
    let joint = other.raised.is_some_and(same_onset);
    match (joint, difference.raised) {
        (true, Some(raise)) if same_onset(raise) && was_alone(own, other, raise) => transducer,
        (true, Some(_)) => Suspect::Undecided,
        (true, None) => Suspect::Process,
        (false, Some(raise)) if same_onset(raise) => transducer,
        (false, _) if other.verdict == Verdict::Healthy => transducer,
        (false, _) => Suspect::Undecided,
    }
}

/// Whether `own` was the only observer raised when FDE3 was.
fn was_alone(own: Raise, other: FdeState, difference: Raise) -> bool {
    own.at <= difference.at && other.raised.is_none_or(|raise| raise.at > difference.at)
}

/// The suspect of FDE3's warning `own`: the transducer whose observer, and only whose, exceeded its
/// threshold when FDE3 was raised, or soon after; otherwise undecided, since C1 − Ĉ2 alone has no
/// side.
pub fn of_difference(own: Raise, fde1: FdeState, fde2: FdeState, coincidence: Span) -> Suspect {
    let before = |seen: FdeState| {
        seen.raised.is_some_and(|raise| {
            raise.at <= own.at && own.at.since(raise.last_exceeded) <= coincidence
        })
    };
    let after = |seen: FdeState| {
        seen.raised.is_some_and(|raise| raise.at > own.at && raise.at.since(own.at) <= coincidence)
    };
    match (before(fde1), before(fde2), after(fde1), after(fde2)) {
        (true, false, ..) | (false, false, true, false) => Suspect::C1,
        (false, true, ..) | (false, false, false, true) => Suspect::C2,
        _ => Suspect::Undecided,
    }
}

fn within(span: Span, limit: Span) -> bool {
    span.as_nanos().unsigned_abs() <= limit.as_nanos().unsigned_abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::Timestamp;

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
        let own = raise(1000, 1000);
        let of = |other, third| of_observer(Suspect::C1, own, other, third, COINCIDENCE);
        assert_eq!(of(HEALTHY, faulty(1000, 1000)), Suspect::C1, "FDE1 with FDE3");
        assert_eq!(of(HEALTHY, HEALTHY), Suspect::C1, "FDE1 alone");
        assert_eq!(of(UNKNOWN, HEALTHY), Suspect::Undecided, "FDE1 alone, FDE2 does not judge");
        assert_eq!(of(UNKNOWN, faulty(1100, 1100)), Suspect::C1, "FDE1 with FDE3 a little later");
        assert_eq!(of(faulty(900, 900), HEALTHY), Suspect::Process, "both observers, not FDE3");
        assert_eq!(of(faulty(900, 900), faulty(1000, 1000)), Suspect::Undecided, "all three");
        assert_eq!(of(faulty(1060, 1060), faulty(1000, 1000)), Suspect::C1, "FDE2 only follows");
        assert_eq!(of(faulty(100, 100), HEALTHY), Suspect::Undecided, "FDE2 has its own fault");
    }

    #[test]
    fn fde3_takes_the_side_of_the_observer_that_exceeds_with_it() {
        let of = |fde1, fde2| of_difference(raise(1000, 1000), fde1, fde2, COINCIDENCE);
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
        assert_eq!(of(faulty(100, 100)), Suspect::Undecided);
        assert_eq!(of(faulty(5000, 5000)), Suspect::Undecided);
    }
}
