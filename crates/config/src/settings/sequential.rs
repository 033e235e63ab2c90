//! `[sequential]`, and what `tertius calibrate` has fitted for the detector of one cylinder.

use serde::Deserialize;
use tertius_core::sequential::drive::FEATURES;
use tertius_core::sequential::whitening::ORDER;
use tertius_core::sequential::wild::Outliers;
use tertius_core::sequential::windows::WIDTHS;

/// The sequential detectors of all cylinders that have a calibration for it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sequential {
    /// Of the whole machine, in a year of monitoring.
    pub false_alarms_per_year: f64,
    /// h of all cylinders, nats; absent: that of each cylinder's calibration, else by
    /// [`tertius_core::sequential::level`].
    pub level: Option<f64>,
    /// The share of samples that may be wild, and no fault, on a healthy bus: what `tertius calibrate` reckons
    /// with.
    pub outlier_share: f64,
    /// Platform states in which the rods stand on their mechanical stops, named as
    /// [`Machine::monitored_states`](super::Machine::monitored_states); absent: none is known.
    pub stop_states: Option<Vec<String>>,
    /// The path of the file in which the gateway keeps what was read on the stops, relative to the
    /// configuration file; absent: in memory only.
    pub history: Option<String>,
    /// A transducer that has drifted this far is due for maintenance, m; absent: a tenth of the
    /// difference at which the machine itself trips.
    pub maintenance: Option<f64>,
}

impl Default for Sequential {
    fn default() -> Self {
        Self {
            false_alarms_per_year: 1.0,
            level: None,
            outlier_share: Outliers::USUAL.share,
            stop_states: None,
            history: None,
            maintenance: None,
        }
    }
}

/// What the sequential detector of one cylinder knows of its healthy readings.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CylinderSequential {
    /// Sample time of the readings that it was calibrated to, s; absent: 0.02, as of tables from before this
    /// key.
    pub sample_time: Option<f64>,
    /// h, nats, where the machine has none for all; absent: by the wanted rate alone.
    pub level: Option<f64>,
    /// The first node on the stroke and the distance to the next, m.
    pub first: f64,
    pub spacing: f64,
    /// C1 − C2 at each node, m.
    pub nodes: Vec<f64>,
    /// The standard deviation of each, m; absent: they are taken for known where there were samples enough.
    #[serde(default)]
    pub node_deviations: Vec<f64>,
    /// Samples that the calibration had of each cell between two nodes.
    pub samples: Vec<u64>,
    /// What C1 − C2 grows by with the velocity, s.
    pub velocity: f64,
    /// The share of wild samples that the calibration reckoned with.
    #[serde(default = "unsaid")]
    pub outlier_share: f64,
    /// Standard deviation of the residual, m, whatever the speed, …
    pub deviation: f64,
    /// … at rest, m, …
    pub noise: f64,
    /// … and what it grows by with the speed, s: how far apart both are sampled by chance.
    pub timing: f64,
    /// What the readings of C1 and of C2 move in, m; 0 where that is not known.
    #[serde(default)]
    pub resolution: [f64; 2],
    /// The rate functions of the mean and of the root mean square of residuals that are weighed to
    /// scatter as at rest, nats, from 0 in steps of
    /// `rate_spacing`, m.
    pub rate_spacing: f64,
    pub rate: Vec<f64>,
    pub square_rate: Vec<f64>,
    /// Samples of mean and of mean square that say as much as one, for each of [`WIDTHS`].
    pub mean_dependence: [f64; WIDTHS.len()],
    pub square_dependence: [f64; WIDTHS.len()],
    /// The velocity by the commands; absent: nothing is located.
    pub drive: Option<[f64; FEATURES]>,
    /// What the readings differ by from it in a cycle, m.
    #[serde(default)]
    pub prediction: f64,
    /// Correlation of these errors that are 1, 2, … cycles apart; absent: not known.
    pub prediction_correlation: Option<[f64; ORDER]>,
}

const fn unsaid() -> f64 {
    Outliers::UNSAID.share
}
