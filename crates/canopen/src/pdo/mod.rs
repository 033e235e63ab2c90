//! Process data objects: which objects of a device are where in its PDOs, and what their numbers stand for,
//! from its EDS or DCF.

mod mapping;
mod scale;

pub use mapping::{Direction, MappedObject, Pdo, PdoFlaw, Pdos};
pub use scale::{BITS, COUNT, FULL_SCALE, Scale, ScaleError, scale};
