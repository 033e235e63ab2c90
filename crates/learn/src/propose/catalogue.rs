//! The signals of a DBC in a row, and the frames that carry them.

use super::naming;
use super::words::{Measure, measure};
use std::collections::BTreeMap;
use tertius_core::decode::{Decoded, Value};
use tertius_core::frame::{Frame, Id};
use tertius_dbc::{Database, Message, Signal};

/// Beginning of the names of the gateway's own messages, which tell nothing of the machine.
const OWN: &str = "Fd_";

/// The signals of a DBC, numbered in the order of the file.
#[derive(Clone, Debug)]
pub struct Catalogue<'a> {
    pub(super) messages: Vec<&'a Message>,
    pub(super) signals: Vec<Listed<'a>>,
    /// Number of each message's first signal.
    first: Vec<usize>,
    by_id: BTreeMap<Id, usize>,
    /// Why the first message that cannot be used is refused, and how many there are.
    pub(super) refused: Option<(String, usize)>,
}

/// A signal of a [`Catalogue`].
#[derive(Clone, Debug)]
pub(super) struct Listed<'a> {
    /// Number of its message.
    pub message: usize,
    pub signal: &'a Signal,
    /// `MESSAGE.SIGNAL`.
    pub name: String,
}

impl<'a> Catalogue<'a> {
    /// The signals of `database`.
    pub fn new(database: &'a Database) -> Self {
        let messages: Vec<&Message> =
            database.messages().iter().filter(|it| !it.name.starts_with(OWN)).collect();
        let (mut signals, mut first) = (Vec::new(), Vec::new());
        for (place, message) in messages.iter().enumerate() {
            first.push(signals.len());
            signals.extend(message.signals.iter().map(|signal| Listed {
                message: place,
                signal,
                name: format!("{}.{}", message.name, signal.name),
            }));
        }
        let by_id = messages.iter().enumerate().map(|(place, it)| (it.id, place)).collect();
        let mut refused = database.refused().map(|(_, why)| why.to_string());
        let refused = refused.next().map(|first| (first, 1 + refused.count()));
        Self { messages, signals, first, by_id, refused }
    }

    /// Number of messages.
    pub fn messages(&self) -> usize {
        self.messages.len()
    }

    /// Number of signals.
    pub fn signals(&self) -> usize {
        self.signals.len()
    }

    /// The number of a frame's message; `None` if the DBC has none.
    pub(super) fn message_of(&self, frame: &Frame) -> Option<usize> {
        self.by_id.get(&frame.id).copied()
    }

    /// The numbers and values of the signals that a frame of this message carries.
    pub(super) fn values(
        &self,
        message: usize,
        frame: &Frame,
    ) -> impl Iterator<Item = (usize, Value)> {
        let first = self.first[message];
        let signals = &self.messages[message].signals;
        signals.iter().enumerate().filter_map(move |(place, signal)| {
            match signal.plan.decode(frame) {
                Decoded::Value(value) => Some((first + place, value)),
                Decoded::Absent | Decoded::Short => None,
            }
        })
    }

    /// The signals of the same message, with their numbers.
    pub(super) fn beside(&self, signal: usize) -> std::ops::Range<usize> {
        let first = self.first[self.signals[signal].message];
        first..first + self.messages[self.signals[signal].message].signals.len()
    }

    /// The signals of what answers the command of this number: those of its message, or, where the command travels alone,
    /// those of all messages whose names have the same first number, or without one those that have the words of its
    /// `cylinder` in their names.
    pub(super) fn answering(&self, command: usize, cylinder: Option<&[String]>) -> Vec<usize> {
        let own = self.beside(command);
        let message = |signal: usize| &*self.messages[self.signals[signal].message].name;
        let tells = |signal: &usize| matches!(measure(self.unit(*signal)), Measure::Pressure);
        let number = first_number(message(command));
        if own.clone().any(|signal| tells(&signal)) {
            return own.collect();
        }
        if number.is_none() {
            let Some(cylinder) = cylinder else { return own.collect() };
            let is_of = |signal: &usize| naming::is_of(self.name(*signal), cylinder);
            return (0..self.signals()).filter(|it| own.contains(it) || is_of(it)).collect();
        }
        (0..self.signals()).filter(|signal| first_number(message(*signal)) == number).collect()
    }

    /// The number of the signal of that name.
    pub(super) fn find(&self, name: &str) -> Option<usize> {
        self.signals.iter().position(|listed| listed.name == name)
    }

    pub(super) fn name(&self, signal: usize) -> &str {
        &self.signals[signal].name
    }

    pub(super) fn unit(&self, signal: usize) -> &str {
        &self.signals[signal].signal.unit
    }
}

/// The first number in a name, such as 3 of `Leg3_Servo1`.
fn first_number(name: &str) -> Option<&str> {
    let begin = name.find(|letter: char| letter.is_ascii_digit())?;
    let rest = &name[begin..];
    let end = rest.find(|letter: char| !letter.is_ascii_digit()).unwrap_or(rest.len());
    Some(&rest[..end])
}
