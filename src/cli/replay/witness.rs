//! What a replay sees of a recording besides the monitor: the states of the platform.

use super::super::machine::Machine;
use crate::bus::{Interfaces, Statistics};
use crate::frame::{BusNumber, Frame, Id};
use crate::monitor::Monitor;
use crate::monitor::subscriptions::Target;
use crate::report::Judgement;
use crate::report::judgement::{MissedStates, RecordedFacts};

/// Most states that are told.
const MOST_STATES: usize = 16;

/// Sees all frames of a recording.
#[derive(Clone, Debug)]
pub struct Witness {
    /// The message with the platform's state.
    state: Option<(BusNumber, Id)>,
    /// Numbers of the states, in the order in which they came.
    seen: Vec<i64>,
}

impl Witness {
    pub fn new(machine: &Machine) -> Self {
        let tells = |target: Target| target == Target::State;
        let all = machine.design.subscriptions.all().iter();
        let mut found = all.filter(|it| it.signals.iter().any(|signal| tells(signal.target)));
        Self { state: found.next().map(|it| (it.bus, it.id)), seen: Vec::new() }
    }

    /// Takes a frame that `monitor` has taken.
    #[inline]
    pub fn take(&mut self, frame: &Frame, monitor: &Monitor) {
        if self.state == Some((frame.bus, frame.id)) {
            self.see(monitor);
        }
    }

    #[cold]
    fn see(&mut self, monitor: &Monitor) {
        let Some(number) = monitor.platform() else { return };
        if self.seen.len() < MOST_STATES && !self.seen.contains(&number) {
            self.seen.push(number);
        }
    }

    /// Whether anything was judged by a `monitor` that `goes_on` from another recording or began anew.
    pub fn judgement(
        &self,
        machine: &Machine,
        (interfaces, statistics): (&Interfaces, &Statistics),
        monitor: &Monitor,
        goes_on: bool,
    ) -> Judgement {
        let counts = monitor.counts();
        let (design, used) = (&machine.design, counts.used);
        let recorded = RecordedFacts { statistics, interfaces, design, used, goes_on };
        let tallies = monitor.tallies().copied().collect::<Vec<_>>();
        Judgement::new(&recorded, counts, &tallies, self.missed(machine, monitor).as_ref())
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
