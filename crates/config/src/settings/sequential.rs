//! `[sequential]`, and the tables that `tertius calibrate` has fitted for the detector of one
//! cylinder.

use super::fitted::{FITTED, dependence, fitted};
use crate::kinds::{number, numbers, text, whole};
use crate::schema::{Kind, Limits, Scalar, WholeLimits, table};
use crate::text::TextRule;
use tertius_core::sequential::drive::FEATURES;
use tertius_core::sequential::excursions::{BOXES, CLIPS, STRAYS};
use tertius_core::sequential::whitening::ORDER;
use tertius_core::sequential::wild::Outliers;
use tertius_core::sequential::windows::WIDTHS;

table! {
    /// Settings of the sequential detectors of all cylinders that are calibrated for one.
    pub struct Sequential = SEQUENTIAL {
        false_alarms_per_year: f64 = 1.0 =>
            number(Limits::above(0.0, "a rate of the whole machine, in a year of monitoring").most(1e6)),
            "1.0", "the false alarms that a year of monitoring may bring, all cylinders together";
        /// See [`tertius_core::sequential::level`].
        level: Option<f64> = None =>
            number(Limits::above(0.0, "evidence in nats, at which a detector warns").most(1000.0)),
            "20.0",
            "the level h of all cylinders, nats; absent: that of each cylinder's calibration, else by \
             false_alarms_per_year";
        outlier_share: f64 = Outliers::USUAL.share =>
            number(Limits::least(Outliers::LEAST.share, "the share of samples that may be wild").most(0.05)),
            "0.01",
            "the share of samples that may be off by any amount without a fault, on a healthy bus; `tertius \
             calibrate` allows for it: where there are none, 0.001 finds a fault with three samples";
        /// Named as in [`Machine::monitored_states`](super::Machine::monitored_states).
        stop_states: Option<Vec<String>> = None =>
            Kind::List { least: 1, most: 64, of: Scalar::Text(TextRule::Name) },
            "[\"settled\"]", "the platform states in which the rods stand on their mechanical stops";
        history: Option<String> = None => text(TextRule::Path),
            "\"/var/lib/tertius/e-type.dwells\"",
            "the file in which the gateway keeps what was read on the stops, relative to this file; absent: \
             in memory only";
        maintenance: Option<f64> = None =>
            number(Limits::above(0.0, "how far a reading on the stop may move, in metres")),
            "0.005",
            "a transducer that has drifted this far is due for maintenance, m; absent: a tenth of \
             comparator.critical";
    }
}

table! {
    /// Calibration of the sequential detector of one cylinder.
    pub struct CylinderSequential = CYLINDER_SEQUENTIAL {
        sample_time: Option<f64> = None => number(Limits::above(0.0, FITTED)),
            "0.02",
            "the sample time of the readings that it was calibrated to, s; absent: 0.02, as of tables from \
             before this key";
        level: Option<f64> = None =>
            number(Limits::above(0.0, "evidence in nats, at which the detector warns").most(1000.0)),
            "19.5",
            "the level h of this cylinder, nats, where `sequential.level` has none for all; absent: by \
             false_alarms_per_year";
        first: f64 => number(Limits::finite(FITTED)),
            "-1.5", "where on the stroke the first node is, m";
        spacing: f64 => number(Limits::above(0.0, FITTED)),
            "0.1", "from node to node, m";
        nodes: Vec<f64> => fitted(2, 1001),
            "[0.001, 0.0012]", "C1 - C2 at each node, m";
        node_deviations: Vec<f64> = Vec::new() =>
            Kind::List { least: 2, most: 1001, of: Scalar::Number(Limits::least(0.0, FITTED)) },
            "[0.00001, 0.00005]",
            "the standard deviation of each node, m: where three times it exceeds 0.2 mm, nothing is judged; \
             absent: nodes count as known where `samples` are 400 or more";
        samples: Vec<u64> =>
            Kind::List { least: 1, most: 1000, of: Scalar::Whole(WholeLimits::new(0, i64::MAX as i128, FITTED)) },
            "[5000]", "samples that the calibration had between each two nodes";
        velocity: f64 => number(Limits::finite(FITTED)),
            "0.0001", "the growth of C1 - C2 with the velocity, s";
        outlier_share: f64 = Outliers::UNSAID.share =>
            number(Limits::least(Outliers::LEAST.share, FITTED).most(0.05)),
            "0.01", "the share of wild samples that the calibration allowed for; absent: 0.02";
        deviation: f64 => number(Limits::above(0.0, FITTED)),
            "0.0001", "the standard deviation of the residual, m";
        noise: f64 => number(Limits::above(0.0, FITTED)),
            "0.0001",
            "the standard deviation of the residual at rest, m; a table without it is of an earlier version: \
             make a new one with `tertius calibrate`";
        timing: f64 => number(Limits::least(0.0, FITTED)),
            "0.0001", "the growth of the standard deviation with the speed, s; `tertius calibrate` writes it";
        resolution: [f64; 2] = [0.0; 2] => numbers(2, Limits::least(0.0, FITTED)),
            "[1e-4, 1e-4]", "the resolutions of the readings of C1 and of C2, m";
        rate_spacing: f64 => number(Limits::above(0.0, FITTED)),
            "1e-5", "from value to value of the rate functions, m";
        rate: Vec<f64> => fitted(2, 1001),
            "[0.0, 0.5]", "the rate function of the residual's mean, nats";
        square_rate: Vec<f64> => fitted(2, 1001),
            "[0.0, 0.5]", "the rate function of its root mean square, nats";
        /// One for each of [`WIDTHS`].
        mean_dependence: [f64; WIDTHS.len()] => dependence(),
            "[1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1]",
            "samples of the mean that carry as much information as one, by the width of the window";
        square_dependence: [f64; WIDTHS.len()] => dependence(),
            "[1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1]",
            "samples of the mean square that carry as much information as one, by the width of the window";
        drive: Option<[f64; FEATURES]> = None => fitted(FEATURES, FEATURES),
            "[0.1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]", "the velocity by the commands";
        prediction: f64 = 0.0 => number(Limits::least(0.0, FITTED)),
            "0.0001", "the deviation of the readings from it, m";
        prediction_correlation: Option<[f64; ORDER]> = None =>
            Kind::List { least: ORDER, most: ORDER, of: Scalar::Number(Limits::least(-1.0, FITTED).most(1.0)) },
            "[0.4, 0.1, -0.2, -0.4, -0.3, -0.1]",
            "how alike two of these deviations are that are 1, 2, ... cycles apart; absent: not known";
        excursions: Option<CylinderExcursions> = None => Kind::Table(&CYLINDER_EXCURSIONS),
            "", "limits by the excursions of transducers that fluctuate; absent: they do not, or are too coarse to show it";
    }
}

/// Limits of runs: for each box, with each number of strays.
const RUNS: usize = BOXES * STRAYS;

/// A limit above 0 for each window of each of so many statistics.
const fn limits_of(count: usize) -> Kind {
    let count = count * WIDTHS.len();
    Kind::List { least: count, most: count, of: Scalar::Number(Limits::above(0.0, FITTED)) }
}

table! {
    /// How far the readings of one cylinder may be apart, and for how long, where its transducers fluctuate.
    pub struct CylinderExcursions = CYLINDER_EXCURSIONS {
        level: f64 => number(Limits::above(0.0, "evidence in nats, at which the detector warns").most(1000.0)),
            "23.0", "the level that these limits stand for, nats";
        rate: f64 => number(Limits::least(0.0, FITTED)),
            "0.05", "excursions of both transducers together, 1/s";
        size: f64 => number(Limits::above(0.0, FITTED)),
            "4.34e-4", "the size that 95 % of them do not exceed, m";
        longest: u64 => whole(1, u16::MAX as i128, FITTED),
            "11", "the longest one, samples";
        first_box: f64 => number(Limits::above(0.0, FITTED)),
            "2.8e-4", "the lower end of the first box of C1 - C2, m; the others follow every 0.125 mm";
        box_width: f64 => number(Limits::above(0.0, FITTED)),
            "5e-4", "from the lower to the upper end of a box, m; the last one has no upper end";
        /// For each box without a stray, with one, and with two.
        runs: Vec<u64> =>
            Kind::List { least: RUNS, most: RUNS, of: Scalar::Whole(WholeLimits::new(0, u16::MAX as i128, FITTED)) },
            "[31, 41, 45, 22, 28, 32, 13, 15, 21, 12, 14, 19, 12, 13, 16, 11, 12, 12, 9, 11, 11, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5]",
            "samples in a row in each box that are too many, with 0, 1 and 2 strays; 0: none are";
        clips: [f64; CLIPS] => numbers(CLIPS, Limits::above(0.0, FITTED)),
            "[2.8e-4, 6.1e-4, 1.25e-3]", "values beyond which a sample counts no more, m";
        sums: Vec<f64> => limits_of(CLIPS),
            "[0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01]",
            "largest sums of C1 - C2, for each clip and each width of the windows, m";
        squares: Vec<f64> => limits_of(1),
            "[1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6]",
            "largest sums of its square, for each width, m2";
        elsewhere: Vec<f64> => limits_of(1),
            "[9.5, 9.5, 9.5, 9.5, 9.5, 9.5, 9.5, 9.5, 9.5, 9.5, 9.5, 9.5, 9.5, 9.5, 9.5, 9.5, 9.5, 9.5, 9.5, 9.5]",
            "most samples that are off and elsewhere than the one before, for each width";
    }
}
