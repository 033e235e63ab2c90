//! The gateway as a CANopen node.
