//! What was reported of a cylinder's last transducer.

use tertius_core::alarm::detector::PLACES;
use tertius_core::alarm::{State, Warning};
use tertius_core::incident::Incident;
use tertius_core::time::{Span, Timestamp};
use tertius_core::verdict::Suspect;

/// How long a fault is watched, s.
pub(super) const WATCH: f64 = 10.0;

/// Which transducer of a cylinder is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pair {
    /// Number of the cylinder, counted from 1.
    pub cylinder: u8,
    /// The last transducer and the other one, C1 and C2 or the reverse.
    pub last: Suspect,
    pub other: Suspect,
}

/// What a monitor reported.
#[derive(Clone, Copy)]
pub(super) struct Heard<'a> {
    pub warnings: &'a [Warning],
    pub incidents: &'a [Incident],
    /// Cycles in which the estimate of the cylinder was valid and wrong.
    pub wrong: &'a [Timestamp],
}

/// What was reported of one fault of the last transducer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LastOutcome {
    /// A warning named the last transducer when its fault began.
    pub spoilt: bool,
    /// From the fault to the first warning, or incident of its own, that names the last transducer, s.
    pub delay: Option<f64>,
    /// Whether any warning said after the fault that the suspect is undecided, the process, or the other transducer.
    pub otherwise: [bool; 3],
    /// How long the estimate was valid and wrong, s.
    pub wrong: f64,
    /// Whether that was longer than it took to name the last transducer.
    pub outlasted: bool,
}

/// What was reported of a machine whose last transducers have no fault.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LastQuiet {
    /// How often a cylinder's last transducer was named.
    pub named: u64,
    /// Warnings that named none of the transducers that the cylinder has or had.
    pub otherwise: u64,
    /// Cycles since the outages, of all cylinders together.
    pub cycles: u64,
}

/// Suspects of the warnings of a cylinder that stand, by their places.
#[derive(Default)]
struct Standing([Option<Suspect>; PLACES]);

impl Standing {
    /// The suspect of `warning`, if no warning at its place named it before.
    fn news(&mut self, warning: &Warning) -> Option<Suspect> {
        let said = (warning.state != State::Cleared).then_some(warning.finding.suspect);
        let before = std::mem::replace(&mut self.0[warning.place], said);
        said.filter(|_| said != before)
    }

    fn names(&self, suspect: Suspect) -> bool {
        self.0.contains(&Some(suspect))
    }
}

impl LastOutcome {
    /// What was reported of a fault of the last transducer of `pair` that began at `onset`; `sample_time` in s.
    pub(super) fn read(heard: Heard<'_>, pair: Pair, onset: Timestamp, sample_time: f64) -> Self {
        let end = onset.after(Span::from_seconds(WATCH));
        let mut outcome = Self::default();
        let mut standing = Standing::default();
        let mut named: Option<Timestamp> = None;
        let own = heard.warnings.iter().filter(|it| it.cylinder == pair.cylinder);
        for warning in own.filter(|it| it.timestamp <= end) {
            let news = standing.news(warning);
            if warning.timestamp < onset {
                outcome.spoilt = standing.names(pair.last);
                continue;
            }
            match news {
                None => {}
                Some(Suspect::Undecided) => outcome.otherwise[0] = true,
                Some(Suspect::Process) => outcome.otherwise[1] = true,
                Some(suspect) if suspect == pair.last => {
                    named.get_or_insert(warning.timestamp);
                }
                Some(_) => outcome.otherwise[2] = true,
            }
        }
        let told = heard.incidents.iter().find(|it| {
            it.scope.has(pair.cylinder.into()) && it.suspect == pair.last && it.begin >= onset
        });
        let told = told.map(|it| it.timestamp).filter(|at| *at <= end);
        let named = named.into_iter().chain(told).min();
        let wrong = heard.wrong.iter().filter(|at| (onset..end).contains(*at)).count() as f64;
        outcome.delay = named.map(|at| at.since(onset).as_seconds());
        outcome.wrong = wrong * sample_time;
        // In whole cycles, as estimates are made.
        outcome.outlasted = wrong > outcome.delay.map_or(0.0, |it| (it / sample_time).ceil());
        outcome
    }
}

impl LastQuiet {
    /// Counts what `warnings` say of the cylinder of `pair` after its outage, which began at `from`.
    pub(super) fn count(&mut self, warnings: &[Warning], pair: Pair, from: Timestamp) {
        let mut standing = Standing::default();
        for warning in warnings.iter().filter(|it| it.cylinder == pair.cylinder) {
            let was_named = standing.names(pair.last);
            let news = standing.news(warning);
            if warning.timestamp >= from {
                self.named += u64::from(news == Some(pair.last) && !was_named);
                let neither = news.is_some_and(|it| it != pair.last && it != pair.other);
                self.otherwise += u64::from(neither && warning.state == State::Raised);
            }
        }
    }

    /// Adds what was reported of another machine.
    pub(super) const fn add(&mut self, other: Self) {
        self.named += other.named;
        self.otherwise += other.otherwise;
        self.cycles += other.cycles;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tertius_core::alarm::{Finding, Level, register};
    use tertius_core::blame::Rule;
    use tertius_core::verdict::Fault;

    const PAIR: Pair = Pair { cylinder: 2, last: Suspect::C2, other: Suspect::C1 };

    fn at(seconds: f64) -> Timestamp {
        Timestamp::from_nanos(0).after(Span::from_seconds(seconds))
    }

    fn warning(seconds: f64, place: usize, state: State, suspect: Suspect) -> Warning {
        let finding = Finding {
            fault: Fault::Abrupt,
            suspect,
            rule: Rule::OneObserver,
            level: Level::Yellow,
            residual: None,
            threshold: None,
            evidence: None,
            device: None,
        };
        let detector = register::DETECTORS[place];
        Warning { timestamp: at(seconds), cylinder: 2, detector, place, state, finding }
    }

    fn read(warnings: &[Warning], wrong: &[Timestamp]) -> LastOutcome {
        let heard = Heard { warnings, incidents: &[], wrong };
        LastOutcome::read(heard, PAIR, at(100.0), 0.02)
    }

    #[test]
    fn only_what_is_new_after_the_fault_counts_for_it() {
        let before = warning(90.0, 0, State::Raised, Suspect::C1);
        let again = warning(100.5, 0, State::Changed, Suspect::C1);
        let undecided = warning(101.0, 2, State::Raised, Suspect::Undecided);
        let named = warning(103.0, 2, State::Changed, Suspect::C2);
        let late = warning(111.0, 0, State::Changed, Suspect::Process);
        let outcome = read(&[before, again, undecided, named, late], &[]);
        assert_eq!((outcome.delay, outcome.spoilt), (Some(3.0), false));
        assert_eq!(outcome.otherwise, [true, false, false]);
        let of_another = Warning { cylinder: 3, ..named };
        assert_eq!(read(&[of_another], &[]), LastOutcome::default());
    }

    #[test]
    fn a_transducer_that_was_named_before_spoils_the_trial_unless_that_is_over() {
        let named = warning(99.0, 1, State::Raised, Suspect::C2);
        let cleared = warning(99.5, 1, State::Cleared, Suspect::C2);
        assert!(read(&[named], &[]).spoilt && !read(&[named, cleared], &[]).spoilt);
    }

    #[test]
    fn an_estimate_may_be_wrong_until_the_cycle_in_which_the_transducer_is_named() {
        let found = [warning(100.027, 1, State::Raised, Suspect::C2)];
        let wrong = [99.98, 100.0, 100.02, 100.04].map(at);
        assert_eq!(
            (read(&found, &wrong[..3]).wrong, read(&found, &wrong[..3]).outlasted),
            (0.04, false)
        );
        assert!(read(&found, &wrong).outlasted && read(&[], &wrong[..2]).outlasted);
        assert!(!read(&[], &wrong[..1]).outlasted, "it was wrong before the fault");
    }

    #[test]
    fn a_name_that_stands_is_one_false_alarm_until_it_is_withdrawn() {
        let mut quiet = LastQuiet::default();
        let of = |seconds, place, state| warning(seconds, place, state, Suspect::C2);
        let warnings = [
            of(101.0, 0, State::Raised),
            of(102.0, 1, State::Raised),
            of(103.0, 0, State::Cleared),
            of(104.0, 1, State::Cleared),
            of(105.0, 1, State::Raised),
            warning(106.0, 2, State::Raised, Suspect::C1),
            warning(107.0, 3, State::Raised, Suspect::Process),
        ];
        quiet.count(&warnings, PAIR, at(100.0));
        assert_eq!(quiet, LastQuiet { named: 2, otherwise: 1, cycles: 0 });
    }
}
