//! How much evidence residuals are.

/// The numbers by which residuals become nats. Calibration and detector have to agree on them.
#[derive(Clone, Debug, PartialEq)]
pub struct EvidenceParameters {
    /// What is below this is no fault but a temperature or a bend that the calibration has left, m; 5e-5
    /// to 3e-4.
    pub dead_band: f64,
    /// What a displacement of the dead band may add to the evidence of any window, nats; 0.5 to 2.
    pub by_dead_band: f64,
    /// The least dead band of the mean square, in healthy ones; 0 to 1. A mean square is known no better
    /// than to some ten per cent, and changes with the load.
    pub least_spread_band: f64,
    pub outliers: OutlierParameters,
    pub dependence: DependenceParameters,
}

impl EvidenceParameters {
    pub const DEFAULT: Self = Self {
        dead_band: 1e-4,
        by_dead_band: 1.0,
        least_spread_band: 0.25,
        outliers: OutlierParameters::DEFAULT,
        dependence: DependenceParameters::DEFAULT,
    };
}

/// What wild samples prove ([`crate::sequential::wild`]). The numbers come from `scripts/sweep-healthy spikes`:
/// simulated hours with spikes on up to 3 % of the samples of either transducer or of both.
#[derive(Clone, Debug, PartialEq)]
pub struct OutlierParameters {
    /// No level is less, nats, however calm the recording was that it is learnt from: it says nothing of
    /// spikes to come.
    pub least_level: f64,
    /// What healthy samples beside wild ones may add, nats.
    pub beside: f64,
    /// Where wild samples are frequent, so many in a row to one side reach the least level. Where both
    /// transducers of a pair have 3 % of them, twice as many of their differences are wild: five in a row
    /// to one side come once in some days then.
    pub in_a_row: f64,
    /// The same to any side.
    pub of_any_side: f64,
    /// So many wild ones in a row must not be a fault where they are frequent; samples, one of
    /// [`crate::sequential::windows::WIDTHS`].
    pub several: usize,
    /// They are frequent beyond this part of the share that is expected; 0 to 1.
    pub frequent: f64,
    /// Their share is a mean over so many samples that of the share which is frequent this many are wild;
    /// samples.
    pub counted: f64,
}

impl OutlierParameters {
    pub const DEFAULT: Self = Self {
        least_level: 19.3,
        beside: 3.45,
        in_a_row: 4.75,
        of_any_side: 5.59,
        several: 4,
        frequent: 0.3,
        counted: 10.0,
    };
}

/// How the dependence of healthy samples is measured ([`crate::sequential::dependence`]).
#[derive(Clone, Debug, PartialEq)]
pub struct DependenceParameters {
    /// The tail that is looked at is this part of the windows, …
    pub tail: f64,
    /// … or what so many windows without a sample in common have, …
    pub apart: f64,
    /// … but no more than this part.
    pub most: f64,
    /// What fewer windows without a sample in common have seen is chance.
    pub rare: f64,
    /// So many samples that say as much as one are a stretch in which the readings stand off, …
    pub stretch: f64,
    /// … and it is as long as the widest window in which they are this part of the most.
    pub nearly: f64,
    /// A longer one is a fault that comes and goes, and is not expected to; samples, one of
    /// [`crate::sequential::windows::WIDTHS`].
    pub longest: usize,
}

impl DependenceParameters {
    pub const DEFAULT: Self = Self {
        tail: 0.001,
        apart: 30.0,
        most: 0.2,
        rare: 3.0,
        stretch: 2.0,
        nearly: 0.8,
        longest: 48,
    };
}
