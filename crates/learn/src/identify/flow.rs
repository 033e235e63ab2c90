//! The non-linear flow curve f_NL of (3-17) and (3-18): a singleton fuzzy model of each cylinder and
//! direction.
//!
//! The rule "if the spool is about c_j, f_NL is s_j" with triangular memberships μ_j that add up to
//! 1 makes f_NL(x) = Σ μ_j(x) s_j, which is linear in the s_j: least squares on rows of
//! memberships. It is linear from node to node, so that an s_j that few rows determine is not
//! reported at all.

use super::qr::{NoRegression, Triangle};
use crate::extremes::Thinned;
use crate::survey::{Row, Surveyor};
use thiserror::Error;

/// Number of membership functions of a direction (section 3-3-1).
pub const MEMBERSHIPS: usize = 20;
const COLUMNS: usize = MEMBERSHIPS + 1;

/// Fewest cycles, weighted by their membership, with which a singleton is known: a second at 50 Hz.
pub const FEWEST: f64 = 50.0;

/// Number of samples of each cylinder that are kept for a figure.
const SAMPLES: usize = 800;

/// Direction of the oil.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Extending, x_m > 0.
    Extend = 0,
    /// Retracting, x_m < 0.
    Retract = 1,
}

/// Sources of the signals of (3-18).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowSources {
    /// Whether x_m is the recorded spool position; otherwise the command u replaces it.
    pub spool: bool,
    /// Supply pressure P_S, bar, where it is given instead of recorded.
    pub supply: Option<f64>,
    /// Area ratio α of (3-5) and (3-17): a_p / A_p.
    pub area_ratio: f64,
}

/// Data of one cylinder for (3-18).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reach {
    /// Largest |x_m| out and in.
    pub largest: [f64; 2],
    /// Number of monitored cycles.
    pub rows: u64,
    /// Number of monitored cycles without a velocity, load pressure, P_S or x_m.
    pub missing: [u64; 4],
    /// Number of cycles in which P_S − sign(x_m) P_L is not positive.
    pub no_drop: u64,
}

/// One rule: f_NL is `value` at `centre`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Singleton {
    /// Centre c_j, in the unit of x_m, with its sign.
    pub centre: f64,
    /// Σ μ_j over all rows, cycles.
    pub coverage: f64,
    /// s_j and its standard error (for white residuals), m/s/√bar: f_NL over A_p. `None` where
    /// fewer than [`FEWEST`] cycles determine it.
    pub value: Option<(f64, f64)>,
}

/// f_NL of one cylinder and direction.
#[derive(Clone, Debug, PartialEq)]
pub struct FlowCurve {
    pub singletons: Vec<Singleton>,
    pub rows: u64,
    /// Root mean square of φ/√(P_S ∓ P_L) against the curve, over A_p, m/s/√bar.
    pub rms: f64,
    pub condition: f64,
}

/// Why there is no curve.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum NoFlow {
    #[error("none of its cycles is in a monitored state")]
    NeverMonitored,
    #[error("{what} missing in {missing} of {rows} monitored cycles: {help}")]
    Missing { what: &'static str, missing: u64, rows: u64, help: &'static str },
    #[error("the spool hardly goes that way: {rows} cycles, and at least {least:.0} are needed")]
    TooFewRows { rows: u64, least: f64 },
    #[error(
        "the spool stays between membership functions {among} so that they cannot be told apart \
         (condition number {condition:.1e}); record with a spool that moves"
    )]
    Collinear { among: String, condition: f64 },
}

const MISSING: [(&str, &str); 4] = [
    ("the velocity of C1 is", "name it as signals.cylinder.c1_velocity, and record it"),
    (
        "the load pressure is",
        "(3-18) needs it; name signals.cylinder.pressure_bottom and pressure_rod, or load_pressure, \
         and record them",
    ),
    ("the supply pressure P_S is", "name signals.supply and record it, or give --supply BAR"),
    (
        "the spool position is",
        "record signals.cylinder.spool, or leave the key out to use the command",
    ),
];

/// x_m and f_NL over A_p, or the index in [`MISSING`]; `Ok(None)` if the pressure does not drop or
/// the spool is centred.
fn point(row: &Row, sources: &FlowSources) -> Result<Option<(f64, f64)>, usize> {
    let v = row.v1.ok_or(0_usize)?;
    let load = row.load_pressure(sources.area_ratio).ok_or(1_usize)?;
    let supply = sources.supply.or(row.supply).ok_or(2_usize)?;
    let x = if sources.spool { row.spool } else { row.u }.ok_or(3_usize)?;
    // (3-17); α is the area ratio of (3-5), not the α of (3-8).
    let (flow, drop) =
        if x > 0.0 { (v, supply - load) } else { (sources.area_ratio * v, supply + load) };
    let value = flow / drop.sqrt();
    let sound = x != 0.0 && drop > 0.0 && x.is_finite() && value.is_finite();
    Ok(sound.then_some((x, value)))
}

fn direction(x: f64) -> Direction {
    if x > 0.0 { Direction::Extend } else { Direction::Retract }
}

/// Memberships of the place `part` (0 to 1) on the way from 0 to the last centre: triangles over 20
/// equidistant centres, at most two of which are not 0.
pub fn memberships(part: f64) -> [f64; MEMBERSHIPS] {
    let last = MEMBERSHIPS - 1;
    let place = part.clamp(0.0, 1.0) * last as f64;
    std::array::from_fn(|j| (1.0 - (place - j as f64).abs()).max(0.0))
}

/// The first pass: the reach of the spools, and missing signals.
#[derive(Clone, Debug, PartialEq)]
pub struct Scout {
    sources: FlowSources,
    pub cylinders: Vec<Reach>,
}

impl Scout {
    pub fn new(cylinders: u8, sources: FlowSources) -> Self {
        Self { sources, cylinders: vec![Reach::default(); cylinders.into()] }
    }
}

impl Surveyor for Scout {
    fn row(&mut self, row: &Row) {
        let place = usize::from(row.cylinder).wrapping_sub(1);
        let Some(reach) = self.cylinders.get_mut(place).filter(|_| row.monitored) else { return };
        reach.rows += 1;
        match point(row, &self.sources) {
            Ok(Some((x, _))) => {
                let largest = &mut reach.largest[direction(x) as usize];
                *largest = largest.max(x.abs());
            }
            Ok(None) => reach.no_drop += 1,
            Err(missing) => reach.missing[missing] += 1,
        }
    }

    fn gap(&mut self, _: u8) {}
}

impl Reach {
    /// Checks that there is what (3-18) needs.
    ///
    /// # Errors
    /// What is missing in every second cycle or more.
    pub fn judge(&self) -> Result<(), NoFlow> {
        let Self { rows, missing, .. } = *self;
        if rows == 0 {
            return Err(NoFlow::NeverMonitored);
        }
        let lacks = |(count, (what, help)): (u64, (&'static str, &'static str))| {
            (2 * count >= rows).then_some(NoFlow::Missing { what, missing: count, rows, help })
        };
        missing.into_iter().zip(MISSING).find_map(lacks).map_or(Ok(()), Err)
    }
}

/// The second pass: the curves.
#[derive(Clone, Debug)]
pub struct FlowFit {
    sources: FlowSources,
    cylinders: Vec<(Reach, [Fit; 2])>,
    samples: Vec<Thinned<(f64, f64)>>,
}

#[derive(Clone, Debug)]
struct Fit {
    triangle: Triangle<COLUMNS>,
    coverage: [f64; MEMBERSHIPS],
}

impl FlowFit {
    /// A fit over the reach that `scout` found.
    pub fn new(scout: &Scout) -> Self {
        let fit = || Fit { triangle: Triangle::new(), coverage: [0.0; MEMBERSHIPS] };
        let cylinders: Vec<_> =
            scout.cylinders.iter().map(|reach| (*reach, [fit(), fit()])).collect();
        let samples = vec![Thinned::new(SAMPLES); cylinders.len()];
        Self { sources: scout.sources, cylinders, samples }
    }

    /// Samples of the curves' data, spread evenly over the recording: x_m and f_NL over A_p,
    /// m/s/√bar, for each cylinder.
    pub fn samples(&self) -> Vec<Vec<(f64, f64)>> {
        self.samples.iter().map(|samples| samples.samples().to_vec()).collect()
    }

    /// Curves out and in, for each cylinder.
    pub fn curves(&self) -> Vec<[Result<FlowCurve, NoFlow>; 2]> {
        let both = |(reach, fits): &(Reach, [Fit; 2])| {
            [Direction::Extend, Direction::Retract].map(|direction| {
                reach.judge()?;
                fits[direction as usize].curve(direction, reach.largest[direction as usize])
            })
        };
        self.cylinders.iter().map(both).collect()
    }
}

impl Surveyor for FlowFit {
    fn row(&mut self, row: &Row) {
        let place = usize::from(row.cylinder).wrapping_sub(1);
        let Some((reach, fits)) = self.cylinders.get_mut(place).filter(|_| row.monitored) else {
            return;
        };
        if let Ok(Some((x, value))) = point(row, &self.sources) {
            let direction = direction(x) as usize;
            fits[direction].add(x.abs() / reach.largest[direction], value);
            self.samples[place].add((x, value));
        }
    }

    fn gap(&mut self, _: u8) {}
}

impl Fit {
    fn add(&mut self, part: f64, value: f64) {
        let memberships = memberships(part);
        let mut row = [0.0; COLUMNS];
        row[..MEMBERSHIPS].copy_from_slice(&memberships);
        row[MEMBERSHIPS] = value;
        self.triangle.add(&row);
        for (sum, membership) in self.coverage.iter_mut().zip(memberships) {
            *sum += membership;
        }
    }

    fn curve(&self, direction: Direction, largest: f64) -> Result<FlowCurve, NoFlow> {
        let rows = self.triangle.rows();
        if (rows as f64) < FEWEST {
            return Err(NoFlow::TooFewRows { rows, least: FEWEST });
        }
        // What no row speaks of drops out and changes nothing. What few speak of stays in, so that
        // their rows do not pull at its neighbours, but is not told.
        let spoken: Vec<usize> = (0..MEMBERSHIPS).filter(|j| self.coverage[*j] > 0.0).collect();
        let regression = self.triangle.solve(&spoken, MEMBERSHIPS).map_err(|why| match why {
            NoRegression::TooFewRows { rows } => NoFlow::TooFewRows { rows, least: FEWEST },
            NoRegression::Collinear { condition, among } => {
                let names: Vec<String> =
                    among.iter().map(|place| (spoken[*place] + 1).to_string()).collect();
                NoFlow::Collinear { among: names.join(" and "), condition }
            }
        })?;
        let sign = if direction == Direction::Extend { 1.0 } else { -1.0 };
        let singleton = |j: usize| {
            let place = spoken.iter().position(|it| *it == j);
            let place = place.filter(|_| self.coverage[j] >= FEWEST);
            Singleton {
                centre: sign * largest * j as f64 / (MEMBERSHIPS - 1) as f64,
                coverage: self.coverage[j],
                value: place.map(|i| (regression.coefficients[i], regression.standard_errors[i])),
            }
        };
        Ok(FlowCurve {
            singletons: (0..MEMBERSHIPS).map(singleton).collect(),
            rows,
            rms: regression.residual_norm / (rows as f64).sqrt(),
            condition: regression.condition,
        })
    }
}

impl FlowCurve {
    /// Number of singletons that are known.
    pub fn known(&self) -> usize {
        self.singletons.iter().filter(|singleton| singleton.value.is_some()).count()
    }

    /// f_NL over A_p at `x`, m/s/√bar; `None` beyond the data, or where a singleton it needs is not
    /// known.
    pub fn at(&self, x: f64) -> Option<f64> {
        let part = x / self.singletons.last()?.centre;
        if !(0.0..=1.0).contains(&part) {
            return None;
        }
        let parts = memberships(part).into_iter().zip(&self.singletons);
        parts.filter(|(weight, _)| *weight > 0.0).try_fold(0.0, |sum, (weight, singleton)| {
            singleton.value.map(|(value, _)| sum + weight * value)
        })
    }
}
