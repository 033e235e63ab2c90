//! The flaws of a design in words.

use tertius_config::design::Flaw;

/// All `flaws` on one line.
pub(crate) fn listed(flaws: &[Flaw]) -> String {
    let listed = flaws.iter().map(|flaw| format!("{}: {}", flaw.key, flaw.message));
    listed.collect::<Vec<_>>().join("; ")
}
