//! HTML pages: one file each, with figures as SVG inside, without network or script.
//!
//! [`html`] is the skeleton, [`figure`] the data of a figure, [`axis`] and `drawing` its drawing.
//! The data of a whole recording are gathered while it streams, in bounded memory: [`traces`]
//! (extremes by time), [`histogram`], [`zoom`] (the cycles around warnings), [`differences`] (C1 −
//! C2 by time and by position). Each page also has a file of its own.

pub mod axis;
pub mod calibration;
pub mod commission;
mod coverage;
pub mod curves;
pub mod differences;
mod drawing;
mod escaping;
pub mod evaluation;
pub mod figure;
pub mod histogram;
pub mod html;
pub mod identification;
mod incidents;
pub mod palette;
pub mod recorder;
pub mod replay;
mod stops;
pub mod traces;
pub mod tuning;
pub mod zoom;

pub use differences::Differences;
pub use html::Page;
pub use recorder::PageRecorder;
