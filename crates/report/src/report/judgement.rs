//! Whether anything was judged, and why not: a recording in which nothing was judged says nothing
//! about the machine, and must not look as if all were well.

use super::stamps::{self, Stamped};
use std::fmt::{self, Display, Formatter};
use tertius_core::frame::Id;
use tertius_core::monitor::cylinder::Tally;
use tertius_core::monitor::{Counts, MonitorDesign};
use tertius_recordings::{Interfaces, Statistics};

/// Most identifiers that are listed; further ones are counted.
const LISTED: usize = 6;

const SWITCHED_OFF: &str =
    "FDE1 and FDE2 are switched off (fde.enabled), and no cylinder has a sequential detector";

/// Facts about a recording that has been read.
#[derive(Clone, Copy, Debug)]
pub struct RecordedFacts<'a> {
    pub statistics: &'a Statistics,
    /// The requested interface.
    pub interfaces: &'a Interfaces,
    pub design: &'a MonitorDesign,
    /// Frames with an identifier of the configuration.
    pub used: u64,
    /// Whether the monitor went on from what it knew at the end of another recording.
    pub goes_on: bool,
}

/// States of the platform in a recording in which it was never in a monitored one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissedStates {
    /// Those that were seen, by number and name.
    pub seen: Vec<String>,
    /// Those that are monitored, by number and name.
    pub monitored: Vec<String>,
}

/// What a monitor has judged.
#[derive(Clone, Copy, Debug)]
pub struct Judged<'a> {
    pub counts: &'a Counts,
    /// Of each cylinder.
    pub tallies: &'a [Tally],
    /// Cycles that the observers of each cylinder did not judge; `None` for a transducer that is not configured.
    pub unjudged: &'a [[Option<u64>; 2]],
}

impl Judged<'_> {
    /// Whether an observer judged a cycle; of a machine without observers, whether readings were `compared`.
    fn is_any(&self, compared: bool) -> bool {
        let of = |(tally, unjudged): (&Tally, &[Option<u64>; 2])| {
            unjudged.map(|unjudged| unjudged.map(|unjudged| tally.cycles > unjudged))
        };
        let observed = self.tallies.iter().zip(self.unjudged).flat_map(of).flatten();
        observed.reduce(|one, other| one || other).unwrap_or(compared)
    }
}

/// Reasons why nothing was judged; none where something was.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Judgement {
    reasons: Vec<String>,
    /// Whether C1 and C2 were compared with each other all the same.
    compared: bool,
}

impl Judgement {
    /// The judgement of a replay. Something was judged where an observer of any cylinder judged a cycle, except in a
    /// recording in which the platform was never in a monitored state (`missed`), or whose time stamps cannot be those of
    /// its frames: R3 alone, of rods that are parked, does not make a machine look healthy.
    pub fn new(
        recorded: &RecordedFacts<'_>,
        judged: &Judged<'_>,
        stamped: Stamped,
        missed: Option<&MissedStates>,
    ) -> Self {
        let Judged { counts, tallies, .. } = *judged;
        let compared = tallies.iter().any(|tally| tally.worst.iter().any(Option::is_some));
        let unusable = stamps::unusable(recorded.statistics, counts, stamped);
        if unusable.is_none() && judged.is_any(compared) && missed.is_none() {
            return Self::default();
        }
        let mut reasons: Vec<String> = unusable.into_iter().collect();
        if reasons.is_empty() {
            reasons = recorded.nothing();
        }
        if reasons.is_empty() && recorded.is_switched_off() {
            reasons.push(SWITCHED_OFF.to_owned());
        }
        if reasons.is_empty() {
            reasons = unjudged(counts, tallies, missed, recorded.goes_on);
        }
        Self { reasons, compared }
    }

    pub const fn is_judged(&self) -> bool {
        self.reasons.is_empty()
    }

    pub fn reasons(&self) -> &[String] {
        &self.reasons
    }

    /// First line for a person; empty where something was judged.
    pub fn headline(&self) -> String {
        if self.is_judged() {
            return String::new();
        }
        let mut text = match self.compared {
            true => {
                "NOTHING WAS JUDGED by the observers, so this does not say that the machine is \
                 healthy:\n"
            }
            false => "NOTHING WAS JUDGED, so this says nothing about the machine:\n",
        }
        .to_owned();
        self.reasons.iter().for_each(|reason| text += &format!("  {reason}\n"));
        if self.compared {
            text +=
                "  below is only what C1 and C2 showed beside each other (R3), and on the stops\n";
        }
        text
    }

    /// What takes the place of the number of warnings where there are none.
    pub const fn without_warnings(&self) -> &'static str {
        match (self.is_judged(), self.compared) {
            (true, _) => "No warnings.",
            (false, true) => "No warnings, but the observers judged nothing.",
            (false, false) => "No warnings, because nothing was judged.",
        }
    }
}

impl RecordedFacts<'_> {
    /// Whether the configuration leaves no detector by which a transducer is healthy.
    fn is_switched_off(&self) -> bool {
        let mut cylinders = self.design.cylinders.iter();
        cylinders.all(|cylinder| !cylinder.observes && cylinder.sequential.is_none())
    }

    /// Why the recording has nothing of this machine; empty where it has.
    pub fn nothing(&self) -> Vec<String> {
        if self.used > 0 {
            return Vec::new();
        }
        let Statistics { frames, damage, barren, other_interface_frames, .. } = self.statistics;
        let mut reasons = Vec::new();
        if *frames > 0 && other_interface_frames == frames {
            let found = self.statistics.interfaces_found();
            reasons
                .push(format!("no frame is from {}; the recording has {found}", self.interfaces));
        } else if *frames > *other_interface_frames {
            let frames = frames - other_interface_frames;
            let listened = identifiers(self.design);
            reasons.push(format!(
                "none of the {frames} frames has an identifier of the configuration ({listened}): \
                 the recording or the DBC belongs to another machine"
            ));
        }
        reasons.extend(damage.iter().map(ToString::to_string));
        reasons.extend(barren.iter().map(ToString::to_string));
        reasons
    }
}

impl Display for MissedStates {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let seen = match self.seen.as_slice() {
            [] => "no state was received".to_owned(),
            [one] => format!("the only state seen is {one}"),
            several => format!("the states seen are {}", several.join(", ")),
        };
        let are = if self.monitored.len() == 1 { "is" } else { "are" };
        let monitored = self.monitored.join(", ");
        write!(
            f,
            "the platform was never in a monitored state: {seen}; monitored {are} {monitored} \
             (machine.monitored_states)"
        )
    }
}

/// Identifiers that the configuration uses.
fn identifiers(design: &MonitorDesign) -> String {
    let ids: Vec<Id> = design.subscriptions.all().iter().map(|line| line.id).collect();
    let shown = ids.iter().take(LISTED).map(ToString::to_string).collect::<Vec<_>>().join(", ");
    match ids.len().saturating_sub(LISTED) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// Why the frames that the monitor uses gave no residual.
fn unjudged(
    counts: &Counts,
    tallies: &[Tally],
    missed: Option<&MissedStates>,
    goes_on: bool,
) -> Vec<String> {
    let sum = |of: fn(&Tally) -> u64| tallies.iter().map(of).sum::<u64>();
    let (cycles, incomplete) = (sum(|tally| tally.cycles), sum(|tally| tally.incomplete));
    let implausible = sum(|tally| tally.implausible.iter().sum());
    if cycles == 0 {
        let why = match goes_on {
            true => {
                "what came is of a cycle from before this recording, or is neither Sync nor a reading"
            }
            false => "there is neither Sync nor a reading",
        };
        return vec![format!(
            "none of the {} frames with an identifier of the configuration opened a cycle: {why}",
            counts.used
        )];
    }
    let mut reasons = Vec::new();
    reasons.extend(missed.map(ToString::to_string));
    if implausible > 0 {
        reasons.push(format!("{implausible} readings did not pass the plausibility checks"));
    }
    if incomplete == cycles {
        reasons.push("in every cycle a reading or the command is missing".to_owned());
    }
    if reasons.is_empty() {
        let cycles = counts.cycles;
        reasons.push(format!("{cycles} cycles are too few for the observers to settle"));
    }
    reasons
}
