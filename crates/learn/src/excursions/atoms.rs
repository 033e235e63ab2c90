//! Sizes and lengths of excursions as atoms of a distribution, with what was never seen.
//!
//! Of n excursions the next one is the largest with a chance of 1 in n + 1, and the longest with the
//! same: beyond what was seen, both go on exponentially. Size and length are taken as independent.

use super::law::Atom;
use crate::order_statistics::{mean_excess, upper_ends};

/// Parts of equal number into which sizes are divided.
const SIZE_PARTS: usize = 10;

/// Parts of equal number into which lengths are divided.
const LENGTH_PARTS: usize = 20;

/// Parts of the other one where one is in its tail.
const TAIL_PARTS: usize = 4;

/// Steps of a tail: 13.5 of its means, which is one in 700,000.
const TAIL_STEPS: u32 = 9;

/// Width of a step, in means of the tail.
const TAIL_STEP: f64 = 1.5;

/// Sizes are rounded up to a multiple of this, m.
const SIZE_STEP: f64 = 0.02e-3;

/// Least mean of the tail of sizes, m: a third of a count of 0.1085 mm.
const LEAST_SIZE_EXCESS: f64 = 0.036e-3;

/// Least mean of the tail of lengths, samples.
const LEAST_LENGTH_EXCESS: f64 = 1.0;

/// Largest weight of a tail, of one excursion alone.
const LARGEST_TAIL: f64 = 0.33;

/// Most atoms of a law.
pub(super) const MOST_ATOMS: usize =
    SIZE_PARTS * LENGTH_PARTS + 2 * TAIL_STEPS as usize * TAIL_PARTS;

/// The size, m, rounded up.
fn rounded_up(size: f64) -> f64 {
    // Rounding of a multiple is not rounded up once more.
    (size / SIZE_STEP - 1e-6).ceil().max(1.0) * SIZE_STEP
}

/// Excesses, in means of the tail, and their weights, which add up to 1. A step is represented by its
/// upper end, and the last one has all that is beyond.
fn tail_steps() -> impl Iterator<Item = (f64, f64)> {
    (1..=TAIL_STEPS).map(|step| {
        let [from, to] = [step - 1, step].map(|step| TAIL_STEP * f64::from(step));
        let beyond = if step == TAIL_STEPS { 0.0 } else { (-to).exp() };
        (to, (-from).exp() - beyond)
    })
}

/// The atoms of `entries` excursions whose `sizes`, m, and `lengths`, samples, are sorted; none of
/// none. Their weights add up to 1; they are in the order of size and length.
pub(super) fn atoms(entries: usize, sizes: &[f64], lengths: &[f64]) -> Vec<Atom> {
    let (Some(largest), Some(longest)) = (sizes.last(), lengths.last()) else { return Vec::new() };
    let tail = (1.0 / (entries as f64 + 1.0)).min(LARGEST_TAIL);
    let sizes_of =
        |parts| -> Vec<f64> { upper_ends(sizes, parts).into_iter().map(rounded_up).collect() };
    let size_excess = mean_excess(sizes).max(LEAST_SIZE_EXCESS);
    let length_excess = mean_excess(lengths).max(LEAST_LENGTH_EXCESS);
    let mut atoms = Vec::with_capacity(MOST_ATOMS);
    let seen = (1.0 - 2.0 * tail) / (SIZE_PARTS * LENGTH_PARTS) as f64;
    add(&mut atoms, &sizes_of(SIZE_PARTS), &upper_ends(lengths, LENGTH_PARTS), seen);
    for (excess, share) in tail_steps() {
        let weight = tail * share / TAIL_PARTS as f64;
        let larger = largest + excess * size_excess;
        add(&mut atoms, &[larger], &upper_ends(lengths, TAIL_PARTS), weight);
        let longer = longest + (excess * length_excess).ceil();
        add(&mut atoms, &sizes_of(TAIL_PARTS), &[longer], weight);
    }
    pooled(atoms)
}

/// Adds every size, m, with every length, samples, each of the same weight.
fn add(atoms: &mut Vec<Atom>, sizes: &[f64], lengths: &[f64], weight: f64) {
    for size in sizes {
        // A length is a small whole number, at least 1.
        atoms.extend(lengths.iter().map(|length| Atom {
            size: *size,
            length: *length as u32,
            weight,
        }));
    }
}

/// Atoms of the same size and length as one, in their order.
fn pooled(mut atoms: Vec<Atom>) -> Vec<Atom> {
    atoms.sort_by(|one, other| one.size.total_cmp(&other.size).then(one.length.cmp(&other.length)));
    let mut pooled: Vec<Atom> = Vec::new();
    for atom in atoms {
        match pooled.last_mut() {
            Some(last) if last.length == atom.length && last.size.total_cmp(&atom.size).is_eq() => {
                last.weight += atom.weight;
            }
            _ => pooled.push(atom),
        }
    }
    let total: f64 = pooled.iter().map(|atom| atom.weight).sum();
    for atom in &mut pooled {
        atom.weight /= total;
    }
    pooled
}

#[cfg(test)]
mod tests {
    use super::*;

    fn total(atoms: &[Atom], which: impl Fn(&Atom) -> bool) -> f64 {
        atoms.iter().filter(|atom| which(atom)).map(|atom| atom.weight).sum()
    }

    #[test]
    fn weights_of_what_was_seen_and_of_both_tails() {
        let sizes: Vec<f64> = (0..199).map(|k| 1e-6 * (300.5 + f64::from(k))).collect();
        let lengths: Vec<f64> = (0..199).map(|k| 5.0 + f64::from(k)).collect();
        let atoms = atoms(199, &sizes, &lengths);
        assert_eq!(atoms.len(), MOST_ATOMS);
        assert!((total(&atoms, |_| true) - 1.0).abs() < 1e-12);
        // The upper end is rounded up to 0.50 mm; 203 samples are the longest.
        let larger = total(&atoms, |atom| atom.size > 0.501e-3);
        let longer = total(&atoms, |atom| atom.length > 203);
        assert!((larger - 1.0 / 200.0).abs() < 1e-12 && (longer - 1.0 / 200.0).abs() < 1e-12);
        // The mean excess of the largest 39 is 20 steps; e^-1.5 of the tail is beyond 1.5 of them.
        let reach = total(&atoms, |atom| atom.length > 203 + 30);
        assert!((reach - (-1.5_f64).exp() / 200.0).abs() < 1e-12);
        assert_eq!(atoms.iter().map(|atom| atom.length).max(), Some(203 + 270));
        // That of the largest 39 sizes is 0.02 mm, which is less than the least.
        let size_tail = sizes[198] + 13.5 * 0.036e-3;
        assert!((atoms[MOST_ATOMS - 1].size - size_tail).abs() < 1e-12);
        assert!(
            atoms.is_sorted_by(|one, other| (one.size, one.length) < (other.size, other.length))
        );
    }

    #[test]
    fn entries_that_are_alike_are_few_atoms() {
        let atoms = atoms(50, &[0.42e-3; 50], &[10.0; 50]);
        // One, nine larger and nine longer ones.
        assert_eq!(atoms.len(), 19);
        assert!((atoms[0].size - 0.42e-3).abs() < 1e-12 && atoms[0].length == 10);
        assert!((atoms[0].weight - (1.0 - 2.0 / 51.0)).abs() < 1e-12);
        let longer: Vec<u32> = atoms[1..10].iter().map(|atom| atom.length).collect();
        assert_eq!(longer, [12, 13, 15, 16, 18, 19, 21, 22, 24]);
        assert!((atoms[10].size - (0.42e-3 + 1.5 * 0.036e-3)).abs() < 1e-12);
    }

    #[test]
    fn of_one_or_none() {
        assert!(atoms(0, &[], &[]).is_empty());
        let one = atoms(1, &[0.4e-3], &[10.0]);
        assert!((total(&one, |atom| atom.size > 0.41e-3) - 0.33).abs() < 1e-12);
        assert!((total(&one, |atom| atom.length > 10) - 0.33).abs() < 1e-12);
        // Means of 0.3 of the largest: 0.12 mm and 3 samples.
        assert_eq!(one.iter().map(|atom| atom.length).max(), Some(10 + 41));
    }
}
