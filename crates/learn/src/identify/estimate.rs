//! θ and γ of one cylinder by (4-7) and (4-8).

use super::moments::Spread;
use super::qr::{LARGEST_CONDITION, NoRegression, Regression, Triangle};
use super::refusal::IdentificationRefusal;
use super::shaper::{Sample, Shaper};
use nalgebra::{Matrix2, Vector2};
use tertius_core::observe::model::Model;

/// Fewest pairs of cycles for a fit: ten seconds at 50 Hz.
pub const FEWEST_ROWS: u64 = 500;

/// Number of columns: l, l̇, P_L, u, 1 | Δl̇, ΔP_L.
const COLUMNS: usize = 7;
const NAMES: [&str; 5] =
    ["the position", "the velocity", "the load pressure", "the command", "the constant"];
const CONSTANT: usize = 4;
const VELOCITY_STEP: usize = 5;
const PRESSURE_STEP: usize = 6;

/// Most by which the residual may grow where the constant is left out because the rest was never commanded, as a factor: beyond
/// it the constant carries the motion, and the model without it is of another machine.
const HARDLY: f64 = 1.05;

/// Least offset that is worth a parameter, as a part of the command's standard deviation.
const WORTHWHILE: f64 = 0.1;

/// Two-sided 99 % of the normal distribution.
const SIGNIFICANT: f64 = 2.576;

/// Whether a constant, the command at which the cylinder rests, is estimated beside (4-7) and
/// (4-8).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OffsetRule {
    /// No constant, as in the thesis.
    Never,
    Always,
    /// A constant if it is significant and exceeds a tenth of the command's standard deviation; none where the cylinder would
    /// rest at a command that was never given and the model without it predicts as well.
    WhereItMatters,
}

/// Estimates of one cylinder.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    pub theta: [f64; 5],
    pub gamma: [f64; 2],
    /// Standard errors of θ1..θ5; zero for parameters that the reduced model does not have. They
    /// hold for white residuals, which filtered signals do not have, and are thus a lower bound.
    pub theta_errors: [f64; 5],
    /// Standard errors of γ1 and γ2, a lower bound like those of θ.
    pub gamma_errors: [f64; 2],
    /// Command at which the cylinder rests, m/s, where it was estimated.
    pub command_offset: Option<f64>,
    /// Command at which it would rest, m/s, left out because it was never given.
    pub never_commanded: Option<f64>,
    /// Load pressure at rest, bar; needed only for simulations.
    pub pressure_offset: f64,
    /// Regression (4-7).
    pub velocity_row: Regression,
    /// Regression (4-8); absent in the reduced model.
    pub pressure_row: Option<Regression>,
    /// Root mean squares of l, l̇, P_L and u.
    pub sizes: [f64; 4],
}

impl Estimate {
    pub fn model(&self, sample_time: f64) -> Model {
        Model::new(sample_time, self.theta, self.gamma)
    }

    pub fn is_reduced(&self) -> bool {
        self.pressure_row.is_none()
    }
}

/// Collects one cylinder's rows of (4-7) and (4-8).
#[derive(Clone, Debug)]
pub struct Estimator {
    shaper: Shaper,
    pressure: bool,
    last: Option<Sample>,
    triangle: Triangle<COLUMNS>,
    /// Commands of all rows taken, for comparison.
    command: Spread,
}

impl Estimator {
    /// An estimator from the samples of `shaper`; `pressure`: they have a load pressure.
    pub fn new(shaper: Shaper, pressure: bool) -> Self {
        let (last, triangle) = (None, Triangle::new());
        Self { shaper, pressure, last, triangle, command: Default::default() }
    }

    pub fn row(&mut self, row: &crate::survey::Row) {
        let sample = self.shaper.take(row);
        if let (Some(now), Some(next)) = (self.last, sample) {
            self.step(&now, &next);
        }
        self.last = sample;
    }

    pub fn gap(&mut self) {
        self.shaper.gap();
        self.last = None;
    }

    fn step(&mut self, now: &Sample, next: &Sample) {
        let (p, next_p) = (now.p.unwrap_or(0.0), next.p.unwrap_or(0.0));
        self.command.add(now.u);
        self.triangle.add(&[now.l, now.v, p, now.u, 1.0, next.v - now.v, next_p - p]);
    }

    /// The parameters.
    ///
    /// # Errors
    /// Too few rows, signals that cannot be told apart, or a command at rest outside the
    /// recorded commands.
    pub fn estimate(&self, rule: OffsetRule) -> Result<Estimate, IdentificationRefusal> {
        let plain = || self.fit(false);
        let estimate = match rule {
            OffsetRule::Never => plain()?,
            OffsetRule::Always => self.fit(true)?,
            OffsetRule::WhereItMatters => match self.fit(true) {
                Ok(estimate) if self.is_worthwhile(&estimate) => estimate,
                // A constant that cannot be told from the signals is none to estimate.
                _ => plain()?,
            },
        };
        let Spread { low, high, .. } = self.command;
        let offset = estimate.command_offset.filter(|offset| offset.is_finite());
        let estimate = match offset.filter(|offset| !(low..=high).contains(offset)) {
            None => estimate,
            Some(offset) => {
                let without = plain().ok().filter(|it| {
                    rule == OffsetRule::WhereItMatters && predicts_as_well(it, &estimate)
                });
                let refusal = IdentificationRefusal::RestNeverCommanded { offset, low, high };
                Estimate { never_commanded: Some(offset), ..without.ok_or(refusal)? }
            }
        };
        let numbers = estimate.theta.iter().chain(&estimate.gamma).chain(&estimate.command_offset);
        if numbers.copied().all(f64::is_finite) {
            Ok(estimate)
        } else {
            Err(IdentificationRefusal::NotFinite)
        }
    }

    fn is_worthwhile(&self, estimate: &Estimate) -> bool {
        let row = &estimate.velocity_row;
        let last = row.coefficients.len() - 1;
        let significant = row.coefficients[last].abs() > SIGNIFICANT * row.standard_errors[last];
        let deviation = self.command.variance().sqrt();
        let offset = estimate.command_offset.unwrap_or(0.0);
        significant && offset.abs() > WORTHWHILE * deviation
    }

    fn fit(&self, constant: bool) -> Result<Estimate, IdentificationRefusal> {
        let columns = |first: usize| -> Vec<usize> {
            (first..=CONSTANT)
                .filter(|column| match *column {
                    2 => self.pressure,
                    CONSTANT => constant,
                    _ => true,
                })
                .collect()
        };
        let velocity_row = self.solve(&columns(0), VELOCITY_STEP, "velocity's equation (4-7)")?;
        let pressure_row = if self.pressure {
            Some(self.solve(&columns(1), PRESSURE_STEP, "load pressure's equation (4-8)")?)
        } else {
            None
        };
        let sizes = std::array::from_fn(|column| self.triangle.rms(column));
        Ok(assemble(velocity_row, pressure_row, constant, sizes))
    }

    fn solve(
        &self,
        columns: &[usize],
        target: usize,
        equation: &'static str,
    ) -> Result<Regression, IdentificationRefusal> {
        if self.triangle.rows() < FEWEST_ROWS {
            return Err(IdentificationRefusal::TooFewRows {
                rows: self.triangle.rows(),
                least: FEWEST_ROWS,
            });
        }
        self.triangle.solve(columns, target).map_err(|reason| match reason {
            NoRegression::TooFewRows { rows } => {
                IdentificationRefusal::TooFewRows { rows, least: FEWEST_ROWS }
            }
            NoRegression::Collinear { condition, among } => {
                let names: Vec<&str> = among.iter().map(|place| NAMES[columns[*place]]).collect();
                let (among, most) = (names.join(" and "), LARGEST_CONDITION);
                IdentificationRefusal::Collinear { equation, among, condition, most }
            }
        })
    }
}

/// Whether the model without a constant, `plain`, predicts as well as the one `with` it.
fn predicts_as_well(plain: &Estimate, with: &Estimate) -> bool {
    let pressures = plain.pressure_row.iter().zip(&with.pressure_row);
    let mut rows = [(&plain.velocity_row, &with.velocity_row)].into_iter().chain(pressures);
    rows.all(|(plain, with)| plain.residual_norm <= HARDLY * with.residual_norm)
}

/// Puts the coefficients of both rows into their places in (4-1).
fn assemble(
    velocity: Regression,
    pressure: Option<Regression>,
    constant: bool,
    sizes: [f64; 4],
) -> Estimate {
    let rest = |values: &[f64]| if constant { values[values.len() - 1] } else { 0.0 };
    // Without a load pressure the third state is kept at zero by θ5 = −1 and reaches nothing.
    let place = |v: &[f64], p: Option<&[f64]>, nothing: f64| match p {
        Some(p) => ([v[0], v[1], v[2], p[0], p[1]], [v[3], p[2]]),
        None => ([v[0], v[1], 0.0, 0.0, nothing], [v[2], 0.0]),
    };
    let of_pressure = pressure.as_ref();
    let (theta, gamma) =
        place(&velocity.coefficients, of_pressure.map(|row| &row.coefficients[..]), -1.0);
    let (theta_errors, gamma_errors) =
        place(&velocity.standard_errors, of_pressure.map(|row| &row.standard_errors[..]), 0.0);
    let constants =
        [rest(&velocity.coefficients), of_pressure.map_or(0.0, |row| rest(&row.coefficients))];
    let (offset, pressure_offset) =
        if constant { offsets(theta, gamma, constants) } else { (0.0, 0.0) };
    Estimate {
        theta,
        gamma,
        theta_errors,
        gamma_errors,
        command_offset: constant.then_some(offset),
        never_commanded: None,
        pressure_offset,
        velocity_row: velocity,
        pressure_row: pressure,
        sizes,
    }
}

/// The command u₀ and the load pressure p₀ from which (4-1) counts if it is to need no constants:
/// θ3 p₀ + γ1 u₀ = −c₁ and θ5 p₀ + γ2 u₀ = −c₂.
fn offsets(theta: [f64; 5], gamma: [f64; 2], constants: [f64; 2]) -> (f64, f64) {
    let matrix = Matrix2::new(gamma[0], theta[2], gamma[1], theta[4]);
    let rest = matrix.lu().solve(&-Vector2::from(constants));
    rest.map_or((-constants[0] / gamma[0], 0.0), |rest| (rest[0], rest[1]))
}
