//! A DBC, checked and compiled.

use std::collections::{BTreeMap, HashMap};

use super::check::{self, OVERLAP_STEPS};
use super::collect::collect;
use super::device::{Device, DeviceMessages, DeviceServices, IdTaken};
use super::draft::Draft;
use super::finding::{Concern, Finding, Findings, Severity};
use super::lookup::{LookupError, nearest};
use super::message::{Message, Signal};
use super::parse_error::ParseError;
use super::statement;
use super::text::without_bom;
use super::{MAX_MESSAGES, MAX_TEXT};

/// The messages of a DBC: sound ones to use, and the others with the reason why they cannot be
/// used.
#[derive(Clone, Debug, Default)]
pub struct Database {
    messages: Vec<Message>,
    by_name: HashMap<String, usize>,
    by_id: HashMap<tertius_core::frame::Id, usize>,
    /// Names of unusable messages, each with its first error.
    refused: BTreeMap<String, Finding>,
    findings: Findings,
    /// Devices that describe their messages themselves.
    devices: Vec<Device>,
    /// Devices by their names.
    by_device: BTreeMap<String, usize>,
}

impl Database {
    /// Parses, checks and compiles a DBC's text (with or without byte order mark, any line ends).
    /// VECTOR__INDEPENDENT_SIG_MSG is left out. A message with an error is kept apart and is
    /// refused only when it is asked for.
    ///
    /// # Errors
    /// The text is not a DBC, has a syntax error in a statement that affects decoding
    /// (BO_, SG_, SIG_VALTYPE_, SG_MUL_VAL_), or exceeds a limit.
    pub fn parse(text: &str) -> Result<Self, ParseError> {
        if text.len() > MAX_TEXT {
            return Err(ParseError::TooLong { bytes: text.len() });
        }
        let mut findings = Findings::default();
        let statements = statement::split(without_bom(text), &mut findings)?;
        let mut drafts = collect(statements, &mut findings)?;
        if drafts.is_empty() {
            return Err(ParseError::NoMessages);
        }
        refuse_duplicates(&mut drafts, &mut findings);
        let mut database = Self::default();
        let mut steps = OVERLAP_STEPS;
        for mut draft in drafts {
            match check::compile(&mut draft, &mut findings, &mut steps)? {
                Some(message) => database.add(message),
                None => {
                    let reason = draft.refused.expect("compile refuses only for a finding");
                    database.refused.entry(draft.name).or_insert(reason);
                }
            }
        }
        database.add_short_names();
        findings.sort();
        database.findings = findings;
        Ok(database)
    }

    fn add(&mut self, message: Message) {
        let index = self.messages.len();
        debug_assert!(index < MAX_MESSAGES);
        self.by_name.insert(message.name.clone(), index);
        self.by_id.insert(message.id, index);
        self.messages.push(message);
    }

    /// Makes messages available by their short names, too, except for short names that are another
    /// message's name or that two messages share.
    fn add_short_names(&mut self) {
        let mut short: HashMap<&str, Option<usize>> = HashMap::new();
        for (index, message) in self.messages.iter().enumerate() {
            if let Some(name) = message.short.as_deref() {
                short.entry(name).and_modify(|known| *known = None).or_insert(Some(index));
            }
        }
        short.retain(|name, _| !self.refused.contains_key(*name));
        for (name, index) in short {
            if let Some(index) = index {
                self.by_name.entry(name.to_owned()).or_insert(index);
            }
        }
    }

    /// Adds the messages of a device, which are not the DBC's. Its signals are then found by the device's
    /// names, whatever message they are in.
    ///
    /// # Errors
    /// A message's identifier is taken; nothing is added then.
    pub fn add_device(&mut self, device: DeviceMessages) -> Result<(), IdTaken> {
        for message in &device.messages {
            if let Some(&other) = self.by_id.get(&message.id) {
                return Err(IdTaken {
                    message: message.name.clone(),
                    other: self.messages[other].name.clone(),
                    id: message.id,
                });
            }
        }
        let first = self.messages.len();
        for message in device.messages {
            self.by_id.insert(message.id, self.messages.len());
            self.messages.push(message);
        }
        let messages = first..self.messages.len();
        let place = self.devices.len();
        self.by_device.extend(device.names.into_iter().map(|name| (name, place)));
        let (services, note) = (device.services, device.note);
        self.devices.push(Device { messages, services, note });
        Ok(())
    }

    /// Services of the device of that name.
    pub fn device_services(&self, name: &str) -> Option<&DeviceServices> {
        Some(&self.devices[*self.by_device.get(name)?].services)
    }

    /// Number of messages that are devices' own.
    pub fn device_messages(&self) -> usize {
        self.devices.iter().map(|device| device.messages.len()).sum()
    }

    /// Whether `message` is a device's own, and not the DBC's.
    pub fn is_of_device(&self, message: &Message) -> bool {
        let place = self.by_id.get(&message.id);
        place.is_some_and(|place| self.devices.iter().any(|it| it.messages.contains(place)))
    }

    /// The signal of that name in whichever message of the device.
    fn device_signal(&self, name: &str, signal: &str) -> Option<DeviceSignal<'_>> {
        let device = &self.devices[*self.by_device.get(name)?];
        let messages = &self.messages[device.messages.clone()];
        let found = messages.iter().find_map(|it| it.signal(signal).map(|found| (it, found)));
        Some(found.ok_or_else(|| LookupError::Object {
            device: name.to_owned(),
            given: signal.to_owned(),
            carried: messages.iter().flat_map(|it| &it.signals).map(|it| it.name.clone()).collect(),
            note: device.note.clone(),
        }))
    }

    /// The usable messages, in the file's order, and then those of devices.
    pub fn messages(&self) -> &[Message] {
        &self.messages
    }

    /// Findings in the order of lines: errors, which make their message unusable, and warnings. At
    /// most [`super::MAX_FINDINGS`].
    pub fn findings(&self) -> &[Finding] {
        self.findings.list()
    }

    /// Number of findings beyond [`Self::findings`].
    pub fn findings_left_out(&self) -> usize {
        self.findings.left_out()
    }

    /// The names of messages with an error, and their first error, in the order of the names.
    pub fn refused(&self) -> impl Iterator<Item = (&str, &Finding)> {
        self.refused.iter().map(|(name, finding)| (name.as_str(), finding))
    }

    /// The usable message with that identifier.
    pub fn message_by_id(&self, id: tertius_core::frame::Id) -> Option<&Message> {
        self.by_id.get(&id).map(|&index| &self.messages[index])
    }

    /// The message of that name, long or short, letter case respected.
    ///
    /// # Errors
    /// There is no such message (the nearest names are given), or it has an error.
    pub fn message(&self, name: &str) -> Result<&Message, LookupError> {
        if let Some(&index) = self.by_name.get(name) {
            return Ok(&self.messages[index]);
        }
        if let Some(reason) = self.refused.get(name) {
            return Err(LookupError::Refused {
                message: name.to_owned(),
                reason: reason.to_string(),
            });
        }
        let known = self.messages.iter().map(|message| message.name.as_str());
        let known = known.chain(self.refused.keys().map(String::as_str));
        Err(LookupError::Message { given: name.to_owned(), nearest: nearest(name, known) })
    }

    /// The signal that `MESSAGE.SIGNAL` or `DEVICE.SIGNAL` names, and its message.
    ///
    /// # Errors
    /// See [`Self::message`]; also if the message or device has no such signal, or if `name` has no
    /// point.
    pub fn signal(&self, name: &str) -> Result<(&Message, &Signal), LookupError> {
        let Some((message, signal)) = name.split_once('.') else {
            return Err(LookupError::Form { given: name.to_owned() });
        };
        if let Some(found) = self.device_signal(message, signal) {
            return found;
        }
        let message = self.message(message)?;
        let found = message.signal(signal).ok_or_else(|| LookupError::Signal {
            message: message.name.clone(),
            given: signal.to_owned(),
            nearest: nearest(signal, message.signals.iter().map(|signal| signal.name.as_str())),
        })?;
        Ok((message, found))
    }
}

impl Database {
    /// Gives the signal `name` of the DBC, `MESSAGE.SIGNAL`, in another `unit`, in which its numbers are `times` / `per`
    /// as large. Signals that are not in it, and those of devices, stay as they are.
    pub fn rescale(&mut self, name: &str, unit: &str, [times, per]: [f64; 2]) {
        let Some((message, own)) = name.split_once('.') else { return };
        if self.device_signal(message, own).is_some() {
            return;
        }
        let Some(message) = self.by_name.get(message).map(|&place| &mut self.messages[place])
        else {
            return;
        };
        let Some(place) = message.signal(own).and_then(|found| {
            message.signals.iter().position(|signal| std::ptr::eq(signal, found))
        }) else {
            return;
        };
        let signal = &mut message.signals[place];
        unit.clone_into(&mut signal.unit);
        signal.plan = signal.plan.clone().rescaled(times, per);
        signal.range = signal.range.map(|range| range.map(|end| end * times / per));
    }
}

/// A signal of a device and its message, or why there is none.
type DeviceSignal<'a> = Result<(&'a Message, &'a Signal), LookupError>;

/// Refuses two messages with the same identifier or name, since it cannot be told which is meant.
fn refuse_duplicates(drafts: &mut [Draft], findings: &mut Findings) {
    let mut by_id: HashMap<u64, Vec<usize>> = HashMap::new();
    let mut by_name: HashMap<String, Vec<usize>> = HashMap::new();
    for (index, draft) in drafts.iter().enumerate() {
        by_id.entry(draft.id).or_default().push(index);
        by_name.entry(draft.name.clone()).or_default().push(index);
    }
    let ids = by_id.into_values().map(|twins| (Concern::DuplicateId, twins));
    let names = by_name.into_values().map(|twins| (Concern::DuplicateName, twins));
    let mut groups: Vec<_> = ids.chain(names).filter(|(_, twins)| twins.len() > 1).collect();
    groups.sort_by_key(|(concern, twins)| (twins[0], *concern));
    for (concern, twins) in groups {
        for (place, &index) in twins.iter().enumerate() {
            let other = &drafts[twins[usize::from(place == 0)]];
            let (what, remedy) = if concern == Concern::DuplicateId {
                (
                    format!("message {} in line {} has its identifier", other.name, other.line),
                    "give each message its own identifier",
                )
            } else {
                (format!("the message in line {} has its name", other.line), "rename one of them")
            };
            let draft = &mut drafts[index];
            let finding = draft.finding(Severity::Error, concern, None, what, remedy);
            draft.judge(finding, findings);
        }
    }
}
