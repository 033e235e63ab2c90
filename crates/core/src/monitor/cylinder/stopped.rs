//! What a cylinder reads on its mechanical stop, over days and months.
//!
//! A pair hands what the stops say to its sequential detector. An only transducer has none: what C1 reads there
//! is then compared with what it read there before. A stop that wears by more than usual, or that is dented,
//! looks the same, so that the finding leaves open which of the two it is.

use super::{Cycle, CylinderDesign};
use crate::alarm::{Evidence, Finding, Level};
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
    pub fn of(design: &CylinderDesign) -> Option<Box<Self>> {
        let is_judged = design.sequential.is_some() || !design.has(Transducer::C2);
        is_judged.then(|| {
            let mut on_stop = Box::<Self>::default();
            on_stop.restore(&DwellHistory::default(), design);
            on_stop
        })
    }

    /// Readings on the stop so far.
    pub const fn history(&self) -> &DwellHistory {
        &self.history
    }

    /// Restores the dwells of an earlier monitor.
    pub fn restore(&mut self, dwells: &DwellHistory, design: &CylinderDesign) {
        self.history.clone_from(dwells);
        match &design.sequential {
            Some(sequential) => {
                let Comparator { gain, offset } = design.comparator;
                let [one, two] = sequential.resolution;
                let corrected = Some([gain, offset]);
                self.history.gauge(Gauging { count: one.max(two), corrected });
            }
            None => self.history.keep_c1(),
        }
    }

    /// Takes the readings of a cycle on the stop.
    #[inline(never)]
    pub fn stand(&mut self, cycle: &Cycle, has_c2: bool) {
        let [c1, c2] = cycle.lengths();
        let readings = match has_c2 {
            true => c1.zip(c2).map(|(c1, c2)| StopReadings::both([c1, c2])),
            false => c1.map(StopReadings::single),
        };
        if let Some(dwell) = self.dwelling.step(cycle.now.opened, readings) {
            self.history.add(dwell);
            self.dwelt = Some(dwell);
        }
    }

    /// Takes a cycle off the stop.
    #[inline]
    pub fn leave(&mut self) {
        self.dwelling.leave();
    }

    /// Reading on the stop in the newest cycle, returned once.
    pub fn take_dwell(&mut self) -> Option<Dwell> {
        self.dwelt.take()
    }

    /// Takes the judgement of the only transducer from the dwells of the machine up to `at`.
    pub fn judge(&mut self, at: Timestamp, judgement: &Judgement) {
        if judgement.blame == Blame::C1 {
            let size = judgement.moved.c1;
            self.drift.get_or_insert(StopDrift { size, onset: at });
        } else {
            self.drift = None;
        }
    }

    /// Whether the stop finds anything of the only transducer.
    #[inline]
    pub const fn has_drifted(&self) -> bool {
        self.drift.is_some()
    }

    /// The finding of the stop where the cylinder has one transducer, of this `level`. It blames nobody: a millimetre of
    /// months makes neither the estimate nor the supervision of C1 worthless, and it may be the stop's.
    pub fn finding(&self, level: Level) -> Option<Finding> {
        let drift = self.drift.as_ref()?;
        Some(Finding {
            fault: Fault::Incipient,
            suspect: Suspect::Undecided,
            rule: Rule::Stop,
            level,
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

    /// Forgets the stay of which a part may be missing.
    pub fn interrupt(&mut self) {
        self.dwelling = Dwelling::default();
    }
}
