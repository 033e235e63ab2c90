//! The command of a cylinder: whether it comes, and how far it moves the rod in a cycle.

use super::CylinderDesign;
use crate::observe::commands::CommandWatch;
use crate::sample::Quality;
use crate::state::state;

/// What is known of the command.
#[derive(Clone, Debug)]
pub(super) struct CommandState {
    /// Whether it was beyond those that the thresholds were learnt with.
    pub watch: CommandWatch,
    /// Cycles since the newest one in which its bus was heard.
    missing: u32,
    /// Cycles of those after which it is stale.
    stale: u32,
    /// Whether none came because its bus is silent.
    is_silent: bool,
    /// Way in one cycle of the newest command that moves the cylinder, m, signed; zero where it does not.
    pub way: f64,
}

state! {
    CommandState { watch, missing, is_silent, way }
    but { stale }
}

impl CommandState {
    pub fn new(design: &CylinderDesign) -> Self {
        let watch = CommandWatch::new(design.commands, design.observers[0].settle);
        Self { watch, missing: 0, stale: design.command_stale, is_silent: false, way: 0.0 }
    }

    /// Takes the command of a cycle, m/s, less that at which the cylinder rests; `is_heard` if anything came from its bus.
    #[inline(always)]
    pub fn follow(
        &mut self,
        command: Option<f64>,
        is_heard: bool,
        design: &CylinderDesign,
    ) -> Quality {
        match command {
            Some(u) => {
                self.missing = 0;
                let moves = u.abs() > design.moving_speed;
                self.way = if moves { u * design.bank.sample_time } else { 0.0 };
            }
            None => self.missing = self.missing.saturating_add(u32::from(is_heard)),
        }
        self.is_silent = command.is_none() && !is_heard;
        match command {
            Some(_) => Quality::Good,
            None if self.is_stale() => Quality::Stale,
            None => Quality::Missing,
        }
    }

    pub const fn is_stale(&self) -> bool {
        self.missing >= self.stale
    }

    /// Whether the model may predict by it: it comes, or observers hold the last one.
    #[inline]
    pub const fn is_known(&self) -> bool {
        !self.is_stale() && !self.is_silent
    }

    /// Whether none came in the newest cycle.
    pub const fn is_absent(&self) -> bool {
        self.missing > 0 || self.is_silent
    }

    /// Forgets the motion, after a time of which nothing is known.
    pub const fn interrupt(&mut self) {
        self.way = 0.0;
        self.watch.reset();
    }
}
