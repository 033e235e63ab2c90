//! How fast the command makes the rod go: what both transducers will read, before they do.

use super::tanh::{of_five_times, tanh};

/// Cycles by which commands are looked back at.
const LAGS: [usize; 11] = [0, 1, 2, 3, 4, 5, 6, 8, 10, 13, 16];

/// What a velocity is made of: the lagged commands, and what a valve does not do in proportion.
pub const FEATURES: usize = LAGS.len() + BENT;

const BENT: usize = 6;

/// The command of so many cycles ago has the valve open now.
const DELAY: usize = 3;

const NEEDED: usize = 17;

/// As many as there are places in a ring, a power of two.
const HELD: usize = 32;

/// Speeds at which a valve's overlap and friction bend, m/s; the second is five times the first.
const BENDS: [f64; 2] = [0.01, 0.05];

/// The newest commands, m/s.
#[derive(Clone, Debug)]
pub struct Commands {
    /// A ring, twice: somewhere it has the newest in a row.
    rings: [f64; 2 * HELD],
    /// Commands that came.
    count: usize,
}

impl Default for Commands {
    fn default() -> Self {
        Self { rings: [0.0; 2 * HELD], count: 0 }
    }
}

impl Commands {
    /// Takes the command of a cycle.
    #[inline]
    pub fn push(&mut self, command: f64) {
        let place = self.count % HELD;
        self.rings[place] = command;
        self.rings[place + HELD] = command;
        self.count += 1;
    }

    pub const fn clear(&mut self) {
        self.count = 0;
    }

    /// The regressors of the velocity until the next cycle; `None` before enough commands came.
    #[inline]
    pub fn features(&self) -> Option<[f64; FEATURES]> {
        if self.count < NEEDED {
            return None;
        }
        let newest = (self.count - 1) % HELD + HELD;
        let ago = |cycles: usize| self.rings[newest - cycles];
        let lagged = LAGS.map(ago);
        let bent = bent(ago(DELAY));
        Some(core::array::from_fn(
            |i| if i < LAGS.len() { lagged[i] } else { bent[i - LAGS.len()] },
        ))
    }
}

/// What the velocity has of a command `u`, m/s, that is not in proportion to it.
#[inline]
fn bent(u: f64) -> [f64; BENT] {
    let wide = tanh(u * (1.0 / BENDS[1]));
    [u * u.abs(), u * u * u, u.max(0.0), of_five_times(wide), wide, 1.0]
}

/// The velocity, m/s, by coefficients that a calibration has fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive(pub [f64; FEATURES]);

impl Drive {
    /// The velocity until the next cycle, m/s; `None` before enough commands came.
    #[inline(always)]
    pub fn velocity(&self, commands: &Commands) -> Option<f64> {
        let features = commands.features()?;
        Some(self.0.iter().zip(&features).map(|(coefficient, feature)| coefficient * feature).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_features_are_those_of_the_newest_commands() {
        let mut commands = Commands::default();
        for k in 0..40 {
            assert_eq!(commands.features().is_some(), k >= NEEDED, "{k}");
            commands.push(f64::from(k as u32));
        }
        let features = commands.features().expect("enough came");
        assert_eq!(features[..LAGS.len()], LAGS.map(|lag| 39.0 - lag as f64));
        assert_eq!(features[LAGS.len()..], [1296.0, 46656.0, 36.0, 1.0, 1.0, 1.0]);
        commands.clear();
        assert_eq!(commands.features(), None);
    }

    #[test]
    fn a_valve_bends_at_both_speeds() {
        for u in [-0.3, -0.02, 0.0, 0.004, 0.05] {
            let mut commands = Commands::default();
            (0..NEEDED).for_each(|_| commands.push(u));
            let features = commands.features().expect("enough came");
            let bent = BENDS.map(|bend| (u / bend).tanh());
            for (found, expected) in features[LAGS.len() + 3..].iter().zip(bent) {
                assert!((found - expected).abs() < 1e-12, "{u}: {found}, {expected}");
            }
            let drive = Drive(std::array::from_fn(|i| 0.1 * i as f64));
            let sum: f64 = drive.0.iter().zip(features).map(|(c, feature)| c * feature).sum();
            assert_eq!(drive.velocity(&commands), Some(sum));
        }
        assert_eq!(Drive([1.0; FEATURES]).velocity(&Commands::default()), None);
    }
}
