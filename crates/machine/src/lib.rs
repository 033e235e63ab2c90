//! A machine in software, part by part, and faults put into frames.
//!
//! - [`hexapod`], [`sea`], [`plant`], [`controller`], [`transducer`]: the parts.
//! - [`simulator`]: the whole machine, which sends frames. The monitor uses none of these.
//! - [`inject`]: puts faults into frames, to test whether they are found.

pub mod controller;
pub mod hexapod;
pub mod inject;
pub mod plant;
pub mod sea;
pub mod simulator;
pub mod transducer;
