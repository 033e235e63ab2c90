//! What a cylinder reads on its mechanical stop, over days and months.
//!
//! A pair hands what the stops say to its sequential detector. An only transducer has none: what C1 reads there
//! is then compared with what it read there before. A stop that wears by more than usual, or that is dented,
//! looks the same, so that the finding leaves open which of the two it is.

use super::{Cycle, Cylinder};
use crate::alarm::{Evidence, Finding};
use crate::blame::Rule;
use crate::compare::Comparator;
use crate::sample::Transducer;
use crate::sequential::dwell::Dwelling;
use crate::sequential::{Blame, Dwell, DwellHistory, Gauging, Judgement, StopReadings};
use crate::state::{state, whole};
use crate::time::Timestamp;
use crate::verdict::{Fault, Suspect, Testimony};
use alloc::boxed::Box;

/// Readings of a cylinder on its stop.
#[derive(Clone, Debug, Default)]
pub(super) struct OnStop {
    dwelling: Dwelling,
    history: DwellHistory,
    /// Dwell of the newest cycle.
    dwelt: Option<Dwell>,
    /// What the stop finds of the only transducer.
    drift: Option<StopDrift>,
}

state! {
    OnStop { dwelling, history, dwelt, drift }
}

/// What the stop finds of the only transducer.
#[derive(Clone, Copy, Debug)]
pub(super) struct StopDrift {
    /// m, when it was found.
    size: f64,
    onset: Timestamp,
}

whole! { StopDrift { size, onset } }

impl OnStop {
    /// `None` on a pair that no calibration compares: its stops are not judged.
    pub fn of(is_compared: bool, has_c2: bool) -> Option<Box<Self>> {
        (is_compared || !has_c2).then(Box::default)
    }

    /// Forgets the stay of which a part may be missing.
    pub fn interrupt(&mut self) {
        self.dwelling = Dwelling::default();
    }
}

impl Cylinder {
    /// Takes the readings of a cycle, on the stop or not.
    #[inline]
    pub(super) fn rest(&mut self, cycle: &Cycle) {
        match &mut self.on_stop {
            Some(_) if cycle.now.at_stop => self.stand(cycle),
            Some(on_stop) => on_stop.dwelling.leave(),
            None => {}
        }
    }

    /// Takes the readings of a cycle on the stop.
    #[inline(never)]
    fn stand(&mut self, cycle: &Cycle) {
        let has_c2 = self.has(Transducer::C2);
        let Some(on_stop) = &mut self.on_stop else { return };
        let [c1, c2] = cycle.lengths();
        let readings = match has_c2 {
            true => c1.zip(c2).map(|(c1, c2)| StopReadings::both([c1, c2])),
            false => c1.map(StopReadings::single),
        };
        if let Some(dwell) = on_stop.dwelling.step(cycle.now.opened, readings) {
            on_stop.history.add(dwell);
            on_stop.dwelt = Some(dwell);
        }
    }

    /// Reading on the stop in the newest cycle, returned once.
    pub fn take_dwell(&mut self) -> Option<Dwell> {
        self.on_stop.as_mut()?.dwelt.take()
    }

    /// Cylinder number and readings on the stop so far, if they are kept.
    pub fn dwells(&self) -> Option<(u8, &DwellHistory)> {
        Some((self.design.number, &self.on_stop.as_ref()?.history))
    }

    /// Restores the dwells of an earlier monitor, if the cylinder keeps any.
    pub fn restore(&mut self, dwells: &DwellHistory) {
        let Some(on_stop) = &mut self.on_stop else { return };
        on_stop.history.clone_from(dwells);
        match &self.design.sequential {
            Some(design) => {
                let Comparator { gain, offset } = self.design.comparator;
                let [one, two] = design.resolution;
                let corrected = Some([gain, offset]);
                on_stop.history.gauge(Gauging { count: one.max(two), corrected });
            }
            None => on_stop.history.keep_c1(),
        }
    }

    /// Takes the judgement of this cylinder from the dwells of the machine up to `at`.
    pub fn judge_stop(&mut self, at: Timestamp, judgement: &Judgement) {
        match (&mut self.sequential, &mut self.on_stop) {
            (Some(sequential), _) => sequential.judge_stop(at, judgement),
            (None, Some(on_stop)) if judgement.blame == Blame::C1 => {
                let size = judgement.moved.c1;
                on_stop.drift.get_or_insert(StopDrift { size, onset: at });
            }
            (None, Some(on_stop)) => on_stop.drift = None,
            (None, None) => {}
        }
        self.is_busy |= self.has_findings();
    }

    /// Whether the stop finds anything of the only transducer.
    #[inline]
    pub(super) fn has_drifted(&self) -> bool {
        self.on_stop.as_ref().is_some_and(|it| it.drift.is_some())
    }

    /// The finding of the stop where the cylinder has one transducer. It blames nobody: a millimetre of months makes
    /// neither the estimate nor the supervision of C1 worthless, and it may be the stop's.
    pub(super) fn stop_finding(&self) -> Option<Finding> {
        let drift = self.on_stop.as_ref()?.drift.as_ref()?;
        Some(Finding {
            fault: Fault::Incipient,
            suspect: Suspect::Undecided,
            rule: Rule::Stop,
            level: self.design.levels.undecided,
            residual: Some(drift.size),
            threshold: None,
            evidence: Some(Evidence {
                fault: 0.0,
                location: None,
                by: Some(Testimony::Stop),
                onset: drift.onset,
                gain: None,
                size: None,
            }),
            device: None,
        })
    }
}
