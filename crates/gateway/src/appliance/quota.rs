//! A limit on the number of log lines.

use std::time::{Duration, Instant};

/// Most lines at once: a little more than one loss of the bus causes.
const AT_ONCE: u32 = 32;

/// Interval after which one more line is allowed.
const EACH: Duration = Duration::from_secs(2);

/// Limits the log lines that a flaky bus repeats for months.
#[derive(Debug)]
pub(super) struct Quota {
    left: u32,
    since: Instant,
    withheld: u64,
}

impl Quota {
    pub(super) fn new(now: Instant) -> Self {
        Self { left: AT_ONCE, since: now, withheld: 0 }
    }

    /// Whether a line may be written at `now`, and how many were withheld before it.
    pub(super) fn ask(&mut self, now: Instant) -> Option<u64> {
        let earned = now.saturating_duration_since(self.since).as_nanos() / EACH.as_nanos();
        let earned = u32::try_from(earned).unwrap_or(u32::MAX).min(AT_ONCE);
        if earned > 0 {
            self.left = self.left.saturating_add(earned).min(AT_ONCE);
            self.since = now;
        }
        if self.left == 0 {
            self.withheld += 1;
            return None;
        }
        self.left -= 1;
        Some(std::mem::take(&mut self.withheld))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_is_cut_to_its_rate_and_what_was_withheld_is_told() {
        let start = Instant::now();
        let mut quota = Quota::new(start);
        // Ten lines a second for an hour.
        let asked: Vec<Option<u64>> =
            (0..36_000).map(|n| quota.ask(start + Duration::from_millis(100 * n))).collect();
        let written = asked.iter().flatten().count();
        assert!((1800..=1840).contains(&written), "{written}");
        let told: u64 = asked.iter().flatten().sum();
        let withheld = asked.iter().filter(|it| it.is_none()).count() as u64;
        assert!(withheld - told <= 20, "all but the newest are told: {withheld} {told}");
        assert!(asked[..32].iter().all(|it| *it == Some(0)), "what happens once is told whole");
    }
}
