//! Sums of the newest samples, of which none may be too large.

use super::filled::Filled;
use super::limits::{CLIPS, ExcursionLimits};
use crate::sequential::parameters::ExcursionParameters;
use crate::sequential::windows::{NARROW_WINDOWS, Sums, WIDE_EVERY, WIDTHS};
use crate::state::state;

/// Values that are summed: the residual by each clip, its square, and whether it is off and elsewhere than the one before.
const VALUES: usize = CLIPS + 2;

/// Most samples of a window.
const WIDEST: usize = 1024;

const _: () = assert!(WIDTHS[WIDTHS.len() - 1] == WIDEST);

#[derive(Clone, Debug)]
pub struct WindowSums {
    clips: [f64; CLIPS],
    /// Beyond this a sample is off, and beyond √2 of it elsewhere, m.
    off: f64,
    /// 1 by the limit of each value in each window.
    parts: [[f64; VALUES]; WIDTHS.len()],
    sums: Sums<WIDEST, VALUES>,
    before: f64,
    /// Number of samples since the wide windows were compared.
    age: u32,
    wide: [Filled; 2],
}

state! {
    WindowSums { sums, before, age, wide }
    but { clips, off, parts }
    sound |it| it.age < WIDE_EVERY
}

/// [`ExcursionParameters::off`], by which calibration and detector count alike.
pub const OFF: f64 = ExcursionParameters::DEFAULT.off;

impl WindowSums {
    pub fn new(limits: &ExcursionLimits) -> Self {
        let part = |limit: f64| if limit > 0.0 { 1.0 / limit } else { 0.0 };
        let parts = |index: usize| {
            let [first, second, third] = limits.sums.map(|sums| sums[index]);
            [first, second, third, limits.squares[index], limits.elsewhere[index]].map(part)
        };
        Self {
            clips: limits.clips,
            off: OFF * limits.rest,
            parts: core::array::from_fn(parts),
            sums: Sums::new(),
            before: 0.0,
            age: 0,
            wide: [Filled::default(); 2],
        }
    }

    pub fn clear(&mut self) {
        self.sums.clear();
        (self.before, self.age, self.wide) = (0.0, 0, [Filled::default(); 2]);
    }

    /// Takes a weighted residual, m: the largest sum, and the largest one of noise, as parts of their limits.
    #[inline]
    pub fn step(&mut self, weighted: f64, widest: usize) -> [Filled; 2] {
        let [first, second, third] = self.clips;
        let clipped = weighted.clamp(-first, first);
        let is_off = weighted.abs() > self.off;
        let moved = (weighted - self.before).abs() > core::f64::consts::SQRT_2 * self.off;
        self.before = weighted;
        self.sums.push([
            clipped,
            weighted.clamp(-second, second),
            weighted.clamp(-third, third),
            clipped * clipped,
            f64::from(u8::from(is_off && moved)),
        ]);
        let reach = self.sums.held().min(widest);
        if self.age == 0 {
            self.wide = self.largest(NARROW_WINDOWS, WIDTHS.len(), reach);
        }
        self.age = (self.age + 1) % WIDE_EVERY;
        let narrow = self.largest(0, NARROW_WINDOWS, reach);
        let larger =
            |i: usize| if self.wide[i].part > narrow[i].part { self.wide[i] } else { narrow[i] };
        [larger(0), larger(1)]
    }

    /// Of the windows of these indices.
    #[inline]
    fn largest(&self, from: usize, to: usize, reach: usize) -> [Filled; 2] {
        let mut filled = [Filled::default(); 2];
        for (width, parts) in WIDTHS[from..to].iter().zip(&self.parts[from..to]) {
            if *width > reach {
                break;
            }
            let sums = self.sums.newest(*width);
            let part = |value: usize| sums[value].abs() * parts[value];
            filled[0].raise(part(0).max(part(1)).max(part(2)), *width);
            filled[1].raise(part(3).max(part(4)), *width);
        }
        filled
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::limits;
    use super::*;

    fn found(
        sums: &mut WindowSums,
        residuals: impl IntoIterator<Item = f64>,
    ) -> [Option<usize>; 2] {
        let mut first = [None; 2];
        for (k, residual) in residuals.into_iter().enumerate() {
            for (first, filled) in first.iter_mut().zip(sums.step(residual, WIDEST)) {
                if filled.part > 1.0 {
                    first.get_or_insert(k);
                }
            }
        }
        first
    }

    #[test]
    fn a_step_beyond_two_excursions_is_found_within_a_few_samples() {
        let limits = limits();
        let mut sums = WindowSums::new(&limits);
        assert_eq!(found(&mut sums, [0.0; 100]), [None, None]);
        // 4 samples of 1.3 mm are beyond 4 × 1.256 mm, clipped at 1.25 mm they are not; 6 are.
        let [step, _] = found(&mut sums, [1.25e-3; 12]);
        assert_eq!(step, Some(5));
        // Two excursions at once for 10 samples, then nothing.
        sums.clear();
        let healthy = (0..200).map(|k| if k < 10 { 0.868e-3 } else { 0.0 });
        assert_eq!(found(&mut sums, healthy)[0], None);
    }

    #[test]
    fn noise_is_found_by_samples_that_are_off_and_elsewhere() {
        let limits = limits();
        let mut sums = WindowSums::new(&limits);
        let noise = (0..60).map(|k| if k % 2 == 0 { 0.5e-3 } else { -0.5e-3 });
        let [mean, noise] = found(&mut sums, noise);
        assert_eq!(mean, None);
        assert!(noise.is_some_and(|k| k < 20), "{noise:?}");
    }

    /// Otherwise an excursion would be noise.
    #[test]
    fn samples_that_stand_still_are_no_noise() {
        let limits = limits();
        let mut sums = WindowSums::new(&limits);
        let stands = 1.03 * OFF * limits.rest;
        assert_eq!(found(&mut sums, [stands; 100])[1], None);
    }

    #[test]
    fn the_result_of_wide_windows_is_kept_between_comparisons() {
        let limits = limits();
        let mut sums = WindowSums::new(&limits);
        let mut largest = 0.0_f64;
        for k in 0..2000_usize {
            let [mean, _] = sums.step(0.11e-3, WIDEST);
            assert!(k < 40 || mean.part >= 0.9 * largest, "{k}: {mean:?}");
            largest = largest.max(mean.part);
        }
        assert!(largest > 0.7, "{largest}");
    }
}
