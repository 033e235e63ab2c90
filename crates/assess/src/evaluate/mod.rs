//! How good the monitor is: Monte Carlo over seeds, seas, grades of transducers, kinds and sizes of
//! faults, on the simulated machine.
//!
//! ```text
//! Plan ─ jobs ─→ Stand: machine, faults, monitor ─ outcomes ─→ Gathering ─ figures ─→ Evaluation
//! ```
//!
//! A [`Plan`] says which rows of faults are tried and how long nothing is wrong. Each of its jobs is
//! one simulated machine, and all that is random in it comes from the plan's seed and the job's own
//! number. So jobs can run in any order and on any number of cores: the [`Gathering`] puts what they
//! bring in its place, and the same seed gives the same [`Evaluation`].
//!
//! The sequential detectors are compared with the thesis's thresholds in a [`contest`]; what they know
//! of the machine they learn from it first ([`Stand::learn`]).
//!
//! Sets of the observers' weights, each with its threshold, are compared by [`weights`].
//!
//! A fault begins on a machine that is engaged, with observers that have settled; its delay counts
//! from the Sync at which the first faulty reading was sampled. Where it is *in the loop* the
//! machine's controller reads it, too: the second recommendation of the thesis's chapter 6.

mod claim;
pub mod contest;
mod estimate;
mod figures;
mod gathering;
mod grade;
mod healthy;
mod interval;
mod learning;
mod outcome;
mod plan;
mod proportion;
mod rate;
mod row;
mod stand;
mod trial;
pub mod weights;

pub use claim::{Claim, Judged};
pub use estimate::{CASES, Case, Errors, EstimateResult};
pub use figures::{Delay, DetectorFigures, Figures, Moved, SuspectFigures, WITHIN};
pub use gathering::{Evaluation, Gathering, HealthyCell, RowResult};
pub use grade::Grade;
pub use healthy::Healthy;
pub use interval::{CONFIDENCE, clopper_pearson, poisson_upper};
pub use learning::{Learnt, Lessons};
pub use outcome::{Blame, DETECTORS, First, Outcome};
pub use plan::{Cell, Extent, Job, Plan, PlanError, Product};
pub use proportion::Proportion;
pub use rate::Rate;
pub use row::{Row, SIGMA, Study, rows};
pub use stand::{Stand, StandError};
pub use trial::Try;
