//! The resolution of a transducer's readings.

/// Largest difference of moves that count as equal, m: the rounding of readings that come as 32-bit
/// floats.
const ROUNDING: f64 = 1e-6;

/// Number of smallest moves that are kept.
const KEPT: usize = 32;

/// Least share of all moves that the resolution must have: a slow rod makes many moves of one
/// count, and a single odd reading makes none.
const LEAST: f64 = 1e-3;

/// The smallest moves of a reading from cycle to cycle, and how often each occurred. Memory does
/// not grow.
#[derive(Clone, Debug, Default)]
pub struct Resolution {
    newest: Option<f64>,
    /// Moves by size, m, with their counts.
    smallest: Vec<(f64, u64)>,
    moves: u64,
}

impl Resolution {
    /// Reports that readings are missing.
    pub const fn interrupt(&mut self) {
        self.newest = None;
    }

    /// Takes the reading of a cycle, m.
    pub fn add(&mut self, length: f64) {
        let Some(before) = self.newest.replace(length) else { return };
        let moved = (length - before).abs();
        if moved < ROUNDING {
            return;
        }
        self.moves += 1;
        let at = self.smallest.partition_point(|(size, _)| *size < moved - ROUNDING);
        match self.smallest.get_mut(at) {
            Some((size, count)) if *size < moved + ROUNDING => *count += 1,
            _ => self.smallest.insert(at, (moved, 1)),
        }
        self.smallest.truncate(KEPT);
    }

    /// The resolution, m; 0 where the readings move in no discernible steps.
    pub fn count(&self) -> f64 {
        let often = |(_, count): &&(f64, u64)| *count as f64 >= LEAST * self.moves as f64;
        self.smallest.iter().find(often).map_or(0.0, |(size, _)| *size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(lengths: impl Iterator<Item = f64>) -> f64 {
        let mut resolution = Resolution::default();
        lengths.for_each(|length| resolution.add(length));
        assert!(resolution.smallest.len() <= KEPT);
        resolution.count()
    }

    fn rod() -> impl Iterator<Item = f64> {
        (0..20_000).map(|k| 0.3 * (0.017 * f64::from(k)).sin())
    }

    #[test]
    fn readings_in_counts_have_their_count_also_as_floats() {
        let counted = |length: f64| (length / 4.34e-4).round() * 4.34e-4;
        assert!((of(rod().map(counted)) - 4.34e-4).abs() < 1e-9);
        let float = |length: f64| f64::from((counted(length) + 1.5) as f32);
        assert!((of(rod().map(float)) - 4.34e-4).abs() < 1e-6);
        // One reading in a thousand is a hair off.
        let odd =
            rod().enumerate().map(|(k, l)| counted(l) + if k % 5000 == 7 { 1e-5 } else { 0.0 });
        assert!((of(odd) - 4.34e-4).abs() < 1e-9);
    }

    #[test]
    fn readings_in_no_counts_have_none() {
        assert_eq!(of(rod()), 0.0);
        assert_eq!(of((0..100).map(|_| 0.1)), 0.0);
    }
}
