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
    /// How far the other transducer has to move meanwhile, m.
    pub travel: f64,
}

/// While the other transducer does not move either, a constant reading is frozen only after so many
/// times [`Limits::frozen`]: where a slow stroke turns, friction holds the rod still for a while
/// under a command that moves again.
const UNWITNESSED: u32 = 5;

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
    /// What the other transducer reads in this cycle, m; `None` where there is none to be relied on.
    pub other: Option<f64>,
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
    /// What the other transducer read when this one stopped.
    beside: Option<f64>,
    /// Whether it moved since, or cannot be asked.
    witnessed: bool,
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
            beside: None,
            witnessed: false,
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
                self.follow(reading.position, moment);
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
    fn follow(&mut self, position: f64, moment: Moment) {
        let same = self.last == Some(position);
        let moving = moment.moving || self.is_frozen();
        self.last = Some(position);
        if !(same && moving) {
            (self.constant, self.beside, self.witnessed) = (0, moment.other, false);
            return;
        }
        self.constant = self.constant.saturating_add(1);
        let travel = self.beside.zip(moment.other).map(|(then, now)| (now - then).abs());
        self.witnessed |= travel.is_none_or(|travel| travel >= self.limits.travel);
    }

    /// The command moves and the reading does not, nor is it the rod that stands still.
    fn is_frozen(&self) -> bool {
        let alone = self.limits.frozen.saturating_mul(UNWITNESSED);
        self.constant >= if self.witnessed { self.limits.frozen } else { alone }
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
        } else if self.is_frozen() {
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
            travel: 1e-3,
        }
    }

    fn reading(position: f64) -> Reading {
        Reading { position, code: Some(100), status: Some(0), ..Reading::default() }
    }

    const MOVING: Moment = Moment { cycle: 0, live: true, moving: true, other: None };
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

    /// The cycle in which a reading that stops in cycle 0 is frozen, the other one at `other`.
    fn frozen_in(other: impl Fn(u64) -> Option<f64>) -> u64 {
        let mut checks = Plausibility::new(limits(), None);
        let judge = |cycle: &u64| {
            let moment = Moment { other: other(*cycle), ..MOVING };
            checks.judge(Some(&reading(0.5)), moment) == Quality::Frozen
        };
        (0..100).find(judge).expect("it is frozen in the end")
    }

    #[test]
    fn while_the_other_one_stands_still_too_it_is_the_rod_for_a_while() {
        assert_eq!(frozen_in(|_| None), 4, "nobody to ask");
        assert_eq!(frozen_in(|cycle| Some(3e-4 * cycle as f64)), 4, "it moves slowly");
        assert_eq!(frozen_in(|cycle| (cycle < 2).then_some(0.0)), 4, "it cannot be asked any more");
        assert_eq!(frozen_in(|cycle| Some(4.34e-4 * (cycle % 3) as f64)), 20, "it flickers");
        assert_eq!(frozen_in(|cycle| Some(if cycle < 9 { 0.1 } else { 0.2 })), 9, "it moves later");
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
