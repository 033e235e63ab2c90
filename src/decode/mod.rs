//! From frames to physical values.
