//! Who tries tokens: how often, and how long an address has to wait until it may try again.

use super::connections::network;
use std::collections::VecDeque;
use std::net::IpAddr;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use tertius_core::text::counted;

/// Most addresses that are remembered; the one that failed longest ago gives way.
const MOST: usize = 256;

/// Failures of an address that cost nothing: people mistype.
const FREE: u32 = 4;

/// Wait after the next failure; it doubles with each, up to the longest.
const FIRST_WAIT: Duration = Duration::from_millis(500);
const LONGEST_WAIT: Duration = Duration::from_secs(16);

/// Failures of all addresses together that are taken at once, and the time until there is room for another one.
const AT_ONCE: u32 = 32;
const ROOM_AFTER: Duration = Duration::from_millis(500);

/// Time without a failure after which an address is forgotten, unless it is locked out for longer.
const FORGET: Duration = Duration::from_secs(900);

/// Failures are logged so far apart at least; those in between are counted.
const LOG_APART: Duration = Duration::from_secs(10);

/// What a configuration says of wrong tokens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoginLimits {
    /// Failures after which an address is locked out.
    pub failures: u32,
    /// For how long it is.
    pub lockout: Duration,
}

impl Default for LoginLimits {
    fn default() -> Self {
        Self { failures: 10, lockout: Duration::from_secs(300) }
    }
}

/// The failures so far. Times are uptimes.
#[derive(Debug, Default)]
pub(super) struct Attempts(Mutex<Failures>);

#[derive(Debug, Default)]
struct Failures {
    /// The one that failed last is the last.
    of: VecDeque<Stranger>,
    /// When all failures will have had their time.
    busy_until: Duration,
    /// When the next failure is logged, and those before it that were not.
    log_at: Duration,
    unlogged: u64,
}

/// An address that has failed.
#[derive(Debug)]
struct Stranger {
    from: IpAddr,
    failures: u32,
    last: Duration,
    /// When it may try again.
    until: Duration,
}

impl Attempts {
    /// How long the address `from` has to wait before it may try a token; `None` if it may.
    pub fn wait(&self, from: IpAddr, now: Duration) -> Option<Duration> {
        let failures = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let from = network(from);
        let own = failures.of.iter().find(|it| it.from == from).map_or(now, |it| it.until);
        let all = failures.busy_until.saturating_sub(ROOM_AFTER * AT_ONCE);
        let wait = own.max(all).saturating_sub(now);
        (!wait.is_zero()).then_some(wait)
    }

    /// Takes a failure of `from`.
    pub fn fail(&self, from: IpAddr, now: Duration, limits: LoginLimits) -> Failed {
        let mut failures = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let network = network(from);
        let forget = FORGET.max(limits.lockout);
        failures.of.retain(|it| now.saturating_sub(it.last) < forget);
        let known = failures.of.iter().position(|it| it.from == network);
        let known = known.and_then(|place| failures.of.remove(place));
        let count = known.map_or(0, |it| it.failures).saturating_add(1);
        let is_out = count >= limits.failures;
        let wait = match count.checked_sub(FREE + 1) {
            _ if is_out => limits.lockout,
            None => Duration::ZERO,
            Some(more) => FIRST_WAIT.saturating_mul(1 << more.min(16)).min(LONGEST_WAIT),
        };
        if failures.of.len() >= MOST {
            failures.of.pop_front();
        }
        failures.of.push_back(Stranger {
            from: network,
            failures: count,
            last: now,
            until: now + wait,
        });
        failures.busy_until = failures.busy_until.max(now) + ROOM_AFTER;
        let unlogged = failures.unlogged;
        // Who is locked out is told at any rate: it is told once.
        if now < failures.log_at && !is_out {
            failures.unlogged += 1;
            return Failed { is_out, told: None };
        }
        (failures.log_at, failures.unlogged) = (now + LOG_APART, 0);
        let others = match unlogged {
            0 => String::new(),
            more => format!("; {} before were not logged", counted(more, "failure")),
        };
        let then = if is_out {
            format!("it is locked out for {} s", limits.lockout.as_secs())
        } else {
            format!("it may try again in {} s", wait.as_secs_f64())
        };
        let told =
            format!("a wrong token from {from}, failure {count} of that address; {then}{others}");
        Failed { is_out, told: Some(told) }
    }

    /// Forgets the failures of who knew the token after all.
    pub fn succeed(&self, from: IpAddr) {
        let mut failures = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        failures.of.retain(|it| it.from != network(from));
    }
}

/// What came of a failure.
#[derive(Debug)]
pub(super) struct Failed {
    /// Whether its address is locked out now.
    pub is_out: bool,
    /// What is to be logged of it, if it is the time.
    pub told: Option<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: LoginLimits = LoginLimits { failures: 8, lockout: Duration::from_secs(300) };

    fn address(last: u8) -> IpAddr {
        IpAddr::from([192, 168, 1, last])
    }

    #[test]
    fn an_address_waits_longer_each_time_and_is_then_locked_out() {
        let attempts = Attempts::default();
        let mut now = Duration::from_secs(100);
        let mut waits = Vec::new();
        for _ in 0..8 {
            assert_eq!(attempts.wait(address(1), now), None);
            _ = attempts.fail(address(1), now, LIMITS);
            let wait = attempts.wait(address(1), now).unwrap_or_default();
            waits.push(wait.as_secs_f64());
            now += wait;
        }
        assert_eq!(waits, [0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 2.0, 300.0]);
        assert_eq!(attempts.wait(address(2), now), None, "others may");
        _ = attempts.fail(address(1), now, LIMITS);
        assert_eq!(attempts.wait(address(1), now), Some(LIMITS.lockout), "it stays so");
        attempts.succeed(address(1));
        assert_eq!(attempts.wait(address(1), now), None);
    }

    #[test]
    fn many_addresses_together_are_slowed_down_and_forgotten() {
        let attempts = Attempts::default();
        let now = Duration::from_secs(100);
        let of = |n: u16| IpAddr::from([10, 0, n.to_be_bytes()[0], n.to_be_bytes()[1]]);
        let taken = (0..5000).filter(|n| {
            let may = attempts.wait(of(*n), now).is_none();
            if may {
                _ = attempts.fail(of(*n), now, LIMITS);
            }
            may
        });
        assert_eq!(taken.count(), AT_ONCE as usize + 1);
        let later = now + Duration::from_secs(60);
        assert_eq!(attempts.wait(of(6000), later), None);
        (0..1000).for_each(|n| _ = attempts.fail(of(n), later, LIMITS));
        assert_eq!(attempts.0.lock().expect("ours").of.len(), MOST, "bounded");
        let own = ["2001:db8::1", "2001:db8::2:3"].map(|it| network(it.parse().expect("IPv6")));
        assert_eq!(own[0], own[1], "one computer has all of them");
    }

    #[test]
    fn the_log_is_not_flooded_and_counts() {
        let attempts = Attempts::default();
        let limits = LoginLimits { failures: 1000, ..LIMITS };
        let at = |millis| Duration::from_millis(millis);
        let told: Vec<String> =
            (0..2001).filter_map(|n| attempts.fail(address(9), at(10 * n), limits).told).collect();
        let logged = told.iter().filter(|it| !it.contains("locked out")).count();
        assert_eq!(logged, 1, "{told:?}");
        let limits = LoginLimits { failures: 100_000, ..LIMITS };
        let attempts = Attempts::default();
        let told: Vec<String> =
            (0..2001).filter_map(|n| attempts.fail(address(9), at(10 * n), limits).told).collect();
        assert_eq!(told.len(), 3, "{told:?}");
        assert!(told[0].starts_with("a wrong token from 192.168.1.9, failure 1 "), "{}", told[0]);
        assert!(told[1].contains("999 failures before were not logged"), "{}", told[1]);
    }
}
