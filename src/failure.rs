//! Why a command failed.

#[cfg(feature = "cli")]
use crate::appliance::logging::LogError;
use crate::bus::SourceError;
use crate::config::{ConfigError, visible_lines};
use std::fmt;
use std::io::{self, Write};
use std::path::Path;

/// Writes a line for a person to standard error, where nothing in it acts on a terminal. If that cannot be written
/// nobody is there to read it, which is no reason to end.
macro_rules! tell {
    ($($argument:tt)*) => {{
        use std::io::Write as _;
        _ = writeln!(std::io::stderr(), "{}", $crate::config::visible_lines(&format!($($argument)*)));
    }};
}

/// Writes a text for a person to standard output, where nothing in it acts on a terminal.
///
/// # Errors
/// It cannot be written.
pub fn print(text: &str) -> Result<(), Failure> {
    let written = io::stdout().write_all(visible_lines(text).as_bytes());
    written.map_err(|error| Failure::writing("standard output", &error))
}

/// A failure with its exit code: 1 if the command failed, 2 if the call or a file of the user's is
/// wrong, 3 if the command did what it could and left something out.
#[derive(Debug)]
pub enum Failure {
    /// The configuration is refused.
    Config(Box<ConfigError>),
    /// The call or a file of the user's is wrong.
    Wrong(String),
    /// The command failed.
    Failed(String),
    /// The command did what it could, and left something out.
    Limited(String),
    /// The reader of the output has closed it.
    OutputClosed,
}

impl Failure {
    pub const fn exit_code(&self) -> u8 {
        match self {
            Self::OutputClosed => 0,
            Self::Failed(_) => 1,
            Self::Config(_) | Self::Wrong(_) => 2,
            Self::Limited(_) => 3,
        }
    }

    /// What could not be written, and why.
    pub fn writing(what: &str, error: &io::Error) -> Self {
        if error.kind() == io::ErrorKind::BrokenPipe {
            return Self::OutputClosed;
        }
        Self::Failed(format!("{what} cannot be written: {error}"))
    }

    /// A file that could not be written, and why. A closed pipe is a failure, too, since the rest
    /// of the request is not done.
    pub fn writing_file(what: &str, error: &io::Error) -> Self {
        Self::Failed(format!("{what} cannot be written: {error}"))
    }

    /// Cylinders that were refused, each with its reason on a line of its own.
    pub fn refused(cylinders: &[(u8, String)]) -> Self {
        let told = cylinders.iter().map(|(number, why)| format!("cylinder {number}: {why}"));
        Self::Failed(told.collect::<Vec<_>>().join("\ntertius: "))
    }

    /// An output file that cannot be created.
    pub fn creating(path: &Path, error: &io::Error) -> Self {
        Self::Wrong(format!("{} cannot be created: {error}", path.display()))
    }

    /// Writes the message to standard error.
    pub fn report(&self) {
        match self {
            // A file that could not be read has no lines to show, and is told as any other file.
            Self::Config(error) if error.problems().iter().all(|it| it.place().is_none()) => {
                for it in error.problems() {
                    let help = if it.help().is_empty() { "" } else { "; " };
                    tell!("tertius: {}: {}{help}{}", it.file(), it.message(), it.help());
                }
                if error.more() > 0 {
                    tell!("tertius: {} more are not shown", error.more());
                }
            }
            #[cfg(feature = "cli")]
            Self::Config(error) => {
                // Its colours are for the terminal, and what it shows is escaped already.
                _ = writeln!(io::stderr(), "{:?}", error.report());
            }
            #[cfg(not(feature = "cli"))]
            Self::Config(error) => tell!("{error}"),
            Self::Wrong(message) | Self::Failed(message) | Self::Limited(message) => {
                tell!("tertius: {message}");
            }
            Self::OutputClosed => {}
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Config(error) => write!(f, "{error}"),
            Self::Wrong(message) | Self::Failed(message) | Self::Limited(message) => {
                f.write_str(message)
            }
            Self::OutputClosed => f.write_str("the output was closed"),
        }
    }
}

impl From<ConfigError> for Failure {
    fn from(error: ConfigError) -> Self {
        Self::Config(Box::new(error))
    }
}

impl From<SourceError> for Failure {
    fn from(error: SourceError) -> Self {
        Self::Wrong(error.to_string())
    }
}

#[cfg(feature = "cli")]
impl From<LogError> for Failure {
    fn from(error: LogError) -> Self {
        match error {
            LogError::NoJournal(_) => Self::Wrong(error.to_string()),
            LogError::Started(_) => Self::Failed(error.to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    #[cfg(feature = "cli")]
    #[test]
    fn a_missing_journal_is_a_wrong_call() {
        let error = super::LogError::NoJournal(std::io::ErrorKind::NotFound.into());
        let failure = super::Failure::from(error);
        assert_eq!(failure.exit_code(), 2);
        assert!(failure.to_string().contains("use --log json"), "{failure}");
    }
}
