//! Slow faults, and the stop that tells which transducer has them.

use super::ladder::Ladder;
use super::trial::{Entry, Heard};
use crate::evaluate::learning::Learnt;
use crate::evaluate::stand::{Stand, StandError};
use crate::evaluate::tried::Try;
use tertius_core::alarm::Warning;
use tertius_core::monitor::{Monitor, Sink};
use tertius_core::time::Span;
use tertius_machine::controller::State;
use tertius_machine::simulator::Options;

/// Times that the rods have stood on their stops before the faults begin.
const BEFORE: usize = 5;

/// Time engaged, s.
const ENGAGED: f64 = 60.0;
/// Time on the way down and at the stop, s.
const STOPPED: f64 = 60.0;

/// When the faults begin, s: the machine has left the last of the healthy stops.
pub const BEGIN: f64 = (ENGAGED + STOPPED) * BEFORE as f64;

#[derive(Default)]
struct Ears(Vec<Warning>);

impl Sink for Ears {
    fn warning(&mut self, warning: &Warning) {
        self.0.push(*warning);
    }
}

impl Stand<'_> {
    /// Plays `one` in `sea`: the rods go to their stops repeatedly, and once more with the faults.
    /// Warnings count until the rods leave that stop.
    ///
    /// # Errors
    /// If there is no such machine, or no place for such a fault on it.
    pub fn stop(
        &self,
        learnt: &Learnt,
        one: &Try,
        sea: [f64; 2],
    ) -> Result<Vec<Entry>, StandError> {
        let options = Options {
            seed: one.seed,
            sea: Some(sea),
            in_loop: true,
            start: State::Safe,
            faults: self.placed(one)?,
            ..Options::default()
        };
        let mut simulator = self.steady(learnt.grade, &options)?;
        let mut monitor = Monitor::new(learnt.design.clone());
        let mut ears = Ears::default();
        let begun = simulator.opening();
        for _ in 0..=BEFORE {
            for (state, seconds) in [(State::Engaged, ENGAGED), (State::Safe, STOPPED)] {
                simulator.request(state);
                for _ in 0..self.cycles(seconds) {
                    simulator.step(&mut |frame| monitor.take(frame, &mut ears));
                }
            }
        }
        let end = simulator.opening();
        monitor.finish(&mut ears);
        let entries = one.faults.iter().map(|fault| {
            let onset = begun.after(Span::from_seconds(fault.at));
            let heard = Heard { warnings: &ears.0, onset, end };
            heard.entry(fault.cylinder, fault.transducer, Ladder::default())
        });
        Ok(entries.collect())
    }
}
