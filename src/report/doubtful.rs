//! Frames of a recording that cannot be relied on.

use super::wording::counted;
use crate::monitor::Counts;

/// That frames contradict each other, and that frames are too short, where they do and are.
pub fn remarks(counts: &Counts) -> impl Iterator<Item = String> {
    let said = |count: u64, what: &str| {
        let frames = counted(count, "frame");
        (count > 0).then(|| {
            format!(
                "the bus: {frames} {what}. What they carry was not judged, and no transducer is to blame: the notices below \
                 say which"
            )
        })
    };
    let twins = "with the same count as another one and another payload, so a second device sends them, too";
    let short =
        "too short for the signals that are configured, so their sender is not the one of the DBC";
    [said(counts.contradicting, twins), said(counts.short, short)].into_iter().flatten()
}
