//! The system's clock: whether it is set meanwhile, and by whom.

use super::super::facts::{ClockFacts, ClockSource};
use super::computer::said_by;
use std::path::Path;
use std::time::{Duration, Instant, SystemTime};
use tertius_core::time::Span;

/// Facts on the clock since it and another one, which nobody sets, were read.
pub(super) fn read(monotonic: Instant, system: SystemTime) -> ClockFacts {
    let watched = monotonic.elapsed();
    let signed = |time: Duration| Span::from_seconds(time.as_secs_f64()).as_nanos();
    let passed = match SystemTime::now().duration_since(system) {
        Ok(ahead) => signed(ahead),
        Err(back) => -signed(back.duration()),
    };
    // By numbers: to ask for names may take long.
    let said = said_by("chronyc", &["-n", "-c", "tracking"]);
    let source = said.and_then(|text| ClockSource::read(&text));
    ClockFacts {
        synchronised: source.is_some().then_some(true).or_else(synchronised),
        step: Span::from_nanos(passed.saturating_sub(signed(watched))),
        watched: watched.as_secs_f64(),
        source,
    }
}

/// Whether systemd-timesyncd synchronises the clock, or another daemon has told the kernel that it
/// does (chrony, ntpd, PTP). No safe interface to `adjtimex` was found; timedatectl asks it.
fn synchronised() -> Option<bool> {
    if Path::new("/run/systemd/timesync/synchronized").exists() {
        return Some(true);
    }
    let said = said_by("timedatectl", &["show", "--property=NTPSynchronized", "--value"])?;
    match said.trim() {
        "yes" => Some(true),
        "no" => Some(false),
        _ => None,
    }
}
