//! From the fitted tables to a sequential detector.

use super::connector::Connector;
use super::flaw::Flaw;
use crate::settings::{CylinderExcursions, CylinderSequential};
use tertius_core::observe::riccati::RiccatiError;
use tertius_core::sequential::excursions::STRAYS;
use tertius_core::sequential::pair::Prediction;
use tertius_core::sequential::reference::DOUBTED;
use tertius_core::sequential::whitening::Whitening;
use tertius_core::sequential::wild::Outliers;
use tertius_core::sequential::windows::WIDTHS;
use tertius_core::sequential::{
    Design, Drive, ExcursionLimits, Noise, PairDesign, Rate, Reference, SequentialParameters,
};

/// Least number of samples with which a cell of the stroke is covered, for a table that does not
/// say how well its nodes are known.
const LEAST_SAMPLES: u64 = 400;

impl Connector<'_> {
    /// The sequential detector of cylinder `n`; `None` where it is not calibrated or has no C2.
    pub(super) fn sequential(&mut self, n: u8) -> Option<Design> {
        let settings = self.settings;
        let fitted = settings.sequential_of(n)?;
        if !settings.has_c2(n) {
            self.flaws.push(Flaw::new(
                "cylinder.sequential",
                format!("cylinder {n} has no C2 to be compared with"),
                "name it as signals.cylinder.c2, or leave the table out",
            ));
            return None;
        }
        let sample_time = settings.machine.sample_time;
        let pair = pair(fitted, sample_time).unwrap_or_else(|error| {
            let what = match error {
                Some(error) => format!("cylinder {n} has no filter of both readings: {error}"),
                None => format!("no errors have the prediction_correlation of cylinder {n}"),
            };
            self.flaws.push(Flaw::new("cylinder.sequential", what, "calibrate it again"));
            None
        });
        Some(Design {
            pair,
            level: settings.sequential_level_of(n),
            clear: settings.warning_cycles(),
            ..unpaired(fitted, sample_time)
        })
    }
}

/// The detector by these tables, sampled every `sample_time` seconds, with a level that nothing reaches.
pub fn sequential(fitted: &CylinderSequential, sample_time: f64) -> Design {
    let pair = pair(fitted, sample_time).unwrap_or(None);
    Design { pair, ..unpaired(fitted, sample_time) }
}

fn unpaired(fitted: &CylinderSequential, sample_time: f64) -> Design {
    Design {
        reference: reference(fitted),
        rate: Rate::new(fitted.rate_spacing, &fitted.rate),
        square_rate: Rate::new(fitted.rate_spacing, &fitted.square_rate),
        dependence: [fitted.mean_dependence, fitted.square_dependence],
        excursions: fitted.excursions.as_ref().map(|it| excursions(it, fitted.noise)),
        deviation: fitted.deviation,
        noise: Noise { rest: fitted.noise, timing: fitted.timing },
        resolution: fitted.resolution,
        outliers: Outliers { share: fitted.outlier_share },
        pair: None,
        level: f64::INFINITY,
        sample_time,
        clear: 1,
        parameters: &SequentialParameters::DEFAULT,
    }
}

/// The filter of both readings; `None` without a drive. The error is that of its gain, or none where no errors have the
/// correlation of the table.
fn pair(
    fitted: &CylinderSequential,
    sample_time: f64,
) -> Result<Option<PairDesign>, Option<RiccatiError>> {
    let Some(drive) = fitted.drive.map(Drive) else { return Ok(None) };
    let whitening = fitted.prediction_correlation.as_ref().map(Whitening::of);
    if whitening == Some(None) {
        return Err(None);
    }
    let prediction = Prediction { deviation: fitted.prediction, whitening: whitening.flatten() };
    let parameters = &SequentialParameters::DEFAULT;
    PairDesign::new(drive, sample_time, fitted.deviation, prediction, parameters)
        .map(Some)
        .map_err(Some)
}

fn excursions(fitted: &CylinderExcursions, rest: f64) -> ExcursionLimits {
    let limits = |values: &[f64], from: usize| core::array::from_fn(|index| values[from + index]);
    let run = |limit: u64| u16::try_from(limit).ok().filter(|limit| *limit > 0);
    ExcursionLimits {
        level: fitted.level,
        rest,
        longest: u16::try_from(fitted.longest).unwrap_or(u16::MAX),
        boxes: ExcursionLimits::boxes(fitted.first_box, fitted.box_width),
        runs: core::array::from_fn(|g| core::array::from_fn(|j| run(fitted.runs[g * STRAYS + j]))),
        clips: fitted.clips,
        sums: core::array::from_fn(|clip| limits(&fitted.sums, clip * WIDTHS.len())),
        squares: limits(&fitted.squares, 0),
        elsewhere: limits(&fitted.elsewhere, 0),
    }
}

fn reference(fitted: &CylinderSequential) -> Reference {
    let deviations = &fitted.node_deviations;
    let doubts = deviations.iter().map(|deviation| DOUBTED * deviation).collect();
    // A table of an earlier version has samples alone.
    let enough = |samples: &u64| !deviations.is_empty() || *samples >= LEAST_SAMPLES;
    Reference {
        first: fitted.first,
        spacing: fitted.spacing,
        nodes: fitted.nodes.clone(),
        doubts: if deviations.is_empty() { vec![0.0; fitted.nodes.len()] } else { doubts },
        covered: fitted.samples.iter().map(enough).collect(),
        velocity: fitted.velocity,
    }
}
