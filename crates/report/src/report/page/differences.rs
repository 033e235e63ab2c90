//! Differences of C1 and C2 over a whole recording, before and after the correction.

use super::traces::Trace;
use tertius_learn::calibrate::{Calibration, Line};
use tertius_learn::extremes::Thinned;
use tertius_learn::survey::{Row, Surveyor};

/// Number of samples by position that are kept of a cylinder.
const POINTS: usize = 600;

/// One cylinder's differences.
#[derive(Clone, Debug)]
pub struct Difference {
    line: Line,
    /// C1 − C2 and C1 − Ĉ2 over the time since the first frame, m.
    pub over_time: Trace<2>,
    /// C2 and both differences, m.
    points: Thinned<(f64, [f64; 2])>,
}

/// Reads the recording once more, with the lines that were fitted.
#[derive(Clone, Debug)]
pub struct Differences {
    cylinders: Vec<Option<Difference>>,
}

impl Differences {
    /// Differences of the cylinders that have a line.
    pub fn new(result: &Calibration, sample_time: f64) -> Self {
        let difference = |cylinder: &tertius_learn::calibrate::CylinderCalibration| {
            let line = cylinder.result.as_ref().ok()?.line;
            let (over_time, points) = (Trace::new(sample_time), Thinned::new(POINTS));
            Some(Difference { line, over_time, points })
        };
        Self { cylinders: result.cylinders.iter().map(difference).collect() }
    }

    /// Differences of the cylinder `number` (from 1).
    pub fn of(&self, number: u8) -> Option<&Difference> {
        self.cylinders.get(usize::from(number).checked_sub(1)?)?.as_ref()
    }
}

impl Difference {
    /// C2 and the difference before (0) or after (1) the correction, of samples spread evenly over
    /// the recording, m.
    pub fn points(&self, which: usize) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.points.samples().iter().map(move |(c2, both)| (*c2, both[which]))
    }
}

impl Surveyor for Differences {
    fn row(&mut self, row: &Row) {
        let cylinder = self.cylinders.get_mut(usize::from(row.cylinder).wrapping_sub(1));
        let Some(Some(difference)) = cylinder else { return };
        let Some((c1, c2)) = row.c1.zip(row.c2) else { return };
        let both = [c1 - c2, difference.line.error(c2, c1)];
        difference.over_time.add(row.t, both.map(Some), false);
        difference.points.add((c2, both));
    }

    fn gap(&mut self, _: u8) {}
}
