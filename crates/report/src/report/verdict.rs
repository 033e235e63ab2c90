//! The verdict of a replay: what a person wants to know first.

use super::zone::Zone;
use super::{Summary, counted};
use crate::story;
use tertius_config::MachineNames;
use tertius_core::monitor::cylinder::{Blank, NotJudged};
use tertius_core::sample::Transducer;
use tertius_core::sequential::Unknown;
use tertius_core::text::listed;
use tertius_core::time::{Span, Timestamp};

/// Shortest time without judgement that is told.
const SHORTEST: Span = Span::from_nanos(1_000_000_000);

/// Shortest time that an observer takes to settle that is told: at the beginning it always has to.
const SETTLING: Span = Span::from_nanos(5_000_000_000);

/// Most times without judgement that are told; further ones are counted.
const TOLD: usize = 3;

/// Times that differ by less are one: the cylinders of a cycle are evaluated one after another.
const ALIKE: i64 = 100_000_000;

/// Times in which the observers of a machine did not judge, the longest of each.
#[derive(Clone, Debug, Default)]
pub struct Blanks {
    /// Cylinder number, from 1, and its blank.
    pub blanks: Vec<(usize, Blank)>,
    /// Cycles that the observers of each cylinder did not judge; `None` for a transducer that is not configured.
    pub unjudged: Vec<[Option<u64>; 2]>,
}

/// The verdict, in lines.
pub fn lines(summary: &Summary<'_>, zone: &Zone) -> Vec<String> {
    let found = incidents(summary, zone);
    if !summary.judgement.is_judged() {
        // None is no news where nothing was judged; R3 may have found one all the same.
        return if summary.incidents.count() == 0 { Vec::new() } else { vec![found] };
    }
    let mut lines = vec![found];
    if summary.observes {
        lines.push(format!("The observers judged {} of the time.", judged(summary)));
    }
    lines.extend(summary.switched_off.map(|off| format!("Switched off: {off}.")));
    lines.extend(sequential(summary));
    lines.extend(process(summary));
    lines.extend(summary.blanks.told(summary.names, summary.tallies.len(), zone));
    lines
}

fn incidents(summary: &Summary<'_>, zone: &Zone) -> String {
    let incidents = summary.incidents;
    let length = story::span(Span::from_seconds(summary.recorded));
    let Some(worst) = incidents.worst() else {
        return format!("No incident in {length}.");
    };
    let at = worst.worst().map_or(worst.begin, |(_, peak)| peak.at);
    let which = if incidents.count() == 1 { ": " } else { ". Worst: " };
    let (count, line) = (counted(incidents.count(), "incident"), story::line(worst, summary.names));
    format!("{count} in {length}{which}{line} at {}.", zone.moment(at))
}

/// Part of the cycles of all transducers that their observers judged.
fn judged(summary: &Summary<'_>) -> String {
    let (mut judged, mut cycles) = (0, 0);
    for (tally, unjudged) in summary.tallies.iter().zip(&summary.blanks.unjudged) {
        for unjudged in unjudged.iter().flatten() {
            cycles += tally.cycles;
            judged += tally.cycles - unjudged;
        }
    }
    share(judged, cycles)
}

/// A part of the whole in words; only what is all of it is shown as all.
fn share(part: u64, whole: u64) -> String {
    match part {
        0 => "none".to_owned(),
        part if part == whole => "all".to_owned(),
        part => format!("{:.1} %", (1e2 * part as f64 / whole as f64).min(99.9)),
    }
}

/// How long the sequential detectors judged, and why not otherwise; `None` without one.
fn sequential(summary: &Summary<'_>) -> Option<String> {
    let coverages = summary.tallies.iter().filter_map(|tally| tally.sequential);
    let (mut judged, mut unknown) = (0, [0; Unknown::ALL.len()]);
    for coverage in coverages {
        judged += coverage.judged;
        unknown.iter_mut().zip(coverage.unknown).for_each(|(sum, cycles)| *sum += cycles);
    }
    let cycles = judged + unknown.iter().sum::<u64>();
    if cycles == 0 {
        return None;
    }
    let mut text = format!("The sequential detectors judged {} of the time", share(judged, cycles));
    let reasons = super::wording::UNKNOWN.into_iter().zip(unknown);
    let reasons: Vec<String> = reasons
        .filter(|(_, count)| 1000 * count >= cycles)
        .map(|(reason, count)| format!("{reason} {}", share(count, cycles)))
        .collect();
    if !reasons.is_empty() {
        text += &format!("; {}", reasons.join(", "));
    }
    Some(text + ".")
}

/// How much of the monitored time the process detectors judged; `None` without one.
fn process(summary: &Summary<'_>) -> Option<String> {
    let coverages: Vec<_> = summary.tallies.iter().filter_map(|tally| tally.process).collect();
    let told: Vec<String> = (0..)
        .zip(super::wording::RELATIONS)
        .filter_map(|(which, name)| {
            let own = coverages.iter().filter_map(|it| Some([it.judged()[which]?, it.monitored]));
            let [judged, monitored] =
                own.reduce(|[a, b], [judged, monitored]| [a + judged, b + monitored])?;
            Some(format!("by {name} {}", share(judged, monitored)))
        })
        .collect();
    let judged =
        || format!("The process detectors judged {} of the monitored time.", listed(&told));
    (!told.is_empty()).then(judged)
}

impl Blanks {
    /// The longest ones in words and in the order of time, those of several transducers at the same time together.
    fn told(&self, names: &MachineNames, cylinders: usize, zone: &Zone) -> Vec<String> {
        let mut groups: Vec<(Blank, Vec<(usize, Transducer)>)> = Vec::new();
        for (number, blank) in &self.blanks {
            let length = blank.until.since(blank.from);
            let is_settling = blank.reason == NotJudged::Settling;
            if length < if is_settling { SETTLING } else { SHORTEST } {
                continue;
            }
            let near = |a: Timestamp, b: Timestamp| a.since(b).as_nanos().abs() < ALIKE;
            let same = groups.iter_mut().find(|(of, _)| {
                of.reason == blank.reason
                    && near(of.from, blank.from)
                    && near(of.until, blank.until)
            });
            match same {
                Some((_, who)) => who.push((*number, blank.transducer)),
                None => groups.push((*blank, vec![(*number, blank.transducer)])),
            }
        }
        groups.sort_by_key(|(blank, _)| std::cmp::Reverse(blank.until.since(blank.from)));
        let left_out = groups.len().saturating_sub(TOLD);
        groups.truncate(TOLD);
        groups.sort_by_key(|(blank, _)| blank.from);
        let mut lines: Vec<String> = groups
            .iter()
            .map(|(blank, who)| {
                format!(
                    "Not judged: {} from {} to {} ({}).",
                    those(names, who, cylinders),
                    zone.time(blank.from),
                    zone.time(blank.until),
                    reason(blank.reason)
                )
            })
            .collect();
        if left_out > 0 {
            lines.push(format!("Not judged {} more.", super::times(left_out as u64)));
        }
        lines
    }
}

/// Whose readings were not judged: `cylinder 3's C2`, `cylinder 3`, `every cylinder`.
fn those(names: &MachineNames, who: &[(usize, Transducer)], cylinders: usize) -> String {
    let both =
        |n: usize| Transducer::ALL.into_iter().all(|transducer| who.contains(&(n, transducer)));
    if cylinders > 1 && (1..=cylinders).all(both) {
        return "every cylinder".to_owned();
    }
    let first = |n: usize| who.contains(&(n, Transducer::C1));
    if cylinders > 1 && who.len() == cylinders && (1..=cylinders).all(first) {
        return "every cylinder's C1".to_owned();
    }
    let mut told = Vec::new();
    for n in 1..=cylinders {
        let of = |transducer| who.contains(&(n, transducer));
        let one = |it| match names.of_cylinder(n) {
            Some(_) => format!("{} of {}", names.transducer(n, it), names.cylinder(n)),
            None => format!("{}'s {}", names.cylinder(n), names.transducer(n, it)),
        };
        match (of(Transducer::C1), of(Transducer::C2)) {
            (true, true) => told.push(names.cylinder(n)),
            (true, false) => told.push(one(Transducer::C1)),
            (false, true) => told.push(one(Transducer::C2)),
            (false, false) => {}
        }
    }
    told.join(", ")
}

const fn reason(reason: NotJudged) -> &'static str {
    match reason {
        NotJudged::State => "the platform was in no monitored state",
        NotJudged::NoReadings => "no readings",
        NotJudged::Doubtful => "its frames could not be relied on",
        NotJudged::Implausible => "the readings were not plausible",
        NotJudged::NoCommand => "no command",
        NotJudged::Settling => "the observer had not settled",
        NotJudged::NoBaseline => "the sequential detector had no baseline",
    }
}
