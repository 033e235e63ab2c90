//! The model (4-1) of each cylinder from a healthy recording: chapter 4 of the thesis.
//!
//! ```text
//! rows ─→ census ─ refusals, sources ─→ shaper ─ samples ─→ estimator ─ θ, γ ─→ validator ─→ Outcome
//! ```
//!
//! - [`census`]: the data of each cylinder, and whether they can be what they are configured as.
//! - [`shaper`]: position, smoothed velocity and load pressure, command, one sample for each cycle.
//! - [`qr`]: least squares over a stream, by orthogonal triangles; [`estimate`]: (4-7) and (4-8).
//! - [`validate`]: simulation and one-step prediction on data held back; [`correlate`]:
//!   whether the residuals are white.
//! - [`flow`], [`friction`]: the non-linear parts of section 3-3-1, on request; [`valve`]: the flow in the form of a plant;
//!   [`nonlinear`] holds them.
//! - [`outcome`]: the results as plain data, for reports. [`mod@course`]: all stages in turn.
//!
//! Every stage reads the recording once, as a [`Surveyor`](crate::survey::Surveyor), and keeps
//! nothing that grows with it; of the rows that a valve is identified from, three hours at the most.

pub mod assess;
pub mod census;
pub mod correlate;
pub mod course;
pub mod estimate;
pub mod flow;
pub mod friction;
pub mod moments;
pub mod nonlinear;
pub mod outcome;
pub mod qr;
pub mod refusal;
pub mod shaper;
pub mod stages;
pub mod validate;
pub mod valve;

pub use census::{Census, Expectations};
pub use estimate::{Estimate, Estimator, OffsetRule};
pub use outcome::Outcome;
pub use refusal::IdentificationRefusal;
pub use shaper::{Sample, Shaper, Shaping, Sources};
pub use stages::Each;
pub use validate::{Candidate, Validator};
