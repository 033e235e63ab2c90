//! How good the monitor is: Monte Carlo over seeds, seas, grades of transducers, kinds and sizes of
//! faults, on the simulated machine.
//!
//! ```text
//! Plan ─ jobs ─→ Stand: machine, faults, monitor ─ outcomes ─→ Gathering ─ figures ─→ Evaluation
//! ```
//!
//! A [`Plan`] lists the rows of faults and the fault-free hours. Each of its jobs is one simulated
//! machine, and everything random in it comes from the plan's seed and the job's number. Jobs can
//! therefore run in any order and on any number of cores: the [`Gathering`] puts the results in
//! their places, and the same seed gives the same [`Evaluation`].
//!
//! The sequential detectors are compared with the thesis's thresholds in a [`contest`]; they learn
//! the machine first ([`Stand::learn`]).
//!
//! [`weights`] compares sets of the observers' weights, each with its threshold. [`process`] tries faults of the
//! cylinders themselves, [`handover`] what it is worth that a machine hears who is blamed, [`side`] whose drift it is
//! inside the loop, and [`hexapod`] the same by the attitude of the deck. [`last`] tries the faults of a transducer that
//! has no other one beside it any more, [`accommodate`] the estimate by one whose step is subtracted.
//!
//! A fault begins on an engaged machine whose observers have settled. Its delay counts from the
//! Sync at which the first faulty reading was sampled. *In the loop* means that the machine's
//! controller also reads the fault: the second recommendation of the thesis's chapter 6.

pub mod accommodate;
mod claim;
pub mod contest;
mod estimate;
mod figures;
mod gathering;
mod grade;
pub mod handover;
mod healthy;
pub mod hexapod;
mod interval;
pub mod last;
mod learning;
mod outcome;
mod plan;
pub mod process;
mod proportion;
mod rate;
mod row;
pub mod side;
mod stand;
mod trial;
mod truth;
pub mod weights;

pub use claim::{Claim, Judged};
pub use estimate::{CASES, Case, Errors, EstimateResult};
pub use figures::{
    Delay, DetectorFigures, Figures, IncidentFigures, Moved, SuspectFigures, WITHIN,
};
pub use gathering::{Evaluation, Gathering, HealthyCell, RowResult};
pub use grade::Grade;
pub use healthy::Healthy;
pub use interval::{CONFIDENCE, clopper_pearson, poisson_upper};
pub use learning::{Learnt, Lessons};
pub use outcome::{Blame, DETECTORS, First, IncidentOutcome, Outcome};
pub use plan::{Cell, Extent, Job, Plan, PlanError, Product};
pub use proportion::Proportion;
pub use rate::Rate;
pub use row::{Row, SIGMA, Study, rows};
pub use stand::{Stand, StandError};
pub use trial::Try;
