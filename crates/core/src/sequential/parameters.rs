//! What the sequential detectors judge by: every number of the family, with its unit, source and range.
//!
//! They are data and no configuration: the same for every machine, chosen on simulated machines of every
//! kind (docs/EVALUATION.md), on none of the recordings that ship with the project. Times are in seconds and become
//! counts once, as a detector is built ([`SequentialParameters::cycles`]). What is counted in samples is a matter of
//! chance and not of time: so many are needed to tell, however fast they come.
//!
//! What is reckoned alike by calibration, detector and report has one value for all of them, that of
//! [`SequentialParameters::DEFAULT`]; what a single detector goes by, it takes from its design.

mod alarm;
mod drive;
mod evidence;
mod excursions;
mod onset;
mod residual;
mod sampling;

pub use alarm::{AlarmParameters, KindParameters, PairParameters, ScaleParameters};
pub use drive::{DriveCycles, DriveParameters, MOST_PHASES};
pub use evidence::{DependenceParameters, EvidenceParameters, OutlierParameters};
pub use excursions::ExcursionParameters;
pub use onset::OnsetParameters;
pub use residual::{MOST_CYCLES, ResidualCycles, ResidualParameters};
pub use sampling::{SamplingParameters, WitnessParameters};

use super::samples::NEWEST;
use super::stops::StopParameters;
use crate::time;

/// All of them.
#[derive(Clone, Debug, PartialEq)]
pub struct SequentialParameters {
    pub residual: ResidualParameters,
    pub evidence: EvidenceParameters,
    pub alarm: AlarmParameters,
    pub kind: KindParameters,
    pub pair: PairParameters,
    pub onset: OnsetParameters,
    pub excursions: ExcursionParameters,
    pub drive: DriveParameters,
    pub scale: ScaleParameters,
    pub sampling: SamplingParameters,
    pub witness: WitnessParameters,
    pub stops: StopParameters,
}

impl SequentialParameters {
    pub const DEFAULT: Self = Self {
        residual: ResidualParameters::DEFAULT,
        evidence: EvidenceParameters::DEFAULT,
        alarm: AlarmParameters::DEFAULT,
        kind: KindParameters::DEFAULT,
        pair: PairParameters::DEFAULT,
        onset: OnsetParameters::DEFAULT,
        excursions: ExcursionParameters::DEFAULT,
        drive: DriveParameters::DEFAULT,
        scale: ScaleParameters::DEFAULT,
        sampling: SamplingParameters::DEFAULT,
        witness: WitnessParameters::DEFAULT,
        stops: StopParameters::DEFAULT,
    };

    /// The counts for a machine with this `sample_time`, s. Above 100 Hz the ring of the newest samples is
    /// too short, and what looks back on it does so for a shorter time.
    pub fn cycles(&self, sample_time: f64) -> SequentialCycles {
        let Self { alarm, kind, pair, scale, .. } = self;
        let samples = |seconds: f64| time::samples(seconds, sample_time);
        let at_least_one = |seconds: f64| time::cycles(seconds, sample_time).max(1);
        let newest = (samples(kind.newest) as usize).min(NEWEST);
        SequentialCycles {
            newest,
            looked_at: (samples(kind.looked_at) as usize).min(newest),
            looks: alarm.looks.map(samples),
            noise_told: samples(alarm.noise_told),
            latest: samples(pair.latest) as usize,
            located: samples(pair.located) as usize,
            shared: (self.sampling.shared / sample_time) as u32,
            scale_every: at_least_one(scale.every),
            scale_longest: at_least_one(scale.longest),
            scale_alike: f64::from(at_least_one(scale.alike)),
        }
    }
}

impl Default for SequentialParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The times of [`SequentialParameters`] in cycles of one machine; see there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SequentialCycles {
    pub newest: usize,
    pub looked_at: usize,
    pub looks: [u32; 7],
    pub noise_told: u32,
    pub latest: usize,
    pub located: usize,
    pub shared: u32,
    pub scale_every: u32,
    pub scale_longest: u32,
    pub scale_alike: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_50_hz_and_at_another_rate_times_are_the_same() {
        let of = |rate: f64| SequentialParameters::DEFAULT.cycles(1.0 / rate);
        let (slow, usual, fast) = (of(10.0), of(50.0), of(100.0));
        assert_eq!(usual.looks, [10, 16, 25, 50, 100, 200, 400]);
        assert_eq!((usual.newest, usual.looked_at, usual.noise_told), (64, 50, 25));
        assert_eq!((usual.latest, usual.located), (25, 24));
        assert_eq!((usual.scale_every, usual.scale_longest, usual.scale_alike), (20, 3000, 25.0));
        assert_eq!((fast.newest, fast.looked_at, fast.noise_told), (128, 100, 50));
        assert_eq!((fast.scale_every, fast.scale_longest, fast.scale_alike), (40, 6000, 50.0));
        // A kind is told from as many samples; a gain is one of time.
        assert_eq!((slow.looks, slow.looked_at), (usual.looks, usual.looked_at));
        assert_eq!((slow.scale_every, slow.scale_longest, slow.scale_alike), (4, 600, 5.0));
        assert_eq!([slow, usual, fast].map(|it| it.shared), [50, 250, 500]);
    }
}
