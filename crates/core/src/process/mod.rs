//! Faults of the cylinder itself: what spool and pressures say, which no transducer has a part in.
//!
//! ```text
//! u ─→ spool as it should stand ─┐ x − x̂ ──→ evidence ─ h ─→ sticking, offset, late, another command
//! spool x ───────────────────────┘
//! P_S, P_L, x ─→ sum of the chambers ─┐ ───→ evidence ─ h ─→ pressure sensor; of many cylinders: the supply's
//! P_bot + P_rod ──────────────────────┘
//! x, P_S, P_L ─→ way of the rod by the oil ─┐ ─→ evidence ─ h ─→ leakage, null, dead band
//! C1, corrected C2 ─────────────────────────┘
//! way, speed, acceleration of the rod ─┐ ────→ evidence ─ h ─→ friction
//! P_L ─────────────────────────────────┘
//! ways of all rods ─→ what they take ─┐ ─────→ evidence ─ h ─→ the supply falls short
//! P_S ────────────────────────────────┘
//! ```
//!
//! All relations are learnt from a healthy recording. The first two do not know C1 and C2, and the third one asks both, so
//! that a transducer's fault leaves them alone but by what the controller then commands; the friction looks at C1 and C2
//! as long as they agree. The supply is one for all cylinders, and so is the relation of its pressure. Nothing is judged
//! on commands and positions that were not taught.
//! Memory is bounded, and a step allocates nothing.

pub mod alarm;
pub mod chambers;
pub mod coverage;
pub mod curve;
pub mod detector;
pub mod evidence;
pub mod flow;
pub mod friction;
mod input;
mod losses;
pub mod parameters;
pub mod relation;
pub mod spool;
pub mod supply;
mod trace;

pub use alarm::{Malfunction, ProcessAlarm};
pub use chambers::ChambersDesign;
pub use coverage::ProcessCoverage;
pub use curve::Curve;
pub use detector::{Process, ProcessDesign};
pub use evidence::{EvidenceWindows, Weighing};
pub use flow::{FlowDesign, FlowSample};
pub use friction::{ForceSample, Forces, FrictionDesign};
pub use input::{OilReading, ProcessInput};
pub use parameters::ProcessParameters;
pub use relation::{RELATIONS, Relation};
pub use spool::{Spool, SpoolDesign};
pub use supply::{OilSample, SupplyDesign, SupplyRelation, SupplyWatch};
