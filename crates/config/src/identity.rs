//! Which configuration and which calibration are in force.

use super::loader::Loaded;
use std::fmt;
use tertius_canopen::node::checksum;
use toml::{Table, Value};

/// Tables of what was measured of the machine, and not chosen.
const MEASURED: [&str; 3] = ["model", "calibration", "cylinder"];

/// Keys of the site, which change nothing of what is judged: what is given away does not have them.
pub(super) const SITE: [(&str, &str); 9] = [
    ("http", "token"),
    ("http", "certificate"),
    ("http", "key"),
    ("mqtt", "user"),
    ("mqtt", "password"),
    ("mqtt", "authority"),
    ("store", "file"),
    ("recorder", "folder"),
    ("sequential", "history"),
];

/// A CRC-32 by which files with the same meaning are known: eight hexadecimal digits. It tells
/// configurations apart, and is no protection against forgery.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fingerprint(u32);

impl Fingerprint {
    /// The digits as a number.
    pub const fn number(self) -> u32 {
        self.0
    }
}

impl fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:08x}", self.0)
    }
}

/// The identities of a machine's configuration.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Fingerprints {
    /// Of all keys with their values but for paths, logins and the token, and of the bytes of the DBC and the EDS files.
    pub configuration: Fingerprint,
    /// Of the tables that `identify`, `calibrate` and `commission` write; `None` where no cylinder has one.
    pub calibration: Option<Fingerprint>,
    /// The day (UTC) on which the newest recording ended that it was learnt from, if the file says it.
    pub recorded: Option<String>,
}

/// In words: `configuration 0fe1d2c3, calibration 1a2b3c4d of 2026-03-14`.
impl fmt::Display for Fingerprints {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "configuration {}, ", self.configuration)?;
        match (self.calibration, &self.recorded) {
            (Some(calibration), Some(day)) => write!(f, "calibration {calibration} of {day}"),
            (Some(calibration), None) => write!(f, "calibration {calibration} of an unknown day"),
            (None, _) => write!(f, "not calibrated"),
        }
    }
}

impl Loaded {
    /// The identities of this configuration, overrides included. They depend on what is said, and not on how: comments,
    /// blanks, the order of keys and the spelling of numbers make no difference, and nor do the names of the files
    /// whose content counts.
    pub fn fingerprints(&self) -> Fingerprints {
        // It was read before, so that it is TOML.
        let mut whole: Table = self.document.effective().parse().unwrap_or_default();
        let measured = MEASURED.iter().filter_map(|&name| whole.get_key_value(name));
        let mut measured: Table =
            measured.map(|(name, value)| (name.clone(), value.clone())).collect();
        forget_chosen(measured.get_mut("cylinder"));
        remove(whole.get_mut("bus"), "dbc");
        SITE.iter().for_each(|(table, key)| remove(whole.get_mut(*table), key));
        let devices = whole.get_mut("canopen").and_then(|canopen| canopen.get_mut("device"));
        for device in devices.and_then(Value::as_array_mut).into_iter().flatten() {
            remove(Some(device), "eds");
        }
        let calibrated = measured.get("cylinder").and_then(Value::as_array);
        Fingerprints {
            configuration: of(whole, &self.layout()),
            calibration: calibrated.is_some_and(|all| !all.is_empty()).then(|| of(measured, &[])),
            recorded: self.settings.calibration.recorded.clone(),
        }
    }
}

/// Keys of a cylinder that say what it has and how it is called, and not what was measured.
const CHOSEN: [&str; 4] = ["c2", "name", "c1_name", "c2_name"];

/// Removes what was chosen, and a cylinder of which nothing else is said.
fn forget_chosen(cylinders: Option<&mut Value>) {
    let Some(cylinders) = cylinders.and_then(Value::as_array_mut) else { return };
    for cylinder in cylinders.iter_mut() {
        CHOSEN.iter().for_each(|key| remove(Some(&mut *cylinder), key));
    }
    cylinders.retain(|cylinder| cylinder.as_table().is_none_or(|table| table.len() > 1));
}

fn remove(table: Option<&mut Value>, key: &str) {
    if let Some(table) = table.and_then(Value::as_table_mut) {
        table.remove(key);
    }
}

fn of(table: Table, files: &[u8]) -> Fingerprint {
    let mut bytes = Vec::new();
    put(&mut bytes, &Value::Table(table));
    bytes.extend_from_slice(files);
    Fingerprint(checksum(&bytes))
}

/// Adds `value` so that no two values give the same bytes.
fn put(bytes: &mut Vec<u8>, value: &Value) {
    match value {
        Value::Table(table) => {
            let mut keys: Vec<_> = table.iter().collect();
            keys.sort_unstable_by_key(|(key, _)| *key);
            open(bytes, b't', keys.len());
            for (key, value) in keys {
                put_text(bytes, key);
                put(bytes, value);
            }
        }
        Value::Array(values) => {
            open(bytes, b'a', values.len());
            values.iter().for_each(|value| put(bytes, value));
        }
        Value::String(text) => put_text(bytes, text),
        // Where a key is a number with a fraction, 1 means 1.0.
        Value::Integer(whole) => put_text(bytes, &(*whole as f64).to_string()),
        Value::Float(number) => put_text(bytes, &number.to_string()),
        Value::Boolean(truth) => put_text(bytes, &truth.to_string()),
        Value::Datetime(time) => put_text(bytes, &time.to_string()),
    }
}

fn put_text(bytes: &mut Vec<u8>, text: &str) {
    open(bytes, b's', text.len());
    bytes.extend_from_slice(text.as_bytes());
}

fn open(bytes: &mut Vec<u8>, kind: u8, length: usize) {
    bytes.push(kind);
    bytes.extend_from_slice(&(length as u64).to_le_bytes());
}
