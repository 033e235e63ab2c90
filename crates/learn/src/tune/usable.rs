//! Whether thresholds can be used, and remarks on them.

use super::{Detector, LEAST_HIGH, Thresholds, Tuning};
use crate::calibrate::watch::{Level, Sight, Watch};
use crate::extremes::{HOURS_PER_YEAR, Tail, false_alarms, per_second};
use tertius_config::settings::Settings;
use tertius_core::text::Millimetres;

/// Largest threshold, as a part of the difference at which the machine itself trips.
const LARGEST: f64 = 0.1;

/// Factor within which a larger threshold is accepted after all, if the recording itself shows such
/// residuals at the wanted rate.
const SHOWN: f64 = 1.05;

impl Tuning {
    /// Refuses a threshold that is out of reach, or that was made from nothing.
    ///
    /// # Errors
    /// The reason, in words; nothing may be written then.
    pub fn usable(&self, settings: &Settings) -> Result<(), String> {
        let Thresholds { high, hours, per_year, .. } = self.thresholds;
        let [low_end, high_end] = settings.machine.stroke;
        if high <= 0.0 {
            return Err("the residuals are zero throughout: this is not a recording of a machine"
                .to_owned());
        }
        let critical = settings.comparator.critical;
        let farther = HOURS_PER_YEAR / per_year / hours;
        if high <= LARGEST * critical || (farther <= SHOWN && high < high_end - low_end) {
            return Ok(());
        }
        let tails: Vec<Tail> = self.detectors.iter().filter_map(|detector| detector.tail).collect();
        let at = |level: f64| {
            let rate = tails.iter().map(|tail| tail.rate(level)).sum::<f64>();
            (rate / per_second(1.0)).ceil()
        };
        Err(format!(
            "for {} the threshold would be {:.1}, beyond {:.1}, \
             a tenth of comparator.critical: the observers would hardly find any fault. Record for \
            longer than \
         {hours:.3} h, find a better model (`tertius identify`), or ask for a rate that the \
         recording supports (--false-alarms-per-year): with the thesis's {:.1} it is about \
         {:.0} a year, with \
         {:.1} about {:.0}, with the largest residual seen, {:.1}, about {:.0}",
            false_alarms(per_year),
            Millimetres(high),
            Millimetres(LARGEST * critical),
            Millimetres(LEAST_HIGH),
            at(LEAST_HIGH),
            Millimetres(LARGEST * critical),
            at(LARGEST * critical),
            Millimetres(worst(&tails)),
            at(worst(&tails)),
        ))
    }
}

fn worst(tails: &[Tail]) -> f64 {
    tails.iter().map(|tail| tail.worst).fold(0.0, f64::max)
}

/// Caveats of these thresholds.
pub(super) fn limits(result: &Tuning, critical: f64) -> Vec<String> {
    let mut remarks = Vec::new();
    let heavy: Vec<&Detector> =
        result.detectors.iter().filter(|d| d.tail.is_some_and(|tail| tail.heavy)).collect();
    if !heavy.is_empty() {
        remarks.push(format!(
            "{} of {} residuals have bursts, a tail heavier than an exponential one: the model does \
             not follow the machine at times, and the threshold is that of the bursts",
            heavy.len(),
            result.detectors.len()
        ));
    }
    if result.thresholds.high >= critical {
        remarks.push(format!(
            "the threshold of {:.1} is not below comparator.critical, {:.1}, where the machine \
             itself trips: FDE1 and FDE2 then only tell which transducer has failed",
            Millimetres(result.thresholds.high),
            Millimetres(critical)
        ));
    }
    if result.search.score.times.is_infinite() {
        remarks.push(
            "with no weights the response to a step is over within alarm.coincidence: a fault may \
             be taken for two"
                .to_owned(),
        );
    }
    remarks
}

/// Beginning of remarks on the evidence that a detector with a level of its own has seen.
pub const OF_A_LEVEL: &str = "sequential detector of cylinder";

/// Ending of such remarks where the evidence exceeded the level.
pub const WOULD_HAVE_WARNED: &str = "; it would have warned: is that healthy?";

/// The level of the detectors that have none of their own, where the recording supports one, and
/// remarks on all detectors.
pub(super) fn sequential(
    settings: &Settings,
    watch: &Watch,
    per_year: f64,
) -> (Option<Level>, Vec<String>) {
    let own = |n| settings.sequential_of(n).is_some_and(|fitted| fitted.level.is_some());
    if !(1..=settings.machine.cylinders).any(own) {
        let level = watch.level(per_year);
        let refused = level.filter(|level| !level.sound).map(|level| {
            format!(
                "sequential detectors: {:.1} nats of evidence were seen, which a healthy machine \
                 would not have with these tables; no level is written: calibrate again",
                level.worst
            )
        });
        return (level.filter(|level| level.sound), refused.into_iter().collect());
    }
    let said = (1..).zip(watch.levels(per_year)).filter_map(|(n, level): (u8, _)| {
        let (sight, h) = (level?.worst?, settings.sequential_level_of(n));
        let beyond = if sight.nats > h { WOULD_HAVE_WARNED } else { "" };
        let Sight { nats, t, .. } = sight;
        Some(format!("{OF_A_LEVEL} {n}: {nats:.1} of {h:.1} nats at {t:.1} s{beyond}"))
    });
    (None, said.collect())
}
