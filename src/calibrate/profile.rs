//! The reference of the sequential detector: what C1 − C2 is along the stroke, and how fast the
//! command makes the rod go.

use super::division::{Division, Halves};
use super::fitting::Fitted;
use super::line::Line;
use crate::identify::qr::Triangle;
use crate::sequential::Reference;
use crate::sequential::drive::{Commands, Drive, FEATURES};
use crate::sequential::reference::Place;
use crate::sequential::velocity::Velocity;
use crate::survey::{Row, Surveyor};
use nalgebra::{DMatrix, DVector};

/// From node to node, m.
const SPACING: f64 = 0.1;

/// A cell of the stroke with fewer samples is not covered.
pub const LEAST_SAMPLES: u64 = 400;

/// Of two halves, each that judges the other has to have so many of it.
const LEAST_OF_HALF: u64 = LEAST_SAMPLES / 2;

/// Weight of the squared second differences of neighbouring nodes, in samples.
const RIDGE: f64 = 2500.0;

/// Cycles of a displacement that the drive is fitted to.
const SPAN: usize = 10;

/// Displacements begin every so many cycles; they overlap.
const EVERY: u64 = 5;

/// Commands of neighbouring cycles are nearly one: a pseudo-row of this part of each regressor.
const DRIVE_RIDGE: f64 = 1e-3;

/// Fewer displacements give no drive: half a minute at 50 Hz.
const LEAST_DISPLACEMENTS: u64 = 300;

/// What one cylinder's detector starts from.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    pub reference: Reference,
    /// For each cell between two nodes; of two halves that judge each other, twice what the poorer one
    /// has: what nobody could judge is not covered.
    pub samples: Vec<u64>,
    /// `None` where the commands were too few to fit.
    pub drive: Option<Drive>,
}

/// Fits a [`Profile`] to every cylinder that has a line, on samples near it.
#[derive(Clone, Debug)]
pub struct Profiling {
    division: Division,
    cylinders: Vec<Option<Gathered>>,
}

#[derive(Clone, Debug)]
struct Gathered {
    line: Line,
    limit: f64,
    first: f64,
    halves: [Sums; 2],
    speed: Velocity,
    drives: Box<Drives>,
}

/// The normal equations.
#[derive(Clone, Debug)]
struct Sums {
    /// Of each node: itself squared, with the next one, with the velocity, with the difference.
    nodes: Vec<[f64; 4]>,
    samples: Vec<u64>,
    /// The velocity squared, and with the difference.
    velocity: [f64; 2],
}

impl Profiling {
    /// Of cylinders with the reach `stroke`, m, sampled every `sample_time` seconds, on what teaches by
    /// `division`.
    pub fn new<'a>(
        division: Division,
        stroke: [f64; 2],
        sample_time: f64,
        fits: impl IntoIterator<Item = Option<&'a Fitted>>,
    ) -> Self {
        let first = (stroke[0] / SPACING).floor() * SPACING;
        let cells = (((stroke[1] - first) / SPACING).ceil() as usize).clamp(1, 1000);
        let gathered = |fitted: &Fitted| Gathered {
            line: fitted.line,
            limit: fitted.limit,
            first,
            halves: [(); 2].map(|()| Sums::new(cells)),
            speed: Velocity::new(sample_time),
            drives: Box::new(Drives::new(sample_time)),
        };
        let cylinders = fits.into_iter().map(|fitted| fitted.map(gathered)).collect();
        Self { division, cylinders }
    }

    /// What came of the cylinder of `index` (from 0), and what each half alone has taught; `None` where
    /// there was nothing to fit.
    pub fn result(&self, index: usize) -> Option<(Profile, Halves)> {
        self.cylinders[index].as_ref()?.result(self.division.alternates())
    }
}

impl Surveyor for Profiling {
    fn row(&mut self, row: &Row) {
        let gathered = self.cylinders[usize::from(row.cylinder) - 1].as_mut();
        if let Some((gathered, half)) = gathered.zip(self.division.taught(row.t)) {
            gathered.take(row, half);
        }
    }

    fn gap(&mut self, cylinder: u8) {
        if let Some(gathered) = self.cylinders[usize::from(cylinder) - 1].as_mut() {
            gathered.speed.reset();
            gathered.drives.clear();
        }
    }
}

impl Gathered {
    fn take(&mut self, row: &Row, half: usize) {
        let speed = self.speed.step(row.c2, row.v2);
        let near = |(c1, c2): &(f64, f64)| self.line.error(*c2, *c1).abs() <= self.limit;
        let pair = row.c1.zip(row.c2).filter(|_| row.monitored).filter(near);
        self.drives.step(pair.map(|(c1, c2)| 0.5 * (c1 + c2)), row.u);
        let Some(((c1, c2), velocity)) = pair.zip(speed) else { return };
        let sums = &mut self.halves[half];
        let count = sums.nodes.len();
        let Some(place) = Reference::place(self.first, SPACING, count, c2) else { return };
        sums.add(place, c1 - c2, velocity);
    }

    fn result(&self, alternates: bool) -> Option<(Profile, Halves)> {
        let [one, other] = &self.halves;
        let whole = one.with(other);
        let samples: Vec<u64> = if alternates {
            let both = one.samples.iter().zip(&other.samples);
            both.map(|(one, other)| 2 * *one.min(other)).collect()
        } else {
            whole.samples.clone()
        };
        let (first, least) = (self.first, if alternates { LEAST_OF_HALF } else { LEAST_SAMPLES });
        let halves = [0, 1].map(|half: usize| self.halves[half].reference(first, least));
        let mut reference = whole.reference(first, LEAST_SAMPLES)?;
        reference.covered = samples.iter().map(|samples| *samples >= LEAST_SAMPLES).collect();
        Some((Profile { reference, samples, drive: self.drives.result() }, halves))
    }
}

impl Sums {
    fn new(cells: usize) -> Self {
        Self { nodes: vec![[0.0; 4]; cells + 1], samples: vec![0; cells], velocity: [0.0; 2] }
    }

    fn add(&mut self, place: Place, difference: f64, velocity: f64) {
        let hats = [1.0 - place.part, place.part];
        for (hat, node) in hats.into_iter().zip(&mut self.nodes[place.cell..]) {
            node[0] += hat * hat;
            node[2] += hat * velocity;
            node[3] += hat * difference;
        }
        self.nodes[place.cell][1] += hats[0] * hats[1];
        self.samples[place.cell] += 1;
        self.velocity[0] += velocity * velocity;
        self.velocity[1] += velocity * difference;
    }

    /// Of both.
    fn with(&self, other: &Self) -> Self {
        let mut both = self.clone();
        for (node, more) in both.nodes.iter_mut().zip(&other.nodes) {
            node.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        }
        both.samples.iter_mut().zip(&other.samples).for_each(|(sum, more)| *sum += more);
        both.velocity.iter_mut().zip(&other.velocity).for_each(|(sum, more)| *sum += more);
        both
    }

    /// What solves them, from the node at `first`, m, on; a cell of fewer than `least` samples is not
    /// covered. Hats are between 0 and 1 and hardly overlap, so that nothing is lost by squaring them.
    fn reference(&self, first: f64, least: u64) -> Option<Reference> {
        let count = self.nodes.len();
        let (mut matrix, mut right) =
            (DMatrix::zeros(count + 1, count + 1), DVector::zeros(count + 1));
        for (i, [square, next, velocity, difference]) in self.nodes.iter().enumerate() {
            matrix[(i, i)] += square;
            if i + 1 < count {
                matrix[(i, i + 1)] += next;
                matrix[(i + 1, i)] += next;
            }
            matrix[(i, count)] = *velocity;
            matrix[(count, i)] = *velocity;
            right[i] = *difference;
        }
        for i in 1..count - 1 {
            for (j, a) in [(i - 1, 1.0), (i, -2.0), (i + 1, 1.0)] {
                for (k, b) in [(i - 1, 1.0), (i, -2.0), (i + 1, 1.0)] {
                    matrix[(j, k)] += RIDGE * a * b;
                }
            }
        }
        matrix[(count, count)] = self.velocity[0];
        right[count] = self.velocity[1];
        let solution = matrix.cholesky()?.solve(&right);
        if !solution.iter().all(|value| value.is_finite()) {
            return None;
        }
        Some(Reference {
            first,
            spacing: SPACING,
            nodes: solution.as_slice()[..count].to_vec(),
            covered: self.samples.iter().map(|samples| *samples >= least).collect(),
            velocity: solution[count],
        })
    }
}

/// Displacements of [`SPAN`] cycles on the commands that made them.
#[derive(Clone, Debug)]
struct Drives {
    sample_time: f64,
    commands: Commands,
    /// Lengths and features of the newest cycles, a ring.
    ring: [(f64, [f64; FEATURES]); SPAN],
    held: usize,
    cycle: u64,
    /// The features' means over a displacement, and its velocity.
    triangle: Triangle<{ FEATURES + 1 }>,
}

impl Drives {
    fn new(sample_time: f64) -> Self {
        Self {
            sample_time,
            commands: Commands::default(),
            ring: [(0.0, [0.0; FEATURES]); SPAN],
            held: 0,
            cycle: 0,
            triangle: Triangle::new(),
        }
    }

    fn clear(&mut self) {
        self.commands.clear();
        self.held = 0;
    }

    fn step(&mut self, length: Option<f64>, command: Option<f64>) {
        let Some(command) = command else { return self.clear() };
        self.commands.push(command);
        let Some((length, features)) = length.zip(self.commands.features()) else {
            self.held = 0;
            return;
        };
        let place = (self.cycle % SPAN as u64) as usize;
        if self.held == SPAN && self.cycle.is_multiple_of(EVERY) {
            self.add(length - self.ring[place].0);
        }
        self.ring[place] = (length, features);
        self.held = (self.held + 1).min(SPAN);
        self.cycle += 1;
    }

    fn add(&mut self, displacement: f64) {
        let mut row = [0.0; FEATURES + 1];
        for (_, features) in &self.ring {
            for (mean, feature) in row.iter_mut().zip(features) {
                *mean += feature / SPAN as f64;
            }
        }
        row[FEATURES] = displacement / (SPAN as f64 * self.sample_time);
        self.triangle.add(&row);
    }

    fn result(&self) -> Option<Drive> {
        if self.triangle.rows() < LEAST_DISPLACEMENTS {
            return None;
        }
        let mut triangle = self.triangle.clone();
        let rows = (triangle.rows() as f64).sqrt();
        for feature in 0..FEATURES {
            let mut row = [0.0; FEATURES + 1];
            // A regressor that never was anything else than zero has the coefficient zero.
            row[feature] =
                (DRIVE_RIDGE * rows * self.triangle.rms(feature)).max(f64::MIN_POSITIVE.sqrt());
            triangle.add(&row);
        }
        let regressors: Vec<usize> = (0..FEATURES).collect();
        let solved = triangle.solve(&regressors, FEATURES).ok()?;
        Some(Drive(solved.coefficients.try_into().ok()?))
    }
}
