//! Names the suspect of each finding, and the rule that named it. No other module does.
//!
//! A detector proposes a suspect: FDE1, FDE2 and FDE3 by their pattern (Figure 5-17, [`pattern`]), the sequential detector by
//! the evidence of its samples. Other facts may overrule the proposal. [`OVERRULING`] lists these rules in the order in which
//! they are asked: the first that applies decides. If none applies, the proposal stands.

pub mod agreement;
mod parameters;
pub mod pattern;
mod proposal;
mod rule;
pub mod standing;
#[cfg(test)]
mod tests;

use crate::sample::Transducer;
use crate::state::state;
use crate::time::Span;
use crate::verdict::Suspect;
pub use agreement::Agreement;
pub use parameters::BlameParameters;
pub use pattern::Pattern;
pub use proposal::{Accuser, Blamed, suspect_of};
pub use rule::Rule;
pub use standing::StandingReadings;

/// The facts about a cylinder that may overrule the proposal of a detector.
#[derive(Clone, Copy, Debug)]
pub struct Facts<'a> {
    /// Whether the observer of each transducer alone supervises it, and has found it displaced.
    pub is_last: [bool; 2],
    /// Whether each transducer was latched as the last one, and whether it was dead reckoning that it departed from.
    pub is_latched: [bool; 2],
    pub departs: [bool; 2],
    pub memory: &'a BlameMemory,
    /// The transducer that the oil or the deck's attitude contradicts: both show how the rod itself has moved.
    pub by_the_rod: Option<Blamed>,
    /// Whether a process detector has found that the cylinder does not do what its command says.
    pub is_process_found: bool,
    /// Whether FDE3 or the sequential detector has found that C1 and C2 have parted.
    pub is_apart: bool,
}

/// What the rules keep from cycle to cycle.
#[derive(Clone, Debug)]
pub struct BlameMemory {
    pub pattern: Pattern,
    pub agreement: Agreement,
    pub standing: StandingReadings,
}

state! { BlameMemory { pattern, agreement, standing } }

impl BlameMemory {
    /// Findings within `coincidence` of each other are one event; `cycles` is the same time in cycles of `sample_time` seconds.
    pub fn new(coincidence: Span, cycles: u32, sample_time: f64) -> Self {
        Self {
            pattern: Pattern::new(coincidence),
            agreement: Agreement::default(),
            standing: StandingReadings::new(cycles, &BlameParameters::DEFAULT, sample_time),
        }
    }

    /// Forgets the sides after a time of which nothing is known.
    pub fn interrupt(&mut self) {
        self.pattern.interrupt();
        self.standing.interrupt();
    }
}

/// A finding, the proposal of its detector, and the facts that may overrule it.
#[derive(Clone, Copy, Debug)]
pub struct Case<'a> {
    pub accuser: Accuser,
    pub proposal: Blamed,
    pub facts: &'a Facts<'a>,
}

/// Returns the suspect, or `None` where the rule does not apply.
type Overruling = fn(&Case<'_>) -> Option<Suspect>;

/// The rules that overrule the proposal of a detector, in the order in which they are asked.
pub const OVERRULING: [(Rule, Overruling); 12] = [
    (Rule::DeadReckoning, dead_reckoning),
    (Rule::LastTransducer, last_transducer),
    (Rule::OutBefore, out_before),
    (Rule::StandingReading, standing_reading),
    (Rule::FrozenPartner, frozen_partner),
    (Rule::FlowOfOil, flow_of_oil),
    (Rule::DeckAttitude, deck_attitude),
    (Rule::PartedBefore, parted_before),
    (Rule::BothObserversSee, both_observers_see),
    (Rule::ProcessExplains, process_explains),
    (Rule::MovesBesideStanding, moves_beside_standing),
    (Rule::MayBeMotion, may_be_motion),
];

/// Names the suspect of `case`. Calls `asked` with the answer of each rule, in order, up to the one that decides.
pub fn blame(case: &Case<'_>, mut asked: impl FnMut(Rule, Option<Suspect>)) -> Blamed {
    for (rule, overrules) in OVERRULING {
        let answer = overrules(case);
        asked(rule, answer);
        if let Some(suspect) = answer {
            return Blamed { suspect, rule };
        }
    }
    asked(case.proposal.rule, Some(case.proposal.suspect));
    case.proposal
}

const fn other(transducer: Transducer) -> Transducer {
    match transducer {
        Transducer::C1 => Transducer::C2,
        Transducer::C2 => Transducer::C1,
    }
}

impl Case<'_> {
    fn is_undecided(&self) -> bool {
        self.proposal.suspect == Suspect::Undecided
    }

    /// The transducer that its detector follows, if that is what it proposes.
    fn proposed_own(&self) -> Option<Transducer> {
        self.accuser.observed().filter(|own| self.proposal.suspect == suspect_of(*own))
    }

    /// The transducer that the oil or the deck contradicts, for the detectors that this concerns. FDE3 asks only where no
    /// observer has a side, and the sequential detector always.
    fn contradicted_by_the_rod(&self, rule: Rule) -> Option<Suspect> {
        let asks = match self.accuser {
            Accuser::Fde1 | Accuser::Fde2 => false,
            Accuser::Fde3 => self.is_undecided(),
            Accuser::Sequential => true,
        };
        let seen = self.facts.by_the_rod.filter(|seen| asks && seen.rule == rule)?;
        Some(seen.suspect)
    }
}

/// C1 was lost and C2 drifted by 2 mm/s: its observer followed. The rod's way by dead reckoning did not.
fn dead_reckoning(case: &Case<'_>) -> Option<Suspect> {
    let own = case.accuser.observed()?;
    case.facts.departs[own as usize].then_some(suspect_of(own))
}

/// C1 was lost and C2 stepped by 60 mm. Its observer was raised for a second, and nothing else could confirm or deny the step,
/// so that observer alone names its transducer.
fn last_transducer(case: &Case<'_>) -> Option<Suspect> {
    let own = case.accuser.observed()?;
    case.facts.is_last[own as usize].then_some(suspect_of(own))
}

/// C2 was displaced while C1 was lost. When C1 was back the two differed, which alone says nothing of whose it is.
fn out_before(case: &Case<'_>) -> Option<Suspect> {
    let is_asked = case.accuser == Accuser::Fde3 && case.is_undecided();
    match case.facts.is_latched {
        _ if !is_asked || case.facts.by_the_rod.is_some() => None,
        [true, false] => Some(Suspect::C1),
        [false, true] => Some(Suspect::C2),
        _ => None,
    }
}

/// C1 froze, and the controller followed it: the observer of C2, which moved on with the rod, disagreed first. That a reading
/// stands, or does not come, is a fact.
fn standing_reading(case: &Case<'_>) -> Option<Suspect> {
    let culprit = case.facts.memory.standing.known(case.accuser)?;
    let is_partner = case.accuser.observed().is_some_and(|own| own != culprit);
    (!is_partner).then_some(suspect_of(culprit))
}

/// C1 froze: the observer of C2 is raised because the controller follows C1, or by a fault of C2. It cannot show which.
fn frozen_partner(case: &Case<'_>) -> Option<Suspect> {
    let culprit = case.facts.memory.standing.known(case.accuser)?;
    let is_partner = case.accuser.observed().is_some_and(|own| own != culprit);
    is_partner.then_some(Suspect::Undecided)
}

/// C2 drifted while the rod turned round, where C1 stood for a moment. The oil that has passed the valve is the rod's own way.
fn flow_of_oil(case: &Case<'_>) -> Option<Suspect> {
    case.contradicted_by_the_rod(Rule::FlowOfOil)
}

/// The same, by the attitude sensor of the deck: six lengths determine the attitude.
fn deck_attitude(case: &Case<'_>) -> Option<Suspect> {
    case.contradicted_by_the_rod(Rule::DeckAttitude)
}

/// C1 drifted off, and the controller drove the rod into its stop: R1 and R2 rose alike, and C2 was blamed. Where C1 and C2 had
/// parted before, an error in both innovations comes from the controller or the stop.
fn parted_before(case: &Case<'_>) -> Option<Suspect> {
    let own = case.proposed_own()?;
    case.facts.memory.agreement.is_shared(own).then_some(Suspect::Undecided)
}

/// The load doubled: R1 crossed its threshold three samples before R2, and C1 was blamed although C1 − C2 was zero.
fn both_observers_see(case: &Case<'_>) -> Option<Suspect> {
    let own = case.accuser.observed()?;
    case.facts.memory.agreement.is_process(own).then_some(Suspect::Process)
}

/// A valve stuck: the rod did not do what its command said, one observer rose, and spool and pressures had shown why.
fn process_explains(case: &Case<'_>) -> Option<Suspect> {
    case.accuser.observed()?;
    (case.facts.is_process_found && !case.facts.is_apart).then_some(Suspect::Process)
}

/// C1 stood for a few cycles before it was known to be frozen, and C2 moved on with the rod. Meanwhile that one is not blamed.
fn moves_beside_standing(case: &Case<'_>) -> Option<Suspect> {
    let standing = case.facts.memory.standing.alone(case.accuser)?;
    (case.proposal.suspect == suspect_of(other(standing))).then_some(Suspect::Undecided)
}

/// A rod that starts to move looks like a reading that steps while the other one, which is coarser, stands.
fn may_be_motion(case: &Case<'_>) -> Option<Suspect> {
    let standing = case.facts.memory.standing.awaited(case.accuser)?;
    (case.proposal.suspect == suspect_of(other(standing))).then_some(Suspect::Undecided)
}
