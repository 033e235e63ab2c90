//! Plausibility checks of a reading, in a fixed order: stale, broken wire, out of range, frozen.

use super::motion::ReadingMotion;
use super::quality::Quality;
use super::reading::Reading;
use alloc::vec::Vec;

/// Limits of plausible readings.
#[derive(Clone, Debug)]
pub struct PlausibilityLimits {
    /// Cycles without a new reading after which it is stale.
    pub stale: u32,
    /// Raw codes of a broken wire.
    pub broken_wire_codes: Vec<i64>,
    /// Status bits of a broken wire.
    pub status_mask: u64,
    /// Range of valid raw codes, inclusive.
    pub codes: Option<(i64, i64)>,
    /// Range of valid lengths, inclusive, m.
    pub lengths: (f64, f64),
    /// Cycles of an exactly constant reading under a moving command after which it is frozen.
    pub frozen: u32,
    /// Distance that the other transducer has to move meanwhile, m.
    pub travel: f64,
}

/// Factor on [`PlausibilityLimits::frozen`] where no other transducer can tell: friction holds the rod
/// where a slow stroke turns. The command must have moved both ways: a stop holds against one only.
const UNWITNESSED: u32 = 5;

/// Direction in which a command moves the cylinder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Push {
    Positive,
    Negative,
}

/// The other transducer of the cylinder.
#[derive(Clone, Copy, Debug)]
pub struct Other {
    /// Position, m.
    pub position: f64,
    /// Whether it is in motion, see [`ReadingMotion::goes_on`].
    pub goes_on: bool,
}

impl Other {
    /// The other transducer at `position`, m, whose `motion` was followed up to it.
    pub fn new(position: f64, motion: &ReadingMotion) -> Self {
        Self { position, goes_on: motion.goes_on() }
    }
}

/// Circumstances of a cycle beside the reading.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// Whether anything of the machine was on the bus in this cycle. In silence nothing ages: a
    /// quiet bus is not the fault of a transducer.
    pub live: bool,
    /// Direction in which the command since the last cycle moves the cylinder, in a platform state
    /// in which it follows; `None` if it does not move it.
    pub push: Option<Push>,
    /// The other transducer in this cycle; `None` where it cannot be relied on.
    pub other: Option<Other>,
}

/// An exactly constant reading: since when, and what was seen meanwhile.
#[derive(Clone, Copy, Debug, Default)]
struct Stillness {
    cycles: u32,
    /// Number of cycles under a command that moves, by its [`Push`].
    pushed: [u32; 2],
    /// Reading of the other transducer at the beginning, m.
    beside: Option<f64>,
    /// Whether the other transducer has read anything else since.
    stirred: bool,
    /// Distance that the other transducer has moved since in a continuous motion, m.
    travelled: f64,
}

impl Stillness {
    fn begin(other: Option<Other>) -> Self {
        Self { beside: other.map(|other| other.position), ..Self::default() }
    }

    fn go_on(&mut self, push: Option<Push>, other: Option<Other>) {
        self.cycles = self.cycles.saturating_add(1);
        if let Some(push) = push {
            let pushed = &mut self.pushed[push as usize];
            *pushed = pushed.saturating_add(1);
        }
        let Some((then, now)) = self.beside.zip(other) else { return };
        let travel = (now.position - then).abs();
        self.stirred |= travel > 0.0;
        if now.goes_on {
            self.travelled = self.travelled.max(travel);
        }
    }
}

/// The plausibility of one transducer's readings.
#[derive(Clone, Debug)]
pub struct Plausibility {
    limits: PlausibilityLimits,
    /// Extremes of [`PlausibilityLimits::broken_wire_codes`]: most readings are outside both.
    broken_wire: (i64, i64),
    missing: u32,
    last: Option<f64>,
    /// Stillness since the reading changed.
    still: Stillness,
    /// Stillness since the reading changed and the command moves.
    held: Stillness,
    quality: Quality,
}

impl Plausibility {
    /// Checks with these `limits`.
    pub fn new(limits: PlausibilityLimits) -> Self {
        let broken = || limits.broken_wire_codes.iter().copied();
        Self {
            broken_wire: broken().min().zip(broken().max()).unwrap_or((i64::MAX, i64::MIN)),
            limits,
            missing: 0,
            last: None,
            still: Stillness::default(),
            held: Stillness::default(),
            quality: Quality::default(),
        }
    }

    /// Quality of the newest cycle.
    pub const fn quality(&self) -> Quality {
        self.quality
    }

    /// Distance of `position` beyond the valid lengths, m, signed; zero within them.
    pub fn beyond(&self, position: f64) -> f64 {
        let (lowest, highest) = self.limits.lengths;
        (position - highest).max(0.0) + (position - lowest).min(0.0)
    }

    /// Judges what arrived in the cycle of `moment`.
    pub fn judge(&mut self, reading: Option<&Reading>, moment: Moment) -> Quality {
        self.quality = match reading {
            None => self.without_reading(moment.live),
            Some(reading) => {
                self.missing = 0;
                self.follow(reading.position, moment);
                self.of_new(reading)
            }
        };
        self.quality
    }

    /// Forgets how long the reading has stood still, after a jump in time.
    pub fn reset(&mut self) {
        (self.still, self.held) = Default::default();
    }

    /// Whether the reading stands while the other one moves: it may be frozen, but not yet for long
    /// enough, or not under a command that moves.
    pub fn stands_alone(&self) -> bool {
        self.still.cycles > 0 && self.still.travelled >= 0.5 * self.limits.travel
    }

    /// Whether the other transducer has moved while this one was held, so that the rod does not
    /// stand still.
    pub fn is_witnessed(&self) -> bool {
        self.held.travelled >= self.limits.travel
    }

    /// Number of cycles without a new reading: with none, or with the same.
    pub fn idle(&self) -> u32 {
        self.still.cycles.saturating_add(self.missing)
    }

    fn without_reading(&mut self, live: bool) -> Quality {
        self.missing = self.missing.saturating_add(u32::from(live));
        if self.missing >= self.limits.stale { Quality::Stale } else { Quality::Missing }
    }

    /// Follows a reading. Once frozen it stays so until it changes, even if the command comes to
    /// rest.
    fn follow(&mut self, position: f64, moment: Moment) {
        let same = self.last == Some(position);
        let moving = moment.push.is_some() || self.is_frozen();
        self.last = Some(position);
        let follow = |stillness: &mut Stillness, goes_on: bool| {
            if goes_on {
                stillness.go_on(moment.push, moment.other);
            } else {
                *stillness = Stillness::begin(moment.other);
            }
        };
        follow(&mut self.still, same);
        follow(&mut self.held, same && moving);
    }

    /// Whether the command moves, the reading does not, and the rod does not stand still. If the
    /// other reading changes and yet goes nowhere, the rod is at rest.
    fn is_frozen(&self) -> bool {
        let frozen = self.limits.frozen;
        let Stillness { cycles, pushed, stirred, .. } = self.held;
        // Nearly always it moves, and nothing else is asked.
        if cycles < frozen || self.is_witnessed() {
            return cycles >= frozen;
        }
        let either_way = pushed.into_iter().all(|pushed| pushed >= frozen);
        !stirred && either_way && cycles >= frozen.saturating_mul(UNWITNESSED)
    }

    fn of_new(&self, reading: &Reading) -> Quality {
        let limits = &self.limits;
        let broken_code = reading.code.is_some_and(|code| {
            let (lowest, highest) = self.broken_wire;
            (lowest..=highest).contains(&code) && limits.broken_wire_codes.contains(&code)
        });
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

    fn limits() -> PlausibilityLimits {
        PlausibilityLimits {
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

    const MOVING: Moment = Moment { live: true, push: Some(Push::Positive), other: None };
    const STILL: Moment = Moment { push: None, ..MOVING };

    /// The other transducer in motion, at `position`.
    fn passing(position: f64) -> Moment {
        Moment { other: Some(Other { position, goes_on: true }), ..MOVING }
    }

    #[test]
    fn the_order_is_stale_broken_wire_out_of_range_frozen() {
        let mut checks = Plausibility::new(limits());
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
    fn only_the_codes_of_a_broken_wire_are_one() {
        let broken_wire_codes = vec![32767, 0, 500];
        let limits = PlausibilityLimits { broken_wire_codes, ..limits() };
        let mut checks = Plausibility::new(limits);
        let broken = [0, 100, 500, 501, 32767].map(|code| {
            let reading = Reading { code: Some(code), ..reading(0.0) };
            checks.judge(Some(&reading), STILL) == Quality::BrokenWire
        });
        assert_eq!(broken, [true, false, true, false, true]);
    }

    #[test]
    fn a_status_bit_outside_the_mask_is_no_fault() {
        let mut checks = Plausibility::new(limits());
        let other_bit = Reading { status: Some(0b10), ..reading(0.0) };
        assert_eq!(checks.judge(Some(&other_bit), MOVING), Quality::Good);
        let masked = Reading { status: Some(0b11), ..reading(0.0) };
        assert_eq!(checks.judge(Some(&masked), MOVING), Quality::BrokenWire);
    }

    #[test]
    fn frozen_needs_a_moving_command_and_ends_with_a_change() {
        let mut checks = Plausibility::new(limits());
        for _ in 0..50 {
            assert_eq!(checks.judge(Some(&reading(0.5)), STILL), Quality::Good);
        }
        checks.judge(Some(&reading(0.4)), passing(0.0));
        for cycle in 0..4 {
            let moment = passing(1e-3 * f64::from(cycle));
            assert_eq!(checks.judge(Some(&reading(0.5)), moment), Quality::Good);
        }
        assert_eq!(checks.judge(Some(&reading(0.5)), passing(5e-3)), Quality::Frozen);
        assert_eq!(checks.judge(Some(&reading(0.5)), STILL), Quality::Frozen, "it did not thaw");
        assert_eq!(checks.judge(Some(&reading(0.500_1)), STILL), Quality::Good);
    }

    /// The cycle in which a reading that stops in cycle 0 is frozen, with the other one at `other`
    /// and the command moving as `push` tells.
    fn frozen_in(
        other: impl Fn(u64) -> Option<f64>,
        push: impl Fn(u64) -> Option<Push>,
    ) -> Option<u64> {
        let mut checks = Plausibility::new(limits());
        let mut motion = ReadingMotion::default();
        let judge = |cycle: &u64| {
            motion.follow(other(*cycle));
            let other = other(*cycle).map(|position| Other::new(position, &motion));
            let moment = Moment { other, push: push(*cycle), ..MOVING };
            checks.judge(Some(&reading(0.5)), moment) == Quality::Frozen
        };
        (0..100).find(judge)
    }

    #[test]
    fn a_reading_that_stands_while_the_other_goes_on_is_frozen() {
        let out = |_| Some(Push::Positive);
        let ramp = |cycle: u64| Some(3e-4 * cycle as f64);
        assert_eq!(frozen_in(ramp, out), Some(4), "it moves slowly");
        let later = |cycle: u64| Some(3e-4 * cycle.saturating_sub(6) as f64);
        assert_eq!(frozen_in(later, out), Some(10), "it moves later");
        let lost = |cycle| ramp(cycle).filter(|_| cycle < 9);
        assert_eq!(frozen_in(lost, out), Some(4), "it has moved before it was lost");
    }

    /// Movements of the other transducer while the rod stands on its stop, pushed against it.
    #[test]
    fn at_rest_is_not_frozen() {
        let out = |_| Some(Push::Positive);
        assert_eq!(frozen_in(|_| None, out), None, "it is lost, or frozen itself");
        assert_eq!(frozen_in(|_| Some(0.2), out), None, "it stands, too");
        assert_eq!(frozen_in(|cycle| Some(4.34e-4 * (cycle % 3) as f64), out), None, "it flickers");
        assert_eq!(
            frozen_in(|cycle| Some(if cycle < 9 { 0.1 } else { 0.2 }), out),
            None,
            "it jumps"
        );
        let noise =
            |cycle: u64| Some(1e-3 * [0.0, 1.0, -1.0, -1.0, 0.0, 1.0][(cycle % 6) as usize]);
        assert_eq!(frozen_in(noise, out), None, "it is noisy");
    }

    /// A stop holds the rod against one direction only.
    #[test]
    fn without_a_witness_the_command_has_to_move_either_way() {
        let turning = |cycle| Some(if cycle % 40 < 20 { Push::Positive } else { Push::Negative });
        assert_eq!(frozen_in(|_| None, turning), Some(23));
        assert_eq!(frozen_in(|_| Some(0.2), turning), Some(23), "the cylinder does not follow");
        assert_eq!(frozen_in(|cycle| Some(4.34e-4 * (cycle % 2) as f64), turning), None);
    }

    #[test]
    fn who_stands_alone_is_known_before_it_is_frozen() {
        let mut checks = Plausibility::new(limits());
        checks.judge(Some(&reading(0.5)), passing(0.0));
        assert!(!checks.stands_alone());
        let resting = Moment { push: None, ..passing(6e-4) };
        assert_eq!(checks.judge(Some(&reading(0.5)), resting), Quality::Good);
        assert!(checks.stands_alone() && !checks.is_witnessed());
        checks.judge(Some(&reading(0.6)), passing(7e-4));
        assert!(!checks.stands_alone());
    }

    #[test]
    fn stale_after_the_configured_cycles_but_not_in_silence() {
        let mut checks = Plausibility::new(limits());
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
    fn not_a_number_is_out_of_range() {
        let mut checks = Plausibility::new(limits());
        let nan = Reading { code: None, ..reading(f64::NAN) };
        assert_eq!(checks.judge(Some(&nan), MOVING), Quality::OutOfRange);
    }
}
