//! Prediction of a length from the command: with the drive that a calibration has fitted, or else
//! by the model (4-1).

use super::parameters::EstimateParameters;
use crate::observe::model::Model;
pub use crate::sequential::Drive;
use crate::sequential::drive::Commands;
use crate::sequential::pair;
use crate::sequential::parameters::{DriveParameters, PairParameters};
use crate::state::state;
use alloc::boxed::Box;
use nalgebra::{Matrix3, Vector3};

/// Dynamics x(k+1) = A x(k) + the command's part, with process noise.
#[derive(Clone, Debug)]
pub struct Dynamics {
    /// State matrix A, 3 × 3.
    pub a: Matrix3<f64>,
    /// Process noise: the variance that a cycle adds to each state.
    pub process: Vector3<f64>,
    /// Variance of each state before anything is known; for the length, the distance that the
    /// fastest rod moves in a cycle.
    pub unknown: Vector3<f64>,
    /// Variance of a reading, m².
    pub reading: f64,
    drive: Driving,
}

#[derive(Clone, Debug)]
enum Driving {
    /// Fitted drive, with the length l, the error of the drive's velocity and its slope as the
    /// state; and the sample time, s.
    Fitted(Box<Drive>, f64),
    /// Model (4-1), with the state (l, l̇, P_L): B, and the command at which the cylinder rests,
    /// m/s.
    Model(Vector3<f64>, f64),
}

impl Dynamics {
    /// Dynamics by `drive`, for readings whose difference has the standard deviation `deviation`,
    /// m, every `sample_time` seconds.
    pub fn fitted(
        drive: Drive,
        sample_time: f64,
        deviation: f64,
        parameters: &EstimateParameters,
    ) -> Self {
        let [velocity, slope] = parameters.drive_unknown.map(|deviation| deviation * deviation);
        Self {
            a: pair::dynamics(sample_time, &PairParameters::DEFAULT),
            process: Vector3::from(PairParameters::DEFAULT.process_of(sample_time)),
            unknown: Vector3::new(way(sample_time, parameters), velocity, slope),
            reading: 0.5 * deviation * deviation,
            drive: Driving::Fitted(Box::new(drive), sample_time),
        }
    }

    /// Dynamics by `model`, for a cylinder that rests at the command `offset`, m/s, with the
    /// weights of its observers: the diagonal of Q, and the variance of a position.
    pub fn model(
        model: &Model,
        offset: f64,
        q: [f64; 3],
        r: f64,
        sample_time: f64,
        parameters: &EstimateParameters,
    ) -> Self {
        Self {
            a: model.a,
            process: Vector3::from(q),
            unknown: Vector3::new(
                way(sample_time, parameters),
                parameters.fastest * parameters.fastest,
                parameters.pressure_unknown * parameters.pressure_unknown,
            ),
            reading: r,
            drive: Driving::Model(model.b, offset),
        }
    }
}

/// Variance of a length that is not followed for a cycle, m².
fn way(sample_time: f64, parameters: &EstimateParameters) -> f64 {
    let way = parameters.fastest * sample_time;
    way * way
}

/// The commands, as inputs of the dynamics.
#[derive(Clone, Debug)]
pub struct Feed {
    commands: Commands,
    newest: Option<f64>,
}

state! { Feed { commands, newest } }

impl Feed {
    /// For commands every `sample_time` seconds.
    pub fn new(sample_time: f64) -> Self {
        Self { commands: Commands::new(&DriveParameters::DEFAULT, sample_time), newest: None }
    }

    pub fn clear(&mut self) {
        self.commands.clear();
        self.newest = None;
    }

    /// Takes u(k), m/s, as sent; the last one is held where it is absent. Returns the command's
    /// part of x(k+1); `None` before the first command.
    pub fn step(&mut self, dynamics: &Dynamics, command: Option<f64>) -> Option<Vector3<f64>> {
        self.newest = command.or(self.newest);
        let u = self.newest?;
        match &dynamics.drive {
            Driving::Model(b, offset) => Some(b * (u - offset)),
            Driving::Fitted(drive, sample_time) => {
                self.commands.push(u);
                let velocity = drive.velocity(&self.commands)?;
                Some(Vector3::new(sample_time * velocity, 0.0, 0.0))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequential::drive::FEATURES;

    #[test]
    fn a_model_goes_by_the_command_less_its_offset_and_holds_the_last() {
        let model = Model::new(0.02, [0.0, -0.1, 0.0, 0.0, 0.0], [0.1, 2.0]);
        let dynamics =
            Dynamics::model(&model, 0.5, [0.0; 3], 1e-8, 0.02, &EstimateParameters::DEFAULT);
        let mut feed = Feed::new(0.02);
        assert_eq!(feed.step(&dynamics, None), None);
        assert_eq!(feed.step(&dynamics, Some(1.5)), Some(Vector3::new(0.0, 0.1, 2.0)));
        assert_eq!(feed.step(&dynamics, None), Some(Vector3::new(0.0, 0.1, 2.0)));
        feed.clear();
        assert_eq!(feed.step(&dynamics, None), None);
    }

    #[test]
    fn a_drive_moves_the_length_once_it_knows_enough_commands() {
        let mut coefficients = [0.0; FEATURES];
        coefficients[0] = 1.0;
        let dynamics =
            Dynamics::fitted(Drive(coefficients), 0.02, 1e-4, &EstimateParameters::DEFAULT);
        let mut feed = Feed::new(0.02);
        let parts: Vec<_> = (0..17).map(|_| feed.step(&dynamics, Some(0.5))).collect();
        assert_eq!(parts[15], None);
        assert_eq!(parts[16], Some(Vector3::new(0.01, 0.0, 0.0)));
    }
}
