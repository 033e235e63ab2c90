//! A reading that stands, and what the other one does meanwhile.

use super::limits::PlausibilityLimits;
use super::moment::Moment;
use crate::sample::parameters::PlausibilityParameters;
use crate::state::whole;

const P: &PlausibilityParameters = &PlausibilityParameters::DEFAULT;

/// An exactly constant reading: since when, and what was seen meanwhile.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stillness {
    pub cycles: u32,
    /// Number of cycles under a command that moves, by its [`Push`].
    pub pushed: [u32; 2],
    /// First two readings of the other transducer, at the beginning or where its way began anew, m: either may be wild.
    first: [Option<f64>; 2],
    /// Newest reading of the other transducer, m, and cycles without one.
    seen: Option<f64>,
    pub unseen: u32,
    /// Whether the other transducer has read anything else since.
    pub stirred: bool,
    /// Distance that the other transducer has moved since in a continuous motion, m.
    pub travelled: f64,
    /// The same, whichever of its first two readings and of its newest two is wild. A spike of four coarse counts had a resting
    /// rod called frozen.
    pub witnessed: f64,
}

whole! { Stillness { cycles, pushed, first, seen, unseen, stirred, travelled, witnessed } }

impl Stillness {
    /// Another cycle of it, after one in which the other transducer read `before`, m. Where that one was not there for
    /// longer than what is frozen takes, or has leapt far, its way begins anew: what it reads after a fault may be anywhere.
    pub fn go_on(&mut self, before: Option<f64>, moment: &Moment, limits: &PlausibilityLimits) {
        if self.cycles == 0 {
            self.first = [before, None];
        }
        self.cycles = self.cycles.saturating_add(1);
        if let Some(push) = moment.push {
            let pushed = &mut self.pushed[push as usize];
            *pushed = pushed.saturating_add(1);
        }
        let Some(now) = moment.other else {
            self.unseen = self.unseen.saturating_add(1);
            return;
        };
        // If it was not there at the beginning, its way begins here.
        let then = *self.first[0].get_or_insert(now.position);
        self.stirred |= now.position != then;
        let before = self.seen.replace(now.position);
        let leap = (now.position - before.unwrap_or(then)).abs();
        let leaps = !now.goes_on && leap > P.jump * limits.travel;
        let is_elsewhere = self.unseen > limits.frozen || leaps;
        self.unseen = 0;
        if is_elsewhere {
            self.first = [Some(now.position), None];
            return;
        }
        let second = *self.first[1].get_or_insert(now.position);
        if now.goes_on {
            let [way, former] = [now.position, before.unwrap_or(then)]
                .map(|newest| [then, second].map(|first| (newest - first).abs()));
            self.travelled = self.travelled.max(way[0]);
            self.witnessed = self.witnessed.max(way[0].min(way[1]).min(former[0]).min(former[1]));
        }
    }
}
