//! How suspects were named, as text.

use super::counted;
use super::wording::capitalised;
use crate::story;
use std::fmt::Write;
use tertius_config::MachineNames;
use tertius_core::monitor::{Answer, Explained, Explanation};
use tertius_core::text::Millimetres;

/// The findings at `at` seconds after the first frame, with the answer of each rule that was asked for the suspect.
pub fn text(explained: &Explained, names: &MachineNames, at: f64) -> String {
    let count = explained.findings.len() as u64;
    let mut text = match count {
        0 => format!("At {at} s no detector has found anything.\n"),
        _ => format!("{} at {at} s\n", counted(count, "finding")),
    };
    for number in &explained.unjudged {
        let cylinder = capitalised(&names.cylinder(*number));
        _ = writeln!(text, "{cylinder} was not judged completely at that time.");
    }
    for one in &explained.findings {
        let Explanation { cylinder, detector, finding, answers } = one;
        let (residual, threshold) = (finding.residual, finding.threshold);
        let size = residual.map_or(String::new(), |it| format!(", {}", Millimetres(it)));
        let limit = threshold.map_or(String::new(), |it| format!(", limit {}", Millimetres(it)));
        let (cylinder, detector) = (names.cylinder(*cylinder), detector.label());
        let kind = story::what(finding.suspect, finding.fault);
        let suspect = story::suspect_word(finding.suspect);
        let rule = finding.rule;
        _ = write!(
            text,
            "\n{cylinder}, {detector}: {kind}{size}{limit}\n  suspect {suspect} by {}: {}\n",
            rule.name(),
            rule.reason()
        );
        for Answer { rule, suspect: answer } in answers {
            let said = answer.map_or("does not apply", story::suspect_word);
            _ = writeln!(text, "    {:<24} {said}", rule.name());
        }
    }
    text
}
