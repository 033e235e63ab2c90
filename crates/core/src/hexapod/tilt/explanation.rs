//! Which choice of cylinders, whose C1 it was, explains a tilt best.

use super::super::LEGS;
use nalgebra::{Matrix2, Vector2};

/// For each cylinder with a tilt, half of what the best explanation without its C1 fits worse than the best one with it;
/// nothing where no explanation is within `beside` standard deviations.
pub fn evidence(
    off: &Vector2<f64>,
    inverse: &Matrix2<f64>,
    tilts: &[Option<[f64; 2]>; LEGS],
    beside: f64,
) -> [Option<f64>; LEGS] {
    let mut best = [[f64::INFINITY; 2]; LEGS];
    let parted = tilts
        .iter()
        .enumerate()
        .fold(0_usize, |all, (leg, tilt)| if tilt.is_some() { all | 1 << leg } else { all });
    for chosen in (0..1_usize << LEGS).filter(|chosen| chosen & !parted == 0) {
        let mut left = *off;
        for (leg, tilt) in tilts.iter().enumerate() {
            if let Some(tilt) = tilt.filter(|_| chosen >> leg & 1 == 1) {
                left -= Vector2::from(tilt);
            }
        }
        let fit = (left.transpose() * inverse * left)[(0, 0)];
        for (leg, best) in best.iter_mut().enumerate() {
            let own = &mut best[chosen >> leg & 1];
            *own = own.min(fit);
        }
    }
    core::array::from_fn(|leg| {
        let [without, with] = best[leg];
        let is_explained = without.min(with) < beside * beside;
        (tilts[leg].is_some() && is_explained).then_some(0.5 * (without - with))
    })
}
