//! Whose reading has moved, by the oil.
//!
//! In the closed loop the machine follows a drifting C1, and neither the command nor the other reading tells whose drift
//! it is. But the rod goes where the oil takes it. With d the way by which C1 has moved away from C2 since one of them has
//! been under suspicion, the mean of both leaves the oil by +d/2 if C1 has moved, and by −d/2 if C2 has.
//!
//! What parts rod and oil on a healthy cylinder, a little of each direction and a constant speed, is followed until
//! then by a Kalman filter whose unknowns walk at random. With M what is left of the mean beside it since then,
//! and V its variance, the log-likelihood of C1 less that of C2 is M d / V.

use super::super::parameters::DIRECTIONS;
use super::super::parameters::{ProcessParameters, SideParameters};
use super::FlowBlock;
use crate::state::{state, whole};

const P: &SideParameters = &ProcessParameters::DEFAULT.side;

/// Unknowns: how much there is of each direction, and a speed, m/s.
const UNKNOWNS: usize = DIRECTIONS + 1;

type Vector = [f64; UNKNOWNS];

fn dot(one: &Vector, other: &Vector) -> f64 {
    one.iter().zip(other).map(|(a, b)| a * b).sum()
}

/// What parts rod and oil while nothing is wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Healthy {
    sizes: Vector,
    covariance: [Vector; UNKNOWNS],
}

whole! { Healthy { sizes, covariance } }

impl Default for Healthy {
    /// What a lesson leaves.
    fn default() -> Self {
        let covariance = core::array::from_fn(|i| {
            core::array::from_fn(|j| if i == j { P.usual[i] * P.usual[i] } else { 0.0 })
        });
        Self { sizes: [0.0; UNKNOWNS], covariance }
    }
}

impl Healthy {
    #[inline]
    fn spread(&self, along: &Vector) -> Vector {
        self.covariance.each_ref().map(|row| dot(row, along))
    }

    /// Follows a block of this `variance`, m², that lasts for so many `seconds`; returns by how far it was off, m.
    fn follow(&mut self, along: &Vector, mean: f64, variance: f64, seconds: f64) -> f64 {
        for (i, walk) in P.walks.iter().enumerate() {
            self.covariance[i][i] += walk * walk * seconds;
        }
        let spread = self.spread(along);
        let total = dot(&spread, along) + variance;
        // By rounding, or in a state that was not written by this program, it may be none. NaN is not above 0.
        if !(total > 0.0 && total.is_finite()) {
            *self = Self::default();
            return 0.0;
        }
        let off = mean - dot(&self.sizes, along);
        // One block that is wild teaches no more than one that is odd.
        let limit = P.odd * libm::sqrt(total);
        let taken = off.clamp(-limit, limit);
        for (i, row) in self.covariance.iter_mut().enumerate() {
            let gain = spread[i] / total;
            self.sizes[i] += gain * taken;
            row.iter_mut().zip(&spread).for_each(|(it, spread)| *it -= gain * spread);
        }
        taken
    }
}

/// How much a block is off, in the long run: its variance, m².
#[derive(Clone, Copy, Debug, PartialEq)]
struct Scatter {
    variance: f64,
    /// Sum of a stretch, m, and its blocks.
    sum: f64,
    blocks: u32,
    /// Stretches so far.
    stretches: u32,
}

whole! {
    Scatter { variance, sum, blocks, stretches }
    sound |it| it.blocks < u32::MAX && it.stretches < u32::MAX
}

/// Sums since a transducer has been under suspicion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Since {
    blocks: u32,
    along: Vector,
    /// What the mean has left the oil by, and C1 has left C2, m.
    mean: f64,
    parted: f64,
}

whole! {
    Since { blocks, along, mean, parted }
    sound |it| it.blocks < u32::MAX
}

/// Watches whose reading leaves the oil.
#[derive(Clone, Debug)]
pub struct FlowSide {
    /// Duration of a block, s.
    seconds: f64,
    healthy: Healthy,
    scatter: Scatter,
    since: Option<Since>,
}

state! {
    FlowSide { healthy, scatter, since }
    but { seconds }
}

impl FlowSide {
    pub fn new(seconds: f64) -> Self {
        Self { seconds, healthy: Healthy::default(), scatter: Scatter::usual(seconds), since: None }
    }

    /// Forgets everything: nobody knows what has happened.
    pub fn forget(&mut self) {
        *self = Self::new(self.seconds);
    }

    /// Forgets what was since a suspicion.
    pub const fn rest(&mut self) {
        self.since = None;
    }

    /// Takes a block of a healthy cylinder.
    pub fn learn(&mut self, block: &FlowBlock) {
        self.since = None;
        let Some((along, mean, _)) = self.read(block) else { return };
        let off = self.healthy.follow(&along, mean, self.scatter.variance, self.seconds);
        self.scatter.take(off);
    }

    /// Takes a block in which a transducer is under suspicion. If it `is_asked`, returns the evidence of whose reading has
    /// moved, nats: positive for C1, negative for C2; `None` before there is enough, or where what the mean leaves the
    /// oil by is neither's. A fast drift is suspected by its size before it is found by its form: its way in between
    /// counts.
    pub fn weigh(&mut self, block: &FlowBlock, is_asked: bool) -> Option<f64> {
        let (along, mean, parted) = self.read(block)?;
        if !is_asked && self.since.is_some_and(|it| it.blocks >= P.unasked) {
            self.since = None;
        }
        let since = self.since.get_or_insert_default();
        since.blocks = since.blocks.saturating_add(1);
        since.along.iter_mut().zip(along).for_each(|(sum, it)| *sum += it);
        since.mean += mean;
        since.parted += parted;
        let since = *since;
        let blocks = f64::from(since.blocks);
        let left = since.mean - dot(&self.healthy.sizes, &since.along);
        let spread = self.healthy.spread(&since.along);
        // What has walked on since: a third of the whole way's variance.
        let walked: f64 =
            since.along.iter().zip(P.walks).map(|(it, walk)| it * it * walk * walk).sum();
        let variance = blocks * self.scatter.variance
            + dot(&spread, &since.along)
            + walked * blocks * self.seconds / 3.0
            + P.reading * P.reading;
        let nats = left * since.parted / variance;
        let beside = left.abs() - 0.5 * since.parted.abs();
        let is_either = beside * beside < P.beside * P.beside * variance;
        let is_certain = since.blocks >= P.least_blocks && nats.abs() > P.certain;
        (is_asked && is_either && (is_certain || since.blocks >= P.blocks)).then_some(nats)
    }

    /// The directions of a block, what its mean leaves the oil by and what its readings part by, m; nothing that is not
    /// finite, which no sum would ever forget.
    fn read(&self, block: &FlowBlock) -> Option<(Vector, f64, f64)> {
        let parted = block.parted?;
        let mut along = [self.seconds; UNKNOWNS];
        along[..DIRECTIONS].copy_from_slice(&block.directions);
        let mean = block.left[0] - 0.5 * parted;
        // Of one that is not finite no sum is.
        let all = along.iter().chain([&mean, &parted]).sum::<f64>();
        all.is_finite().then_some((along, mean, parted))
    }
}

impl Scatter {
    /// Of a block of so many `seconds`, before any was seen.
    fn usual(seconds: f64) -> Self {
        let variance = P.scatter * P.scatter * P.scatter_time * seconds;
        Self { variance, sum: 0.0, blocks: 0, stretches: 0 }
    }

    fn take(&mut self, off: f64) {
        self.sum += off;
        self.blocks += 1;
        if self.blocks < P.stretch {
            return;
        }
        let square = self.sum * self.sum / f64::from(self.blocks);
        self.stretches = (self.stretches + 1).min(P.stretches[1]);
        let share = 1.0 / f64::from(P.stretches[0] + self.stretches);
        self.variance += share * (square - self.variance);
        (self.sum, self.blocks) = (0.0, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECONDS: f64 = 0.2;

    /// A block in which C1 and C2 drift by so much, m/s, and the rod leaves the oil by `odd`, m/s, and by noise. Its
    /// directions swing with the waves.
    fn block(k: usize, [c1, c2]: [f64; 2], odd: f64) -> FlowBlock {
        let noise = 3e-4 * (((k * 7919) % 201) as f64 / 100.0 - 1.0);
        let directions = core::array::from_fn(|i| {
            let wave = 0.1 * k as f64 / (1.0 + 0.3 * i as f64);
            0.2 * libm::sin(wave)
        });
        let left = [c1, c2].map(|drift| (drift + odd) * SECONDS + noise);
        FlowBlock { left, directions, parted: Some((c1 - c2) * SECONDS) }
    }

    fn taught(odd: f64) -> FlowSide {
        let mut side = FlowSide::new(SECONDS);
        (0..1500).for_each(|k| side.learn(&block(k, [0.0; 2], odd)));
        side
    }

    /// What is said after `seconds` of these drifts.
    fn said(side: &FlowSide, drifts: [f64; 2], odd: f64, seconds: f64) -> Option<f64> {
        let mut side = side.clone();
        let blocks = 1500..1500 + (seconds / SECONDS) as usize;
        blocks.fold(None, |_, k| side.weigh(&block(k, drifts, odd), true))
    }

    #[test]
    fn whoever_leaves_the_oil_has_drifted_in_either_direction() {
        let side = taught(0.0);
        for rate in [1e-3, -1e-3] {
            let one = said(&side, [rate, 0.0], 0.0, 20.0).expect("there is evidence");
            let two = said(&side, [0.0, rate], 0.0, 20.0).expect("there is evidence");
            assert!(one > 8.0 && two < -8.0, "{rate}: {one}, {two}");
        }
    }

    #[test]
    fn what_was_there_before_is_nobody_s_drift() {
        // As C2 is called off where the rod itself has always been faster than the oil.
        let (odd, drifts) = (-0.8e-3, [1e-3, 0.0]);
        let (ignorant, side) = (FlowSide::new(SECONDS), taught(odd));
        assert!(said(&ignorant, drifts, odd, 20.0).is_some_and(|nats| nats < 0.0));
        assert!(said(&side, drifts, odd, 20.0).is_some_and(|nats| nats > 8.0));
    }

    #[test]
    fn a_rod_that_leaves_the_oil_by_more_than_either_has_drifted_is_nobody_s() {
        let side = taught(0.0);
        assert_eq!(said(&side, [0.5e-3, 0.0], 6e-3, 20.0), None);
    }

    #[test]
    fn the_nats_are_those_of_the_formula_where_nothing_was_learnt() {
        let mut side = FlowSide::new(SECONDS);
        let still =
            FlowBlock { left: [4e-4, 0.0], directions: [0.0; DIRECTIONS], parted: Some(4e-4) };
        let nats = (0..50).fold(None, |_, _| side.weigh(&still, true)).expect("there is evidence");
        let (time, speed, walk) = (10.0_f64, P.usual[DIRECTIONS], P.walks[DIRECTIONS]);
        let scatter = P.scatter * P.scatter * P.scatter_time * time;
        let variance = scatter
            + (speed * time).powi(2)
            + (walk * time).powi(2) * time / 3.0
            + P.reading * P.reading;
        let expected = 0.01 * 0.02 / variance;
        assert!((nats / expected - 1.0).abs() < 1e-9, "{nats}, {expected}");
    }

    #[test]
    fn a_fast_drift_is_named_by_what_it_did_before_anybody_asked() {
        let taught = taught(0.0);
        let after = |suspected: usize| {
            let mut side = taught.clone();
            for k in 1500..1500 + suspected {
                assert_eq!(side.weigh(&block(k, [0.0, 20e-3], 0.0), false), None);
                assert_eq!(side.since.map(|it| it.blocks as usize), Some(k - 1499));
            }
            side.weigh(&block(1500 + suspected, [0.0, 20e-3], 0.0), true)
        };
        assert_eq!(after(0), None, "a single block is not enough");
        assert!(after(2).is_some_and(|nats| nats < -P.certain));
        // Of what was suspected for long the newest part counts.
        let mut side = taught;
        for k in 1500..1800 {
            side.weigh(&block(k, [0.0; 2], 0.0), false);
            assert!(side.since.is_some_and(|it| it.blocks <= P.unasked));
        }
    }

    #[test]
    fn a_covariance_that_is_none_is_learnt_anew() {
        for wrong in [-1.0, f64::NAN, f64::INFINITY] {
            let mut side = FlowSide::new(SECONDS);
            side.healthy.covariance = [[wrong; UNKNOWNS]; UNKNOWNS];
            (0..1500).for_each(|k| side.learn(&block(k, [0.0; 2], 0.0)));
            assert!(said(&side, [1e-3, 0.0], 0.0, 20.0).is_some_and(|nats| nats > 8.0), "{wrong}");
        }
    }

    #[test]
    fn nothing_spoils_what_is_known_for_good() {
        let mut side = taught(0.0);
        let before = side.healthy;
        for wrong in [f64::NAN, f64::INFINITY] {
            side.learn(&FlowBlock { left: [wrong, 0.0], ..block(1, [0.0; 2], 0.0) });
            side.learn(&FlowBlock { directions: [wrong; DIRECTIONS], ..block(1, [0.0; 2], 0.0) });
            side.learn(&FlowBlock { parted: Some(wrong), ..block(1, [0.0; 2], 0.0) });
        }
        side.learn(&FlowBlock { parted: None, ..block(1, [0.0; 2], 0.0) });
        assert_eq!(side.healthy, before);
        // One wild block is worth no more than an odd one.
        side.learn(&block(1500, [0.0; 2], 5.0));
        assert!(said(&side, [1e-3, 0.0], 0.0, 20.0).is_some_and(|nats| nats > 8.0));
    }
}
