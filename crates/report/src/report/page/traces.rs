//! Curves of a whole recording in bounded memory: the least and the largest value of each time
//! bucket.

/// Most buckets of a trace; at least half of them are used once a recording is long enough.
pub const BUCKETS: usize = 2048;

/// Number of consecutive empty buckets beyond which a curve is broken.
const GAP: usize = 2;

#[derive(Clone, Copy, Debug, PartialEq)]
struct Bucket<const N: usize> {
    low: [f64; N],
    high: [f64; N],
    /// Number of cycles.
    count: u32,
    /// Number of cycles that are to be shaded.
    shaded: u32,
    /// Whether the values before do not belong to this bucket.
    breaks: bool,
}

impl<const N: usize> Bucket<N> {
    const EMPTY: Self = Self {
        low: [f64::INFINITY; N],
        high: [f64::NEG_INFINITY; N],
        count: 0,
        shaded: 0,
        breaks: false,
    };

    fn with(&self, other: &Self) -> Self {
        Self {
            low: std::array::from_fn(|i| self.low[i].min(other.low[i])),
            high: std::array::from_fn(|i| self.high[i].max(other.high[i])),
            count: self.count.saturating_add(other.count),
            shaded: self.shaded.saturating_add(other.shaded),
            breaks: self.breaks || other.breaks,
        }
    }
}

/// A trace of `N` signals on one time axis, which begins at 0. No extreme value is lost however
/// long it gets; only its exact time within a bucket is forgotten.
#[derive(Clone, Debug)]
pub struct Trace<const N: usize> {
    /// Width of a bucket, s.
    width: f64,
    buckets: Vec<Bucket<N>>,
    end: f64,
    /// Whether the next values do not belong to the earlier ones.
    broken: bool,
}

impl<const N: usize> Trace<N> {
    /// A trace of signals that come every `sample_time` seconds.
    pub fn new(sample_time: f64) -> Self {
        Self { width: sample_time.max(1e-6), buckets: Vec::new(), end: 0.0, broken: false }
    }

    /// Takes the values at `t` seconds; `shaded`: this cycle is part of a shaded stretch. A time
    /// before 0 counts as 0, and not-a-number is ignored.
    pub fn add(&mut self, t: f64, values: [Option<f64>; N], shaded: bool) {
        if !t.is_finite() {
            return;
        }
        let t = t.max(0.0);
        self.end = self.end.max(t);
        while t / self.width >= BUCKETS as f64 {
            self.halve();
        }
        let place = (t / self.width) as usize;
        if self.buckets.len() <= place {
            self.buckets.resize(place + 1, Bucket::EMPTY);
        }
        let bucket = &mut self.buckets[place];
        bucket.breaks |= std::mem::take(&mut self.broken);
        bucket.count = bucket.count.saturating_add(1);
        bucket.shaded = bucket.shaded.saturating_add(u32::from(shaded));
        for (i, value) in values.into_iter().enumerate() {
            if let Some(value) = value.filter(|value| value.is_finite()) {
                bucket.low[i] = bucket.low[i].min(value);
                bucket.high[i] = bucket.high[i].max(value);
            }
        }
    }

    /// Breaks the curve: the next values are not connected to the earlier ones.
    pub const fn interrupt(&mut self) {
        self.broken = true;
    }

    fn halve(&mut self) {
        let pairs = self.buckets.chunks(2);
        self.buckets = pairs.map(|pair| pair[1..].iter().fold(pair[0], |a, b| a.with(b))).collect();
        self.width *= 2.0;
    }

    /// Newest time, s.
    pub const fn end(&self) -> f64 {
        self.end
    }

    /// Width of a bucket, s.
    pub const fn width(&self) -> f64 {
        self.width
    }

    /// Least and largest value of the signal `i`; `None` where it never came.
    pub fn extremes(&self, i: usize) -> Option<[f64; 2]> {
        let known = self.buckets.iter().filter(|bucket| bucket.low[i] <= bucket.high[i]);
        known
            .map(|bucket| [bucket.low[i], bucket.high[i]])
            .reduce(|[a, b], [low, high]| [a.min(low), b.max(high)])
    }

    /// The signal `i` as a line through the extremes of each bucket, broken where nothing came and
    /// where it was interrupted.
    pub fn runs(&self, i: usize) -> Vec<Vec<(f64, f64)>> {
        let mut runs: Vec<Vec<(f64, f64)>> = Vec::new();
        let mut newest: Option<usize> = None;
        let mut broken = false;
        for (place, bucket) in self.buckets.iter().enumerate() {
            let (low, high) = (bucket.low[i], bucket.high[i]);
            broken |= bucket.breaks;
            if low > high {
                continue;
            }
            let breaks = std::mem::take(&mut broken);
            if breaks || newest.is_none_or(|newest| place - newest > GAP + 1) {
                runs.push(Vec::new());
            }
            newest = Some(place);
            let Some(run) = runs.last_mut() else { continue };
            let t = (place as f64 + 0.5) * self.width;
            // From where the line is the nearer end first, so that it does not go to and fro.
            let falls = run.last().is_some_and(|(_, y)| (y - low).abs() > (y - high).abs());
            let (near, far) = if falls { (high, low) } else { (low, high) };
            run.push((t, near));
            if far != near {
                run.push((t, far));
            }
        }
        runs
    }

    /// Stretches in which every cycle is to be shaded, from and to.
    pub fn shaded(&self) -> Vec<(f64, f64)> {
        let mut stretches: Vec<(f64, f64)> = Vec::new();
        let mut open = false;
        for (place, bucket) in self.buckets.iter().enumerate() {
            if bucket.count == 0 {
                continue;
            }
            let whole = bucket.shaded == bucket.count;
            let (from, to) = (place as f64 * self.width, (place + 1) as f64 * self.width);
            match stretches.last_mut() {
                Some(stretch) if whole && open => stretch.1 = to,
                _ if whole => stretches.push((from, to)),
                _ => {}
            }
            open = whole;
        }
        stretches
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_recording_keeps_every_value() {
        let mut trace = Trace::<1>::new(0.02);
        (0..100).for_each(|k| trace.add(0.02 * f64::from(k) + 0.001, [Some(f64::from(k))], k < 10));
        let runs = trace.runs(0);
        assert_eq!(runs.len(), 1);
        assert!(runs[0].iter().map(|(_, y)| *y).eq((0..100).map(f64::from)), "{runs:?}");
        let [(from, to)] = trace.shaded()[..] else { panic!("{:?}", trace.shaded()) };
        assert!(from == 0.0 && (to - 0.2).abs() < 1e-9);
    }

    /// A single spike in a day at 50 Hz stays at its place, and memory is bounded.
    #[test]
    fn a_spike_survives_a_day() {
        let mut trace = Trace::<2>::new(0.02);
        let spike = 3_000_000;
        for k in 0..4_320_000_u32 {
            let value = if k == spike { 0.05 } else { 1e-4 * f64::from(k % 7) };
            trace.add(0.02 * f64::from(k), [Some(value), None], false);
        }
        assert!(trace.buckets.len() <= BUCKETS && trace.buckets.len() > BUCKETS / 2);
        let runs = trace.runs(0);
        let (t, y) = runs[0].iter().copied().max_by(|a, b| a.1.total_cmp(&b.1)).expect("some");
        assert_eq!(y, 0.05);
        assert!((t - 60_000.0).abs() <= trace.width(), "{t}");
        assert_eq!(trace.extremes(0), Some([0.0, 0.05]));
        assert!(trace.runs(1).is_empty() && trace.extremes(1).is_none());
    }

    #[test]
    fn an_interruption_breaks_the_curve_however_long_the_recording_gets() {
        let mut trace = Trace::<2>::new(0.02);
        for k in 0..10_000 {
            if k == 5000 {
                trace.interrupt();
            }
            // The second signal comes again only some time after.
            let second = (!(5000..6000).contains(&k)).then_some(1.0);
            trace.add(0.02 * f64::from(k), [Some(0.0), second], false);
        }
        for (i, begins) in [(0, 100.0), (1, 120.0)] {
            let runs = trace.runs(i);
            assert_eq!(runs.len(), 2, "signal {i}");
            assert!((runs[1][0].0 - begins).abs() <= trace.width(), "{:?}", runs[1][0]);
        }
    }

    #[test]
    fn a_silence_breaks_the_curve_and_odd_times_lose_nothing() {
        let mut trace = Trace::<1>::new(0.02);
        for t in [0.0, 0.021, 0.04, 1.0, 1.02, -5.0, f64::NAN, f64::INFINITY] {
            trace.add(t, [Some(t)], false);
        }
        let runs = trace.runs(0);
        assert_eq!(runs.len(), 2, "{runs:?}");
        assert_eq!(trace.extremes(0), Some([-5.0, 1.02]));
        trace.add(1e12, [Some(7.0)], false);
        assert!(trace.buckets.len() <= BUCKETS);
        assert_eq!(trace.extremes(0), Some([-5.0, 7.0]));
    }
}
