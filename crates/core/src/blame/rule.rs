//! The rules by which a suspect is named, as they stand in logs, files and reports.

use crate::state::choice;

/// Declares [`Rule`]: its name in files and logs, and for people what it goes by.
macro_rules! rules {
    ($($(#[doc = $doc:literal])* $rule:ident = $name:literal, $reason:literal;)*) => {
        /// The rule that named the suspect of a finding.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Rule {
            $($(#[doc = $doc])* $rule,)*
        }

        choice! { Rule { $($rule),* } }

        impl Rule {
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$rule),*];

            /// Name in files and logs.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$rule => $name,)* }
            }

            /// What it goes by, for people: follows on *because*.
            pub const fn reason(self) -> &'static str {
                match self { $(Self::$rule => $reason,)* }
            }
        }
    };
}

rules! {
    // Proposals of the detectors.
    /// A plausibility check: a fact about one reading, or about the command.
    Plausibility = "plausibility", "the reading itself is not plausible";
    OneObserver = "one-observer", "one observer has risen, and the other one has not";
    ObserverWithDifference = "observer-with-difference", "one observer has risen together with the difference";
    FirstObserver = "first-observer", "one observer had risen with the difference before the other one";
    BothObservers = "both-observers", "both observers have risen, and C1 and C2 agree";
    AllThree = "all-three", "both observers have risen together with the difference";
    NoSecondObserver = "no-second-observer", "the other observer does not judge, or rose at another time";
    DifferenceAlone = "difference-alone", "the difference alone has no side";
    Interrupted = "interrupted", "the bus or the clock was interrupted after the difference had risen";
    NotCalibrated = "not-calibrated", "C1 and C2 have never been calibrated against each other";
    MeasuredLimit = "measured-limit", "the readings differ by more than the machine's own limit";
    Innovations = "innovations", "the samples of one transducer depart from the command";
    NoSide = "no-side", "the samples do not show which transducer has moved";
    Stop = "stop", "a reading on the mechanical stop is another one than before";
    BothJump = "both-jump", "C1 and C2 have jumped alike, as no rod does";
    BothDepart = "both-depart", "C1 and C2 depart alike from dead reckoning";
    ProcessDetector = "process-detector", "spool, pressures and rod contradict each other";
    // Rules that overrule a proposal.
    DeadReckoning = "dead-reckoning", "it is the only transducer that is left, and departs from dead reckoning";
    LastTransducer = "last-transducer", "it is the only transducer that is left, and its observer has risen";
    OutBefore = "out-before", "it was displaced before the other transducer came back";
    StandingReading = "standing-reading", "its reading stands, or does not come";
    FrozenPartner = "frozen-partner", "the other transducer's reading stands, and the machine may follow that";
    FlowOfOil = "flow-of-oil", "the oil that has passed the valve contradicts its reading";
    DeckAttitude = "deck-attitude", "the attitude of the deck contradicts its reading";
    PartedBefore = "parted-before", "C1 and C2 had parted before, and both observers see the same";
    BothObserversSee = "both-observers-see", "both observers see it, and C1 and C2 agree";
    ProcessExplains = "process-explains", "spool and pressures explain it, and C1 and C2 agree";
    MovesBesideStanding = "moves-beside-standing", "it moves while the other reading stands";
    MayBeMotion = "may-be-motion", "the other reading stood, so that it may be the rod that has begun to move";
}
