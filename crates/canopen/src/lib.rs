//! CANopen (CiA 301) for the gateway: what devices say of themselves in EDS and DCF files, and the
//! gateway's own node.

pub mod eds;
pub mod node;
pub mod pdo;
