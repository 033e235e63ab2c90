//! What a recording contains that a healthy cylinder does not show, in words.

use super::watch::{OwnLevel, Sight};
use crate::extremes::{Asked, LARGEST_LEVEL};
use std::fmt;

/// Evidence that contradicts the theory of a healthy cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contradiction {
    pub worst: Sight,
    pub asked: Asked,
}

impl Contradiction {
    pub fn of(level: &OwnLevel) -> Option<Self> {
        Some(Self { worst: level.contradiction()?, asked: level.asked? })
    }
}

impl fmt::Display for Contradiction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Sight { nats, t, length, width, scatter, .. } = self.worst;
        let what = if scatter { "a scatter that grew" } else { "a mean that moved" };
        let most = LARGEST_LEVEL;
        write!(
            f,
            "this is not a recording of a healthy cylinder: {nats:.1} nats of evidence at {t:.1} \
             s, C1 at \
             {length:.3} m, by {what} over {width} samples"
        )?;
        if self.asked.nats > most {
            write!(
                f,
                "; to tolerate it, a level of {:.0} nats would be needed, and beyond {most} the \
                 detector would hardly find any fault",
                self.asked.nats
            )?;
        }
        f.write_str(
            "; look there (`replay --report`) for a fault, spikes, a stop or a valve that sticks, and \
             leave that part out (--from, --to)",
        )
    }
}
