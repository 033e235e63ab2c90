//! What becomes of a frame that comes to a place.

/// What becomes of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// The frame is that of the newest cycle.
    Taken,
    /// The frame is that of the newest cycle, and the one that waits was late.
    Replaces,
    /// The frame is late, and the one that waits is that of the newest cycle.
    Settles,
    /// The frame is that of the newest cycle unless a better one comes before the deadline: it is
    /// kept, in place of one that waits.
    Waits,
    /// The frame is that of the next cycle, and is kept.
    Held,
    /// The place has already had this frame, or another one in this cycle.
    Repeated,
    /// The place has had another frame with the same count.
    Contradicts,
    /// The cycle of the frame is already decided.
    Late,
    /// The counter belongs to no cycle nearby.
    Jumped,
}
