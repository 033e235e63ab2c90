//! Questions at a terminal: Enter takes what is proposed.

use crate::failure::Failure;
use crate::propose::{Certainty, Proposal};
use std::io::{BufRead, Read};
use std::path::Path;

/// Longest answer that is read, bytes.
const LONGEST_ANSWER: u64 = 100;

/// Times that a question is asked before its default is taken.
const PATIENCE: usize = 3;

/// Keys that no question leaves out: a configuration must have them, or their values are in force without them, too.
const REQUIRED: [&str; 8] = [
    "cylinders",
    "sample_time",
    "stroke",
    "interface",
    "bitrate",
    "c1",
    "control_speed",
    "critical",
];

/// Asks about each guess that may be left out.
///
/// # Errors
/// The terminal cannot be read.
pub fn ask(proposal: &mut Proposal, answers: &mut impl BufRead) -> Result<(), Failure> {
    let mut left_out = Vec::new();
    for line in &proposal.lines {
        if line.certainty == Certainty::Sure || REQUIRED.contains(&line.key) {
            continue;
        }
        tell!("\n{}.{} = {}  ({})", line.table, line.key, line.value, line.why);
        if choose(&["take it", "leave it out"], answers)? == 1 {
            left_out.push((line.table, line.key));
        }
    }
    proposal.lines.retain(|line| !left_out.contains(&(line.table, line.key)));
    Ok(())
}

/// Whether to write the file.
///
/// # Errors
/// The terminal cannot be read.
pub fn confirm(place: &Path, answers: &mut impl BufRead) -> Result<bool, Failure> {
    tell!("\nWrite {}?", place.display());
    Ok(choose(&["yes", "no"], answers)? == 0)
}

/// The number of the choice, counted from 0; the first one is the default.
fn choose(choices: &[&str], answers: &mut impl BufRead) -> Result<usize, Failure> {
    for _ in 0..PATIENCE {
        let listed = choices.iter().enumerate();
        let listed: Vec<String> = listed.map(|(at, it)| format!("{} {it}", at + 1)).collect();
        tell!("  {} [Enter: 1]", listed.join(", "));
        let mut answer = String::new();
        let read = answers.by_ref().take(LONGEST_ANSWER).read_line(&mut answer);
        read.map_err(|error| Failure::Failed(format!("the terminal cannot be read: {error}")))?;
        let answer = answer.trim();
        let chosen = choices.iter().enumerate().position(|(at, it)| {
            answer == (at + 1).to_string() || !answer.is_empty() && it.starts_with(answer)
        });
        if let Some(chosen) = chosen.or(answer.is_empty().then_some(0)) {
            return Ok(chosen);
        }
    }
    Ok(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn enter_takes_the_first_choice_and_a_number_another() {
        let answer =
            |text: &str| choose(&["take it", "leave it out"], &mut text.as_bytes()).unwrap();
        assert_eq!(
            [answer("\n"), answer("2\n"), answer("leave\n"), answer("7\n2\n")],
            [0, 1, 1, 1]
        );
        assert_eq!(answer(""), 0, "the end of the input is no endless question");
    }
}
