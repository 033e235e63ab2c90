//! From verdicts to warnings, and from warnings to the frames that carry them.
pub mod e2e;
