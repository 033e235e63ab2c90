//! What people do with alarms.

use crate::alarm_list::{ActKind, ActRefusal};
use tertius_core::time::Timestamp;
use thiserror::Error;
use tokio::sync::oneshot;

/// Longest name, characters.
pub const LONGEST_NAME: usize = 80;

/// Longest note or reason, characters.
pub const LONGEST_NOTE: usize = 500;

/// An act of a person on the alarm of an incident.
#[derive(Clone, Debug, PartialEq)]
pub struct AlarmAct {
    /// Incident in the store.
    pub incident: i64,
    pub kind: ActKind,
    /// Time by the system's clock.
    pub at: Timestamp,
    who: String,
    note: String,
}

/// Why an act was not taken. Nothing was stored then.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ActError {
    #[error("say who you are: a name of 1 to {LONGEST_NAME} characters")]
    Name,
    #[error("say why: shelving needs a reason of 1 to {LONGEST_NOTE} characters")]
    Reason,
    #[error("the note is longer than {LONGEST_NOTE} characters")]
    Note,
    #[error("there is no such incident in the store")]
    Unknown,
    #[error(transparent)]
    Refused(#[from] ActRefusal),
    #[error("the store is busy; try again")]
    Busy,
    #[error("the store cannot be written: {0}")]
    Unavailable(String),
}

/// An act on its way to the writer, which answers once it is on the disk.
#[derive(Debug)]
pub(super) struct ActRequest {
    pub act: Box<AlarmAct>,
    pub answer: oneshot::Sender<Result<(), ActError>>,
}

impl AlarmAct {
    /// An act on the incident `incident` by `who` at `at`, with a note, or with the reason of a shelving.
    ///
    /// # Errors
    /// The name or the reason is missing, or a text is too long.
    pub fn new(
        incident: i64,
        kind: ActKind,
        at: Timestamp,
        [who, note]: [&str; 2],
    ) -> Result<Self, ActError> {
        let [who, note] = [who, note].map(plain);
        if who.is_empty() || who.chars().count() > LONGEST_NAME {
            return Err(ActError::Name);
        }
        if note.chars().count() > LONGEST_NOTE {
            return Err(ActError::Note);
        }
        if note.is_empty() && matches!(kind, ActKind::Shelve(_)) {
            return Err(ActError::Reason);
        }
        Ok(Self { incident, kind, at, who, note })
    }

    pub fn who(&self) -> &str {
        &self.who
    }

    pub fn note(&self) -> &str {
        &self.note
    }
}

/// A text of one line, without control characters.
fn plain(text: &str) -> String {
    let spaced = |c: char| if c.is_control() { ' ' } else { c };
    text.chars().map(spaced).collect::<String>().trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_act_has_a_name_and_a_shelving_a_reason() {
        let until = ActKind::Shelve(Timestamp::from_nanos(9));
        let act = |kind, texts| AlarmAct::new(1, kind, Timestamp::default(), texts);
        let named = act(ActKind::Acknowledge, [" A. Person\n", "on it\r\nnow"]).expect("whole");
        assert_eq!((named.who(), named.note()), ("A. Person", "on it  now"));
        assert_eq!(act(ActKind::Acknowledge, [" \t", "x"]), Err(ActError::Name));
        assert_eq!(act(until, ["A", " "]), Err(ActError::Reason));
        assert!(act(until, ["A", "cable is on its way"]).is_ok());
        let long = "ä".repeat(LONGEST_NOTE + 1);
        assert_eq!(act(ActKind::Unshelve, ["A", &long]), Err(ActError::Note));
        assert_eq!(act(ActKind::Unshelve, [&long, ""]), Err(ActError::Name));
    }
}
