//! What the thesis says of its faults (section 5-4), and whether it holds.

use crate::evaluate::outcome::Outcome;
use crate::evaluate::proportion::Proportion;
use serde::Serialize;

/// A claim of the thesis about the residual of the faulty transducer's own observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Claim {
    /// Every fault is found within one sample (section 5-4-2).
    AtOnce,
    /// Not all faults are found.
    NotAlways,
    /// δ_h is not crossed (section 5-4-3).
    Never,
    /// δ_h is crossed.
    Found,
    /// Every fault is found within this many seconds (section 5-4-4).
    Within(f64),
}

/// A claim beside what was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judged {
    pub claim: String,
    /// How often δ_h was crossed in the claim's time.
    pub found: Proportion,
    /// How often any detector found the fault in that time.
    pub by_any: Proportion,
    pub holds: bool,
}

impl Claim {
    /// The claim in words.
    pub fn text(self) -> String {
        match self {
            Self::AtOnce => "found at once".to_owned(),
            Self::NotAlways => "not always found".to_owned(),
            Self::Never => "below δ_h".to_owned(),
            Self::Found => "crosses δ_h".to_owned(),
            Self::Within(seconds) => format!("within {seconds} s"),
        }
    }

    /// Whether the claim holds for `outcomes`. "Every" fault means every one that was tried.
    pub fn judge(self, outcomes: &[Outcome], sample_time: f64) -> Judged {
        let limit = match self {
            Self::AtOnce => sample_time,
            // Sampled at Sync, judged when the cycle is complete: a part of a sample later.
            Self::Within(seconds) => seconds + sample_time,
            Self::NotAlways | Self::Never | Self::Found => f64::INFINITY,
        };
        let in_time = |delay: Option<f64>| delay.is_some_and(|delay| delay < limit);
        let found = Proportion::counting(outcomes, |outcome| in_time(outcome.own()));
        let by_any = Proportion::counting(outcomes, |outcome| in_time(outcome.delay()));
        let holds = match self {
            Self::AtOnce | Self::Found | Self::Within(_) => found.count == found.of,
            Self::NotAlways => found.count < found.of,
            Self::Never => found.count == 0,
        };
        Judged { claim: self.text(), found, by_any, holds }
    }
}
