//! Pages of HTML: one file each, with figures as SVG inside, that needs no network and no script.
//!
//! [`html`] is the skeleton, [`figure`] what a figure shows, [`axis`] and `drawing` how it is drawn.
//! What a figure of a whole recording needs is gathered while it streams by, in bounded memory:
//! [`traces`] (extremes by time), [`histogram`], [`zoom`] (the cycles around warnings),
//! [`differences`] (C1 − C2 by time and by position). Beside them
//! there is a file for each page.

pub mod axis;
pub mod calibration;
pub mod commission;
mod coverage;
pub mod curves;
pub mod differences;
mod drawing;
pub mod evaluation;
pub mod figure;
pub mod histogram;
pub mod html;
pub mod identification;
pub mod palette;
pub mod recorder;
pub mod replay;
mod stops;
pub mod traces;
pub mod tuning;
pub mod zoom;

pub use differences::Differences;
pub use html::Page;
pub use recorder::Recorder;
