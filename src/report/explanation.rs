//! How suspects were named, as text.

use super::wording::counted;
use crate::config::MachineNames;
use crate::monitor::{Answer, Explanation};
use crate::story;
use std::fmt::Write;

/// The findings at `at` seconds after the first frame, and each rule that was asked whose fault they are.
pub fn text(explained: &[Explanation], names: &MachineNames, at: f64) -> String {
    if explained.is_empty() {
        return format!("At {at} s no detector has found anything.\n");
    }
    let mut text = format!("{} at {at} s\n", counted(explained.len() as u64, "finding"));
    for one in explained {
        let Explanation { cylinder, detector, finding, answers } = one;
        let (residual, threshold) = (finding.residual, finding.threshold);
        let size = residual.map_or(String::new(), |it| format!(", {}", story::millimetres(it)));
        let limit =
            threshold.map_or(String::new(), |it| format!(", limit {}", story::millimetres(it)));
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
