//! `[sequential]`, and the tables that `tertius calibrate` has fitted for the detector of one
//! cylinder.

use serde::Deserialize;
use tertius_core::sequential::drive::FEATURES;
use tertius_core::sequential::whitening::ORDER;
use tertius_core::sequential::wild::Outliers;
use tertius_core::sequential::windows::WIDTHS;

/// Settings of the sequential detectors of all cylinders that are calibrated for one.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sequential {
    /// Wanted false alarms of the whole machine in a year of monitoring.
    pub false_alarms_per_year: f64,
    /// Level h of all cylinders, nats; absent: that of each cylinder's calibration, else by
    /// [`tertius_core::sequential::level`].
    pub level: Option<f64>,
    /// Share of samples that may be wild, without a fault, on a healthy bus; `tertius calibrate`
    /// allows for it.
    pub outlier_share: f64,
    /// Platform states in which the rods stand on their mechanical stops, named as in
    /// [`Machine::monitored_states`](super::Machine::monitored_states); absent: none is known.
    pub stop_states: Option<Vec<String>>,
    /// Path of the file in which the gateway keeps its readings on the stops, relative to the
    /// configuration file; absent: in memory only.
    pub history: Option<String>,
    /// Drift at which a transducer is due for maintenance, m; absent: a tenth of the difference at
    /// which the machine itself trips.
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

/// Calibration of the sequential detector of one cylinder.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CylinderSequential {
    /// Sample time of the readings of the calibration, s; absent: not known.
    pub sample_time: Option<f64>,
    /// Level h where the machine has none for all cylinders, nats; absent: by the wanted rate
    /// alone.
    pub level: Option<f64>,
    /// Position of the first node on the stroke, m.
    pub first: f64,
    /// Distance from each node to the next, m.
    pub spacing: f64,
    /// C1 − C2 at each node, m.
    pub nodes: Vec<f64>,
    /// Standard deviation of each node, m; absent: nodes count as known where there were enough
    /// samples.
    #[serde(default)]
    pub node_deviations: Vec<f64>,
    /// Number of samples of the calibration in each cell between two nodes.
    pub samples: Vec<u64>,
    /// Growth of C1 − C2 with the velocity, s.
    pub velocity: f64,
    /// Share of wild samples that the calibration allowed for.
    #[serde(default = "unsaid")]
    pub outlier_share: f64,
    /// Standard deviation of the residual at any speed, m.
    pub deviation: f64,
    /// Standard deviation of the residual at rest, m.
    pub noise: f64,
    /// Growth of the standard deviation with the speed, s: how far apart C1 and C2 are sampled by
    /// chance.
    pub timing: f64,
    /// Steps in which the readings of C1 and of C2 move, m; 0 where not known.
    #[serde(default)]
    pub resolution: [f64; 2],
    /// Steps of `rate` and `square_rate`, which begin at 0, m.
    pub rate_spacing: f64,
    /// Rate function of the mean of residuals weighted to scatter as at rest, nats.
    pub rate: Vec<f64>,
    /// Rate function of the root mean square of such residuals, nats.
    pub square_rate: Vec<f64>,
    /// Number of samples of the mean that carry as much information as one independent sample, for
    /// each of [`WIDTHS`].
    pub mean_dependence: [f64; WIDTHS.len()],
    /// Number of samples of the mean square that carry as much information as one independent
    /// sample.
    pub square_dependence: [f64; WIDTHS.len()],
    /// Velocity as a function of the commands; absent: no fault is located.
    pub drive: Option<[f64; FEATURES]>,
    /// Standard deviation of the readings from this prediction over a cycle, m.
    #[serde(default)]
    pub prediction: f64,
    /// Correlation of these errors that are 1, 2, … cycles apart; absent: not known.
    pub prediction_correlation: Option<[f64; ORDER]>,
}

const fn unsaid() -> f64 {
    Outliers::UNSAID.share
}
