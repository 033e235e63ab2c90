//! What is to be commissioned.

use tertius_dbc::Database;
use tertius_learn::calibrate::Cuts;
use tertius_learn::survey::Origin;

/// A machine to be commissioned.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// Name of the configuration in messages.
    pub name: &'a str,
    /// Text of the configuration before commissioning.
    pub text: &'a str,
    pub database: &'a Database,
    pub origin: &'a Origin,
    /// Times at which each cylinder is known not to be healthy, s; nothing is learnt from them.
    pub cuts: &'a Cuts,
    /// Wanted false alarms a year: of R1 and R2, of R3, and of the sequential detectors.
    pub per_year: f64,
    /// Version of the program, which is written into the tables.
    pub version: &'a str,
}
