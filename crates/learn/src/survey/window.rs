//! A part of a recording by time.

/// The time from `from` to `to`, exclusive, in seconds since the first frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    pub from: f64,
    pub to: f64,
}

impl Window {
    /// The whole recording.
    pub const ALL: Self = Self { from: f64::NEG_INFINITY, to: f64::INFINITY };

    pub fn holds(&self, t: f64) -> bool {
        self.from <= t && t < self.to
    }

    /// The parts before and after `part` (0 to 1) of this window.
    pub fn split(&self, part: f64) -> [Self; 2] {
        let middle = self.from + part * (self.to - self.from);
        [Self { from: self.from, to: middle }, Self { from: middle, to: self.to }]
    }

    /// Length, s.
    pub fn length(&self) -> f64 {
        self.to - self.from
    }
}
