//! Tables of the hand-over.

use super::{count, percent};
use crate::report::sheet::{Section, Sheet};
use tertius_lab::evaluate::handover::{
    HandoverFigures, HandoverResult, IN_TIME, Policy, PolicyFigures, WrongFigures,
};

/// What became of each fault under each policy, and the runs in which a sound transducer was blamed.
pub fn sections(result: &HandoverResult) -> [Section; 3] {
    [warned(result), policies(result), wrong(result)]
}

fn warned(result: &HandoverResult) -> Section {
    let mut sheet = Sheet::new(&[
        "transducers",
        "fault",
        "machines",
        "blamed right",
        "after (median, 95 %)",
        "black unless heard",
        "lead (median, 5 %)",
        "60 s before",
    ]);
    for figures in &result.faults {
        let HandoverFigures { blamed, delay, lead, in_time, .. } = figures;
        sheet.add_row([
            figures.grade.to_owned(),
            fault(figures),
            machines(figures),
            percent(blamed),
            pair(*delay, |it| format!("{it:.2} s")),
            stays(figures).map_or_else(String::new, |it| count(&it.black)),
            pair(*lead, |it| format!("{it:.2} s")),
            percent(in_time),
        ]);
    }
    sheet.about(format!(
        "warnings that blame a transducer in the loop, and the code blacks of the machine that takes no notice: lead, \
         from the first right one until the code black; {IN_TIME} s before: share of the code blacks"
    ))
}

fn policies(result: &HandoverResult) -> Section {
    let mut header = vec!["transducers".to_owned(), "fault".to_owned()];
    for policy in Policy::ALL {
        let name = policy.name();
        header.extend(["black", "rod, mm", "tip, mm"].map(|what| format!("{name}: {what}")));
    }
    header.extend(Policy::ALL[1..].iter().map(|policy| format!("avoided by {}", policy.letter())));
    let mut sheet = Sheet::new(&header);
    for figures in &result.faults {
        let mut cells = vec![figures.grade.to_owned(), fault(figures)];
        for PolicyFigures { black, rod, tip, .. } in &figures.policies {
            let mm = |it: [f64; 2]| format!("{:.1}, {:.1}", it[0] * 1e3, it[1] * 1e3);
            cells.extend([count(black), mm(*rod), mm(*tip)]);
        }
        let others = figures.policies.iter().filter(|it| it.policy != Policy::Stay);
        cells.extend(others.map(|it| percent(&it.avoided)));
        sheet.add_row(cells);
    }
    sheet.about(
        "the same machines under each policy: code blacks; the largest difference of the rod \
         from where it would be without the fault, before a code black, and the largest way \
         of a gangway's tip 20 m from the deck's middle, a code black's included (median, 95 \
         %)",
    )
}

fn wrong(result: &HandoverResult) -> Section {
    let mut sheet =
        Sheet::new(&["transducers", "runs", "sound one blamed", "at most (95 %)", "by"]);
    for WrongFigures { grade, runs, wrong, by } in &result.wrong {
        let by: Vec<String> = by.iter().map(|(name, count)| format!("{name} {count}")).collect();
        let runs = if *runs == "healthy" {
            "healthy".to_owned()
        } else {
            format!("{} faulty", runs.to_uppercase())
        };
        sheet.add_row([
            (*grade).to_owned(),
            runs,
            count(wrong),
            format!("{:.2} %", wrong.interval[1] * 1e2),
            if by.is_empty() { "–".to_owned() } else { by.join(", ") },
        ]);
    }
    sheet.about("runs in which a sound transducer was blamed and believed: a wrong hand-over")
}

fn fault(figures: &HandoverFigures) -> String {
    if figures.label == "none" {
        "none".to_owned()
    } else {
        format!("{} {}", figures.sensor.to_uppercase(), figures.label)
    }
}

fn machines(figures: &HandoverFigures) -> String {
    match figures.spoilt {
        0 => figures.faults.to_string(),
        spoilt => format!("{} ({spoilt} spoilt)", figures.faults - spoilt),
    }
}

fn stays(figures: &HandoverFigures) -> Option<&PolicyFigures> {
    figures.policies.iter().find(|it| it.policy == Policy::Stay)
}

fn pair(values: Option<[f64; 2]>, text: impl Fn(f64) -> String) -> String {
    values.map_or("–".to_owned(), |values| values.map(text).join(", "))
}
