//! The hydraulic servo system: six cylinders on one supply, non-linear as (3-15).
//!
//! ```text
//! spool command ─ lag ─→ spool ─ flow ─→ load pressure ─→ piston ─→ length, speed
//!                                 ↑ supply pressure        ↑ friction, load
//! ```
//!
//! The plant is integrated in fixed sub-steps by the midpoint rule. When the piston comes to rest
//! within a sub-step, the stop is placed at its end.

mod ailment;
mod cylinder;
mod friction;
mod identified;
mod parameters;
mod supply;
mod system;
mod valve;

pub use ailment::{Ailment, MOST_LATE, Wear};
pub use cylinder::{Cylinder, CylinderState, Drive};
pub use friction::Friction;
pub use identified::{Identified, IdentifiedFlow, identified, is_identified};
pub use parameters::{Chambers, CylinderTable, Parameters, Spread, SupplyTable, ValveTable};
pub use supply::Supply;
pub use system::{Inputs, Plant};
pub use valve::Valve;

/// Cylinders on one supply.
pub const CYLINDERS: usize = 6;

/// Pascals in a bar.
pub const PASCAL: f64 = 1e5;
