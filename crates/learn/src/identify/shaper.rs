//! The signals of (4-1) from the rows of one cylinder.

use crate::survey::Row;
use std::collections::VecDeque;

/// Widest moving average, cycles.
pub const WIDEST: usize = 1001;

/// Cycles on either side from which a velocity is computed from positions.
const REACH: usize = 2;

/// Sources of velocity and load pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sources {
    /// Whether the velocity is recorded; otherwise it is the slope of the position.
    pub velocity: bool,
    /// Whether the load pressure is known; otherwise the model is reduced and does without.
    pub pressure: bool,
}

/// Parameters of the signals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shaping {
    /// Sample time Ts, s.
    pub sample_time: f64,
    /// Width of the moving average, cycles; odd, 1 is none, at most [`WIDEST`].
    pub window: usize,
    /// Area ratio α of (3-5).
    pub area_ratio: f64,
}

/// The signals of one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time since the recording's first frame, s.
    pub t: f64,
    /// Length l as read by C1, m.
    pub l: f64,
    /// Velocity l̇, smoothed, m/s.
    pub v: f64,
    /// Load pressure P_L, smoothed, bar.
    pub p: Option<f64>,
    /// Control speed l̇_ctrl, m/s.
    pub u: f64,
    /// Velocity l̇ as received, m/s, where it is recorded.
    pub raw_v: Option<f64>,
    /// Load pressure P_L as received, bar, where it is recorded.
    pub raw_p: Option<f64>,
}

#[derive(Clone, Copy, Debug)]
struct Raw {
    t: f64,
    l: f64,
    v: f64,
    p: f64,
    u: f64,
}

/// Makes samples of rows, with a delay of some cycles, since a centred average needs later rows.
#[derive(Clone, Debug)]
pub struct Shaper {
    shaping: Shaping,
    sources: Sources,
    rows: VecDeque<Raw>,
}

impl Shaper {
    pub fn new(shaping: Shaping, sources: Sources) -> Self {
        Self { shaping, sources, rows: VecDeque::new() }
    }

    /// Cycles on either side on which a sample depends.
    fn reach(&self) -> usize {
        let average = self.shaping.window / 2;
        if self.sources.velocity { average } else { average + REACH }
    }

    /// Takes a row and returns the sample in the middle of the rows so far. Samples of consecutive
    /// calls are consecutive cycles; `None` where something is missing, or the platform is in no
    /// monitored state.
    pub fn take(&mut self, row: &Row) -> Option<Sample> {
        let Some(raw) = self.raw(row) else {
            self.gap();
            return None;
        };
        let span = 2 * self.reach() + 1;
        if self.rows.len() == span {
            self.rows.pop_front();
        }
        self.rows.push_back(raw);
        (self.rows.len() == span).then(|| self.middle())
    }

    /// Reports that the next row does not follow.
    pub fn gap(&mut self) {
        self.rows.clear();
    }

    fn raw(&self, row: &Row) -> Option<Raw> {
        let v = if self.sources.velocity { row.v1? } else { 0.0 };
        let p =
            if self.sources.pressure { row.load_pressure(self.shaping.area_ratio)? } else { 0.0 };
        let raw = Raw { t: row.t, l: row.c1?, v, p, u: row.u? };
        let finite = [raw.l, raw.v, raw.p, raw.u].iter().all(|value| value.is_finite());
        (row.monitored && finite).then_some(raw)
    }

    fn middle(&self) -> Sample {
        let (centre, half) = (self.reach(), self.shaping.window / 2);
        let around = centre - half..=centre + half;
        let mean =
            |of: &dyn Fn(usize) -> f64| around.clone().map(of).sum::<f64>() / (2 * half + 1) as f64;
        let Raw { t, l, v, p, u } = self.rows[centre];
        let Sources { velocity, pressure } = self.sources;
        Sample {
            t,
            l,
            v: if velocity { mean(&|i| self.rows[i].v) } else { mean(&|i| self.slope(i)) },
            p: pressure.then(|| mean(&|i| self.rows[i].p)),
            u,
            raw_v: velocity.then_some(v),
            raw_p: pressure.then_some(p),
        }
    }

    /// Slope of the least-squares parabola through five positions (Savitzky and Golay), without a
    /// phase shift, m/s.
    fn slope(&self, i: usize) -> f64 {
        let l = |place: usize| self.rows[place].l;
        (2.0 * (l(i + 2) - l(i - 2)) + (l(i + 1) - l(i - 1))) / (10.0 * self.shaping.sample_time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tertius_core::sample::Quality;
    use tertius_core::time::Timestamp;

    fn row(k: u32) -> Row {
        let t = f64::from(k) * 0.02;
        Row {
            timestamp: Timestamp::from_nanos(i64::from(k) * 20_000_000),
            t,
            cycle: k.into(),
            cylinder: 1,
            c1: Some(t * t),
            c2: None,
            v1: Some(f64::from(k % 3)),
            v2: None,
            u: Some(f64::from(k)),
            pressure_bottom: Some(f64::from(k % 3) + 2.0),
            pressure_rod: Some(4.0),
            pressure_load: None,
            supply: None,
            spool: None,
            monitored: true,
            raw: [Some(t * t), None],
            qualities: [Quality::Good; 2],
        }
    }

    fn shaper(velocity: bool) -> Shaper {
        let shaping = Shaping { sample_time: 0.02, window: 3, area_ratio: 0.5 };
        Shaper::new(shaping, Sources { velocity, pressure: true })
    }

    #[test]
    fn the_average_is_centred_and_leaves_position_and_command_alone() {
        let mut shaper = shaper(true);
        let samples: Vec<_> = (0..9).filter_map(|k| shaper.take(&row(k))).collect();
        assert_eq!(samples.len(), 7);
        for (k, sample) in (1..).zip(samples) {
            let raw = row(k);
            assert_eq!((sample.t, Some(sample.l), Some(sample.u)), (raw.t, raw.c1, raw.u));
            // The mean of 0, 1 and 2, and that with 2 − 0.5·4 added.
            assert!((sample.v - 1.0).abs() < 1e-15 && sample.raw_v == raw.v1);
            assert!((sample.p.expect("known") - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn without_a_velocity_it_is_the_slope_of_the_position_at_the_same_time() {
        let mut shaper = shaper(false);
        let samples: Vec<_> = (0..20).filter_map(|k| shaper.take(&row(k))).collect();
        assert_eq!(samples.len(), 14);
        for sample in samples {
            assert!((sample.v - 2.0 * sample.t).abs() < 1e-12, "{sample:?}");
            assert_eq!(sample.raw_v, None);
        }
    }

    #[test]
    fn nothing_is_averaged_across_a_gap_or_what_is_missing() {
        let broken: [fn(&mut Row); 5] = [
            |row| row.c1 = None,
            |row| row.u = None,
            |row| row.pressure_rod = None,
            |row| row.monitored = false,
            |row| row.v1 = Some(f64::NAN),
        ];
        for change in broken {
            let mut shaper = shaper(true);
            let given: Vec<bool> = (0..9)
                .map(|k| {
                    let mut row = row(k);
                    if k == 4 {
                        change(&mut row);
                    }
                    shaper.take(&row).is_some()
                })
                .collect();
            assert_eq!(given, [false, false, true, true, false, false, false, true, true]);
        }
        let mut shaper = shaper(true);
        for k in 0..4 {
            _ = shaper.take(&row(k));
        }
        shaper.gap();
        assert!(shaper.take(&row(50)).is_none() && shaper.take(&row(51)).is_none());
        assert!(shaper.take(&row(52)).is_some());
    }
}
