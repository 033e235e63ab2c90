//! Type I steps of various sizes against the monitor's response: thousands of seeded tries for each
//! size.
//!
//! `cargo run --release --example sweep_steps -- 2000 20` plays 2000 tries a size with seed 20.

use std::fmt::Write as _;
use tertius::verdict::Fault;
use tertius_testing::detection::{Healthy, Outcome, Said, Try, tries};

const SIZES: [f64; 9] = [1e-3, 1.25e-3, 1.5e-3, 1.75e-3, 2e-3, 2.5e-3, 5e-3, 10e-3, 25e-3];
/// Failures that are shown in full for each size.
const SHOWN: usize = 12;

fn main() {
    let mut numbers = std::env::args().skip(1).map(|word| word.parse().expect("a whole number"));
    let count: u64 = numbers.next().unwrap_or(2000);
    let seed: u64 = numbers.next().unwrap_or(20);
    let healthy = Healthy::load();
    println!(
        "{count} tries a size, seed {seed}, engaged {:.2} to {:.2} s",
        healthy.engaged[0], healthy.engaged[1]
    );
    println!(
        "size/mm  at once %  later %  missed %  blamed right %  undecided %  wrong %  abrupt %  \
         FDE3 at once %"
    );
    let mut failures = String::new();
    for size in SIZES {
        row(&healthy, count, seed, size, &mut failures);
    }
    println!("\n{failures}");
}

fn row(healthy: &Healthy, count: u64, seed: u64, size: f64, failures: &mut String) {
    let (mut at_once, mut later, mut right, mut wrong, mut abrupt, mut third) = (0, 0, 0, 0, 0, 0);
    let mut shown = 0;
    for one in tries(healthy, count, seed, 2.0) {
        let spec = format!(
            "step,cylinder={},sensor={},at={},size={}",
            one.cylinder,
            one.sensor(),
            one.t,
            one.sign * size
        );
        let outcome = healthy.play_fault(&spec, one.t, 2.0, one.number);
        let said = Said::of(&outcome, &one);
        let found = said.delay.is_some();
        let soon = said.at_once(healthy);
        let blamed = said.blames(one.suspect);
        at_once += u64::from(soon);
        later += u64::from(found && !soon);
        right += u64::from(found && blamed);
        wrong += u64::from(said.wrongly > 0);
        abrupt += u64::from(said.finally.is_some_and(|finding| finding.fault == Fault::Abrupt));
        let ts = healthy.sample_time().as_seconds();
        third += u64::from(said.difference_delay.is_some_and(|delay| delay < ts));
        let failed = !soon || !blamed || said.beside > 0;
        if failed && size > 1.6e-3 && shown < SHOWN {
            shown += 1;
            tell(failures, &spec, &one, &said, &outcome);
        }
    }
    let found = at_once + later;
    let percent = |n: u64, of: u64| 100.0 * n as f64 / of.max(1) as f64;
    println!(
        "{:7.2} {:10.2} {:8.2} {:9.2} {:15.2} {:12.2} {:8.2} {:9.2} {:15.2}",
        size * 1e3,
        percent(at_once, count),
        percent(later, count),
        percent(count - found, count),
        percent(right, found),
        percent(found - right - wrong.min(found - right), found),
        percent(wrong, count),
        percent(abrupt, found),
        percent(third, count),
    );
}

/// A failure with the residuals around its first faulty frame, mm.
fn tell(text: &mut String, spec: &str, one: &Try, said: &Said, outcome: &Outcome) {
    let first = outcome.first_faulty.expect("a step changes frames");
    writeln!(text, "try {}: {spec}\n  {said:?}", one.number).unwrap();
    for warning in &outcome.warnings {
        let (t, finding) = (warning.timestamp.since(first).as_seconds(), warning.finding);
        writeln!(
            text,
            "  {t:+.4} s cylinder {} {} {} {} {} {:?}",
            warning.cylinder,
            warning.detector.name(),
            warning.state.name(),
            finding.fault.name(),
            finding.suspect.name(),
            finding.residual
        )
        .unwrap();
    }
    let records = outcome.records.iter().filter(|record| record.cylinder == one.cylinder);
    for record in records {
        let t = record.timestamp.since(first).as_seconds();
        if (-0.1..0.12).contains(&t) {
            let mm = |r: Option<f64>| r.map_or("none".to_owned(), |r| format!("{:+.3}", r * 1e3));
            let [r1, r2, r3] = record.residuals.map(mm);
            writeln!(text, "    {t:+.4}  R1 {r1}  R2 {r2}  R3 {r3}").unwrap();
        }
    }
}
