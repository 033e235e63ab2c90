//! The configuration: from a TOML file to settings that are known to be sound.
//!
//! [`load`] reads the file and the DBC beside it; [`parse`] does the same without a file system. A
//! file passes three stages: the walk over its keys and the types of [`settings`], which are declared
//! together, key by key, and the relations between values. A file that does not pass is refused with
//! everything that was found ([`ConfigError`]). [`design`] turns settings and the signals of a DBC
//! into what a monitor is made from.

mod apply;
pub mod design;
pub mod devices;
mod document;
pub mod edit;
mod identity;
mod json_schema;
mod kinds;
mod loader;
mod names;
mod overrides;
mod portable;
mod problem;
pub mod reference;
mod relations;
mod relocate;
mod resolve;
mod schema;
pub mod settings;
mod text;
pub mod units;
mod visible;
mod walk;

use serde::Deserialize;
use toml::de::{DeTable, Deserializer};

pub use document::Document;
pub use identity::{Fingerprint, Fingerprints};
pub use json_schema::json_schema;
pub use loader::{Loaded, MAX_DBC_SIZE, Sheet, load, load_text, load_with};
pub use names::{CylinderNames, MachineNames};
pub use overrides::{Override, OverrideOrigin, Overrides};
pub use portable::{MACHINE_FILE, PortableFile};
pub use problem::{ConfigError, MAX_PROBLEMS, Place, Problem};
pub use relocate::relocate;
pub use settings::Settings;
pub use text::WEAK_TOKENS;
pub use visible::{visible, visible_lines};

pub use text::LONGEST_TAG;

use problem::Problems;
use settings::ROOT;

/// The longest configuration file, bytes.
pub const MAX_SIZE: usize = 1 << 20;

/// Settings from the text of a configuration; `name` is what problems call the file.
///
/// # Errors
/// Everything that is wrong with the text, at most [`MAX_PROBLEMS`] in full. A stage runs
/// only when the earlier ones have passed: text that is not TOML has no keys to judge, and values
/// are compared with each other once every key is there and has its type.
pub fn parse(name: &str, text: &str) -> Result<(Settings, Document), ConfigError> {
    parse_with(name, text, &Overrides::default())
}

/// As [`parse`], with values of single keys from outside of the text.
///
/// # Errors
/// See [`parse`]; a problem with an override names it instead of a place in the file.
pub fn parse_with(
    name: &str,
    text: &str,
    overrides: &Overrides,
) -> Result<(Settings, Document), ConfigError> {
    if text.len() > MAX_SIZE {
        return Err(too_long(name));
    }
    let mut document = Document::new(name, text);
    let mut problems = Problems::default();
    let (mut root, errors) = DeTable::parse_recoverable(text);
    if !errors.is_empty() {
        let configures = root.get_ref().keys().any(|name| ROOT.key(name.get_ref()).is_some());
        if !configures {
            return Err(no_configuration(&document, &errors));
        }
        // What follows from the first ones says less and less.
        for error in errors.iter().take(MAX_SYNTAX) {
            problems.push_with(|| not_toml(&document, error));
        }
        return Err(document.error(problems));
    }
    if !overrides.is_empty() {
        let effective = apply::effective(text, overrides).unwrap_or_else(|| text.to_owned());
        document = document.with(overrides.clone(), &effective);
        apply::apply(root.get_mut(), overrides, &document, &mut problems);
    }
    walk::walk(root.get_mut(), &mut document, &mut problems);
    match Settings::deserialize(Deserializer::from(root)) {
        Ok(mut settings) => {
            settings.signals.cylinder.name_objects();
            relations::check(&settings, &document, &mut problems);
            if problems.is_empty() {
                Ok((settings, document))
            } else {
                Err(document.error(problems))
            }
        }
        Err(error) => {
            // The walk found it already and said it better, or the schema has a hole.
            if problems.is_empty() {
                let span = error.span().unwrap_or(0..0);
                let message = error.message().to_owned();
                problems.push_with(|| document.problem_at(span, "", message, String::new()));
            }
            Err(document.error(problems))
        }
    }
}

/// Most syntax errors of a file that are reported.
const MAX_SYNTAX: usize = 5;

fn not_toml(document: &Document, error: &toml::de::Error) -> Problem {
    let message = format!("not TOML: {}", error.message());
    let help = "a line is [table], key = value or # comment, each key and table once";
    document.problem_at(error.span().unwrap_or(0..0), "", message, help.into())
}

/// The error for a file in which nothing is known: it is the wrong file, and its lines need no
/// comment.
fn no_configuration(document: &Document, errors: &[toml::de::Error]) -> ConfigError {
    if is_dbc(document.text()) {
        return a_dbc(document.name());
    }
    let help = "a configuration is TOML: tables such as [machine] with lines of key = value, for \
                example config/e-type.toml; is this the right file?";
    let first = errors.first().map(|error| not_toml(document, error));
    let place = first.as_ref().and_then(Problem::place).cloned();
    let reason = first.map_or_else(String::new, |first| format!(" ({})", first.message));
    let message = format!("this is not a configuration{reason}");
    let problem = Problem { place, ..Problem::of_file(document.name(), message, help) };
    document.refuse([problem]).expect("one problem is a refusal")
}

/// Whether a text is that of a DBC.
fn is_dbc(text: &str) -> bool {
    text.lines().any(|line| line.starts_with("BO_ ") || line.starts_with("BU_:"))
}

/// The error for a DBC that was given as a configuration.
fn a_dbc(name: &str) -> ConfigError {
    let help = "give the configuration (TOML) that names this file in `bus.dbc`, for example \
                config/e-type.toml; it is checked with its DBC";
    ConfigError::of_file(name, "this is a DBC, not a configuration".to_owned(), help)
}

fn too_long(name: &str) -> ConfigError {
    ConfigError::of_file(
        name,
        format!("longer than {MAX_SIZE} bytes"),
        "a configuration is a page of text; is this the right file?",
    )
}
