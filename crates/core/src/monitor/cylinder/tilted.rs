//! What the deck's attitude is compared by, and what it finds of the cylinder.

use super::{Cylinder, TRANSDUCERS};
use crate::alarm::{Evidence, Finding};
use crate::blame::{Accuser, Rule};
use crate::hexapod::{TiltError, TiltLeg};
use crate::sample::Transducer;
use crate::sequential::Sequential;
use crate::state::whole;
use crate::time::{Span, Timestamp};
use crate::verdict::{Fault, Suspect, Testimony};

/// The error of the only transducer, by the deck's attitude.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tilted {
    fault: Fault,
    /// m.
    size: f64,
    /// That the tilt is not the usual one, and that no other cylinder explains it, nats.
    nats: [f64; 2],
    onset: Timestamp,
}

whole! { Tilted { fault, size, nats, onset } }

impl Cylinder {
    /// What the deck's attitude is compared by in the newest cycle.
    pub fn tilt_leg(&self) -> TiltLeg {
        let parted = || self.sequential.as_deref().and_then(Sequential::residual);
        let (is_doubted, has_parted) = self.doubts();
        let is_single = !self.has(Transducer::C2);
        // Nothing else shows that a single reading is wild, and its mean would be wrong for seconds.
        let is_wild = is_single && self.fde.bank.is_open(TRANSDUCERS[0] as usize);
        TiltLeg {
            length: self.length.filter(|_| !is_wild),
            is_healthy: !is_doubted,
            is_single,
            parted: has_parted.then(parted),
        }
    }

    /// Takes the evidence of whose reading has moved that the deck's attitude gives, nats.
    pub fn take_attitude_evidence(&mut self, nats: f64) {
        if let Some(sequential) = &mut self.sequential {
            sequential.take_evidence(Testimony::Attitude, nats);
        }
    }

    /// Takes at `at` that the only transducer is off.
    pub fn take_tilt_error(&mut self, at: Timestamp, error: &TiltError) {
        let (size, nats) = (error.size, [error.nats, error.apart]);
        let (fault, onset) = match &self.tilted {
            Some(before) => (before.fault, before.onset),
            None => (self.kind_of_tilt(), at.after(Span::from_seconds(-error.since))),
        };
        self.tilted = Some(Tilted { fault, size, nats, onset });
        self.is_busy = true;
    }

    /// Takes that the deck is again where the only transducer has it.
    pub const fn end_tilt_error(&mut self) {
        self.tilted = None;
    }

    /// The kind of an error that tilts the deck: a step of that size is seen by the observer, so that what it has not seen
    /// has grown slowly.
    fn kind_of_tilt(&self) -> Fault {
        let latched = self.last.names(0).then(|| self.observer_finding(Accuser::Fde1)).flatten();
        let of_observer = latched.map(|it| it.fault);
        let unseen = if self.design.observes { Fault::Incipient } else { Fault::Unclassified };
        of_observer.unwrap_or(unseen)
    }

    /// The finding of the deck's attitude where the cylinder has one transducer.
    pub(super) fn tilted_finding(&self) -> Option<Finding> {
        let Tilted { fault, size, nats: [beyond, apart], onset } = self.tilted?;
        Some(Finding {
            fault,
            suspect: Suspect::C1,
            rule: Rule::DeckAttitude,
            level: self.design.levels.both,
            residual: Some(size),
            threshold: None,
            evidence: Some(Evidence {
                fault: beyond,
                location: Some(apart),
                by: Some(Testimony::Attitude),
                onset,
                gain: None,
                size: None,
            }),
            device: None,
        })
    }
}
