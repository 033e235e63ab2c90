//! Summary of the census against its targets.

use crate::line::{Faults, Line};
use crate::plan::{Mishap, Spoilt, Transducers};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use tertius::evaluate::poisson_upper;

const HOURS_PER_YEAR: f64 = 8766.0;

/// False alarms that a year may bring: of R1 and R2, of R3, and of the sequential detectors.
const BUDGET: f64 = 3.0;

/// A figure and its target.
struct Judged {
    what: String,
    found: String,
    asked: String,
    good: bool,
}

/// The tables, and whether every target was met.
pub fn of(lines: &[Line]) -> (String, bool) {
    let (sound, faulty): (Vec<&Line>, Vec<&Line>) =
        lines.iter().partition(|line| line.spoilt.is_none());
    let fit: Vec<&Line> = sound.iter().copied().filter(|line| line.fitness == "fit").collect();
    let mut text = cells(&sound);
    text += &refusals(&sound);
    text += &spoilt(&faulty);
    text += &found(&fit);
    let mut judged = vec![share_fit(&sound), unusable(lines)];
    judged.extend(numbers(&fit));
    judged.push(orders(&fit));
    judged.extend(delays(&fit));
    judged.push(alarms(&fit));
    judged.push(learnt(&faulty));
    text += "\n| asked for | found | bound | |\n| --- | --- | --- | --- |\n";
    for Judged { what, found, asked, good } in &judged {
        let good = if *good { "met" } else { "**short**" };
        _ = writeln!(text, "| {what} | {found} | {asked} | {good} |");
    }
    let cpu = |which: usize| lines.iter().map(|line| line.cpu_s[which]).sum::<f64>();
    let count = lines.len().max(1) as f64;
    _ = writeln!(
        text,
        "\n{} commissionings; CPU time of one, mean: {:.1} s recording, {:.1} s commissioning, {:.1} s held out",
        lines.len(),
        cpu(0) / count,
        cpu(1) / count,
        cpu(2) / count
    );
    (text, judged.iter().all(|it| it.good))
}

/// Table by transducers, length and mishap: how many were fit, and the resulting numbers.
fn cells(sound: &[&Line]) -> String {
    let mut cells: BTreeMap<(Transducers, u64, Mishap), Vec<&Line>> = BTreeMap::new();
    for line in sound {
        let key = (line.transducers, line.length_s as u64, line.mishap);
        cells.entry(key).or_default().push(line);
    }
    let mut text = "| transducers | length | with | fit | levels, nats | bound of R3, mm | δ_h, mm | false alarms |\n\
                    | --- | --- | --- | --- | --- | --- | --- | --- |\n"
        .to_owned();
    for ((transducers, length, mishap), lines) in cells {
        let fit: Vec<&&Line> = lines.iter().filter(|line| line.fitness == "fit").collect();
        let levels = range(fit.iter().flat_map(|line| line.levels_nats.iter().copied()));
        let bounds = range(fit.iter().filter_map(|line| line.bound_mm));
        let highs = range(fit.iter().filter_map(|line| line.high_mm));
        let hours: f64 = fit.iter().map(|line| line.hours).sum();
        let alarms: u64 = fit.iter().flat_map(|line| &line.false_alarms).map(|(_, n)| n).sum();
        _ = writeln!(
            text,
            "| {} | {} min | {mishap:?} | {} of {} | {levels} | {bounds} | {highs} | {alarms} in {hours:.1} h |",
            transducers.name(),
            length / 60,
            fit.len(),
            lines.len()
        );
    }
    text
}

fn range(values: impl Iterator<Item = f64>) -> String {
    let values: Vec<f64> = values.collect();
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if values.is_empty() { "–".to_owned() } else { format!("{low:.2} to {high:.2}") }
}

/// Why sound recordings were not fit.
fn refusals(sound: &[&Line]) -> String {
    let mut text = String::new();
    for line in sound.iter().filter(|line| line.fitness != "fit") {
        let why = line.reasons.first().map_or("", String::as_str);
        _ = writeln!(
            text,
            "\n{}, {}: {} ({why})",
            line.number,
            line.transducers.name(),
            line.sentence
        );
    }
    text
}

/// Table of what became of recordings with a fault.
fn spoilt(faulty: &[&Line]) -> String {
    if faulty.is_empty() {
        return String::new();
    }
    let mut text = "\n| fault in the recording | of | left out | refused | learnt |\n\
                    | --- | --- | --- | --- | --- |\n"
        .to_owned();
    let mut kinds: BTreeMap<&str, Vec<&Line>> = BTreeMap::new();
    for line in faulty {
        kinds.entry(line.spoilt.map_or("none", Spoilt::words)).or_default().push(line);
    }
    for (kind, lines) in kinds {
        let count = |is: fn(&Line) -> bool| lines.iter().filter(|line| is(line)).count();
        let refused = count(|line| !line.cut && is_refused(line));
        let (cut, learnt) = (count(|line| line.cut), count(is_learnt));
        _ = writeln!(text, "| {kind} | {} | {cut} | {refused} | {learnt} |", lines.len());
    }
    text
}

fn is_refused(line: &Line) -> bool {
    line.fitness == "unfit" || line.faulty.is_some_and(|it| line.refused.contains(&it))
}

fn is_learnt(line: &Line) -> bool {
    !line.cut && !is_refused(line)
}

/// All held-out faults of a kind and of transducers.
fn gathered(fit: &[&Line]) -> BTreeMap<(Transducers, String), Faults> {
    let mut all: BTreeMap<(Transducers, String), Faults> = BTreeMap::new();
    for line in fit {
        for one in &line.faults {
            match all.get_mut(&(line.transducers, one.kind.clone())) {
                None => _ = all.insert((line.transducers, one.kind.clone()), one.clone()),
                Some(sum) => {
                    sum.tried += one.tried;
                    sum.spoilt += one.spoilt;
                    sum.delays_s.extend(&one.delays_s);
                    sum.right += one.right;
                    sum.undecided += one.undecided;
                    sum.wrong += one.wrong;
                }
            }
        }
    }
    all.values_mut().for_each(|it| it.delays_s.sort_unstable_by(f64::total_cmp));
    all
}

impl Faults {
    /// Delay within which `part` of all faults that were tried is found, s; infinite where fewer
    /// were found.
    fn quantile(&self, part: f64) -> f64 {
        let place = (part * self.tried as f64).ceil() as usize;
        self.delays_s.get(place.saturating_sub(1)).copied().unwrap_or(f64::INFINITY)
    }
}

fn found(fit: &[&Line]) -> String {
    let all = gathered(fit);
    if all.is_empty() {
        return String::new();
    }
    let mut text =
        "\n| held-out fault | transducers | found | median, s | 95 %, s | right | undecided | wrong |\n\
                    | --- | --- | --- | --- | --- | --- | --- | --- |\n"
            .to_owned();
    for ((transducers, kind), it) in &all {
        let (found, tried) = (it.delays_s.len(), it.tried);
        _ = writeln!(
            text,
            "| {kind} | {} | {found} of {tried} | {:.2} | {:.2} | {} | {} | {} |",
            transducers.name(),
            it.quantile(0.5),
            it.quantile(0.95),
            it.right,
            it.undecided,
            it.wrong
        );
    }
    text
}

fn share_fit(sound: &[&Line]) -> Judged {
    let fit = sound.iter().filter(|line| line.fitness == "fit").count();
    let share = 100.0 * fit as f64 / sound.len().max(1) as f64;
    Judged {
        what: "sound recordings fit for use".to_owned(),
        found: format!("{fit} of {}, {share:.1} %", sound.len()),
        asked: "at least 98 %".to_owned(),
        good: share >= 98.0,
    }
}

/// Checks that no written configuration is refused by `check` or by common sense.
fn unusable(lines: &[Line]) -> Judged {
    let written = lines.iter().filter(|line| line.fitness == "fit");
    let bad = |line: &&Line| {
        let levels = line.levels_nats.len() == 6
            && line.levels_nats.iter().all(|level| (18.0..=30.0).contains(level));
        let most = |value: Option<f64>| value.is_some_and(|mm| mm > 0.0 && mm <= 5.0);
        line.flaw.is_some() || !levels || !most(line.bound_mm) || !most(line.high_mm)
    };
    let count = written.filter(bad).count();
    Judged {
        what: "written though unusable".to_owned(),
        found: count.to_string(),
        asked: "none".to_owned(),
        good: count == 0,
    }
}

/// Levels, and thresholds of both grades.
fn numbers(fit: &[&Line]) -> Vec<Judged> {
    let most = |what: &str, transducers: Transducers, bound: f64, of: fn(&Line) -> Option<f64>| {
        let own = fit.iter().filter(|line| line.transducers == transducers);
        let largest = own.filter_map(|line| of(line)).fold(0.0, f64::max);
        Judged {
            what: format!("{what}, {}", transducers.name()),
            found: format!("up to {largest:.2} mm"),
            asked: format!("{bound} mm"),
            good: largest <= bound,
        }
    };
    let levels = || fit.iter().flat_map(|line| line.levels_nats.iter().copied());
    vec![
        Judged {
            what: "levels".to_owned(),
            found: format!("{} nats", range(levels())),
            asked: "18 to 30 nats".to_owned(),
            good: levels().all(|level| (18.0..=30.0).contains(&level)),
        },
        most("bound of R3", Transducers::Steady, 3.0, |line| line.bound_mm),
        most("bound of R3", Transducers::Fluctuating, 4.0, |line| line.bound_mm),
        most("bound of R3", Transducers::Uneven, 5.0, |line| line.bound_mm),
        most("bound of R3", Transducers::Coarse, 5.0, |line| line.bound_mm),
        most("δ_h", Transducers::Steady, 2.5, |line| line.high_mm),
        most("δ_h", Transducers::Fluctuating, 4.0, |line| line.high_mm),
        most("δ_h", Transducers::Uneven, 5.0, |line| line.high_mm),
        most("δ_h", Transducers::Coarse, 5.0, |line| line.high_mm),
    ]
}

/// Compares both orders of the same files.
fn orders(fit: &[&Line]) -> Judged {
    let mut pairs: BTreeMap<usize, Vec<&Line>> = BTreeMap::new();
    fit.iter().for_each(|line| pairs.entry(line.pair).or_default().push(line));
    let mut worst = (0.0_f64, String::new());
    let mut counted = 0;
    for lines in pairs.values() {
        let [one, other] = lines[..] else { continue };
        counted += 1;
        let mean = |line: &Line| {
            line.levels_nats.iter().sum::<f64>() / line.levels_nats.len().max(1) as f64
        };
        let figures = [
            ("bound", one.bound_mm.zip(other.bound_mm)),
            ("δ_h", one.high_mm.zip(other.high_mm)),
            ("level", Some((mean(one), mean(other)))),
        ];
        for (name, both) in figures {
            let Some((one, other)) = both else { continue };
            let apart = 100.0 * (one / other - 1.0).abs();
            if apart > worst.0 {
                worst = (apart, format!(" ({name}, pair {})", lines[0].pair));
            }
        }
    }
    Judged {
        what: format!("orders of the same files apart, {counted} pairs"),
        found: format!("up to {:.1} %{}", worst.0, worst.1),
        asked: "5 %".to_owned(),
        good: worst.0 <= 5.0,
    }
}

/// Delays, and suspects blamed.
fn delays(fit: &[&Line]) -> Vec<Judged> {
    let all = gathered(fit);
    let (free, usual): (Vec<&Line>, Vec<&Line>) = fit.iter().partition(|line| line.stated_free);
    let (free, usual) = (gathered(&free), gathered(&usual));
    let median =
        |of: &BTreeMap<(Transducers, String), Faults>, transducers, kind: &str, bound: f64, on| {
            let found = of.get(&(transducers, kind.to_owned())).map(|it| it.quantile(0.5));
            Judged {
                what: format!("{kind}, {}{on}, median", transducers.name()),
                found: found.map_or("not tried".to_owned(), |it| format!("{it:.3} s")),
                asked: format!("{bound} s"),
                good: found.is_none_or(|it| it <= bound),
            }
        };
    let mut judged = vec![
        median(&usual, Transducers::Steady, "step 0.5 mm", 0.08, ""),
        median(&free, Transducers::Steady, "step 0.5 mm", 0.05, " without spikes by statement"),
        median(&usual, Transducers::Fluctuating, "step 0.5 mm", 0.65, ""),
        median(&usual, Transducers::Fluctuating, "step 1 mm", 0.24, ""),
        median(&usual, Transducers::Uneven, "step 1 mm", 0.6, ""),
        median(&usual, Transducers::Coarse, "step 1 mm", 0.08, ""),
        median(&all, Transducers::Steady, "drift 0.01 mm/s", 18.0, ""),
        median(&all, Transducers::Fluctuating, "drift 0.01 mm/s", 20.0, ""),
    ];
    for (transducers, kinds, least) in [
        (Transducers::Steady, ["step 0.5 mm", "step 1 mm"], 95.0),
        (Transducers::Fluctuating, ["step 0.5 mm", "step 1 mm"], 90.0),
        (Transducers::Uneven, ["step 1 mm", "noise 0.87 mm"], 90.0),
        (Transducers::Coarse, ["step 0.75 mm", "step 1 mm"], 95.0),
    ] {
        let own = kinds.iter().filter_map(|kind| all.get(&(transducers, (*kind).to_owned())));
        let [tried, right, wrong] = own.fold([0, 0, 0], |[tried, right, wrong], it| {
            [tried + it.tried, right + it.right, wrong + it.wrong]
        });
        let part = |count: u64| 100.0 * count as f64 / tried.max(1) as f64;
        judged.push(Judged {
            what: format!("{} and larger, {}, right", kinds[0], transducers.name()),
            found: format!("{right} of {tried}, {:.1} %", part(right)),
            asked: format!("at least {least} %"),
            good: tried == 0 || part(right) >= least,
        });
        judged.push(Judged {
            what: format!("{} and larger, {}, wrong", kinds[0], transducers.name()),
            found: format!("{wrong} of {tried}, {:.1} %", part(wrong)),
            asked: "at most 1 %".to_owned(),
            good: part(wrong) <= 1.0,
        });
    }
    judged
}

/// All false alarms together, against the budget.
fn alarms(fit: &[&Line]) -> Judged {
    let hours: f64 = fit.iter().map(|line| line.hours).sum();
    let mut by: BTreeMap<&str, u64> = BTreeMap::new();
    for (detector, count) in fit.iter().flat_map(|line| &line.false_alarms) {
        *by.entry(detector).or_default() += count;
    }
    let count: u64 = by.values().sum();
    let told: Vec<String> = by.iter().map(|(name, count)| format!("{name} {count}")).collect();
    let low = if count == 0 { 0.0 } else { poisson_upper(count - 1, 0.025) };
    let high = poisson_upper(count, 0.975);
    let promised = BUDGET * hours / HOURS_PER_YEAR;
    Judged {
        what: "false alarms of the census".to_owned(),
        found: format!(
            "{count} in {hours:.1} h ({}), interval {low:.2} to {high:.2}",
            told.join(", ")
        ),
        asked: format!("{promised:.2} promised"),
        good: low <= promised,
    }
}

fn learnt(faulty: &[&Line]) -> Judged {
    let count = faulty.iter().filter(|line| is_learnt(line)).count();
    Judged {
        what: "faults in the recording that were learnt".to_owned(),
        found: format!("{count} of {}", faulty.len()),
        asked: "none".to_owned(),
        good: count == 0,
    }
}
