//! Who hears of the virtual sensors.

/// What is done with the cylinders' estimated lengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimates {
    /// None are made.
    None,
    /// They are told to the sink.
    Told,
    /// They are sent as Fd_Estimate, too.
    Sent,
}
