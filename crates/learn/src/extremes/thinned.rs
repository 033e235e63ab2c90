//! A bounded number of samples of a whole recording.

/// Every n-th sample of a stream, counted anew after each pause, with n chosen so that they fit.
/// Which samples of a file are kept therefore does not depend on what was recorded before it.
#[derive(Clone, Debug)]
pub struct Thinned<T> {
    most: usize,
    stride: u64,
    seen: u64,
    /// Number of the next sample, from the last pause on.
    number: u64,
    /// Number of each sample that is kept.
    numbers: Vec<u64>,
    samples: Vec<T>,
}

impl<T> Thinned<T> {
    /// A store of at most `most` samples, and at least half as many once that many have come.
    pub fn new(most: usize) -> Self {
        let (numbers, samples) = (Vec::new(), Vec::new());
        Self { most: most.max(2), stride: 1, seen: 0, number: 0, numbers, samples }
    }

    /// Counts anew, because the next sample comes after a pause.
    pub const fn pause(&mut self) {
        self.number = 0;
    }

    pub fn add(&mut self, sample: T) {
        if self.number.is_multiple_of(self.stride) {
            if self.samples.len() == self.most {
                self.halve();
            }
            // What is kept is at multiples of the stride, which has just doubled; of more pauses
            // than samples are kept, the first.
            if self.number.is_multiple_of(self.stride) && self.samples.len() < self.most {
                self.numbers.push(self.number);
                self.samples.push(sample);
            }
        }
        self.number += 1;
        self.seen += 1;
    }

    fn halve(&mut self) {
        self.stride = self.stride.saturating_mul(2);
        let mut numbers = self.numbers.iter();
        let stride = self.stride;
        self.samples.retain(|_| numbers.next().is_some_and(|it| it.is_multiple_of(stride)));
        self.numbers.retain(|number| number.is_multiple_of(stride));
    }

    pub fn samples(&self) -> &[T] {
        &self.samples
    }

    /// Number of samples that came.
    pub const fn seen(&self) -> u64 {
        self.seen
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_spread_evenly_over_all() {
        for count in [1, 7, 8, 9, 100, 1023, 1024, 5000] {
            let mut thinned = Thinned::new(8);
            (0..count).for_each(|k| thinned.add(k));
            let samples = thinned.samples();
            let stride = samples.get(1).copied().unwrap_or(1);
            assert!(samples.iter().copied().eq((0..count).step_by(stride)), "{samples:?}");
            assert!(samples.len() <= 8 && (samples.len() >= 4 || count < 8));
        }
    }

    #[test]
    fn files_in_either_order_keep_the_same() {
        let files = [0..531, 1000..1100, 2000..2777];
        let kept = |order: [usize; 3]| {
            let mut thinned = Thinned::new(50);
            for file in order {
                thinned.pause();
                files[file].clone().for_each(|k| thinned.add(k));
            }
            let mut samples = thinned.samples().to_vec();
            samples.sort_unstable();
            assert!((25..=50).contains(&samples.len()) && thinned.seen() == 1408, "{samples:?}");
            samples
        };
        assert_eq!(kept([0, 1, 2]), kept([2, 1, 0]));
        assert_eq!(kept([0, 1, 2]), kept([1, 2, 0]));
    }

    #[test]
    fn more_pauses_than_samples_fit() {
        let mut thinned = Thinned::new(8);
        for k in 0..1000 {
            thinned.pause();
            thinned.add(k);
        }
        assert!(thinned.samples().len() <= 8 && thinned.seen() == 1000);
    }
}
