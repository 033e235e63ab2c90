//! What a replay sees of a recording besides the monitor: the states of the platform, and the pace.

use super::super::machine::Machine;
use crate::bus::{Interfaces, Statistics};
use crate::frame::{Frame, Kind};
use crate::monitor::Monitor;
use crate::report::judgement::{Judged, MissedStates, RecordedFacts};
use crate::report::stamps::Stamped;
use crate::report::{Judgement, OffPace, RecordedPace};

/// Most states that are told.
const MOST_STATES: usize = 16;

/// Glances from one look at the frames to the next, and how many in turn are looked at in the beginning.
const APART: u64 = 256;
const AT_FIRST: u64 = 4;

/// Looks at what a recording is like, at so few of its frames that the time it takes does not count.
#[derive(Clone, Debug)]
pub struct Witness {
    pace: RecordedPace,
    glances: u64,
    /// Numbers of the states, in the order in which they came.
    seen: Vec<i64>,
}

impl Witness {
    pub fn new(machine: &Machine) -> Self {
        Self { pace: machine.pace(), glances: 0, seen: Vec::new() }
    }

    /// Takes a frame that it looks at.
    pub fn take(&mut self, frame: &Frame) {
        if matches!(frame.kind, Kind::Data | Kind::Fd { .. }) {
            self.pace.take(frame);
        }
    }

    /// Looks at the platform's state now and then; returns whether it looks at the next frames.
    pub fn glance(&mut self, monitor: &Monitor) -> bool {
        let new = monitor.platform().filter(|number| !self.seen.contains(number));
        self.seen.extend(new.filter(|_| self.seen.len() < MOST_STATES));
        self.glances += 1;
        self.glances < AT_FIRST || self.glances.is_multiple_of(APART)
    }

    /// What of the cycle is other than the configuration says.
    pub fn remarks(&self) -> Vec<String> {
        self.pace.off().iter().map(OffPace::text).map(str::to_owned).collect()
    }

    /// Whether anything was judged by a `monitor` that `goes_on` from another recording or began anew, in a recording that
    /// was `stamped` so.
    pub fn judgement(
        &self,
        machine: &Machine,
        (interfaces, statistics): (&Interfaces, &Statistics),
        monitor: &Monitor,
        goes_on: bool,
        stamped: Stamped,
    ) -> Judgement {
        let counts = monitor.counts();
        let (design, used) = (&machine.design, counts.used);
        let recorded = RecordedFacts { statistics, interfaces, design, used, goes_on };
        let tallies = monitor.tallies().copied().collect::<Vec<_>>();
        let unjudged = monitor.unjudged().collect::<Vec<_>>();
        let judged = Judged { counts, tallies: &tallies, unjudged: &unjudged };
        Judgement::new(&recorded, &judged, stamped, self.missed(machine, monitor).as_ref())
    }

    /// The states of the platform, if it was never in a monitored one.
    fn missed(&self, machine: &Machine, monitor: &Monitor) -> Option<MissedStates> {
        let monitored = machine.loaded.settings.machine.monitored_states.as_ref()?;
        if monitor.has_opened() {
            return None;
        }
        let known = machine.platform_states();
        let mut seen = self.seen.clone();
        seen.sort_unstable();
        let by_number = |number: i64| match known.iter().find(|(it, _)| *it == number) {
            Some((_, name)) => format!("{number} ({name})"),
            None => number.to_string(),
        };
        let by_name = |name: &String| {
            let number = known.iter().find(|(_, it)| it.eq_ignore_ascii_case(name));
            let number = number.map(|(number, _)| *number).or_else(|| name.parse().ok());
            number.map_or_else(|| name.clone(), by_number)
        };
        Some(MissedStates {
            seen: seen.into_iter().map(by_number).collect(),
            monitored: monitored.iter().map(by_name).collect(),
        })
    }
}
