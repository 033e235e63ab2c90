//! Score of the gateway.

use super::listener::Warning;
use super::programme::Programme;
use super::wording;
use std::collections::BTreeMap;

/// What became of a fault.
#[derive(Clone, Debug, Default)]
struct Outcome {
    /// Delay after the fault's beginning, s.
    found: Option<f64>,
    suspect: String,
    named: String,
    /// Whether a plausibility check found it.
    known: bool,
}

/// Identity of a warning: cylinder, detector, and the suspect of plausibility, which judges each
/// transducer.
type Key = (i64, String, Option<String>);

/// Contents of a warning apart from its residual.
type Tells = [String; 3];

/// Follows the warnings on the bus.
pub struct Score {
    programme: Programme,
    outcomes: Vec<Outcome>,
    standing: BTreeMap<Key, Tells>,
    /// Number of warnings raised without a fault.
    unfounded: u64,
}

impl Score {
    pub fn new(programme: Programme) -> Self {
        let outcomes = vec![Outcome::default(); programme.acts.len()];
        Self { programme, outcomes, standing: BTreeMap::new(), unfounded: 0 }
    }

    /// Takes a warning that was on the bus at `at`, s; returns whether it contains anything new.
    pub fn take(&mut self, at: f64, warning: &Warning) -> bool {
        let whom = (warning.detector == "plausibility").then(|| warning.suspect.clone());
        let key = (warning.cylinder, warning.detector.clone(), whom);
        if !warning.raised {
            return self.standing.remove(&key).is_some();
        }
        let tells = [&warning.fault, &warning.suspect, &warning.level].map(Clone::clone);
        let before = self.standing.insert(key, tells.clone());
        self.judge(at, warning, before.is_none());
        before.as_ref() != Some(&tells)
    }

    fn judge(&mut self, at: f64, warning: &Warning, is_new: bool) {
        let programme = &self.programme;
        let owed = (0..programme.acts.len()).find(|&index| {
            let [from, until] = programme.window(index);
            let counts = (from..until + programme.aftermath).contains(&at);
            programme.acts[index].cylinder == warning.cylinder && counts
        });
        let Some(index) = owed else { return self.unfounded += u64::from(is_new) };
        let [from, until] = programme.window(index);
        if at < until {
            let outcome = &mut self.outcomes[index];
            outcome.found.get_or_insert(at - from);
            // FDE3 stays undecided beside a check that knows which transducer it is, and what it knows
            // goes before what the others make of it.
            let decides = is_decided(&warning.suspect) || !is_decided(&outcome.suspect);
            let knows = is_decided(&warning.suspect) && warning.detector == "plausibility";
            if knows || (decides && !outcome.known) {
                outcome.known |= knows;
                outcome.suspect.clone_from(&warning.suspect);
                outcome.named.clone_from(&warning.fault);
            }
        }
    }

    /// Whether fault `index` was found as announced; `None` if it was not over at `at`, s.
    fn over(&self, index: usize, at: f64) -> Option<bool> {
        let outcome = &self.outcomes[index];
        let act = &self.programme.acts[index];
        // A calibrated monitor may decide what the thesis's thresholds leave undecided.
        let is_right = [act.suspect, act.faulty].contains(&&*outcome.suspect);
        let right = outcome.found.is_some() && is_right;
        (at >= self.programme.window(index)[1]).then_some(right)
    }

    /// A table of the faults, and of what was found by `at`, s.
    pub fn table(&self, at: f64) -> Vec<String> {
        let row = |title: &str, found: &str, named: &str, suspect: &str| {
            format!("{title:<38} {found:>7}  {named:<12}  {suspect}")
        };
        let mut rows = vec![row("fault", "after", "named", "suspect")];
        for (index, (act, outcome)) in self.programme.acts.iter().zip(&self.outcomes).enumerate() {
            rows.push(match (self.over(index, at), outcome.found) {
                (None, _) => row(&act.title, "–", "", "not over"),
                (Some(_), None) => row(&act.title, "never", "", "NOT FOUND"),
                (Some(right), Some(found)) => {
                    let whom = wording::suspect(&outcome.suspect);
                    let suspect = format!("{whom}, {}", verdict(right));
                    row(&act.title, &format!("{found:.3} s"), &outcome.named, &suspect)
                }
            });
        }
        rows
    }

    /// Number of faults over at `at`, s, that were found as announced, and number of faults over.
    pub fn tally(&self, at: f64) -> [usize; 2] {
        let acts = 0..self.programme.acts.len();
        let over: Vec<bool> = acts.filter_map(|index| self.over(index, at)).collect();
        [over.iter().filter(|right| **right).count(), over.len()]
    }

    pub const fn unfounded(&self) -> u64 {
        self.unfounded
    }
}

fn is_decided(suspect: &str) -> bool {
    matches!(suspect, "c1" | "c2")
}

const fn verdict(right: bool) -> &'static str {
    if right { "right" } else { "WRONG" }
}

#[cfg(test)]
mod tests {
    use super::super::listener::Limit;
    use super::super::programme::tests::programme;
    use super::*;

    fn warning(cylinder: i64, detector: &str, suspect: &str) -> Warning {
        Warning {
            cylinder,
            detector: detector.to_owned(),
            fault: "abrupt".to_owned(),
            suspect: suspect.to_owned(),
            level: "yellow".to_owned(),
            raised: true,
            residual: Some(0.002),
            threshold: Some(Limit::Of(0.001)),
        }
    }

    /// Row of act `index`, from 0, at `at`.
    fn row(score: &Score, index: usize, at: f64) -> String {
        score.table(at)[index + 1].clone()
    }

    #[test]
    fn a_fault_is_found_by_a_warning_in_its_time_that_blames_the_right_one() {
        let programme = programme(6);
        let [from, until] = programme.window(0);
        let mut score = Score::new(programme.clone());
        assert!(row(&score, 0, until - 0.1).ends_with("not over"));
        assert!(row(&score, 0, until).ends_with("NOT FOUND"));
        assert!(score.take(from + 0.5, &warning(3, "fde3", "undecided")));
        assert!(row(&score, 0, until).ends_with("WRONG"));
        assert_eq!(score.tally(until), [0, 1]);
        assert!(score.take(from + 0.6, &warning(3, "fde1", "c1")));
        assert!(score.take(from + 0.7, &warning(3, "plausibility", "undecided")));
        let found = row(&score, 0, until);
        assert!(found.contains("0.500 s  abrupt ") && found.ends_with("  C1, right"), "{found}");
        assert_eq!((score.tally(until), score.unfounded()), ([1, 1], 0));
        // What it leaves behind is no find, and no fault of its own.
        let mut late = Score::new(programme);
        late.take(until + 0.1, &warning(3, "fde1", "c1"));
        assert!(row(&late, 0, until + 1.0).ends_with("NOT FOUND"));
        assert_eq!(late.unfounded(), 0);
    }

    #[test]
    fn a_warning_without_a_fault_is_counted_once_however_often_it_is_repeated() {
        let programme = programme(6);
        let aftermath = programme.aftermath;
        let [from, until] = programme.window(0);
        let mut score = Score::new(programme);
        assert!(score.take(from + 0.5, &warning(4, "fde1", "c1")));
        assert!(!score.take(from + 1.5, &warning(4, "fde1", "c1")), "a repetition");
        assert!(score.take(from + 1.6, &warning(4, "fde1", "process")), "a change");
        assert_eq!(score.unfounded(), 1);
        let cleared = Warning { raised: false, ..warning(4, "fde1", "process") };
        assert!(score.take(from + 2.0, &cleared));
        assert!(!score.take(from + 2.0, &cleared), "it was cleared already");
        score.take(until + aftermath, &warning(3, "fde1", "c1"));
        assert_eq!(score.unfounded(), 2, "long after the fault's end");
        assert_eq!(score.tally(until), [0, 1]);
    }
}
