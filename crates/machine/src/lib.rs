//! A machine in software, part by part, and faults put into frames.
//!
//! - [`hexapod`], [`sea`], [`plant`], [`controller`], [`transducer`]: the parts.
//! - [`simulator`]: all of it as one, which sends frames. The monitor uses none of them.
//! - [`inject`]: faults put into frames, to see that they are found.

pub mod controller;
pub mod hexapod;
pub mod inject;
pub mod plant;
pub mod sea;
pub mod simulator;
pub mod transducer;
