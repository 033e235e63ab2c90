//! Recordings of which one begins within those before it.

use crate::bus::{Options, TimeStamps, later_beginnings};
use crate::failure::Failure;
use crate::time::{Span, Timestamp};
use std::path::PathBuf;

/// Step of the time stamps below which a recording may have begun anew: frames of several senders are out of order by
/// less.
pub const STEP_BACK: Span = Span::from_nanos(-1_000_000_000);

/// Beginnings of the recordings that are named after another one. They are looked for where time steps back, so that
/// recordings in order cost nothing.
#[derive(Debug)]
pub struct Beginnings<'a> {
    logs: &'a [PathBuf],
    options: &'a Options,
    /// Names and first time stamps, once they were looked for.
    known: Option<Vec<(String, Timestamp)>>,
}

impl<'a> Beginnings<'a> {
    /// The beginnings of `logs`, which are read with these `options`.
    pub const fn new(logs: &'a [PathBuf], options: &'a Options) -> Self {
        Self { logs, options, known: None }
    }

    /// Refuses a step back from the time `before` to a time `at` at which a recording begins: its times had been recorded
    /// already. Any other step is a clock that was set within a recording.
    ///
    /// # Errors
    /// The recording that begins there.
    #[cold]
    pub fn refuse(&mut self, at: Timestamp, before: Timestamp) -> Result<(), Failure> {
        let find = || match self.options.time_stamps {
            TimeStamps::Auto | TimeStamps::Absolute => {
                later_beginnings(self.logs, &self.options.interfaces)
            }
            _ => Vec::new(),
        };
        let known = self.known.get_or_insert_with(find);
        let Some((name, _)) = known.iter().find(|(_, begin)| *begin == at) else { return Ok(()) };
        Err(Failure::Wrong(format!(
            "{name} begins at {at}, which had been recorded before, up to {before}: recordings overlap, one is named \
             twice, or the clock was set back; name each recording once. Where the clock was set back in between, \
             read them one by one, or as one: cat FILES | tertius replay -"
        )))
    }
}
