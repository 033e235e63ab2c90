//! Whether the configuration is fit for use, in a sentence.

use super::faults::FaultKind;
use super::taught::{LeftOut, Refused, Stage, Taught, Threshold};
use super::trial::{KindResult, Trial};
use crate::evaluate::poisson_upper;
use tertius_config::MachineNames;
use tertius_core::text::counted;
use tertius_learn::extremes::HOURS_PER_YEAR;

/// Whether the configuration can be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fitness {
    Fit,
    /// It can be used except for these cylinders, and without the detectors of these thresholds; one of both is not empty.
    Partly {
        cylinders: Vec<u8>,
        without: Vec<Threshold>,
    },
    Unfit,
}

/// Verdict on the whole configuration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verdict {
    pub fitness: Fitness,
    pub sentence: String,
    /// Reasons against use, one line each.
    pub reasons: Vec<String>,
    /// What to do about them.
    pub advice: Vec<String>,
}

/// More false alarms than expected count against the tables when chance explains them with a
/// probability below this.
const DOUBT: f64 = 0.05;

/// Least part of the 1 mm steps that has to be found, since the thesis's thresholds find them.
const LEAST_FOUND: f64 = 0.5;

/// Least number of steps that were tried before [`LEAST_FOUND`] applies.
const ENOUGH: usize = 8;

/// Most false alarms a year that anyone would accept: two an hour.
const MOST_PER_YEAR: f64 = 2.0 * HOURS_PER_YEAR;

/// At most this many false alarms are listed one by one.
const TOLD: usize = 6;

impl Verdict {
    /// Verdict on the tables learnt from the whole recording (`taught`), those learnt without the
    /// blocks held back (`rehearsed`), and the `trial` of the latter.
    pub fn of(taught: &Taught, rehearsed: Option<&Taught>, trial: Option<&Trial>) -> Self {
        let refused = taught.refused_cylinders();
        let mut reasons: Vec<String> =
            taught.refused.iter().map(|it| told(it, &taught.names)).collect();
        reasons.extend(taught.left_out.iter().map(LeftOut::to_string));
        let mut advice = Vec::new();
        let short = taught.told_too_short().filter(|short| match &taught.failed {
            Some((_, why)) => why == short,
            None => taught.is_far_too_short(),
        });
        let unfit = match (&taught.failed, trial) {
            _ if short.is_some() => {
                reasons.splice(0..0, short);
                advice.push(LONGER.to_owned());
                Some("the recording is too short".to_owned())
            }
            (Some((stage, why)), _) => {
                reasons.insert(0, format!("{stage}: {why}"));
                advice.push(ADVICE.to_owned());
                Some(nothing(*stage).to_owned())
            }
            (None, None) => {
                let (why, what) = untried(rehearsed);
                reasons.push(why);
                advice.push(what);
                Some("it could not be tried".to_owned())
            }
            (None, Some(trial)) => wrongs(taught, trial, &mut reasons, &mut advice),
        };
        let name = &taught.machine;
        if let Some(why) = unfit {
            let sentence = format!("{name} is not fit for use: {why}");
            return Self { fitness: Fitness::Unfit, sentence, reasons, advice };
        }
        if !refused.is_empty() {
            let longer = taught.told_too_short().map(|_| LONGER);
            advice.extend(longer.into_iter().chain([PARTLY]).map(str::to_owned));
        }
        let without: Vec<Threshold> =
            Threshold::ALL.into_iter().filter(|it| taught.is_left_out(*it)).collect();
        let except = except(&refused, &without, &taught.names);
        let finds = trial.map(finds).unwrap_or_default();
        let sentence = format!("{name} is fit for use{except}: {finds}");
        let fitness = match (&refused[..], &without[..]) {
            ([], []) => Fitness::Fit,
            _ => Fitness::Partly { cylinders: refused, without },
        };
        Self { fitness, sentence, reasons, advice }
    }
}

const ADVICE: &str = "correct what is named above and record again; `tertius identify`, \
    `calibrate` and \
                      `tune` show what each step saw (--report)";

const LONGER: &str = "record for longer; a quarter of an hour at work is enough";

const LOOK: &str = "look there (`replay --report`): is it a fault, or are readings off now and then? \
    Leave a fault out (--from, --to), or record again";

const FROZEN: &str = "a rod that rests counts as frozen: raise plausibility.frozen_speed above the largest command at which it \
    rests, or plausibility.frozen beyond the longest rest";

const PARTLY: &str = "repair the cylinder and record again, or accept the tables of the others \
    (--accept-refused): the refused one keeps its present tables";

/// What is missing when a stage has failed.
const fn nothing(stage: Stage) -> &'static str {
    match stage {
        Stage::Identify => "no model can be identified",
        Stage::Calibrate => "C2 cannot be calibrated",
        Stage::Tune => "no thresholds can be found",
    }
}

fn told(refused: &Refused, names: &MachineNames) -> String {
    let cylinder = names.cylinder(refused.cylinder);
    format!("{cylinder} is refused ({}): {}", refused.by, refused.why)
}

/// The exceptions: ` except for cylinder 3`, ` but for FDE1 and FDE2`, or both.
fn except(refused: &[u8], without: &[Threshold], names: &MachineNames) -> String {
    let mut text = String::new();
    if !refused.is_empty() {
        text += &format!(" except for {}", listed(refused, names));
    }
    if !without.is_empty() {
        text += &format!(" but for {}", Threshold::listed(without));
    }
    text
}

/// `cylinder 3, 4`, or `cylinder 3 FwdPort, 4`.
fn listed(cylinders: &[u8], names: &MachineNames) -> String {
    let all: Vec<String> = cylinders.iter().map(|number| names.short(*number)).collect();
    format!("cylinder {}", all.join(", "))
}

/// Why there was no trial, and what to do.
fn untried(rehearsed: Option<&Taught>) -> (String, String) {
    let why = rehearsed.and_then(|it| it.failed.as_ref()).map_or_else(
        || "without a third of the recording there are no tables to try".to_owned(),
        |(stage, why)| {
            format!("without the third that is held back for the trial, {stage} fails: {why}")
        },
    );
    (why, LONGER.to_owned())
}

/// What the trial found against the tables.
fn wrongs(
    taught: &Taught,
    trial: &Trial,
    reasons: &mut Vec<String>,
    advice: &mut Vec<String>,
) -> Option<String> {
    let wanted = taught.tuning.as_ref().map_or(1.0, |tuning| tuning.thresholds.per_year);
    let heard = trial.false_alarms.len() as u64;
    if beyond(heard, wanted * trial.held / 3600.0 / HOURS_PER_YEAR) {
        reasons.extend(trial.false_alarms.iter().take(TOLD).map(|alarm| {
            let (detector, t) = (alarm.detector.name(), alarm.t);
            let cylinder = taught.names.cylinder(alarm.cylinder);
            let verb = if alarm.stands { "has a standing warning" } else { "warns" };
            format!("{detector} of {cylinder} {verb} at {t:.1} s")
        }));
        // A rig that holds its load was called frozen a dozen times in five healthy minutes.
        let frozen = trial.false_alarms.iter().filter(|it| it.is_frozen()).count() as u64;
        if frozen > 0 {
            advice.push(FROZEN.to_owned());
        }
        let by_chance = heard - frozen;
        if by_chance > 0 {
            advice.push(LOOK.to_owned());
        }
        let per_year = (by_chance as f64 / trial.held * 3600.0 * HOURS_PER_YEAR).ceil();
        if by_chance > 0 && per_year <= MOST_PER_YEAR {
            advice.push(format!(
                "if the machine is like that, allow as many false alarms as it causes \
                 (--false-alarms-per-year {per_year:.0})"
            ));
        }
        let held = trial.held / 60.0;
        return Some(format!(
            "{} in {held:.1} min that were held back",
            counted(heard, "false alarm")
        ));
    }
    // By C1 alone a step of 1 mm only reaches the thesis's threshold; the remarks say what is not found.
    if taught.calibration.as_ref().is_some_and(|it| !it.has_c2()) {
        return None;
    }
    if !taught.left_out.is_empty() {
        // A step of 1 mm may be less than such a machine's own scatter: the sentence says how much is found.
        let found = trial.kinds.iter().any(|it| !it.delays.is_empty());
        return (!found).then(|| {
            advice.push(ADVICE.to_owned());
            "the detectors that are left find none of the faults that were tried".to_owned()
        });
    }
    let one = trial.kinds.iter().find(|it| it.kind == FaultKind::Step(1e-3))?;
    let blind = one.tried >= ENOUGH && (one.delays.len() as f64) < LEAST_FOUND * one.tried as f64;
    blind.then(|| {
        advice.push(ADVICE.to_owned());
        format!("it finds only {} of {} steps of 1 mm", one.delays.len(), one.tried)
    })
}

/// Whether `events` are more than chance explains where `expected` are expected.
fn beyond(events: u64, expected: f64) -> bool {
    // At least so many come with a probability below the doubt: the exact bound from below.
    events > 0 && poisson_lower(events) > expected
}

/// The exact one-sided lower bound of the expected number of events where `events` were seen.
fn poisson_lower(events: u64) -> f64 {
    // At most `events − 1` were seen with the confidence of the other side.
    poisson_upper(events - 1, DOUBT)
}

/// What the trial found, as half a sentence.
fn finds(trial: &Trial) -> String {
    let found = |it: &KindResult| {
        let median = it.median().map_or("rarely".to_owned(), |delay| format!("{delay:.2} s"));
        let KindResult { kind, delays, tried, right, .. } = it;
        format!("{kind} {median} ({} of {tried} found, {right} named)", delays.len())
    };
    let kinds: Vec<String> = trial.kinds.iter().filter(|it| it.tried > 0).map(found).collect();
    let alarms = match trial.false_alarms.len() {
        0 => "no false alarm".to_owned(),
        some => counted(some as u64, "false alarm"),
    };
    let held = trial.held / 60.0;
    format!(
        "{alarms} in {held:.1} min that were held back; warns after (median): {}",
        kinds.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::super::trial::FalseAlarm;
    use super::*;
    use tertius_core::alarm::Detector;
    use tertius_core::verdict::Fault;

    /// scipy.stats.chi2.ppf(0.05, 2 n) / 2.
    #[test]
    fn what_is_more_than_chance_is_the_exact_bound() {
        for (events, bound) in [(1, 0.051_293_294), (2, 0.355_361_51), (10, 5.425_405_697)] {
            assert!((poisson_lower(events) - bound).abs() < 1e-6, "{}", poisson_lower(events));
        }
        assert!(!beyond(0, 1e-9) && beyond(1, 1e-4) && !beyond(1, 0.06) && beyond(10, 5.4));
    }

    fn taught() -> Taught {
        Taught { machine: "It".to_owned(), ..Taught::default() }
    }

    /// A trial of 300 s in which `found` of twelve steps of 1 mm were found.
    fn trial(found: usize) -> Trial {
        let one = KindResult {
            kind: FaultKind::Step(1e-3),
            tried: 12,
            unplaced: 0,
            delays: vec![0.04; found],
            right: found,
            undecided: 0,
            wrong: 0,
        };
        Trial {
            held: 300.0,
            false_alarms: Vec::new(),
            of_process: Vec::new(),
            of_supply: None,
            known: Vec::new(),
            kinds: vec![one],
        }
    }

    #[test]
    fn one_false_alarm_where_one_a_year_is_wanted_is_too_many() {
        let sound = Verdict::of(&taught(), Some(&taught()), Some(&trial(12)));
        assert_eq!(sound.fitness, Fitness::Fit);
        assert_eq!(
            sound.sentence,
            "It is fit for use: no false alarm in 5.0 min that were held back; warns after (median): \
             step of 1 mm 0.04 s (12 of 12 found, 12 named)"
        );
        assert!(sound.reasons.is_empty() && sound.advice.is_empty());
        let mut heard = trial(12);
        let detector = Detector::Fde3;
        heard.false_alarms.push(FalseAlarm {
            t: 130.0,
            cylinder: 4,
            detector,
            fault: Fault::Abrupt,
            stands: false,
        });
        let unfit = Verdict::of(&taught(), Some(&taught()), Some(&heard));
        assert_eq!(unfit.fitness, Fitness::Unfit);
        assert_eq!(unfit.reasons, ["fde3 of cylinder 4 warns at 130.0 s"]);
    }

    #[test]
    fn a_rod_that_rests_and_counts_as_frozen_is_no_fit_machine_and_no_rate_of_false_alarms() {
        let mut heard = trial(12);
        let (detector, fault) = (Detector::Plausibility, Fault::Frozen);
        heard.false_alarms.push(FalseAlarm { t: 9.0, cylinder: 1, detector, fault, stands: false });
        let unfit = Verdict::of(&taught(), Some(&taught()), Some(&heard));
        assert_eq!(unfit.fitness, Fitness::Unfit);
        assert_eq!(unfit.reasons, ["plausibility of cylinder 1 warns at 9.0 s"]);
        assert_eq!(unfit.advice, [FROZEN]);
    }

    #[test]
    fn cylinders_that_speak_against_it_have_their_names() {
        let own = "\n[[cylinder]]\nn = 4\nname = \"AftPort\"\n";
        let text = format!("{}{own}", include_str!("../../../../config/e-type.toml"));
        let names = tertius_config::parse("machine.toml", &text).expect("it is sound").0.names();
        let mut partly = Taught { names, ..taught() };
        for cylinder in [3, 4] {
            let by = Stage::Calibrate;
            partly.refused.push(Refused { cylinder, by, why: "so".to_owned() });
        }
        let verdict = Verdict::of(&partly, Some(&taught()), Some(&trial(12)));
        assert!(
            verdict.sentence.starts_with("It is fit for use except for cylinder 3, 4 AftPort: no"),
            "{}",
            verdict.sentence
        );
        assert!(verdict.reasons[0].starts_with("cylinder 3 is refused ("), "{verdict:?}");
        assert!(verdict.reasons[1].starts_with("cylinder 4 (AftPort) is refused ("), "{verdict:?}");
    }

    #[test]
    fn a_machine_without_its_observers_is_fit_but_for_them_if_the_others_find_anything() {
        let why = "the threshold would be 6.0 mm".to_owned();
        let left_out = vec![LeftOut { threshold: Threshold::OfObservers, by: Stage::Tune, why }];
        let taught = Taught { left_out, ..taught() };
        let verdict = Verdict::of(&taught, Some(&taught), Some(&trial(1)));
        let without = vec![Threshold::OfObservers];
        assert_eq!(verdict.fitness, Fitness::Partly { cylinders: Vec::new(), without });
        assert!(
            verdict.sentence.starts_with("It is fit for use but for FDE1 and FDE2: no false"),
            "{}",
            verdict.sentence
        );
        assert_eq!(
            verdict.reasons,
            ["FDE1 and FDE2 left out (tune): the threshold would be 6.0 mm"]
        );
        let blind = Verdict::of(&taught, Some(&taught), Some(&trial(0)));
        assert_eq!(blind.fitness, Fitness::Unfit);
    }

    #[test]
    fn who_finds_little_is_not_fit() {
        let fitness = |found| Verdict::of(&taught(), Some(&taught()), Some(&trial(found))).fitness;
        assert_eq!([5, 6].map(fitness), [Fitness::Unfit, Fitness::Fit]);
    }

    #[test]
    fn a_refused_cylinder_is_named_once_and_no_trial_is_no_use() {
        let mut partly = taught();
        for by in [Stage::Identify, Stage::Calibrate] {
            partly.refused.push(Refused { cylinder: 3, by, why: "so".to_owned() });
        }
        let verdict = Verdict::of(&partly, Some(&taught()), Some(&trial(12)));
        assert_eq!(verdict.fitness, Fitness::Partly { cylinders: vec![3], without: Vec::new() });
        assert!(verdict.sentence.starts_with("It is fit for use except for cylinder 3: no false"));
        assert_eq!(verdict.reasons.len(), 2);
        let mut short = taught();
        short.failed = Some((Stage::Tune, "too little".to_owned()));
        let untried = Verdict::of(&taught(), Some(&short), None);
        assert_eq!(untried.fitness, Fitness::Unfit);
        assert!(untried.reasons[0].ends_with("tune fails: too little"));
        assert_eq!(Verdict::of(&short, None, None).fitness, Fitness::Unfit);
    }
}
