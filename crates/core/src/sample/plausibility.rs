//! Plausibility checks of a reading, in a fixed order: failed by the device's own word, stale, broken wire,
//! out of range, frozen.

mod drive;
mod limits;
mod moment;
mod stillness;
mod unnamed;

use super::device::DeviceWord;
use super::parameters::PlausibilityParameters;
use super::quality::Quality;
use super::reading::Reading;
use crate::state::{state, whole};
use drive::CommandWay;
pub use limits::PlausibilityLimits;
pub use moment::{Moment, Other, Push};
use stillness::Stillness;
use unnamed::UnnamedBits;

const P: &PlausibilityParameters = &PlausibilityParameters::DEFAULT;

/// No length: nothing is known of where the rod has been, lowest and highest.
pub const NOWHERE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

/// Cycles in a row without a reading.
#[derive(Clone, Copy, Debug, Default)]
struct Absence {
    /// Those in which nothing of it came.
    missing: u32,
    /// Those in which a frame came for another cycle, at most [`PlausibilityParameters::spared`].
    spared: u32,
}

whole! { Absence { missing, spared } }

/// The plausibility of one transducer's readings.
#[derive(Clone, Debug)]
pub struct Plausibility {
    limits: PlausibilityLimits,
    /// Extremes of [`PlausibilityLimits::broken_wire_codes`]: most readings are outside both.
    broken_wire: (i64, i64),
    absence: Absence,
    last: Option<f64>,
    /// Reading of the other transducer in the cycle of `last`, m.
    beside: Option<f64>,
    /// Stillness since the reading changed.
    still: Stillness,
    /// Stillness since the reading changed and the command moves.
    held: Stillness,
    drive: CommandWay,
    quality: Quality,
    pub unnamed: UnnamedBits,
}

state! {
    Plausibility { absence, last, beside, still, held, drive, quality, unnamed }
    but { limits, broken_wire }
    sound |it| it.unnamed.are_beside(it.limits.status_mask)
}

impl Plausibility {
    /// Checks with these `limits`.
    pub fn new(limits: PlausibilityLimits) -> Self {
        let broken = || limits.broken_wire_codes.iter().copied();
        Self {
            broken_wire: broken().min().zip(broken().max()).unwrap_or((i64::MAX, i64::MIN)),
            limits,
            absence: Absence::default(),
            last: None,
            beside: None,
            still: Stillness::default(),
            held: Stillness::default(),
            drive: CommandWay::default(),
            quality: Quality::default(),
            unnamed: UnnamedBits::default(),
        }
    }

    /// Quality of the newest cycle.
    pub const fn quality(&self) -> Quality {
        self.quality
    }

    /// Newest reading, m.
    pub const fn newest(&self) -> Option<f64> {
        self.last
    }

    /// Distance of `position` beyond the valid lengths, m, signed; zero within them.
    pub fn beyond(&self, position: f64) -> f64 {
        let (lowest, highest) = self.limits.lengths;
        (position - highest).max(0.0) + (position - lowest).min(0.0)
    }

    /// Takes a reading that changes and is within all limits, as nearly every one is, as [`Self::judge`] would, but asks
    /// nothing else. The other transducer reads `beside`, m. Returns `false`, and does nothing, for any other reading.
    #[inline(always)]
    pub fn take_plain(&mut self, reading: Option<&Reading>, beside: Option<f64>) -> bool {
        let Some(reading) = reading else { return false };
        let changes = self.last != Some(reading.position);
        // Nearly every status has only bits that it had before, none of which means a broken wire.
        let is_odd = reading.status.is_some_and(|it| self.unnamed.lack(it));
        let is_plain = changes && self.beyond_limits(reading, is_odd).is_none();
        if is_plain {
            (self.last, self.beside) = (Some(reading.position), beside);
            (self.absence, self.quality) = (Absence::default(), Quality::Good);
            if self.still.cycles > 0 {
                self.stir();
            }
        }
        is_plain
    }

    /// Begins anew, since the reading no longer stands.
    #[inline(never)]
    fn stir(&mut self) {
        (self.still, self.held, self.drive) = Default::default();
    }

    /// Judges what arrived in the cycle of `moment`.
    #[inline(never)]
    pub fn judge(&mut self, reading: Option<&Reading>, moment: Moment) -> Quality {
        self.quality = match reading {
            None => self.without_reading(moment.live),
            Some(reading) => {
                self.absence = Absence::default();
                let status = reading.status.unwrap_or_default();
                self.unnamed.note(status, self.limits.status_mask);
                self.follow(reading.position, moment);
                self.of_new(reading)
            }
        };
        self.quality
    }

    /// Takes what the device says of itself in the cycle that was judged, and whether a reading came.
    pub fn overrule(&mut self, word: DeviceWord, reads: bool) -> Quality {
        match word {
            DeviceWord::Failed => self.quality = Quality::Failed,
            DeviceWord::Lost => self.quality = Quality::Stale,
            DeviceWord::NotOperational if !reads => {
                // The time in which a reading is missed begins when the device is operational again.
                self.absence = Absence::default();
                self.quality = Quality::NotOperational;
            }
            DeviceWord::NotOperational | DeviceWord::Nothing => {}
        }
        self.quality
    }

    /// Forgets how long the reading has stood still, after a jump in time.
    pub fn reset(&mut self) {
        self.stir();
        self.beside = None;
    }

    /// Whether the reading stands while the other one moves: it may be frozen, but not yet for long
    /// enough, or not under a command that moves.
    pub fn stands_alone(&self) -> bool {
        self.still.cycles > 0 && self.still.travelled >= P.alone * self.limits.travel
    }

    /// Whether the reading has stood while the command went on, even if not yet for long enough to be frozen. When all
    /// twelve froze at once, they were healthy for two seconds.
    #[inline]
    pub fn is_left_standing(&self) -> bool {
        let is_far = |way: &f64| *way >= P.left_standing * self.limits.driven;
        self.still.cycles >= self.limits.frozen && self.drive.ways.iter().any(is_far)
    }

    /// Whether the other transducer has moved while this one was held, so that the rod does not
    /// stand still.
    pub fn is_witnessed(&self) -> bool {
        self.held.witnessed >= self.limits.travel
    }

    /// Whether the command has moved both ways while the reading was held, for so long that no stop holds the rod.
    pub fn is_driven(&self) -> bool {
        self.is_pushed(P.unwitnessed)
    }

    /// Whether the command has moved both ways while the reading was held, each for so many times what a frozen one takes.
    fn is_pushed(&self, times: u32) -> bool {
        let least = self.limits.frozen.saturating_mul(times);
        self.held.pushed.into_iter().all(|pushed| pushed >= least)
    }

    /// Takes a reading that seems frozen for that of a rod at rest.
    pub const fn take_for_rest(&mut self) -> Quality {
        self.quality = Quality::Good;
        self.quality
    }

    /// Takes that a frame of the reading which the judged cycle lacks came for another one: it is not missing, but late, or
    /// early.
    pub fn spare(&mut self) -> Quality {
        let Absence { missing, spared } = &mut self.absence;
        if *missing > 0 && *spared < P.spared {
            (*missing, *spared) = (*missing - 1, *spared + 1);
            self.quality = self.of_none();
        }
        self.quality
    }

    /// Takes that frames of the reading came in the judged cycle, but cannot be relied on: it is not missing.
    pub fn doubt(&mut self) -> Quality {
        self.absence = Absence::default();
        self.quality = Quality::Doubtful;
        self.quality
    }

    /// Number of cycles without a new reading: with none, or with the same.
    pub fn idle(&self) -> u32 {
        self.still.cycles.saturating_add(self.absence.missing)
    }

    fn without_reading(&mut self, live: bool) -> Quality {
        let missing = &mut self.absence.missing;
        *missing = missing.saturating_add(u32::from(live));
        self.of_none()
    }

    const fn of_none(&self) -> Quality {
        let is_stale = self.absence.missing >= self.limits.stale;
        if is_stale { Quality::Stale } else { Quality::Missing }
    }

    /// Follows a reading. Once frozen it stays so until it changes, even if the command comes to
    /// rest.
    fn follow(&mut self, position: f64, moment: Moment) {
        let changes = self.last != Some(position);
        self.last = Some(position);
        let before = core::mem::replace(&mut self.beside, moment.other.map(|it| it.position));
        if changes {
            return self.stir();
        }
        let moves = moment.push.is_some() || self.is_frozen();
        self.still.go_on(before, &moment, &self.limits);
        if moves {
            self.held.go_on(before, &moment, &self.limits);
        } else {
            self.held = Stillness::default();
        }
        self.drive.go_on(position, &moment, self.limits.driven);
    }

    /// Whether the command moves, the reading does not, and the rod does not stand still. If the
    /// other reading changes and yet goes nowhere, the rod is at rest.
    fn is_frozen(&self) -> bool {
        let frozen = self.limits.frozen;
        // Nearly always it moves, and nothing else is asked.
        if self.still.cycles < frozen {
            return false;
        }
        self.held.cycles >= frozen && self.is_witnessed() || self.is_left_behind()
    }

    /// Whether the command has gone so far while the reading was exactly constant that the rod cannot have stayed, although
    /// no other transducer is a witness. A stop holds the rod against one direction only, and not where it has been beyond.
    fn is_left_behind(&self) -> bool {
        let PlausibilityLimits { frozen, driven, .. } = self.limits;
        let (CommandWay { cycles, ways, is_free, .. }, still) = (self.drive, self.still);
        // A reading that changes and yet goes nowhere is that of a rod at rest, as long as it comes.
        let is_at_rest = still.stirred && still.unseen <= frozen;
        if is_at_rest || cycles < frozen.saturating_mul(P.unwitnessed) {
            return false;
        }
        let is_driven = |i: usize| is_free[i] && ways[i] >= P.one_way * driven;
        ways[0].min(ways[1]) >= driven || is_driven(0) || is_driven(1)
    }

    fn of_new(&self, reading: &Reading) -> Quality {
        let of_rest = if self.is_frozen() { Quality::Frozen } else { Quality::Good };
        let is_broken = reading.status.is_some_and(|it| it & self.limits.status_mask != 0);
        self.beyond_limits(reading, is_broken).unwrap_or(of_rest)
    }

    /// What is wrong with a reading by itself, if anything; `is_broken` by its status.
    #[inline(always)]
    fn beyond_limits(&self, reading: &Reading, is_broken: bool) -> Option<Quality> {
        let limits = &self.limits;
        let broken_code = reading.code.is_some_and(|code| {
            let (lowest, highest) = self.broken_wire;
            (lowest..=highest).contains(&code) && limits.broken_wire_codes.contains(&code)
        });
        let code_in_range = reading
            .code
            .zip(limits.codes)
            .is_none_or(|(code, (lowest, highest))| (lowest..=highest).contains(&code));
        let (lowest, highest) = limits.lengths;
        if broken_code || is_broken {
            Some(Quality::BrokenWire)
        } else if !code_in_range || !(lowest..=highest).contains(&reading.position) {
            Some(Quality::OutOfRange)
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests;
