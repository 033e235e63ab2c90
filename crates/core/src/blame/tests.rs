//! The table of findings: everything that the rules of blame can be asked, and what has to hold of the answers.

use super::agreement::PairState;
use super::standing::ReadingState;
use super::*;
use crate::verdict::Fault;
use Suspect::{C1, C2, Process, Undecided};
use std::vec::Vec;

const SAMPLE_TIME: f64 = 0.02;
/// Cycles within which findings are one event.
const COINCIDENCE: u32 = 10;

/// The facts of a case, without the memory that they borrow.
#[derive(Clone, Debug)]
struct Known {
    is_last: [bool; 2],
    is_latched: [bool; 2],
    departs: [bool; 2],
    memory: BlameMemory,
    by_the_rod: Option<Blamed>,
    is_process_found: bool,
    is_apart: bool,
}

impl Known {
    fn nothing() -> Self {
        Self {
            is_last: [false; 2],
            is_latched: [false; 2],
            departs: [false; 2],
            memory: BlameMemory::new(Span::from_seconds(0.2), COINCIDENCE, SAMPLE_TIME),
            by_the_rod: None,
            is_process_found: false,
            is_apart: false,
        }
    }

    fn blame(&self, accuser: Accuser, proposal: Blamed) -> Blamed {
        let facts = Facts {
            is_last: self.is_last,
            is_latched: self.is_latched,
            departs: self.departs,
            memory: &self.memory,
            by_the_rod: self.by_the_rod,
            is_process_found: self.is_process_found,
            is_apart: self.is_apart,
        };
        blame(&Case { accuser, proposal, facts: &facts }, |_, _| {})
    }

    /// Whether anything that is known shows that the reading of transducer `i` is wrong.
    fn has_evidence_against(&self, i: usize) -> bool {
        let transducer = [Transducer::C1, Transducer::C2][i];
        let is_known = |it: Accuser| self.memory.standing.known(it) == Some(transducer);
        self.is_last[i]
            || self.is_latched[i]
            || self.departs[i]
            || Accuser::ALL.into_iter().any(is_known)
            || self.by_the_rod.is_some_and(|it| it.suspect == [C1, C2][i])
    }
}

const SOUND: ReadingState = ReadingState { known: None, alone: false, idle: 0 };
const ALONE: ReadingState = ReadingState { known: None, alone: true, idle: 5 };
const FROZEN: ReadingState = ReadingState { known: Some(Fault::Frozen), alone: true, idle: 5 };
/// Stood when the other one left it.
const RESTING: ReadingState = ReadingState { known: None, alone: false, idle: 20 };

/// Memories of everything that readings and observers can have done while all detectors are raised.
fn memories() -> Vec<BlameMemory> {
    let mut memories = Vec::new();
    let states = [SOUND, ALONE, FROZEN, RESTING];
    let shared = [Some(2e-3), Some(1.8e-3)];
    let apart = |apart| PairState { apart, ..PairState::default() };
    let agreements = [
        ([None; 2], PairState::default()),
        (shared, apart(Some(1e-4))),
        (shared, PairState { parted: true, ..PairState::default() }),
    ];
    for c1 in states {
        for c2 in states {
            for (residuals, pair) in agreements {
                let mut memory = Known::nothing().memory;
                memory.standing.follow([true; 4], [c1, c2]);
                memory.agreement.judge([true; 2], [false; 2], residuals, pair);
                memories.push(memory);
            }
        }
    }
    memories
}

/// Every combination of what can be known beside the findings.
fn everything_known() -> Vec<Known> {
    let mut all = Vec::new();
    let out = [[false; 2], [true, false], [false, true]];
    let seen = |suspect, rule| Some(Blamed::new(suspect, rule));
    let by_the_rod = [
        None,
        seen(C1, Rule::FlowOfOil),
        seen(C2, Rule::FlowOfOil),
        seen(C1, Rule::DeckAttitude),
        seen(C2, Rule::DeckAttitude),
    ];
    for memory in memories() {
        for (is_last, latches) in out.into_iter().flat_map(|it| [(it, false), (it, true)]) {
            for rod in by_the_rod {
                for [is_process_found, is_apart] in
                    [[false; 2], [true, false], [false, true], [true; 2]]
                {
                    let is_latched = if latches { is_last } else { [false; 2] };
                    for departs in [[false; 2], is_latched] {
                        all.push(Known {
                            is_last,
                            is_latched,
                            departs,
                            memory: memory.clone(),
                            by_the_rod: rod,
                            is_process_found,
                            is_apart,
                        });
                    }
                }
            }
        }
    }
    all
}

/// The possible proposals of each detector.
fn proposals(accuser: Accuser) -> Vec<Blamed> {
    let of = |suspect, rule| Blamed::new(suspect, rule);
    match accuser {
        Accuser::Fde1 | Accuser::Fde2 => {
            let own = if accuser == Accuser::Fde1 { C1 } else { C2 };
            vec![
                of(own, Rule::OneObserver),
                of(own, Rule::ObserverWithDifference),
                of(Process, Rule::BothObservers),
                of(Undecided, Rule::AllThree),
            ]
        }
        Accuser::Fde3 => vec![
            of(C1, Rule::ObserverWithDifference),
            of(C2, Rule::ObserverWithDifference),
            of(Undecided, Rule::DifferenceAlone),
        ],
        Accuser::Sequential => {
            vec![of(C1, Rule::Innovations), of(C2, Rule::Innovations), of(Undecided, Rule::NoSide)]
        }
    }
}

fn cases() -> impl Iterator<Item = (Known, Accuser, Blamed)> {
    everything_known().into_iter().flat_map(|known| {
        Accuser::ALL.into_iter().flat_map(move |accuser| {
            let known = known.clone();
            proposals(accuser).into_iter().map(move |it| (known.clone(), accuser, it))
        })
    })
}

/// A transducer is named where the detector's own evidence or a fact is against it, and never else.
#[test]
fn no_transducer_is_named_without_evidence() {
    let mut decided = std::collections::BTreeSet::new();
    for (known, accuser, proposal) in cases() {
        let blamed = known.blame(accuser, proposal);
        for (i, suspect) in [C1, C2].into_iter().enumerate() {
            if blamed.suspect == suspect {
                let has = proposal.suspect == suspect || known.has_evidence_against(i);
                assert!(has, "{blamed:?} of {accuser:?} with {proposal:?}: {known:?}");
            }
        }
        decided.insert(blamed.rule.name());
    }
    for (rule, _) in OVERRULING {
        assert!(decided.contains(rule.name()), "{} decides nothing", rule.name());
    }
}

/// The difference and the samples never name a transducer that an observer's rule has cleared because of what stands, and
/// where one reading is known to stand every detector that names anybody names that one.
#[test]
fn what_is_known_to_stand_has_no_second_suspect() {
    for (known, accuser, proposal) in cases() {
        let Some(culprit) = known.memory.standing.known(accuser) else { continue };
        let second = 1 - culprit as usize;
        let blamed = known.blame(accuser, proposal);
        let is_out = known.is_last[second] || known.departs[second] || known.is_latched[second];
        if !is_out {
            assert_ne!(blamed.suspect, [C1, C2][second], "{accuser:?} {proposal:?}: {known:?}");
        }
    }
}

/// Neither transducer is treated in another way than the other one.
#[test]
fn c1_and_c2_may_be_exchanged() {
    let exchanged = |suspect| match suspect {
        C1 => C2,
        C2 => C1,
        Undecided | Process => suspect,
    };
    let other = |accuser| match accuser {
        Accuser::Fde1 => Accuser::Fde2,
        Accuser::Fde2 => Accuser::Fde1,
        Accuser::Fde3 | Accuser::Sequential => accuser,
    };
    let reversed = |[c1, c2]: [bool; 2]| [c2, c1];
    // The memories stand in the order of C1's state and C2's, three of agreement each.
    let all = memories();
    let mirrored: Vec<&BlameMemory> =
        (0..all.len()).map(|k| &all[(k / 3 % 4 * 4 + k / 12) * 3 + k % 3]).collect();
    let per_memory = everything_known().len() / all.len();
    for (k, known) in everything_known().into_iter().enumerate() {
        let mirror = Known {
            is_last: reversed(known.is_last),
            is_latched: reversed(known.is_latched),
            departs: reversed(known.departs),
            memory: mirrored[k / per_memory].clone(),
            by_the_rod: known.by_the_rod.map(|it| Blamed::new(exchanged(it.suspect), it.rule)),
            ..known.clone()
        };
        for accuser in Accuser::ALL {
            for proposal in proposals(accuser) {
                let blamed = known.blame(accuser, proposal);
                let expected = Blamed::new(exchanged(blamed.suspect), blamed.rule);
                let turned = Blamed::new(exchanged(proposal.suspect), proposal.rule);
                assert_eq!(mirror.blame(other(accuser), turned), expected, "{accuser:?} {known:?}");
            }
        }
    }
}

/// Asserts what a rule makes of a proposal.
fn assert_blamed(known: &Known, accuser: Accuser, proposal: Blamed, expected: (Suspect, Rule)) {
    let blamed = known.blame(accuser, proposal);
    assert_eq!((blamed.suspect, blamed.rule), expected);
}

fn standing(readings: [ReadingState; 2]) -> Known {
    let mut known = Known::nothing();
    known.memory.standing.follow([true; 4], readings);
    known
}

const FDE2_ALONE: Blamed = Blamed::new(C2, Rule::OneObserver);
const C2_WITH_DIFFERENCE: Blamed = Blamed::new(C2, Rule::ObserverWithDifference);
const DIFFERENCE: Blamed = Blamed::new(Undecided, Rule::DifferenceAlone);

#[test]
fn a_proposal_stands_where_nothing_is_known() {
    let known = Known::nothing();
    assert_eq!(known.blame(Accuser::Fde2, FDE2_ALONE), FDE2_ALONE);
    assert_eq!(known.blame(Accuser::Fde3, DIFFERENCE), DIFFERENCE);
}

#[test]
fn dead_reckoning_and_last_transducer() {
    let mut known = Known { is_last: [false, true], ..Known::nothing() };
    let nobody = Blamed::new(Undecided, Rule::NoSecondObserver);
    assert_blamed(&known, Accuser::Fde2, nobody, (C2, Rule::LastTransducer));
    assert_blamed(&known, Accuser::Fde1, nobody, (Undecided, Rule::NoSecondObserver));
    (known.is_latched, known.departs) = ([false, true], [false, true]);
    assert_blamed(&known, Accuser::Fde2, nobody, (C2, Rule::DeadReckoning));
}

#[test]
fn out_before() {
    let mut known = Known { is_latched: [false, true], ..Known::nothing() };
    assert_blamed(&known, Accuser::Fde3, DIFFERENCE, (C2, Rule::OutBefore));
    let named = Blamed::new(C1, Rule::ObserverWithDifference);
    assert_eq!(known.blame(Accuser::Fde3, named), named, "an observer has a side");
    // C1 has moved since, as the oil shows.
    known.by_the_rod = Some(Blamed::new(C1, Rule::FlowOfOil));
    assert_blamed(&known, Accuser::Fde3, DIFFERENCE, (C1, Rule::FlowOfOil));
    (known.is_latched, known.by_the_rod) = ([true; 2], None);
    assert_eq!(known.blame(Accuser::Fde3, DIFFERENCE), DIFFERENCE, "both were out");
}

#[test]
fn standing_reading_and_frozen_partner() {
    let known = standing([FROZEN, SOUND]);
    assert_blamed(&known, Accuser::Fde2, FDE2_ALONE, (Undecided, Rule::FrozenPartner));
    let process = Blamed::new(Process, Rule::BothObservers);
    assert_blamed(&known, Accuser::Fde2, process, (Undecided, Rule::FrozenPartner));
    assert_blamed(&known, Accuser::Fde1, process, (C1, Rule::StandingReading));
    assert_blamed(&known, Accuser::Fde3, C2_WITH_DIFFERENCE, (C1, Rule::StandingReading));
    let by_samples = Blamed::new(C2, Rule::Innovations);
    assert_blamed(&known, Accuser::Sequential, by_samples, (C1, Rule::StandingReading));
}

#[test]
fn moves_beside_standing() {
    let known = standing([ALONE, SOUND]);
    let expected = (Undecided, Rule::MovesBesideStanding);
    assert_blamed(&known, Accuser::Fde2, FDE2_ALONE, expected);
    assert_blamed(&known, Accuser::Fde3, C2_WITH_DIFFERENCE, expected);
    let of_the_one_that_stands = Blamed::new(C1, Rule::OneObserver);
    assert_eq!(known.blame(Accuser::Fde1, of_the_one_that_stands), of_the_one_that_stands);
}

/// C2 drifts while the rod turns round, where C1 stands for a moment.
#[test]
fn flow_of_oil_and_deck_attitude() {
    for rule in [Rule::FlowOfOil, Rule::DeckAttitude] {
        let seen = Some(Blamed::new(C2, rule));
        let moment = Known { by_the_rod: seen, ..standing([ALONE, SOUND]) };
        assert_blamed(&moment, Accuser::Sequential, Blamed::new(C2, rule), (C2, rule));
        assert_blamed(&moment, Accuser::Fde3, DIFFERENCE, (C2, rule));
        let of_c1 = Blamed::new(C1, Rule::OneObserver);
        assert_eq!(moment.blame(Accuser::Fde1, of_c1), of_c1, "an observer has its own side");
        let frozen = Known { by_the_rod: seen, ..standing([FROZEN, SOUND]) };
        assert_blamed(&frozen, Accuser::Fde3, DIFFERENCE, (C1, Rule::StandingReading));
    }
}

#[test]
fn parted_before() {
    let mut known = Known::nothing();
    let parted = PairState { parted: true, ..PairState::default() };
    known.memory.agreement.judge([true; 2], [false; 2], [Some(1.7e-3), Some(1.6e-3)], parted);
    assert_blamed(&known, Accuser::Fde2, FDE2_ALONE, (Undecided, Rule::PartedBefore));
    let process = Blamed::new(Process, Rule::BothObservers);
    assert_eq!(known.blame(Accuser::Fde2, process), process);
    // They agree again, but the controller still answers that difference.
    let mut known = Known::nothing();
    let close = PairState { apart: Some(1e-4), ..parted };
    known.memory.agreement.judge([true; 2], [false; 2], [Some(1.7e-3), Some(1.6e-3)], close);
    assert_blamed(&known, Accuser::Fde2, FDE2_ALONE, (Undecided, Rule::PartedBefore));
}

#[test]
fn both_observers_see() {
    let mut known = Known::nothing();
    let agree = PairState { apart: Some(1e-4), ..PairState::default() };
    known.memory.agreement.judge([true, false], [false; 2], [Some(1.6e-3), Some(1.1e-3)], agree);
    let alone = Blamed::new(C1, Rule::OneObserver);
    assert_blamed(&known, Accuser::Fde1, alone, (Process, Rule::BothObserversSee));
}

#[test]
fn process_explains() {
    let mut known = Known { is_process_found: true, ..Known::nothing() };
    assert_blamed(&known, Accuser::Fde2, FDE2_ALONE, (Process, Rule::ProcessExplains));
    assert_eq!(known.blame(Accuser::Fde3, C2_WITH_DIFFERENCE), C2_WITH_DIFFERENCE);
    known.is_apart = true;
    assert_eq!(known.blame(Accuser::Fde2, FDE2_ALONE), FDE2_ALONE);
}

#[test]
fn may_be_motion() {
    let known = standing([RESTING, SOUND]);
    let expected = (Undecided, Rule::MayBeMotion);
    assert_blamed(&known, Accuser::Fde3, C2_WITH_DIFFERENCE, expected);
    assert_eq!(known.blame(Accuser::Fde2, FDE2_ALONE), FDE2_ALONE);
}

/// A rule that decides nothing is not told to have done so, and none is asked behind one that has.
#[test]
fn rules_are_asked_up_to_the_one_that_decides() {
    let known = standing([FROZEN, SOUND]);
    let facts = Facts {
        is_last: [false; 2],
        is_latched: [false; 2],
        departs: [false; 2],
        memory: &known.memory,
        by_the_rod: None,
        is_process_found: false,
        is_apart: true,
    };
    let case = Case { accuser: Accuser::Fde2, proposal: FDE2_ALONE, facts: &facts };
    let mut asked = Vec::new();
    let blamed = blame(&case, |rule, answer| asked.push((rule, answer)));
    assert_eq!(blamed, Blamed::new(Undecided, Rule::FrozenPartner));
    let names: Vec<_> = OVERRULING.iter().map(|(rule, _)| *rule).take(asked.len()).collect();
    assert_eq!(asked.iter().map(|(rule, _)| *rule).collect::<Vec<_>>(), names);
    assert!(asked.iter().rev().skip(1).all(|(_, answer)| answer.is_none()));
}
