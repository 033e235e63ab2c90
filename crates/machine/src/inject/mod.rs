//! Faults on recorded or running machines: the thesis's first recommendation (chapter 6).
//!
//! ```text
//! text ─ Fault ─→ place ─ Placed ─→ Injector: frames in, frames out
//! ```
//!
//! [`Fault::parse`] and [`table::parse`] read requested faults, [`place()`] finds their signals by
//! configuration and DBC, and [`Injector`] changes frames one by one: only the bits of signals with
//! a fault, and no time stamp. It is pure: time comes with the frames and randomness from a seed,
//! so that the same seed gives the same bytes.
//!
//! The same words name faults of the machine itself ([`Wanted::Machine`]), which only a simulated machine can
//! have.
//!
//! A fault is added after the event: the machine's controller did not see it, so the motion in the
//! recording does not answer to it. On a simulated machine, where the exact lengths are known, a
//! fault of a transducer is added to the length before it is rounded to counts.

mod fault;
mod injector;
mod kind;
mod place;
mod placed;
mod service;
mod shape;
pub mod table;
mod tally;

pub use fault::{Fault, MACHINE, SENSORS, SERVICES, SpecError, Wanted};
pub use injector::Injector;
pub use kind::{grammar, machine_grammar};
pub use place::place;
pub use placed::{PlaceError, Placed};
pub use shape::{Code, Shape, Unrounded, Window};
pub use tally::Tally;

/// The most faults at once.
pub const MAX_FAULTS: usize = 10_000;
