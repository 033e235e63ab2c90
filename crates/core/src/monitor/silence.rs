//! Buses that are silent while another one of the same machine is heard.

use super::subscriptions::Subscriptions;
use crate::frame::{BusNumber, Buses};
use crate::state::state;

/// Follows which buses are heard, cycle by cycle. Silence of all of them is evidence of nothing, and changes nothing.
#[derive(Clone, Debug)]
pub(super) struct Silence {
    /// Buses with messages that belong to cycles.
    expected: Buses,
    /// Cycles after which silence is reported.
    patience: u64,
    /// Cycles since each bus was heard last, in which another one was.
    cycles: [u64; BusNumber::ALL.len()],
    /// Buses of which it was reported that they are silent.
    reported: Buses,
}

state! {
    Silence { cycles, reported }
    but { expected, patience }
}

impl Silence {
    /// `None` if the machine has a single bus.
    pub fn of(subscriptions: &Subscriptions, patience: u64) -> Option<Self> {
        let cyclic = subscriptions.all().iter().filter(|message| message.cyclic);
        let expected: Buses = cyclic.map(|message| message.bus).collect();
        (expected.iter().count() > 1).then(|| Self {
            expected,
            patience,
            cycles: Default::default(),
            reported: Buses::NONE,
        })
    }

    /// Takes the buses that were `heard` in a cycle, and passes to `report` those that fell silent (`true`) or are heard
    /// again.
    pub fn follow(&mut self, heard: Buses, mut report: impl FnMut(BusNumber, bool)) {
        if heard.is_empty() {
            return;
        }
        for bus in self.expected.iter() {
            let cycles = &mut self.cycles[bus.index()];
            *cycles = if heard.has(bus) { 0 } else { cycles.saturating_add(1) };
            let silent = *cycles > self.patience;
            if silent != self.reported.has(bus) && (silent || *cycles == 0) {
                if silent {
                    self.reported.insert(bus)
                } else {
                    self.reported.remove(bus)
                }
                report(bus, silent);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIRST: BusNumber = BusNumber::First;
    const SECOND: BusNumber = BusNumber::Second;

    fn silence() -> Silence {
        let expected = [FIRST, SECOND].into_iter().collect();
        Silence { expected, patience: 5, cycles: Default::default(), reported: Buses::NONE }
    }

    /// What is reported in `cycles` cycles in which `heard` are heard, with the number of the cycle, from 1.
    fn reports(
        silence: &mut Silence,
        cycles: usize,
        heard: &[BusNumber],
    ) -> Vec<(usize, BusNumber, bool)> {
        let mut reports = Vec::new();
        for cycle in 1..=cycles {
            silence.follow(heard.iter().copied().collect(), |bus, silent| {
                reports.push((cycle, bus, silent));
            });
        }
        reports
    }

    #[test]
    fn a_bus_that_falls_silent_is_reported_once_and_again_when_it_is_heard() {
        let mut silence = silence();
        assert_eq!(reports(&mut silence, 100, &[FIRST, SECOND]), []);
        assert_eq!(reports(&mut silence, 5, &[FIRST]), []);
        assert_eq!(reports(&mut silence, 1, &[FIRST, SECOND]), [], "so much may be lost");
        assert_eq!(reports(&mut silence, 100, &[FIRST]), [(6, SECOND, true)]);
        assert_eq!(reports(&mut silence, 100, &[SECOND]), [(1, SECOND, false), (6, FIRST, true)]);
    }

    #[test]
    fn silence_of_all_buses_is_nobodys() {
        let mut silence = silence();
        assert_eq!(reports(&mut silence, 100, &[]), []);
        assert_eq!(reports(&mut silence, 5, &[SECOND]), []);
        assert_eq!(reports(&mut silence, 100, &[]), []);
        assert_eq!(reports(&mut silence, 2, &[SECOND]), [(1, FIRST, true)]);
    }
}
