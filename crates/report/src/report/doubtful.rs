//! What of a recording cannot be relied on, though it is no fault of a transducer.

use super::counted;
use tertius_core::monitor::Counts;

/// Remarks on frames that contradict each other, on frames that are too short, and on bits of a status without a meaning.
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
    let unnamed = (counts.unnamed_status_bits > 0).then(|| {
        let bits = counted(counts.unnamed_status_bits, "bit");
        format!(
            "the status signals: {bits} that `plausibility.status_mask` does not have, so readings with them were judged as \
             without: the notices below say which. Add to the mask what means a broken wire"
        )
    });
    [said(counts.contradicting, twins), said(counts.short, short), unnamed].into_iter().flatten()
}
