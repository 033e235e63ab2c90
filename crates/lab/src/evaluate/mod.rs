//! How good the monitor is: Monte Carlo over seeds, seas, grades of transducers, kinds and sizes of
//! faults, on the simulated machine.
//!
//! ```text
//! Extent ─→ Plan ─ teach ─→ Campaign: one TaughtStudy a study
//!                                      │ jobs, by Workers
//!                                      ↓
//!               Stand: machine, faults, monitor ─ products ─→ gathered ─ figures ─→ Evaluation
//! ```
//!
//! What is tried is a [`Study`] each: its machines and faults, what its monitors learn beforehand, one trial, and how the
//! results become figures. The file `studies.rs` lists them. A [`Plan`] has those that are asked for, and a [`Campaign`]
//! carries it out. Each job is one simulated machine, and everything random in it comes from the plan's seed and the
//! job's number. Jobs can therefore run in any order and on any number of cores: a [`TaughtStudy`] puts the results in
//! their places, and the same seed gives the same [`Evaluation`].
//!
//! [`rows`] are faults of every kind and size, [`HealthyStudy`] has hours without a fault, and [`EstimateStudy`] tries the
//! virtual sensor.
//! The sequential detectors are compared with the thesis's thresholds in a [`contest`]; they learn
//! the machine first ([`Stand::learn`]).
//!
//! [`weights`] compares sets of the observers' weights, each with its threshold. [`process`] tries faults of the
//! cylinders themselves, [`handover`] what a machine gains whose controller uses the warnings, [`side`] whose drift it is
//! inside the loop, and [`hexapod`] the same by the attitude of the deck. [`last`] tries the faults of a transducer that
//! has no other one beside it any more, [`accommodate`] the estimate by one whose step is subtracted.
//!
//! A fault begins on an engaged machine whose observers have settled. Its delay counts from the
//! Sync at which the first faulty reading was sampled. *In the loop* means that the machine's
//! controller also reads the fault: the second recommendation of the thesis's chapter 6.

pub mod accommodate;
pub mod contest;
mod estimate;
mod extent;
mod fault;
mod figures;
mod grade;
pub mod handover;
mod healthy;
pub mod hexapod;
mod interval;
pub mod last;
mod learning;
mod machines;
mod outcome;
pub mod process;
mod proportion;
mod random;
mod rate;
pub mod rows;
pub mod side;
mod stand;
mod studies;
mod study;
mod tried;
mod truth;
pub mod weights;
mod workers;

pub use estimate::{CASES, Case, Errors, EstimateResult, EstimateStudy};
pub use extent::{Extent, Lessons, PlanError, StudyName};
pub use fault::SIGMA;
pub use figures::{Delay, DetectorFigures, SuspectFigures, WITHIN};
pub use grade::{Cell, Grade};
pub use healthy::{Healthy, HealthyCell, HealthyStudy};
pub use interval::{CONFIDENCE, clopper_pearson, poisson_upper};
pub use learning::Learnt;
pub use machines::ProcessMachine;
pub use outcome::{Blame, DETECTORS, First, IncidentOutcome, Outcome};
pub use proportion::Proportion;
pub use rate::Rate;
pub use stand::{Stand, StandError};
pub use studies::{Campaign, Evaluation, Plan, study_names};
pub use study::{Study, TaughtStudy};
pub use tried::Try;
pub use workers::{Serial, Workers};
