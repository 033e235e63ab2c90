//! Excursions of healthy transducers: found in a recording, and the law that they follow.
//!
//! A transducer that is now and then some counts off for a fraction of a second is healthy. What the
//! detectors have to tolerate follows from how often that happens, by how much and for how long.
//!
//! - [`Segmentation`] divides the stream of one cylinder's difference into excursions, wild samples and core.
//! - [`CylinderPopulation`] collects what it finds of one cylinder.
//! - [`Population`] pools the cylinders of a machine and makes each one's `Law`; [`Summary`] is for a report.
//!
//! All of it is counts, order statistics and sums of counts: files in another order give the same law.

mod atoms;
mod candidate;
mod chains;
mod cylinder;
mod excursion;
mod law;
mod limits;
mod noise;
mod plateaus;
mod population;
mod quantiles;
mod renewal;
mod runs;
mod segment;
mod segmentation;
#[cfg(test)]
mod simulated;
mod speeds;
mod summary;
mod sums;
mod survival;
#[cfg(test)]
mod tests;

pub use cylinder::CylinderPopulation;
pub use excursion::Excursion;
pub use limits::{HealthyCylinder, LimitLevels, LimitTable, SmallestStep};
pub use noise::CoreNoise;
pub use population::{MachineLaw, Population};
pub use segment::Segment;
pub use segmentation::Segmentation;
pub use summary::Summary;
