//! What the deck's attitude finds of the only transducer.

use crate::alarm::{Evidence, Finding, Level};
use crate::blame::Rule;
use crate::state::whole;
use crate::time::Timestamp;
use crate::verdict::{Fault, Suspect, Testimony};

/// The error of the only transducer, by the deck's attitude.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tilted {
    pub fault: Fault,
    /// m.
    pub size: f64,
    /// That the tilt is not the usual one, and that no other cylinder explains it, nats.
    pub nats: [f64; 2],
    pub onset: Timestamp,
}

whole! { Tilted { fault, size, nats, onset } }

impl Tilted {
    /// The finding of the deck's attitude where the cylinder has one transducer, of this `level`.
    pub const fn finding(&self, level: Level) -> Finding {
        let Self { fault, size, nats: [beyond, apart], onset } = *self;
        Finding {
            fault,
            suspect: Suspect::C1,
            rule: Rule::DeckAttitude,
            level,
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
        }
    }
}
