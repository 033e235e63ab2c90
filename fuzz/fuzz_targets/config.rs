//! Configurations of any text: read or refused with reasons at places that the text has, and what
//! is read leads to a monitor or to flaws; never a panic.

#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use tertius::config::design;
use tertius::config::{ConfigError, MAX_PROBLEMS, parse};
use tertius::dbc::Database;
use tertius::monitor::Monitor;

static DATABASE: LazyLock<Database> = LazyLock::new(|| {
    Database::parse(include_str!("../../dbc/e-type.dbc")).expect("the shipped DBC is sound")
});

fn check_refusal(error: &ConfigError, text: &str) {
    assert!((1..=MAX_PROBLEMS).contains(&error.problems().len()));
    for problem in error.problems() {
        assert!(!problem.message().is_empty());
        let place = problem.place().expect("every problem of a text has a place");
        assert!(text.get(place.span.clone()).is_some());
    }
    assert!(!format!("{:?}", error.report()).is_empty());
}

fuzz_target!(|text: &str| {
    match parse("fuzz.toml", text) {
        Err(error) => check_refusal(&error, text),
        Ok((settings, document)) => match design::judging(&settings, &DATABASE) {
            Ok(design) => drop(Monitor::new(design)),
            Err(flaws) => {
                let problems = flaws
                    .iter()
                    .map(|flaw| document.problem(&flaw.key, flaw.message.clone(), &*flaw.help));
                check_refusal(&document.refuse(problems).expect("a flaw is a refusal"), text);
            }
        },
    }
});
