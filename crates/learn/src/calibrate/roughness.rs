//! The scatter of the difference of two readings from cycle to cycle, whatever its shape along the
//! stroke.

use tertius_core::sequential::Magnitudes;

/// Initial width of the bins of magnitudes, m.
const BIN: f64 = 1e-6;

/// Part of a normal distribution within the quantile that is used: on a lattice of counts the
/// median may be zero, and the outermost values may be wild.
const PART: f64 = 0.9;
/// Deviations of a normal distribution within which [`PART`] of it lies.
const WITHIN: f64 = 1.645;

/// Second differences of successive values, in which a bend hardly appears.
#[derive(Clone, Debug)]
pub(super) struct Roughness {
    newest: [f64; 2],
    held: u8,
    magnitudes: Magnitudes,
}

impl Default for Roughness {
    fn default() -> Self {
        Self { newest: [0.0; 2], held: 0, magnitudes: Magnitudes::new(BIN) }
    }
}

impl Roughness {
    /// Reports that cycles are missing.
    pub(super) const fn interrupt(&mut self) {
        self.held = 0;
    }

    /// Takes the difference of the readings of a cycle, m.
    pub(super) fn add(&mut self, difference: f64) {
        let [before, last] = self.newest;
        self.newest = [last, difference];
        if self.held == 2 {
            self.magnitudes.add((before - 2.0 * last + difference) / 6.0_f64.sqrt());
        } else {
            self.held += 1;
        }
    }

    /// The standard deviation, m; 0 where there are no data.
    pub(super) fn deviation(&self) -> f64 {
        quantile(&self.magnitudes, PART) / WITHIN
    }
}

/// The magnitude below which `part` of them are, m; 0 without data.
pub(super) fn quantile(magnitudes: &Magnitudes, part: f64) -> f64 {
    let mut left = (part * magnitudes.total() as f64) as u64;
    for (magnitude, count) in magnitudes.bins() {
        if count > left {
            return magnitude;
        }
        left -= count;
    }
    0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// Bends of a millimetre, a lattice of counts and a few wild samples do not count.
    #[test]
    fn it_is_what_follows_each_other_closely() {
        for (count, expected) in [(1e-9, 1e-4), (2e-4, 1.2e-4)] {
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            let mut roughness = Roughness::default();
            for k in 0..20_000_u32 {
                let normal: f64 = StandardNormal.sample(&mut rng);
                let wild = if k.is_multiple_of(100) { 1e-3 } else { 0.0 };
                let bent = 1e-3 * (0.01 * f64::from(k)).sin();
                roughness.add(((bent + 1e-4 * normal + wild) / count).round() * count);
                if k.is_multiple_of(1000) {
                    roughness.interrupt();
                }
            }
            let found = roughness.deviation();
            assert!((0.8..1.25).contains(&(found / expected)), "{found} for {expected}");
        }
    }
}
