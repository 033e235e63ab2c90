//! How fast the command makes the rod go: what both transducers will read, before they do.

/// Cycles by which commands are looked back at.
const LAGS: [usize; 11] = [0, 1, 2, 3, 4, 5, 6, 8, 10, 13, 16];

/// What a velocity is made of: the lagged commands, and what a valve does not do in proportion.
pub const FEATURES: usize = LAGS.len() + 6;

/// The command of so many cycles ago has the valve open now.
const DELAY: usize = 3;

const HELD: usize = 17;

/// Speeds at which a valve's overlap and friction bend, m/s.
const BENDS: [f64; 2] = [0.01, 0.05];

/// The newest commands, m/s.
#[derive(Clone, Debug)]
pub struct Commands {
    /// A ring, twice: from `next` on it has the newest in a row, the oldest first.
    rings: [f64; 2 * HELD],
    next: usize,
    held: usize,
}

impl Default for Commands {
    fn default() -> Self {
        Self { rings: [0.0; 2 * HELD], next: 0, held: 0 }
    }
}

impl Commands {
    /// Takes the command of a cycle.
    pub fn push(&mut self, command: f64) {
        self.rings[self.next] = command;
        self.rings[self.next + HELD] = command;
        self.next = if self.next + 1 == HELD { 0 } else { self.next + 1 };
        self.held = (self.held + 1).min(HELD);
    }

    pub fn clear(&mut self) {
        self.held = 0;
    }

    /// The regressors of the velocity until the next cycle; `None` before enough commands came.
    pub fn features(&self) -> Option<[f64; FEATURES]> {
        if self.held < HELD {
            return None;
        }
        let newest: &[f64; HELD] = self.rings.get(self.next..self.next + HELD)?.first_chunk()?;
        let ago = |cycles: usize| newest[HELD - 1 - cycles];
        let mut features = [0.0; FEATURES];
        for (feature, lag) in features.iter_mut().zip(LAGS) {
            *feature = ago(lag);
        }
        let u = ago(DELAY);
        features[LAGS.len()..].copy_from_slice(&[
            u * u.abs(),
            u * u * u,
            u.max(0.0),
            (u / BENDS[0]).tanh(),
            (u / BENDS[1]).tanh(),
            1.0,
        ]);
        Some(features)
    }
}

/// The velocity, m/s, by coefficients that a calibration has fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive(pub [f64; FEATURES]);

impl Drive {
    pub fn velocity(&self, features: &[f64; FEATURES]) -> f64 {
        self.0.iter().zip(features).map(|(coefficient, feature)| coefficient * feature).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_features_are_those_of_the_newest_commands() {
        let mut commands = Commands::default();
        for k in 0..40 {
            assert_eq!(commands.features().is_some(), k >= HELD, "{k}");
            commands.push(f64::from(k as u32));
        }
        let features = commands.features().expect("enough came");
        assert_eq!(features[..LAGS.len()], LAGS.map(|lag| 39.0 - lag as f64));
        assert_eq!(features[LAGS.len()..], [1296.0, 46656.0, 36.0, 1.0, 1.0, 1.0]);
        commands.clear();
        assert_eq!(commands.features(), None);
    }
}
