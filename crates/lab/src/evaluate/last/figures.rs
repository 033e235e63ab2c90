//! Figures of the last transducers.

use super::cases::{LastGroup, Outage};
use super::outcome::{LastOutcome, LastQuiet};
use crate::evaluate::fault::fault_label;
use crate::evaluate::figures::{Delay, Found, SuspectFigures, WITHIN};
use crate::evaluate::proportion::Proportion;
use crate::evaluate::rate::Rate;
use serde::Serialize;
use std::collections::BTreeMap;
use tertius_machine::inject::Wanted;

/// The result of the study.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LastResult {
    pub faults: Vec<LastFigures>,
    pub hours: Vec<LastHours>,
}

/// One fault of the last transducer after one outage of the other one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LastFigures {
    pub grade: &'static str,
    /// State of the other transducer.
    pub outage: &'static str,
    pub in_loop: bool,
    pub label: String,
    /// Number of faults that the figures are of.
    pub faults: u64,
    /// Faults of a transducer that was named already when they began; no other figure counts them.
    pub spoilt: u64,
    /// Faults of which the last transducer was named within each of [`WITHIN`].
    pub found: [Found; WITHIN.len()],
    /// Quantiles of the time until it was named, s.
    pub delay: Delay,
    /// Faults after which a warning named the last transducer, and faults after which one said something else. A fault
    /// may count in several of these.
    pub named: SuspectFigures,
    /// Median and maximum of the time in which the estimate was valid and off by more than three of its standard
    /// deviations, s.
    pub wrong: [f64; 2],
    /// Faults for which that time was longer than the delay, and those that were not found, if it was not 0.
    pub outlasted: Proportion,
}

/// Machines with an outage and no other fault.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LastHours {
    pub grade: &'static str,
    pub outage: &'static str,
    /// Hours of one cylinder.
    pub hours: f64,
    /// False warnings of one cylinder that named its last transducer.
    pub named: Rate,
    /// False warnings of one cylinder that named no transducer that it has or had.
    pub otherwise: Rate,
}

/// What became of a trial.
#[derive(Clone, Debug, PartialEq)]
pub enum LastProduct {
    /// By outage and fault, of a machine of that group.
    Faulty { group: usize, number: u32, outcomes: Vec<Vec<LastOutcome>> },
    /// Of a machine with that outage of that group.
    Quiet { group: usize, outage: usize, quiet: LastQuiet },
}

/// Products so far.
#[derive(Clone, Debug, Default)]
pub struct LastGathered {
    /// By group and number of the machine.
    faulty: BTreeMap<(usize, u32), Vec<Vec<LastOutcome>>>,
    /// By group and outage.
    quiet: BTreeMap<(usize, usize), LastQuiet>,
}

impl LastGathered {
    pub(super) fn add(&mut self, product: LastProduct) {
        match product {
            LastProduct::Faulty { group, number, outcomes } => {
                self.faulty.insert((group, number), outcomes);
            }
            LastProduct::Quiet { group, outage, quiet } => {
                self.quiet.entry((group, outage)).or_default().add(quiet);
            }
        }
    }

    /// The figures of every one of `wanted` after every outage; `sample_time` is the machine's, s.
    pub(super) fn result(
        &self,
        groups: &[LastGroup],
        wanted: &[Option<Wanted>],
        sample_time: f64,
    ) -> LastResult {
        let mut faults = Vec::new();
        for (index, group) in groups.iter().enumerate() {
            let each = group.outages().iter().flat_map(|it| wanted.iter().map(move |f| (it, f)));
            for (place, (outage, wanted)) in each.enumerate() {
                let machines = self.faulty.range((index, 0)..=(index, u32::MAX));
                let outcomes = machines.flat_map(|(_, outcomes)| &outcomes[place]);
                let outcomes: Vec<LastOutcome> = outcomes.copied().collect();
                faults.push(LastFigures::of(group, *outage, *wanted, &outcomes));
            }
        }
        let hours = self.quiet.iter().map(|((group, outage), quiet)| {
            let group = &groups[*group];
            let hours = quiet.cycles as f64 * sample_time / 3600.0;
            LastHours {
                grade: group.grade.name(),
                outage: group.outages()[*outage].name(),
                hours,
                named: Rate::new(quiet.named, hours),
                otherwise: Rate::new(quiet.otherwise, hours),
            }
        });
        LastResult { faults, hours: hours.collect() }
    }
}

impl LastFigures {
    fn of(
        group: &LastGroup,
        outage: Outage,
        wanted: Option<Wanted>,
        outcomes: &[LastOutcome],
    ) -> Self {
        let fair: Vec<LastOutcome> = outcomes.iter().filter(|it| !it.spoilt).copied().collect();
        let within = |within: f64| Found {
            within,
            found: Proportion::counting(&fair, |it| it.delay.is_some_and(|delay| delay <= within)),
        };
        let otherwise = |at: usize| fair.iter().filter(|it| it.otherwise[at]).count() as u64;
        let mut wrong: Vec<f64> = fair.iter().map(|it| it.wrong).collect();
        wrong.sort_unstable_by(f64::total_cmp);
        let at = |index: usize| wrong.get(index).copied().unwrap_or(0.0);
        Self {
            grade: group.grade.name(),
            outage: outage.name(),
            in_loop: group.in_loop,
            label: fault_label(wanted),
            faults: fair.len() as u64,
            spoilt: (outcomes.len() - fair.len()) as u64,
            found: WITHIN.map(within),
            delay: Delay::of(fair.iter().map(|it| it.delay).collect()),
            named: SuspectFigures {
                right: fair.iter().filter(|it| it.delay.is_some()).count() as u64,
                undecided: otherwise(0),
                process: otherwise(1),
                wrong: otherwise(2),
            },
            wrong: [at(wrong.len() / 2), at(wrong.len().saturating_sub(1))],
            outlasted: Proportion::counting(&fair, |it| it.outlasted),
        }
    }
}
