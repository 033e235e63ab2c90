//! A bounded number of stretches of a recording of any length, drawn by what they hold.

use super::cycle::Cycle;
use crc::{CRC_64_XZ, Crc};

/// Hash of the readings, which is the lot.
const LOT: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);

/// Stretches of one cylinder, drawn by lot from all that came, in the order of their lots.
///
/// The lot is a hash of the readings, so that the same recordings give the same stretches in the same order,
/// whichever was made first.
#[derive(Clone, Debug)]
pub struct Drawn {
    most: usize,
    /// Lot of each, ascending.
    lots: Vec<u64>,
    stretches: Vec<Vec<Cycle>>,
}

impl Drawn {
    /// A store of at most `most` stretches.
    pub const fn new(most: usize) -> Self {
        Self { most, lots: Vec::new(), stretches: Vec::new() }
    }

    pub fn add(&mut self, stretch: Vec<Cycle>) {
        let lot = lot(&stretch);
        let at = self.lots.partition_point(|other| *other < lot);
        if at < self.most {
            self.lots.insert(at, lot);
            self.stretches.insert(at, stretch);
            self.lots.truncate(self.most);
            self.stretches.truncate(self.most);
        }
    }

    pub fn stretches(&self) -> &[Vec<Cycle>] {
        &self.stretches
    }
}

/// The hash of the positions that were read: commands come less an offset that was estimated.
fn lot(stretch: &[Cycle]) -> u64 {
    let mut digest = LOT.digest();
    for read in stretch.iter().flat_map(|cycle| cycle.measurements) {
        digest.update(&read.map_or(0, |(position, _)| position.to_bits()).to_le_bytes());
    }
    digest.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stretch(number: u32) -> Vec<Cycle> {
        let position = |k: u32| 0.1 * f64::from(number) + 1e-3 * f64::from(k);
        let cycle = |k| Cycle {
            command: Some(f64::from(number)),
            measurements: [Some((position(k), None)), None],
            monitored: true,
        };
        (0..10).map(cycle).collect()
    }

    fn drawn(numbers: impl Iterator<Item = u32>) -> Vec<Vec<Cycle>> {
        let mut drawn = Drawn::new(20);
        numbers.for_each(|number| drawn.add(stretch(number)));
        drawn.stretches().to_vec()
    }

    #[test]
    fn the_same_stretches_are_drawn_in_either_order() {
        let all = 0..400;
        let one = drawn(all.clone());
        let other = drawn(all.clone().rev());
        assert_eq!(one, other);
        // From everywhere: of each quarter there is some.
        let of = |quarter: u32| {
            let within =
                |it: &&Vec<Cycle>| it[0].command.is_some_and(|u| u as u32 / 100 == quarter);
            one.iter().filter(within).count()
        };
        assert_eq!(one.len(), 20);
        assert!((0..4).all(|quarter| of(quarter) > 0), "{:?}", [0, 1, 2, 3].map(of));
    }

    #[test]
    fn of_few_all_are_drawn() {
        let mut all = drawn(0..20);
        all.sort_by_key(|it| it[0].command.map(|u| u as u32));
        assert_eq!(all, (0..20).map(stretch).collect::<Vec<_>>());
    }
}
