//! How long C1 − C2 stands off.
//!
//! For each of some levels there is a box around it. A step of any size fills one of them for as long as it lasts, a healthy
//! difference as long as an excursion, or two one after the other, which begin and end to the sample.

use super::filled::Filled;
use super::limits::{BOXES, ExcursionLimits, STRAYS};
use crate::state::state;

/// Runs in either direction.
const SIDES: usize = 2;

/// The newest samples outside of a box: the newest one, the one before, and the one before that.
type Outside = [u32; STRAYS];

#[derive(Clone, Debug)]
pub struct Runs {
    boxes: [[f64; 2]; BOXES],
    /// 1 by the limit, 0 where there is none.
    parts: [[f64; STRAYS]; BOXES],
    /// Number of samples that came.
    count: u32,
    outside: [[Outside; BOXES]; SIDES],
    /// Samples in a row outside of all boxes. Beyond [`STRAYS`] there is nothing to be noted.
    idle: u32,
}

state! {
    Runs { count, outside, idle }
    but { boxes, parts }
    sound |it| it.outside.iter().flatten().flatten().all(|at| *at <= it.count)
}

impl Runs {
    pub fn new(limits: &ExcursionLimits) -> Self {
        let part = |limit: Option<u16>| limit.map_or(0.0, |limit| 1.0 / f64::from(limit.max(1)));
        Self {
            boxes: limits.boxes,
            parts: limits.runs.map(|of_box| of_box.map(part)),
            count: 0,
            outside: [[[0; STRAYS]; BOXES]; SIDES],
            idle: STRAYS as u32,
        }
    }

    pub const fn clear(&mut self) {
        self.count = 0;
        self.outside = [[[0; STRAYS]; BOXES]; SIDES];
        self.idle = STRAYS as u32;
    }

    /// Takes a residual, m: the longest run as a part of its limit.
    #[inline]
    pub fn step(&mut self, residual: f64) -> Filled {
        if self.count == u32::MAX {
            // After 2.7 years at 50 Hz.
            self.clear();
        }
        self.count += 1;
        if residual.abs() < self.boxes[0][0] {
            self.idle = self.idle.saturating_add(1);
            if self.idle > STRAYS as u32 {
                return Filled::default();
            }
        }
        self.note(residual)
    }

    #[cold]
    fn note(&mut self, residual: f64) -> Filled {
        let off = residual.abs() >= self.boxes[0][0];
        if off {
            if self.idle >= STRAYS as u32 {
                let before = |ago: u32| self.count.saturating_sub(ago);
                self.outside = [[core::array::from_fn(|i| before(1 + i as u32)); BOXES]; SIDES];
            }
            self.idle = 0;
        }
        let mut filled = Filled::default();
        for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
            let along = sign * residual;
            for ((outside, [low, high]), parts) in
                self.outside[side].iter_mut().zip(&self.boxes).zip(&self.parts)
            {
                if along < *low || along > *high {
                    outside.rotate_right(1);
                    outside[0] = self.count;
                }
                for (strays, (last, part)) in (0..).zip(outside.iter().zip(parts)) {
                    let run = (self.count - last).saturating_sub(strays);
                    // Half a sample on, since a run that has reached its limit is beyond it.
                    let part = (f64::from(run) + 0.5) * part;
                    if run > 0 {
                        filled.raise(part, (self.count - last) as usize);
                    }
                }
            }
        }
        filled
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::limits;
    use super::*;

    /// The first sample whose run is too long.
    fn found(runs: &mut Runs, residuals: impl IntoIterator<Item = f64>) -> Option<usize> {
        residuals.into_iter().position(|residual| runs.step(residual).part > 1.0)
    }

    #[test]
    fn a_level_is_found_when_it_has_stood_for_longer_than_its_limit() {
        let limits = limits();
        for sign in [1.0, -1.0] {
            let mut runs = Runs::new(&limits);
            assert_eq!(found(&mut runs, [0.0; 500]), None);
            // Boxes of the lowest level have a limit of 31 samples: the 31st is too much.
            assert_eq!(found(&mut runs, [sign * 0.4e-3; 40]), Some(30));
            runs.clear();
            assert_eq!(found(&mut runs, [sign * 0.4e-3; 30]), None);
        }
    }

    #[test]
    fn one_or_two_strays_do_not_begin_a_run_anew() {
        let limits = limits();
        for (strays, limit) in [(&[20][..], 41), (&[14, 28], 42)] {
            let mut runs = Runs::new(&limits);
            let residual = |k: usize| if strays.contains(&k) { 0.0 } else { 0.4e-3 };
            found(&mut runs, [0.0; 10]);
            assert_eq!(found(&mut runs, (0..60).map(residual)), Some(limit + strays.len() - 1));
        }
        let mut runs = Runs::new(&limits);
        let residual = |k: usize| if k % 8 == 5 { 0.0 } else { 0.4e-3 };
        assert_eq!(found(&mut runs, (0..400).map(residual)), None);
    }

    /// What is noted only now and then is as if it were always.
    #[test]
    fn samples_in_no_box_are_outside_of_all() {
        let limits = limits();
        let mut runs = Runs::new(&limits);
        for gap in 1..6 {
            found(&mut runs, [0.4e-3; 25]);
            let found = found(&mut runs, [vec![0.0; gap], vec![0.4e-3; 20]].concat());
            assert_eq!(found.is_some(), gap <= 2, "{gap}");
            runs.clear();
        }
    }
}
