//! A bounded number of samples of a whole recording.

/// Every n-th sample of a stream, with n chosen so that they fit.
#[derive(Clone, Debug)]
pub struct Thinned<T> {
    most: usize,
    stride: u64,
    seen: u64,
    samples: Vec<T>,
}

impl<T> Thinned<T> {
    /// A store of at most `most` samples, and at least half as many once that many have come.
    pub fn new(most: usize) -> Self {
        Self { most: most.max(2), stride: 1, seen: 0, samples: Vec::new() }
    }

    pub fn add(&mut self, sample: T) {
        if self.seen.is_multiple_of(self.stride) {
            if self.samples.len() == self.most {
                self.halve();
            }
            // What is kept is at multiples of the stride, which has just doubled.
            if self.seen.is_multiple_of(self.stride) {
                self.samples.push(sample);
            }
        }
        self.seen += 1;
    }

    fn halve(&mut self) {
        let mut even = false;
        self.samples.retain(|_| {
            even = !even;
            even
        });
        self.stride *= 2;
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
}
