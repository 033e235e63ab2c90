//! The checks of a reading before any model, in a fixed order: stale, broken wire, out of range,
//! frozen.

use super::counter::{AliveCounter, Progress};
use super::quality::Quality;
use super::reading::Reading;

/// What makes a reading implausible.
#[derive(Clone, Debug)]
pub struct Limits {
    /// Cycles without a new reading until it is stale.
    pub stale: u32,
    /// Raw codes of a broken wire.
    pub broken_wire_codes: Vec<i64>,
    /// Status bits of a broken wire.
    pub status_mask: u64,
    /// Valid raw codes, both inclusive.
    pub codes: Option<(i64, i64)>,
    /// Valid lengths, both inclusive, m.
    pub lengths: (f64, f64),
    /// Cycles of an exactly constant reading under a moving command until it is frozen.
    pub frozen: u32,
}

/// What is known of the cycle beside the reading.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    pub cycle: u64,
    /// Something of the machine was on the bus in this cycle. In silence nothing ages: a quiet bus
    /// is not the fault of a transducer.
    pub live: bool,
    /// The command that acted since the last cycle moves the cylinder, and the platform's state is
    /// one in which it follows.
    pub moving: bool,
}

/// The plausibility of one transducer's readings.
#[derive(Clone, Debug)]
pub struct Plausibility {
    limits: Limits,
    counter: Option<AliveCounter>,
    counter_jumps: u64,
    missing: u32,
    last: Option<f64>,
    constant: u32,
    quality: Quality,
}

impl Plausibility {
    /// Checks by `limits`; `counter_bits` is the size of the alive counter, where there is one.
    pub fn new(limits: Limits, counter_bits: Option<u32>) -> Self {
        Self {
            limits,
            counter: counter_bits.map(AliveCounter::new),
            counter_jumps: 0,
            missing: 0,
            last: None,
            constant: 0,
            quality: Quality::default(),
        }
    }

    /// The quality of the newest cycle.
    pub const fn quality(&self) -> Quality {
        self.quality
    }

    /// Times that the alive counter advanced by another number than the cycles that passed.
    pub const fn counter_jumps(&self) -> u64 {
        self.counter_jumps
    }

    /// How far `position` is beyond the valid lengths, m, signed; zero within them.
    pub fn beyond(&self, position: f64) -> f64 {
        let (lowest, highest) = self.limits.lengths;
        (position - highest).max(0.0) + (position - lowest).min(0.0)
    }

    /// Judges what arrived in the cycle of `moment`.
    pub fn judge(&mut self, reading: Option<&Reading>, moment: Moment) -> Quality {
        let fresh = reading.filter(|reading| self.is_new(reading, moment.cycle));
        self.quality = match fresh {
            None => self.without_reading(moment.live),
            Some(reading) => {
                self.missing = 0;
                self.follow(reading.position, moment.moving);
                self.of_new(reading)
            }
        };
        self.quality
    }

    /// Forgets the counter's last value, after a jump in time.
    pub fn reset(&mut self) {
        if let Some(counter) = &mut self.counter {
            counter.reset();
        }
        self.constant = 0;
    }

    fn is_new(&mut self, reading: &Reading, cycle: u64) -> bool {
        let Some((counter, value)) = self.counter.as_mut().zip(reading.counter) else {
            return true;
        };
        let progress = counter.follow(cycle, value);
        self.counter_jumps += u64::from(progress == Progress::Jumped);
        progress != Progress::Repeated
    }

    fn without_reading(&mut self, live: bool) -> Quality {
        self.missing = self.missing.saturating_add(u32::from(live));
        if self.missing >= self.limits.stale { Quality::Stale } else { Quality::Missing }
    }

    /// Once frozen it stays so until the reading changes, even if the command comes to rest.
    fn follow(&mut self, position: f64, moving: bool) {
        let same = self.last == Some(position);
        self.last = Some(position);
        self.constant = match (same, moving || self.constant >= self.limits.frozen) {
            (true, true) => self.constant.saturating_add(1),
            _ => 0,
        };
    }

    fn of_new(&self, reading: &Reading) -> Quality {
        let limits = &self.limits;
        let broken_code = reading.code.is_some_and(|c| limits.broken_wire_codes.contains(&c));
        let broken_status = reading.status.is_some_and(|s| s & limits.status_mask != 0);
        let code_in_range = reading
            .code
            .zip(limits.codes)
            .is_none_or(|(code, (lowest, highest))| (lowest..=highest).contains(&code));
        let (lowest, highest) = limits.lengths;
        if broken_code || broken_status {
            Quality::BrokenWire
        } else if !code_in_range || !(lowest..=highest).contains(&reading.position) {
            Quality::OutOfRange
        } else if self.constant >= limits.frozen {
            Quality::Frozen
        } else {
            Quality::Good
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits() -> Limits {
        Limits {
            stale: 3,
            broken_wire_codes: vec![32767],
            status_mask: 0b01,
            codes: Some((1, 27648)),
            lengths: (-1.5, 1.5),
            frozen: 4,
        }
    }

    fn reading(position: f64) -> Reading {
        Reading { position, code: Some(100), status: Some(0), ..Reading::default() }
    }

    const MOVING: Moment = Moment { cycle: 0, live: true, moving: true };
    const STILL: Moment = Moment { moving: false, ..MOVING };

    #[test]
    fn the_order_is_stale_broken_wire_out_of_range_frozen() {
        let mut checks = Plausibility::new(limits(), None);
        let worst = Reading { code: Some(32767), position: 2.0, status: Some(1), ..reading(2.0) };
        for _ in 0..6 {
            assert_eq!(checks.judge(Some(&worst), MOVING), Quality::BrokenWire);
        }
        assert_eq!(checks.judge(Some(&reading(2.0)), MOVING), Quality::OutOfRange);
        let zero = Reading { code: Some(0), ..reading(2.0) };
        assert_eq!(checks.judge(Some(&zero), MOVING), Quality::OutOfRange);
        assert_eq!(checks.judge(Some(&reading(1.0)), MOVING), Quality::Good);
    }

    #[test]
    fn a_status_bit_outside_the_mask_is_no_fault() {
        let mut checks = Plausibility::new(limits(), None);
        let other_bit = Reading { status: Some(0b10), ..reading(0.0) };
        assert_eq!(checks.judge(Some(&other_bit), MOVING), Quality::Good);
        let masked = Reading { status: Some(0b11), ..reading(0.0) };
        assert_eq!(checks.judge(Some(&masked), MOVING), Quality::BrokenWire);
    }

    #[test]
    fn frozen_needs_a_moving_command_and_ends_with_a_change() {
        let mut checks = Plausibility::new(limits(), None);
        for _ in 0..50 {
            assert_eq!(checks.judge(Some(&reading(0.5)), STILL), Quality::Good);
        }
        for _ in 0..3 {
            assert_eq!(checks.judge(Some(&reading(0.5)), MOVING), Quality::Good);
        }
        assert_eq!(checks.judge(Some(&reading(0.5)), MOVING), Quality::Frozen);
        assert_eq!(checks.judge(Some(&reading(0.5)), STILL), Quality::Frozen, "it did not thaw");
        assert_eq!(checks.judge(Some(&reading(0.500_1)), STILL), Quality::Good);
    }

    #[test]
    fn stale_after_the_configured_cycles_but_not_in_silence() {
        let mut checks = Plausibility::new(limits(), None);
        assert_eq!(checks.judge(Some(&reading(0.0)), MOVING), Quality::Good);
        for _ in 0..100 {
            let silence = Moment { live: false, ..MOVING };
            assert_eq!(checks.judge(None, silence), Quality::Missing);
        }
        assert_eq!(checks.judge(None, MOVING), Quality::Missing);
        assert_eq!(checks.judge(None, MOVING), Quality::Missing);
        assert_eq!(checks.judge(None, MOVING), Quality::Stale);
        assert_eq!(checks.judge(Some(&reading(0.0)), MOVING), Quality::Good);
    }

    #[test]
    fn a_repeated_counter_is_no_new_reading() {
        let mut checks = Plausibility::new(limits(), Some(8));
        let counted = |counter| Reading { counter: Some(counter), ..reading(0.0) };
        let at = |cycle| Moment { cycle, ..STILL };
        assert_eq!(checks.judge(Some(&counted(7)), at(1)), Quality::Good);
        assert_eq!(checks.judge(Some(&counted(7)), at(2)), Quality::Missing);
        assert_eq!(checks.judge(Some(&counted(7)), at(3)), Quality::Missing);
        assert_eq!(checks.judge(Some(&counted(7)), at(4)), Quality::Stale);
        assert_eq!(checks.judge(Some(&counted(12)), at(5)), Quality::Good);
        assert_eq!(checks.counter_jumps(), 1);
    }

    #[test]
    fn not_a_number_is_out_of_range() {
        let mut checks = Plausibility::new(limits(), None);
        let nan = Reading { code: None, ..reading(f64::NAN) };
        assert_eq!(checks.judge(Some(&nan), MOVING), Quality::OutOfRange);
    }
}
