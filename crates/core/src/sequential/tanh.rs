//! The hyperbolic tangent by the four basic operations only: a library's takes three times as long,
//! and its last digits depend on the machine.

/// Nodes in a unit.
const DENSITY: f64 = 16.0;

/// A power of two, so that no index is beyond them.
const NODES: usize = 512;

/// From here on it is 1 to the last digit.
const FARTHEST: f64 = 20.0;

/// That of 1/16.
const STEP: f64 = 0.062_418_746_747_512_51;

/// Its values, from node to node by the addition theorem, whose errors do not add up.
const VALUES: [f64; NODES] = {
    let mut values = [1.0; NODES];
    values[0] = 0.0;
    let mut node = 1;
    while node < (DENSITY * FARTHEST) as usize {
        let before = values[node - 1];
        values[node] = (before + STEP) / (1.0 + before * STEP);
        node += 1;
    }
    values
};

/// Added to a number that is small beside it, it leaves the nearest integer in the last digits.
const ROUNDS: f64 = 6_755_399_441_055_744.0;

/// Hyperbolic tangent tanh x, to 1e-13 of its value.
#[inline]
pub fn tanh(x: f64) -> f64 {
    let magnitude = x.abs();
    // Not `min`, which would make a number of what is none.
    let magnitude = if FARTHEST < magnitude { FARTHEST } else { magnitude };
    let rounded = DENSITY * magnitude + ROUNDS;
    let node = VALUES[rounded.to_bits() as usize % NODES];
    // From the nearest node on, by the series: what follows is less than 3e-14 of it.
    let rest = magnitude - (rounded - ROUNDS) * (1.0 / DENSITY);
    let square = rest * rest;
    let series = 1.0 - square * (1.0 / 3.0 - square * (2.0 / 15.0 - square * (17.0 / 315.0)));
    let small = rest * series;
    ((node + small) / (1.0 + node * small)).copysign(x)
}

/// tanh 5x, from tanh x.
#[inline]
pub fn of_five_times(tanh: f64) -> f64 {
    let square = tanh * tanh;
    tanh * (5.0 + square * (10.0 + square)) / (1.0 + square * (10.0 + square * 5.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_librarys() {
        let grid = (0..400_000).map(|k| 1e-4 * f64::from(k));
        let small = (0..320).map(|k| 10_f64.powi(-k));
        for x in grid.chain(small).chain([1e300, f64::INFINITY]) {
            let expected = [x.tanh(), (5.0 * x).tanh()];
            let found = tanh(x);
            for (found, expected) in [found, of_five_times(found)].into_iter().zip(expected) {
                assert!((found - expected).abs() <= 1e-13 * expected, "{x}: {found}, {expected}");
            }
            assert_eq!(tanh(-x), -found, "{x}");
        }
        assert!(tanh(f64::NAN).is_nan());
    }
}
