//! Whether anything was judged, and why nothing was: a recording of which nothing was judged says
//! nothing about the machine, and must not look as if all were well.

use crate::bus::{Interfaces, Statistics};
use crate::frame::Id;
use crate::monitor::cylinder::Tally;
use crate::monitor::{Counts, MonitorDesign};

/// Identifiers that are told by number; of more, how many there are.
const LISTED: usize = 6;

/// What is known of a recording once it has been read.
#[derive(Clone, Copy, Debug)]
pub struct Recorded<'a> {
    pub statistics: &'a Statistics,
    /// The interface that was asked for.
    pub interfaces: &'a Interfaces,
    pub design: &'a MonitorDesign,
    /// Frames with an identifier of the configuration.
    pub used: u64,
}

/// Why nothing was judged; no reason where something was.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Judgement {
    reasons: Vec<String>,
}

impl Judgement {
    /// Of a replay. Something was judged where a residual was, of whatever cylinder and detector;
    /// `missed` are the monitored states by name, where the platform was in none of them.
    pub fn new(
        recorded: &Recorded<'_>,
        counts: &Counts,
        tallies: &[Tally],
        missed: Option<&[String]>,
    ) -> Self {
        if tallies.iter().any(|tally| tally.worst.iter().any(Option::is_some)) {
            return Self::default();
        }
        let mut reasons = recorded.nothing();
        if reasons.is_empty() {
            reasons = unjudged(counts, tallies, missed);
        }
        Self { reasons }
    }

    pub const fn is_judged(&self) -> bool {
        self.reasons.is_empty()
    }

    pub fn reasons(&self) -> &[String] {
        &self.reasons
    }

    /// What a person reads first; empty where something was judged.
    pub fn headline(&self) -> String {
        if self.is_judged() {
            return String::new();
        }
        let mut text = "NOTHING WAS JUDGED, so this says nothing about the machine:\n".to_owned();
        self.reasons.iter().for_each(|reason| text += &format!("  {reason}\n"));
        text
    }
}

impl Recorded<'_> {
    /// Why there is nothing of this machine in the recording; empty where there is something.
    pub fn nothing(&self) -> Vec<String> {
        if self.used > 0 {
            return Vec::new();
        }
        let Statistics { frames, damage, barren, other_interface_frames, .. } = self.statistics;
        let mut reasons = Vec::new();
        if *frames > 0 && other_interface_frames == frames {
            let found = self.statistics.interfaces_found();
            reasons.push(format!("no frame is of {}; the recording has {found}", self.interfaces));
        } else if *frames > *other_interface_frames {
            let frames = frames - other_interface_frames;
            let listened = identifiers(self.design);
            reasons.push(format!(
                "of {frames} frames none has an identifier of the configuration ({listened}): the \
                 recording is of another machine, or the DBC is"
            ));
        }
        reasons.extend(damage.iter().map(ToString::to_string));
        reasons.extend(barren.iter().map(ToString::to_string));
        reasons
    }
}

/// What the configuration listens to.
fn identifiers(design: &MonitorDesign) -> String {
    let ids: Vec<Id> = design.wiring.lines().iter().map(|line| line.id).collect();
    let shown = ids.iter().take(LISTED).map(ToString::to_string).collect::<Vec<_>>().join(", ");
    match ids.len().saturating_sub(LISTED) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// Why no residual came of the frames that the monitor listens to.
fn unjudged(counts: &Counts, tallies: &[Tally], missed: Option<&[String]>) -> Vec<String> {
    let sum = |of: fn(&Tally) -> u64| tallies.iter().map(of).sum::<u64>();
    let (cycles, incomplete) = (sum(|tally| tally.cycles), sum(|tally| tally.incomplete));
    let implausible = sum(|tally| tally.implausible.iter().sum());
    if cycles == 0 {
        return vec![format!(
            "of {} frames with an identifier of the configuration none opened a cycle: there is \
             neither Sync nor a reading",
            counts.used
        )];
    }
    let mut reasons = Vec::new();
    if let Some(states) = missed {
        let states = states.join(", ");
        reasons.push(format!("the platform was never in a monitored state ({states})"));
    }
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
