//! A bounded number of stretches of a recording of any length, drawn by what they hold.

use super::store::Cycle;

/// Stretches of one cylinder, drawn by lot from all that came, in the order in which they came.
///
/// The lot is a hash of the readings, so that the same recordings give the same stretches in whichever order they
/// were made.
#[derive(Clone, Debug)]
pub struct Drawn {
    most: usize,
    /// Lot of each.
    lots: Vec<u64>,
    stretches: Vec<Vec<Cycle>>,
}

impl Drawn {
    /// A store of at most `most` stretches.
    pub const fn new(most: usize) -> Self {
        Self { most, lots: Vec::new(), stretches: Vec::new() }
    }

    pub fn add(&mut self, stretch: Vec<Cycle>) {
        self.lots.push(lot(&stretch));
        self.stretches.push(stretch);
        if self.lots.len() > self.most
            && let Some((last, _)) = self.lots.iter().enumerate().max_by_key(|(_, lot)| **lot)
        {
            self.lots.remove(last);
            self.stretches.remove(last);
        }
    }

    pub fn stretches(&self) -> &[Vec<Cycle>] {
        &self.stretches
    }
}

/// FNV-1a over the positions that were read: commands come less an offset that was estimated.
fn lot(stretch: &[Cycle]) -> u64 {
    let positions = stretch.iter().flat_map(|cycle| cycle.measurements);
    let bits = positions.map(|read| read.map_or(0, |(position, _)| position.to_bits()));
    bits.fold(0xCBF2_9CE4_8422_2325, |hash, bits| {
        bits.to_le_bytes()
            .into_iter()
            .fold(hash, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3))
    })
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
        let mut other = drawn(all.clone().rev());
        other.reverse();
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
    fn of_few_all_are_drawn_as_they_came() {
        assert_eq!(drawn(0..20), (0..20).map(stretch).collect::<Vec<_>>());
    }
}
