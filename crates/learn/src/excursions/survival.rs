//! How long excursions last, by size: the law as tables that are indexed by length and size.
//!
//! The recursions of runs and sums ask the same three questions for every number of samples, with the lengths of equal
//! size together. The tables answer them without going through the atoms again.

use super::law::Law;

/// Distance of the sizes of overlaps, m: their sums are rounded up, so that there are not as many sizes as pairs.
const OVERLAP_SPACING: f64 = 0.05e-3;
/// Part of this distance that the rounding of numbers may add.
const ROUNDING: f64 = 1e-6;
/// Lengths of overlaps are rounded up by less than a part of 1 / this, so that there are some tens of them.
const OVERLAP_PARTS: usize = 8;

/// Distribution of the lengths, for each size that occurs.
#[derive(Clone, Debug, PartialEq)]
pub struct Survival {
    /// Chance that an excursion of one direction begins with a sample, on one transducer that is in none.
    chance: f64,
    /// Sizes in ascending order, m, each once: the columns of the tables.
    sizes: Vec<f64>,
    /// Longest length that has its own row; the first row is that of length 1.
    reach: usize,
    /// Share of the excursions that have this size and exactly this length.
    ending: Vec<f64>,
    /// Share that has this size and at least this length, with a row more.
    lasting: Vec<f64>,
    /// Sum of `lasting` over this length and all that are longer, samples, with a row more.
    remaining: Vec<f64>,
    /// Lengths up to `reach` at which excursions end, in ascending order.
    ends: Vec<usize>,
    /// Mean length, samples.
    mean_length: f64,
}

impl Survival {
    /// Tables for lengths up to `most` samples; `None` where there are no excursions. Longer ones are not cut off: they
    /// count as lasting beyond `most`.
    pub fn of(law: &Law, most: usize) -> Option<Self> {
        let kept = |size: f64, weight: f64| size > 0.0 && size.is_finite() && weight > 0.0;
        let atoms: Vec<_> = law.atoms.iter().filter(|atom| kept(atom.size, atom.weight)).collect();
        let longest = atoms.iter().map(|atom| atom.length.max(1) as usize).max()?;
        if law.chance.is_nan() || law.chance <= 0.0 {
            return None;
        }
        let sizes = ascending(atoms.iter().map(|atom| atom.size));
        let reach = longest.min(most.max(1));
        let mut ending = vec![0.0; reach * sizes.len()];
        let mut beyond = vec![[0.0; 2]; sizes.len()];
        for atom in atoms {
            let length = atom.length.max(1) as usize;
            let column = sizes.partition_point(|size| *size < atom.size);
            if length <= reach {
                ending[(length - 1) * sizes.len() + column] += atom.weight;
            } else {
                beyond[column][0] += atom.weight;
                beyond[column][1] += atom.weight * (length - reach) as f64;
            }
        }
        // Two directions: more than one half would be more than always.
        Some(Self::of_tables(law.chance.min(0.5), sizes, ending, &beyond))
    }

    /// The tables whose rows end like this; `beyond` is what `lasting` and `remaining` have of each size after the last row.
    fn of_tables(chance: f64, sizes: Vec<f64>, ending: Vec<f64>, beyond: &[[f64; 2]]) -> Self {
        let columns = sizes.len();
        let mut sums = beyond.to_vec();
        let [mut lasting, mut remaining] = [0, 1]
            .map(|of| [vec![0.0; ending.len()], beyond.iter().map(|b| b[of]).collect()].concat());
        for at in (0..ending.len()).rev() {
            let sum = &mut sums[at % columns];
            sum[0] += ending[at];
            sum[1] += sum[0];
            (lasting[at], remaining[at]) = (sum[0], sum[1]);
        }
        let used = |(row, shares): (usize, &[f64])| {
            shares.iter().any(|share| *share > 0.0).then_some(row + 1)
        };
        let ends = ending.chunks(columns).enumerate().filter_map(used).collect();
        let mean_length = sums.iter().map(|sum| sum[1]).sum();
        let reach = ending.len() / columns;
        Self { chance, sizes, reach, ending, lasting, remaining, ends, mean_length }
    }

    /// The overlaps of two excursions, one on each transducer, that push the difference to one side, as excursions whose size
    /// is the sum of both, rounded up. `chance` becomes that of an overlap of one side to begin with a sample.
    #[must_use]
    pub fn overlaps(&self) -> Self {
        let rounded = |sum: f64| (sum / OVERLAP_SPACING - ROUNDING).ceil() * OVERLAP_SPACING;
        let sums = self.sizes.iter().flat_map(|a| self.sizes.iter().map(move |b| a + b));
        let sums: Vec<f64> = sums.map(rounded).collect();
        let sizes = ascending(sums.iter().copied());
        let places: Vec<_> =
            sums.iter().map(|sum| sizes.partition_point(|size| size < sum)).collect();

        let first = self.overlaps_lasting(1, &places, sizes.len());
        let rate: f64 = first.iter().map(|[lasting, _]| lasting).sum();
        let mut ending = vec![0.0; self.reach * sizes.len()];
        let (mut start, mut at_least) = (1, first);
        while start <= self.reach {
            let end = (start + start / OVERLAP_PARTS).min(self.reach);
            let more = self.overlaps_lasting(end + 1, &places, sizes.len());
            let row = ending[(end - 1) * sizes.len()..].iter_mut();
            for (share, (less, more)) in row.zip(at_least.iter().zip(&more)) {
                *share = ((less[0] - more[0]) / rate).max(0.0);
            }
            (start, at_least) = (end + 1, more);
        }
        let beyond: Vec<_> = at_least.iter().map(|sums| sums.map(|sum| sum / rate)).collect();
        Self::of_tables((self.chance * self.chance * rate).min(0.5), sizes, ending, &beyond)
    }

    /// For each size of overlaps the number of ways in which two excursions begin an overlap of at least `length` samples,
    /// and the sum of these numbers from `length` on; the pairs of sizes belong to these `places`.
    fn overlaps_lasting(&self, length: usize, places: &[usize], sizes: usize) -> Vec<[f64; 2]> {
        let columns = self.sizes.len();
        let row = (length - 1) * columns..length * columns;
        let (lasting, remaining) = (&self.lasting[row.clone()], &self.remaining[row]);
        let mut sums = vec![[0.0; 2]; sizes];
        for (pair, place) in places.iter().enumerate() {
            let (i, j) = (pair / columns, pair % columns);
            let ways = overlapping([lasting[i], lasting[j]], [remaining[i], remaining[j]]);
            sums[*place][0] += ways;
            sums[*place][1] += remaining[i] * remaining[j];
        }
        sums
    }

    /// Chance that an excursion of one direction begins with a sample, on one transducer that is in none.
    pub const fn chance(&self) -> f64 {
        self.chance
    }

    /// Sizes in ascending order, m: the columns of the tables.
    pub fn sizes(&self) -> &[f64] {
        &self.sizes
    }

    /// Longest length that has its own row, samples.
    pub const fn reach(&self) -> usize {
        self.reach
    }

    /// Mean length, samples.
    pub const fn mean_length(&self) -> f64 {
        self.mean_length
    }

    /// Lengths up to [`Self::reach`] at which excursions end, samples, in ascending order.
    pub fn ends(&self) -> &[usize] {
        &self.ends
    }

    /// Share of excursions of exactly `length` samples, for each size; empty outside of 1 to [`Self::reach`].
    pub fn ending(&self, length: usize) -> &[f64] {
        self.row(&self.ending, length)
    }

    /// Share of excursions of at least `length` samples, for each size; empty outside of 1 to [`Self::reach`].
    pub fn lasting(&self, length: usize) -> &[f64] {
        self.row(&self.lasting, length)
    }

    /// Sum of [`Self::lasting`] from `length` on, samples, for each size; empty outside of 1 to [`Self::reach`].
    pub fn remaining(&self, length: usize) -> &[f64] {
        self.row(&self.remaining, length)
    }

    fn row<'a>(&self, table: &'a [f64], length: usize) -> &'a [f64] {
        let columns = self.sizes.len();
        if (1..=self.reach).contains(&length) {
            &table[(length - 1) * columns..length * columns]
        } else {
            &[]
        }
    }
}

/// Number of ways in which two excursions, one on each transducer, begin an overlap of at least t samples, where `lasting` are
/// the shares of their sizes that last t samples, and `remaining` the sums of these from t on.
pub fn overlapping(lasting: [f64; 2], remaining: [f64; 2]) -> f64 {
    lasting[1] * remaining[0] + lasting[0] * remaining[1] - lasting[0] * lasting[1]
}

/// These sizes in ascending order, each once.
fn ascending(sizes: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sizes: Vec<f64> = sizes.collect();
    sizes.sort_unstable_by(f64::total_cmp);
    sizes.dedup();
    sizes
}
