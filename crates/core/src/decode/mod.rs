//! From frames to physical values and back: bit plans, which read and write a signal without allocating.
//!
//! [`SignalPlan::decode`] is the hot path.

mod field;
mod plan;
mod value;

pub use field::{BitField, NoField};
pub use plan::{MultiplexGate, NumberForm, Plain, SignalPlan};
pub use value::{Decoded, Inserted, Raw, Value};
