//! Recipients of the virtual sensors' estimates.

/// Use of the cylinders' estimated lengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimates {
    /// No estimates are made.
    None,
    /// Estimates go to the sink.
    Computed,
    /// Estimates go to the sink and are sent as Fd_Estimate.
    Sent,
}
