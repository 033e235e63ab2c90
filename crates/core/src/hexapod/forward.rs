//! The pose from the cylinders' lengths (section A-2).

use super::{Hexapod, KinematicsError, LEGS, Legs, Pose};
use nalgebra::{SMatrix, SVector};

/// Most Newton–Raphson steps; from anywhere within the workspace about five are needed.
pub const MAX_ITERATIONS: usize = 30;

/// Length of a step below which the iteration has converged, m and rad. A further step would change
/// the result by the square of this.
const LAST_STEP: f64 = 1e-9;

/// Determinant of the Jacobian, rows scaled to length 1, below which it counts as zero: 1e-5 rad
/// from a singular pose.
const SINGULAR: f64 = 1e-6;

/// A pose that has the wanted lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseSolution {
    /// Pose of the deck in the base's frame.
    pub pose: Pose,
    pub iterations: usize,
}

impl Hexapod {
    /// Finds the deck's pose in the base's frame from the strokes, m, beginning at `guess`
    /// to. Up to 40 poses have these lengths; the guess (the neutral pose, or that of the
    /// sample before) determines which one is found.
    ///
    /// # Errors
    /// Strokes beyond the reach, lengths that no pose has, and singular poses on the way.
    pub fn forward(
        &self,
        strokes: &[f64; LEGS],
        guess: &Pose,
    ) -> Result<PoseSolution, KinematicsError> {
        self.check(strokes)?;
        if !guess.is_finite() {
            return Err(KinematicsError::NotFinite);
        }
        let base = Pose::default();
        let wanted = strokes.map(|stroke| stroke + self.neutral_length());
        let mut pose = *guess;
        let mut worst = f64::INFINITY;
        for iterations in 1..=MAX_ITERATIONS {
            let legs = Legs::new(self, &base, &pose);
            let step = self.newton_step(&legs, &pose, &wanted)?;
            pose.translation -= step.fixed_rows::<3>(0);
            pose.attitude -= step.fixed_rows::<3>(3);
            worst = errors(&legs, &wanted);
            if !pose.is_finite() {
                return Err(KinematicsError::NoPose { worst });
            }
            if step.amax() < LAST_STEP {
                return Ok(PoseSolution { pose, iterations });
            }
        }
        Err(KinematicsError::NoPose { worst })
    }

    /// `[∂f/∂x]⁻¹ f` of for f = lᵀl − ℓ², over translation and roll, pitch, yaw. Both
    /// are divided by twice the length, which leaves the Jacobian times the axes of the
    /// angles.
    fn newton_step(
        &self,
        legs: &Legs,
        pose: &Pose,
        wanted: &[f64; LEGS],
    ) -> Result<SVector<f64, LEGS>, KinematicsError> {
        let mut slope: SMatrix<f64, LEGS, LEGS> = legs.jacobian();
        let turning = slope.fixed_view::<LEGS, 3>(0, 3) * pose.axes();
        slope.fixed_view_mut::<LEGS, 3>(0, 3).copy_from(&turning);
        let f = SVector::<f64, LEGS>::from_fn(|leg, _| {
            let (is, wanted) = (legs.lengths[leg], wanted[leg]);
            (is * is - wanted * wanted) / (2.0 * is)
        });
        let mut scaled = slope;
        scaled.fixed_view_mut::<LEGS, 3>(0, 3).scale_mut(1.0 / self.top_radius);
        let determinant = scaled.determinant().abs();
        if determinant < SINGULAR || determinant.is_nan() {
            return Err(KinematicsError::Singular);
        }
        slope.lu().solve(&f).ok_or(KinematicsError::Singular)
    }
}

/// The largest error of a length, m.
fn errors(legs: &Legs, wanted: &[f64; LEGS]) -> f64 {
    legs.lengths.iter().zip(wanted).map(|(is, wanted)| (is - wanted).abs()).fold(0.0, f64::max)
}
