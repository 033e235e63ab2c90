//! A plan as text, as lines of JSON, and as shell commands.

use super::plan::{FleetPlan, MachinePlan, PlannedInput};
use crate::config::visible;
use crate::report::Zone;
use crate::text::counted;
use jiff::tz::TimeZone;
use serde::Serialize;
use std::fmt::Write;

/// A job: one recording of one machine.
#[derive(Serialize)]
struct JobLine<'a> {
    r#type: &'static str,
    /// From 1, over the whole fleet.
    job: usize,
    machine: &'a str,
    /// From 1, of the machine.
    index: usize,
    of: usize,
    /// The job whose state this one goes on from.
    after: Option<usize>,
    recording: String,
    is_url: bool,
    bytes: Option<u64>,
    begin: Option<String>,
    end: Option<String>,
    config: String,
    configuration: &'a str,
    history: Option<String>,
    /// What the program is called with; who runs it adds where results, state and history are.
    arguments: Vec<String>,
}

impl MachinePlan {
    /// What replays of the machine have in common, after the recording; with its name if there are `tables`.
    pub fn options(&self, tables: bool) -> Vec<String> {
        // Machines are replayed beside each other: each on a core of its own.
        let mut options = vec!["--threads".to_owned(), "1".to_owned()];
        options.extend(["--config".to_owned(), self.config.display().to_string()]);
        if tables {
            options.extend(["--machine".to_owned(), self.name.clone()]);
        }
        if let Some(interface) = &self.interface {
            options.extend(["--interface".to_owned(), interface.clone()]);
        }
        options.extend(["--format".to_owned(), "jsonl".to_owned()]);
        options
    }
}

impl PlannedInput {
    fn name(&self) -> String {
        match self {
            Self::File(recording) => recording.path.display().to_string(),
            Self::Url(url) => url.clone(),
        }
    }
}

/// A line of JSON for each job.
pub fn lines(fleet: &FleetPlan) -> String {
    let (mut text, mut job) = (String::new(), 0);
    for machine in &fleet.machines {
        for (index, input) in (1..).zip(&machine.inputs) {
            job += 1;
            let (file, is_url) = match input {
                PlannedInput::File(recording) => (Some(recording), false),
                PlannedInput::Url(_) => (None, true),
            };
            // What is somewhere else comes on standard input.
            let source = if is_url { "-".to_owned() } else { input.name() };
            let line = JobLine {
                r#type: "job",
                job,
                machine: &machine.name,
                index,
                of: machine.inputs.len(),
                after: (index > 1).then(|| job - 1),
                recording: input.name(),
                is_url,
                bytes: file.map(|it| it.bytes),
                begin: file.map(|it| it.begin.to_string()),
                end: file.and_then(|it| it.end).map(|it| it.to_string()),
                config: machine.config.display().to_string(),
                configuration: &machine.configuration,
                history: machine.history.as_ref().map(|it| it.display().to_string()),
                arguments: [vec!["replay".to_owned(), source], machine.options(true)].concat(),
            };
            // Texts and numbers always become JSON.
            text += &serde_json::to_string(&line).unwrap_or_default();
            text.push('\n');
        }
    }
    text
}

/// A list for people.
pub fn text(fleet: &FleetPlan) -> String {
    let recordings = fleet.machines.iter().map(|machine| machine.inputs.len() as u64).sum();
    let mut text = format!(
        "{}, {}. Those of a machine are replayed in this order, machines beside each other.\n",
        counted(fleet.machines.len() as u64, "machine"),
        counted(recordings, "recording"),
    );
    for machine in &fleet.machines {
        let MachinePlan { name, config, configuration, .. } = machine;
        let (name, config) = (visible(name), config.display().to_string());
        _ = writeln!(text, "\n{name}: {} (configuration {configuration})", visible(&config));
        for (index, input) in (1..).zip(&machine.inputs) {
            _ = match input {
                PlannedInput::Url(url) => writeln!(text, "{index:>6}  {}", visible(url)),
                PlannedInput::File(it) => {
                    let moment = |at| Zone::new(TimeZone::UTC, it.begin, f64::MAX).moment(at);
                    let end = it.end.map_or(String::new(), |end| format!(" to {}", moment(end)));
                    let path = it.path.display().to_string();
                    let path = visible(&path);
                    writeln!(text, "{index:>6}  {}{end}  {path}", moment(it.begin))
                }
            };
        }
    }
    text
}

/// A shell command for each machine: `fleet/fold` with its name, its history, its options and its recordings.
pub fn shell(fleet: &FleetPlan) -> String {
    let line = |machine: &MachinePlan| {
        let history =
            machine.history.as_ref().map_or("-".to_owned(), |it| it.display().to_string());
        let head = ["fleet/fold".to_owned(), machine.name.clone(), history];
        let options = machine.options(true);
        let recordings = machine.inputs.iter().map(PlannedInput::name);
        let words = head.into_iter().chain(options).chain(["--".to_owned()]).chain(recordings);
        words.map(|word| quoted(&word)).collect::<Vec<_>>().join(" ") + "\n"
    };
    fleet.machines.iter().map(line).collect()
}

/// A word as a shell reads it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=%+,@".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    let shown = visible(word);
    if shown != word {
        // Not for every shell, but for those that know of escapes: bash, ksh and zsh.
        let word = word.replace('\\', "\\\\").replace('\'', "\\'");
        return format!("$'{}'", visible(&word));
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_for_a_shell() {
        assert_eq!(quoted("a/b-1.log"), "a/b-1.log");
        assert_eq!(quoted("it's; rm $x"), "'it'\\''s; rm $x'");
        assert_eq!(quoted(""), "''");
        assert_eq!(quoted("it's\\\u{1b}[2J"), "$'it\\'s\\\\\\u001b[2J'");
    }
}
