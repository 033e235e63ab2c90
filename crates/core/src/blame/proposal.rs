//! What a detector proposes.

use super::rule::Rule;
use crate::sample::Transducer;
use crate::state::whole;
use crate::verdict::Suspect;

/// A suspect and the rule that named it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Blamed {
    pub suspect: Suspect,
    pub rule: Rule,
}

whole! { Blamed { suspect, rule } }

impl Blamed {
    pub const fn new(suspect: Suspect, rule: Rule) -> Self {
        Self { suspect, rule }
    }
}

/// A detector whose finding names one of two transducers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Accuser {
    Fde1,
    Fde2,
    Fde3,
    Sequential,
}

impl Accuser {
    pub const ALL: [Self; 4] = [Self::Fde1, Self::Fde2, Self::Fde3, Self::Sequential];

    /// The transducer that it follows; `None` where it compares both.
    pub const fn observed(self) -> Option<Transducer> {
        match self {
            Self::Fde1 => Some(Transducer::C1),
            Self::Fde2 => Some(Transducer::C2),
            Self::Fde3 | Self::Sequential => None,
        }
    }
}

/// The suspect that a transducer is.
pub const fn suspect_of(transducer: Transducer) -> Suspect {
    match transducer {
        Transducer::C1 => Suspect::C1,
        Transducer::C2 => Suspect::C2,
    }
}
