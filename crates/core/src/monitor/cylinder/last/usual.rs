//! The motion of the rod in which its observers were quiet. In another one they are no evidence.

use super::parameters::LastParameters;
use crate::sample::plausibility::NOWHERE;
use crate::state::whole;

/// A range of motion: lengths and commands.
#[derive(Clone, Copy, Debug)]
pub struct MotionRange {
    /// Lowest and highest length, m.
    pub been: [f64; 2],
    /// Largest command, m/s.
    pub command: f64,
    /// Largest change of the command from one cycle to the next, m/s.
    pub change: f64,
}

whole! { MotionRange { been, command, change } }

impl MotionRange {
    pub const NONE: Self = Self { been: NOWHERE, command: 0.0, change: 0.0 };

    #[inline]
    pub fn include(&mut self, other: &Self) {
        // Nearly always it is within.
        let ([low, high], [lowest, highest]) = (other.been, self.been);
        if low < lowest || high > highest {
            self.been = [lowest.min(low), highest.max(high)];
        }
        if other.command > self.command {
            self.command = other.command;
        }
        if other.change > self.change {
            self.change = other.change;
        }
    }

    /// Whether it has a command of more than `further` times those of `range`.
    pub fn exceeds(&self, range: &Self, further: f64) -> bool {
        self.command > further * range.command || self.change > further * range.change
    }
}

/// The motion of the rod in which the observers were quiet.
#[derive(Clone, Copy, Debug)]
pub struct UsualMotion {
    pub range: MotionRange,
    /// MotionRange of which it is not known yet whether they stay quiet in it.
    pub tried: MotionRange,
    /// Newest command, m/s.
    pub newest: f64,
    /// Cycles in which nothing was found.
    pub calm: u32,
    /// Cycles for which an innovation may still have the error of another motion.
    pub unusual: u32,
}

whole! { UsualMotion { range, tried, newest, calm, unusual } }

impl UsualMotion {
    #[inline]
    pub fn motion(&mut self, length: f64, command: Option<f64>) -> MotionRange {
        let command = command.unwrap_or(self.newest);
        let before = core::mem::replace(&mut self.newest, command);
        MotionRange { been: [length; 2], command: command.abs(), change: (command - before).abs() }
    }

    /// Takes a cycle in which nothing was found.
    #[inline]
    pub fn extend(&mut self, length: f64, command: Option<f64>) {
        let motion = self.motion(length, command);
        self.range.include(&motion);
        self.calm = self.calm.saturating_add(1);
        self.unusual = 0;
    }

    /// Takes a cycle in which anything was found. Where the observer of the last transducer `is_quiet` for as long as it
    /// takes to `settle`, the motion since is usual, too.
    pub fn try_out(
        &mut self,
        motion: &MotionRange,
        is_elsewhere: bool,
        is_quiet: bool,
        settle: u32,
        parameters: &LastParameters,
    ) {
        let is_new = self.calm < parameters.known.saturating_mul(settle);
        if !is_quiet {
            self.tried = MotionRange::NONE;
        } else if self.unusual == 1 {
            // On its way to a stop the rod is quiet, too: places are learnt from a healthy cylinder, if there was one.
            let been = if is_new { self.tried.been } else { self.range.been };
            self.range.include(&MotionRange { been, ..self.tried });
            self.tried = MotionRange::NONE;
        }
        let is_unusual = is_elsewhere || motion.exceeds(&self.range, parameters.further);
        if is_quiet {
            self.tried.include(motion);
        }
        self.unusual = match is_unusual {
            // Not again for each cycle of it: it is over when it was quiet for long enough.
            true if self.unusual > 0 && is_quiet => self.unusual - 1,
            true => settle,
            false => self.unusual.saturating_sub(1),
        };
    }
}
