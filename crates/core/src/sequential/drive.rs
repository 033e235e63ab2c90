//! How fast the command makes the rod go: what both transducers will read, before they do.

use super::parameters::{DriveCycles, DriveParameters, MOST_PHASES};
use super::tanh::{of_five_times, tanh};
use crate::state::state;

/// Steps by which commands are looked back at, of [`DriveParameters::step`].
const LAGS: [usize; 11] = [0, 1, 2, 3, 4, 5, 6, 8, 10, 13, 16];

/// What a velocity is made of: the lagged commands, and what a valve does not do in proportion.
pub const FEATURES: usize = LAGS.len() + BENT;

const BENT: usize = 6;

/// As many as there are places in a ring, a power of two.
const COMMANDS_HELD: usize = 32;

/// The higher one of the speeds at which a valve bends, m/s.
const WIDE_BEND: f64 = 5.0 * DriveParameters::DEFAULT.bend;

/// The newest commands, m/s.
#[derive(Clone, Debug)]
pub struct Commands {
    /// A ring, twice: somewhere it has the newest in a row. One for each cycle of a step, so that in each
    /// neighbours are a step apart.
    rings: [[f64; 2 * COMMANDS_HELD]; MOST_PHASES],
    cycles: DriveCycles,
    /// The ring of the newest command, and how many it has had.
    phase: usize,
    turn: usize,
    /// Commands that came.
    count: usize,
    /// Commands that it takes.
    needed: usize,
}

state! {
    Commands { rings, phase, turn, count }
    but { cycles, needed }
    sound |it| it.phase < it.cycles.phases
}

impl Commands {
    /// For commands every `sample_time` seconds.
    pub fn new(parameters: &DriveParameters, sample_time: f64) -> Self {
        let cycles = parameters.cycles(sample_time);
        let needed = LAGS[LAGS.len() - 1] * cycles.phases + 1;
        let rings = [[0.0; 2 * COMMANDS_HELD]; MOST_PHASES];
        Self { rings, cycles, phase: 0, turn: 0, count: 0, needed }
    }

    /// Takes the command of a cycle.
    #[inline]
    pub fn push(&mut self, command: f64) {
        self.phase += 1;
        if self.phase >= self.cycles.phases {
            (self.phase, self.turn) = (0, self.turn.wrapping_add(1));
        }
        let (ring, place) = (&mut self.rings[self.phase % MOST_PHASES], self.turn % COMMANDS_HELD);
        ring[place] = command;
        ring[place + COMMANDS_HELD] = command;
        self.count += 1;
    }

    pub const fn clear(&mut self) {
        self.count = 0;
    }

    /// The regressors of the velocity until the next cycle; `None` before enough commands came.
    #[inline]
    pub fn features(&self) -> Option<[f64; FEATURES]> {
        if self.count < self.needed {
            return None;
        }
        let (ring, newest) =
            (&self.rings[self.phase % MOST_PHASES], self.turn % COMMANDS_HELD + COMMANDS_HELD);
        let ago = |steps: usize| ring[newest - steps];
        let lagged = LAGS.map(ago);
        let bent = bent(ago(self.cycles.delay % COMMANDS_HELD));
        Some(core::array::from_fn(
            |i| if i < LAGS.len() { lagged[i] } else { bent[i - LAGS.len()] },
        ))
    }
}

/// What the velocity has of a command `u`, m/s, that is not in proportion to it.
#[inline]
fn bent(u: f64) -> [f64; BENT] {
    let wide = tanh(u * (1.0 / WIDE_BEND));
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

    /// Commands every so many milliseconds.
    fn every(milliseconds: f64) -> Commands {
        Commands::new(&DriveParameters::DEFAULT, 1e-3 * milliseconds)
    }

    /// The same time is looked back at up to 100 Hz; a cycle is the shortest of steps.
    #[test]
    fn the_features_are_those_of_the_newest_commands() {
        for (milliseconds, step, delay) in [(20.0, 1, 3), (10.0, 2, 6), (100.0, 1, 1)] {
            let (mut commands, newest) = (every(milliseconds), 79);
            for k in 0..=newest {
                assert_eq!(commands.features().is_some(), k > 16 * step, "{k}");
                commands.push(f64::from(k as u32));
            }
            let features = commands.features().expect("enough came");
            let ago = |cycles: usize| f64::from((newest - cycles) as u32);
            assert_eq!(features[..LAGS.len()], LAGS.map(|lag| ago(lag * step)));
            let u = ago(delay);
            assert_eq!(features[LAGS.len()..], [u * u, u * u * u, u, 1.0, 1.0, 1.0]);
            commands.clear();
            assert_eq!(commands.features(), None);
        }
    }

    #[test]
    fn a_valve_bends_at_both_speeds() {
        for u in [-0.3, -0.02, 0.0, 0.004, 0.05] {
            let mut commands = every(20.0);
            (0..17).for_each(|_| commands.push(u));
            let features = commands.features().expect("enough came");
            let bent = [0.01, 0.05].map(|bend: f64| (u / bend).tanh());
            for (found, expected) in features[LAGS.len() + 3..].iter().zip(bent) {
                assert!((found - expected).abs() < 1e-12, "{u}: {found}, {expected}");
            }
            let drive = Drive(std::array::from_fn(|i| 0.1 * i as f64));
            let sum: f64 = drive.0.iter().zip(features).map(|(c, feature)| c * feature).sum();
            assert_eq!(drive.velocity(&commands), Some(sum));
        }
        assert_eq!(Drive([1.0; FEATURES]).velocity(&every(20.0)), None);
    }
}
