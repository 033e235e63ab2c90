//! The readings of both transducers in a recording, and the line near which they lie.

use super::line::{Line, Robust};
use super::refusal::CalibrationRefusal;
use super::resolution::Resolution;
use crate::extremes::Thinned;
use crate::identify::moments::{Pair, Spread};
use crate::order_statistics::ranked;
use crate::survey::{Lull, Row, Surveyor};
use tertius_core::sample::{Quality, Transducer};
use tertius_core::sequential::Noise;

/// Most samples of a cylinder that are kept for the line.
const KEPT: usize = 20_000;

/// Fewest samples with both readings for a calibration: ten seconds at 50 Hz.
const LEAST_ROWS: u64 = 500;

/// Least part of the stroke that has to be used.
const LEAST_MOTION: f64 = 0.1;

/// Least correlation of C1 and C2 of one cylinder; whatever their noise, they are far above it.
const LEAST_CORRELATION: f64 = 0.9;

/// Data of one cylinder.
#[derive(Clone, Debug)]
struct Gathered {
    rows: u64,
    good: [Spread; 2],
    raw: [Spread; 2],
    qualities: [[u64; Quality::COUNT]; 2],
    /// C2 and C1 of single samples.
    points: Thinned<(f64, f64)>,
    lull: Lull,
    /// Resolutions of C1 and C2.
    resolutions: [Resolution; 2],
}

/// The first pass: whether the data suffice for a calibration.
#[derive(Clone, Debug)]
pub struct Gathering {
    stroke: f64,
    /// a and b of each cylinder, where configured.
    configured: Vec<Option<(f64, f64)>>,
    cylinders: Vec<Gathered>,
    newest: Vec<Option<(u64, f64, f64)>>,
    cycle: u64,
    /// C1 of one cylinder with C2 of another, row by row.
    crossed: Vec<Pair>,
}

impl Gathering {
    /// A pass over a machine whose cylinders have the length `stroke`, m, and the calibrations
    /// `configured`.
    pub fn new(stroke: f64, configured: Vec<Option<(f64, f64)>>) -> Self {
        let count = configured.len();
        let gathered = Gathered {
            rows: 0,
            good: [Spread::default(); 2],
            raw: [Spread::default(); 2],
            qualities: [[0; Quality::COUNT]; 2],
            points: Thinned::new(KEPT),
            lull: Lull::default(),
            resolutions: Default::default(),
        };
        Self {
            stroke,
            configured,
            cylinders: vec![gathered; count],
            newest: vec![None; count],
            cycle: 0,
            crossed: vec![Pair::default(); count * count],
        }
    }

    /// Number of cylinders.
    pub const fn count(&self) -> usize {
        self.cylinders.len()
    }

    /// The line of the cylinder of `index` (from 0), and the deviation from it.
    ///
    /// # Errors
    /// What is wrong with its data.
    pub fn judge(&self, index: usize) -> Result<Robust, CalibrationRefusal> {
        let gathered = &self.cylinders[index];
        gathered.presence()?;
        let rows = gathered.points.seen();
        if rows < LEAST_ROWS {
            return Err(CalibrationRefusal::TooFewRows { rows, least: LEAST_ROWS });
        }
        let range_mm = 1e3 * gathered.range();
        let least_mm = 1e3 * LEAST_MOTION * self.stroke;
        let robust = Robust::fit(gathered.points.samples(), gathered.rounding());
        // A wrong unit makes a motion of metres one of millimetres: told first.
        let together = self.correlation(index, index).abs() > LEAST_CORRELATION;
        if let Some(Robust { line, .. }) = robust.as_ref().filter(|_| together) {
            unit(line.gain)?;
        }
        if range_mm < least_mm {
            return Err(CalibrationRefusal::HardlyMoves { range_mm, least_mm });
        }
        self.partners(index)?;
        self.sides(index)?;
        robust.ok_or(CalibrationRefusal::HardlyMoves { range_mm, least_mm })
    }

    /// The line of the cylinder of `index` (from 0), whatever is wrong with its data; `None` where they have none.
    pub fn line(&self, index: usize) -> Option<Line> {
        let gathered = &self.cylinders[index];
        Some(Robust::fit(gathered.points.samples(), gathered.rounding())?.line)
    }

    /// Remarks on what cannot be determined of a cylinder that can be calibrated.
    pub fn remarks(&self, index: usize) -> Vec<String> {
        let unknown = self.configured[index].is_none().then(|| {
            "whether C1 and C2 are swapped cannot be told without an earlier calibration (c2_gain, \
             c2_offset)"
                .to_owned()
        });
        unknown.into_iter().collect()
    }

    fn correlate(&mut self) {
        let (count, cycle) = (self.count(), self.cycle);
        let now = |newest: &Option<(u64, f64, f64)>| newest.filter(|(at, ..)| *at == cycle);
        for i in 0..count {
            let Some((_, c1, _)) = now(&self.newest[i]) else { continue };
            for j in 0..count {
                if let Some((_, _, c2)) = now(&self.newest[j]) {
                    self.crossed[i * count + j].add(c1, c2);
                }
            }
        }
    }

    /// Correlation of C1 of one cylinder with C2 of another.
    fn correlation(&self, first: usize, second: usize) -> f64 {
        self.crossed[first * self.count() + second].correlation().unwrap_or(0.0)
    }

    /// Checks that C1 of the cylinder of `index` moves with its own C2, and names the cylinder
    /// whose C2 it moves with.
    fn partners(&self, index: usize) -> Result<(), CalibrationRefusal> {
        let count = self.count();
        let with = |j: usize| self.correlation(index, j);
        let own = with(index);
        let best = (0..count).max_by(|i, j| with(*i).total_cmp(&with(*j))).unwrap_or(index);
        // The unexplained part, 1 − ρ², of the right one is smaller by far.
        if best != index && with(best) > LEAST_CORRELATION && 1.0 - with(best) < 0.1 * (1.0 - own) {
            return Err(CalibrationRefusal::SwappedCylinders {
                other: best as u8 + 1,
                with_other: with(best),
                with_own: own,
            });
        }
        if own < LEAST_CORRELATION {
            return Err(CalibrationRefusal::Unrelated { correlation: own });
        }
        Ok(())
    }

    /// Checks against an earlier calibration whether C1 is where C2 was.
    fn sides(&self, index: usize) -> Result<(), CalibrationRefusal> {
        let Some((a, b)) = self.configured[index] else { return Ok(()) };
        let points = self.cylinders[index].points.samples();
        let middle = |errors: &dyn Fn(f64, f64) -> f64| {
            let mut errors: Vec<f64> =
                points.iter().map(|(c2, c1)| errors(*c2, *c1).abs()).collect();
            ranked(&mut errors, 0.5, f64::total_cmp).unwrap_or(0.0)
        };
        // Medians: a few faulty samples say nothing about it.
        let as_given_mm = 1e3 * middle(&|c2, c1| c1 - (a * c2 + b));
        let swapped_mm = 1e3 * middle(&|c2, c1| c2 - (a * c1 + b));
        if swapped_mm < 0.5 * as_given_mm && as_given_mm - swapped_mm > 0.5 {
            return Err(CalibrationRefusal::SwappedTransducers { as_given_mm, swapped_mm });
        }
        Ok(())
    }
}

impl Surveyor for Gathering {
    fn row(&mut self, row: &Row) {
        if row.cycle != self.cycle {
            self.correlate();
            self.cycle = row.cycle;
        }
        let index = usize::from(row.cylinder) - 1;
        self.newest[index] = self.cylinders[index].take(row).map(|(c1, c2)| (row.cycle, c1, c2));
    }

    fn gap(&mut self, cylinder: u8) {
        let gathered = &mut self.cylinders[usize::from(cylinder) - 1];
        gathered.resolutions.iter_mut().for_each(Resolution::interrupt);
    }
}

impl Gathered {
    fn take(&mut self, row: &Row) -> Option<(f64, f64)> {
        self.rows += 1;
        if self.lull.ends(row.t) {
            self.points.pause();
        }
        for (i, (good, raw)) in [row.c1, row.c2].into_iter().zip(row.raw).enumerate() {
            if let Some(value) = good {
                self.good[i].add(value);
            }
            if let Some(value) = raw.filter(|value| value.is_finite()) {
                self.raw[i].add(value);
            }
            self.qualities[i][row.qualities[i] as usize] += 1;
        }
        let (c1, c2) = row.c1.zip(row.c2)?;
        for (resolution, length) in self.resolutions.iter_mut().zip([c1, c2]) {
            resolution.add(length);
        }
        self.points.add((c2, c1));
        Some((c1, c2))
    }

    /// Difference that the rounding of both readings always leaves, m.
    fn rounding(&self) -> f64 {
        Noise::of_rounding([0, 1].map(|which: usize| self.resolutions[which].count()))
    }

    fn presence(&self) -> Result<(), CalibrationRefusal> {
        if self.rows == 0 {
            return Err(CalibrationRefusal::Absent);
        }
        for (i, signal) in Transducer::LABELS.into_iter().enumerate() {
            let missing = self.rows - self.good[i].count;
            if missing > self.rows / 2 {
                let detail = self.detail(i);
                return Err(CalibrationRefusal::Missing {
                    signal,
                    missing,
                    rows: self.rows,
                    detail,
                });
            }
            if self.good[i].range() <= 0.0 {
                let (value, rows) = (self.good[i].mean, self.good[i].count);
                return Err(CalibrationRefusal::Constant { signal, value, rows });
            }
        }
        Ok(())
    }

    /// What became of the readings, in words.
    fn detail(&self, i: usize) -> String {
        let kinds = [
            (Quality::OutOfRange, "out of range"),
            (Quality::BrokenWire, "with a broken wire"),
            (Quality::Frozen, "frozen"),
            (Quality::Stale, "stale"),
            (Quality::Failed, "of a device that says it is faulty"),
            (Quality::NotOperational, "missing from a device that is not operational"),
        ];
        let count = |quality: Quality| self.qualities[i][quality as usize];
        let parts: Vec<String> = kinds
            .iter()
            .filter(|(quality, _)| count(*quality) > 0)
            .map(|(quality, name)| format!("{} {name}", count(*quality)))
            .collect();
        let Spread { low, high, largest, .. } = self.raw[i];
        let mut text = parts.join(", ");
        if count(Quality::OutOfRange) > 0 {
            text += &format!(", readings from {low:.3} to {high:.3} m");
        }
        if largest > 20.0 {
            text += "; are they in millimetres, a factor of 1000?";
        }
        if text.is_empty() { text } else { format!(": {text}") }
    }

    /// The stroke that C1 used, m, without the outermost hundredth on either side, since a faulty
    /// sample is no motion.
    fn range(&self) -> f64 {
        let mut lengths: Vec<f64> = self.points.samples().iter().map(|(_, c1)| *c1).collect();
        lengths.sort_unstable_by(f64::total_cmp);
        let outer = lengths.len() / 100;
        match lengths.get(outer..lengths.len() - outer) {
            Some([low, .., high]) => high - low,
            _ => 0.0,
        }
    }
}

/// Checks the gain: two transducers of one stroke have about the same.
fn unit(gain: f64) -> Result<(), CalibrationRefusal> {
    if (0.5..=2.0).contains(&gain) {
        return Ok(());
    }
    let power = gain.abs().log10();
    let near = power.round();
    let guess = if gain < 0.0 {
        ": their directions are opposite".to_owned()
    } else if near != 0.0 && (power - near).abs() < 0.1 {
        let times = 10_f64.powf(near.abs());
        format!(", about a factor of {}{times}", if near < 0.0 { "1/" } else { "" })
    } else {
        String::new()
    };
    Err(CalibrationRefusal::Unit { gain, guess })
}
