//! The reference of the sequential detector: C1 − C2 along the stroke, and its accuracy.

use super::division::{Division, Halves};
use super::driving::Drives;
use super::fitting::Fitted;
use super::line::Line;
use super::residuals::deviation;
use super::smoothing::{Equations, Look, Solution};
use crate::survey::{Row, Surveyor};
use tertius_core::sequential::drive::Drive;
use tertius_core::sequential::noise::LEAST_TIMING;
use tertius_core::sequential::parameters::ResidualParameters;
use tertius_core::sequential::reference::DOUBTED;
use tertius_core::sequential::samples::{Independence, Sample};
use tertius_core::sequential::thinning::Thinning;
use tertius_core::sequential::velocity::Velocity;
use tertius_core::sequential::{Noise, Reference};

/// Distance between nodes, m.
const SPACING: f64 = 0.1;

/// Largest change of a difference by temperature within [`WARMING_TIME`], m.
const WARMING: f64 = 3e-4;
/// Time within which the temperature may change a difference by [`WARMING`], s.
const WARMING_TIME: f64 = 900.0;

/// Profile and drive of one cylinder's detector.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    pub reference: Reference,
    /// Number of samples in motion, for each cell between two nodes.
    pub samples: Vec<u64>,
    /// Assumed standard deviation of the nodes' second differences, m.
    pub bend: f64,
    /// Drive; `None` where there were too few commands to fit one.
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
    noise: Noise,
    first: f64,
    halves: [Equations; 2],
    /// The look that is being gathered, and the half that is learnt from it.
    current: Option<([u64; 2], usize)>,
    look: Look,
    samples: Vec<u64>,
    speed: Velocity,
    thinning: Thinning,
    drives: Box<Drives>,
}

impl Profiling {
    /// A fit for cylinders with the reach `stroke`, m, sampled every `sample_time` seconds, on the
    /// parts that `division` learns from.
    pub fn new<'a>(
        division: Division,
        stroke: [f64; 2],
        sample_time: f64,
        fits: impl IntoIterator<Item = Option<&'a Fitted>>,
    ) -> Self {
        let first = (stroke[0] / SPACING).floor() * SPACING;
        let cells = (((stroke[1] - first) / SPACING).ceil() as usize).clamp(1, 1000);
        let own = WARMING * (division.fitted().length() / WARMING_TIME).clamp(0.01, 1.0);
        let gathered = |fitted: &Fitted| Gathered {
            line: fitted.line,
            limit: fitted.limit,
            noise: Noise { rest: fitted.roughness.max(1e-6), timing: LEAST_TIMING },
            first,
            halves: [(); 2].map(|()| Equations::new(cells, own)),
            current: None,
            look: Look::new(cells),
            samples: vec![0; cells],
            speed: Velocity::new(&ResidualParameters::DEFAULT, sample_time),
            thinning: Thinning::new(
                &ResidualParameters::DEFAULT,
                sample_time,
                deviation(fitted),
                f64::INFINITY,
            ),
            drives: Box::new(Drives::new(sample_time)),
        };
        let cylinders = fits.into_iter().map(|fitted| fitted.map(gathered)).collect();
        Self { division, cylinders }
    }

    /// The profile of the cylinder of `index` (from 0), and the references of each half alone;
    /// `None` where there was nothing to fit.
    pub fn result(&self, index: usize) -> Option<(Profile, Halves)> {
        self.cylinders[index].as_ref()?.result()
    }
}

impl Surveyor for Profiling {
    fn row(&mut self, row: &Row) {
        let gathered = self.cylinders[usize::from(row.cylinder) - 1].as_mut();
        if let Some((gathered, half)) = gathered.zip(self.division.taught(row.t)) {
            gathered.take(row, (self.division.look(row.t), half));
        }
    }

    fn gap(&mut self, cylinder: u8) {
        if let Some(gathered) = self.cylinders[usize::from(cylinder) - 1].as_mut() {
            gathered.speed.reset();
            gathered.thinning.reset();
            gathered.drives.clear();
        }
    }
}

impl Gathered {
    fn take(&mut self, row: &Row, look: ([u64; 2], usize)) {
        let speed = self.speed.step(row.c2, row.v2);
        let near = |(c1, c2): &(f64, f64)| self.line.error(*c2, *c1).abs() <= self.limit;
        let pair = row.c1.zip(row.c2).filter(|_| row.monitored).filter(near);
        self.drives.step(pair.map(|(c1, c2)| 0.5 * (c1 + c2)), row.u);
        let Some(((c1, c2), velocity)) = pair.zip(speed) else { return };
        let error = self.line.error(c2, c1);
        // At rest one reading says what the one before has said, however it was rounded.
        let independence = self.thinning.step([c1, c2], Sample::at_rest(error));
        let place = Reference::place(self.first, SPACING, self.samples.len() + 1, c2);
        let Some(place) = place.filter(|_| independence == Independence::InMotion) else { return };
        if let Some((_, half)) = self.current.replace(look).filter(|before| *before != look) {
            self.halves[half].take(&self.look);
            self.look.clear();
        }
        self.look.add(place, velocity, error, 1.0 / self.noise.variance(velocity));
        self.samples[place.cell] += 1;
    }

    fn result(&self) -> Option<(Profile, Halves)> {
        let mut halves = self.halves.clone();
        if let Some((_, half)) = self.current {
            halves[half].take(&self.look);
        }
        let whole = halves[0].with(&halves[1]);
        let bend = whole.bend()?;
        let whole = whole.solve(bend)?;
        let halves = halves.map(|half| Some(self.reference(half.solve(bend)?.beside(&whole))));
        let (reference, samples) = (self.reference(whole), self.samples.clone());
        Some((Profile { reference, samples, bend, drive: self.drives.result() }, halves))
    }

    /// The reference of C1 − C2, with the line as a part of it.
    fn reference(&self, solution: Solution) -> Reference {
        let Line { gain, offset } = self.line;
        let along = |i: usize| (gain - 1.0) * (self.first + SPACING * i as f64) + offset;
        let nodes = solution.nodes.iter().enumerate().map(|(i, node)| node + along(i)).collect();
        Reference {
            first: self.first,
            spacing: SPACING,
            nodes,
            doubts: solution.deviations.iter().map(|deviation| DOUBTED * deviation).collect(),
            covered: vec![true; self.samples.len()],
            velocity: solution.velocity,
        }
    }
}
