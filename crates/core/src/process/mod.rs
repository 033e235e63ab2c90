//! Faults of the cylinder itself: what spool and pressures say, which no transducer has a part in.
//!
//! ```text
//! u ─→ spool as it should stand ─┐ x − x̂ ──→ evidence ─ h ─→ sticking, offset, late, another command
//! spool x ───────────────────────┘
//! P_S, P_L, x ─→ sum of the chambers ─┐ ───→ evidence ─ h ─→ pressure sensor; of many cylinders: the supply's
//! P_bot + P_rod ──────────────────────┘
//! ```
//!
//! Both relations are learnt from a healthy recording. Neither knows C1 or C2, so that a transducer's fault leaves
//! them alone but by what the controller then commands, and nothing is judged on commands that were not taught.
//! Memory is bounded, and a step allocates nothing.

pub mod chambers;
pub mod coverage;
pub mod curve;
pub mod detector;
pub mod evidence;
pub mod parameters;
pub mod spool;
mod trace;

pub use chambers::ChambersDesign;
pub use coverage::ProcessCoverage;
pub use curve::Curve;
pub use detector::{Malfunction, Process, ProcessAlarm, ProcessDesign, ProcessInput};
pub use evidence::{EvidenceWindows, Weighing};
pub use parameters::ProcessParameters;
pub use spool::{Spool, SpoolDesign};
