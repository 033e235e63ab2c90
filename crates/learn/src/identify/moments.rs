//! Means, variances and products of streams.

/// Mean and variance of one signal (Welford).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    pub count: u64,
    pub mean: f64,
    squares: f64,
    /// Largest magnitude.
    pub largest: f64,
    pub low: f64,
    pub high: f64,
}

impl Spread {
    pub fn add(&mut self, value: f64) {
        if self.count == 0 {
            (self.low, self.high) = (value, value);
        }
        self.count += 1;
        let from_old = value - self.mean;
        self.mean += from_old / self.count as f64;
        self.squares += from_old * (value - self.mean);
        self.largest = self.largest.max(value.abs());
        (self.low, self.high) = (self.low.min(value), self.high.max(value));
    }

    /// Mean square deviation from the mean.
    pub fn variance(&self) -> f64 {
        if self.count == 0 { 0.0 } else { self.squares / self.count as f64 }
    }

    /// Root mean square, mean included.
    pub fn rms(&self) -> f64 {
        (self.variance() + self.mean * self.mean).sqrt()
    }

    pub fn range(&self) -> f64 {
        self.high - self.low
    }
}

/// Joint moments of two signals.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pair {
    count: u64,
    mean: [f64; 2],
    squares: [f64; 2],
    product: f64,
}

impl Pair {
    pub fn add(&mut self, x: f64, y: f64) {
        self.count += 1;
        let [dx, dy] = [x - self.mean[0], y - self.mean[1]];
        self.mean[0] += dx / self.count as f64;
        self.mean[1] += dy / self.count as f64;
        self.squares[0] += dx * (x - self.mean[0]);
        self.squares[1] += dy * (y - self.mean[1]);
        self.product += dx * (y - self.mean[1]);
    }

    pub const fn count(&self) -> u64 {
        self.count
    }

    /// Correlation coefficient, −1 to 1; `None` where one signal is constant.
    pub fn correlation(&self) -> Option<f64> {
        let size = (self.squares[0] * self.squares[1]).sqrt();
        (size > 0.0 && size.is_finite()).then(|| self.product / size)
    }

    /// Standard deviation of y over that of x: the factor between them if they are the same signal
    /// in other units.
    pub fn ratio(&self) -> Option<f64> {
        (self.squares[0] > 0.0).then(|| (self.squares[1] / self.squares[0]).sqrt())
    }

    /// Both means.
    pub const fn means(&self) -> [f64; 2] {
        self.mean
    }

    /// The slope of y over x.
    pub fn slope(&self) -> Option<f64> {
        (self.squares[0] > 0.0).then(|| self.product / self.squares[0])
    }
}
