//! Statistics of a recording, beside the frames that were returned.

use tertius_config::visible;
use tertius_core::frame::Kind;

use super::bad_line::{BadLine, BadPlace};
use super::barren::Barren;
use super::reason::Reason;

/// Most bad lines that are kept with their text; further ones are only counted.
pub const KEPT_BAD_LINES: usize = 5;
/// Most interfaces that are told apart by name.
pub const INTERFACES_KEPT: usize = 16;
/// Most damage reports that are kept; further ones are only counted.
pub const KEPT_DAMAGE: usize = 16;
/// Most inputs without a frame that are kept.
pub const KEPT_BARREN: usize = 16;
/// Most bytes of a bad line that are shown.
const EXCERPT: usize = 80;
/// Most bytes of a bad record that are shown.
const SHOWN_BYTES: usize = 16;

/// Statistics of what was read so far.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Lines, or records of a format without lines, of any kind, empty and bad ones included.
    pub lines: u64,
    /// Well-formed frames of every kind on every interface, returned or not.
    pub frames: u64,
    /// Error frames among [`Self::frames`].
    pub error_frames: u64,
    /// Remote frames among [`Self::frames`].
    pub remote_frames: u64,
    /// Frames that were not returned because they are of another interface.
    pub other_interface_frames: u64,
    /// Lines or records that should be frames and are not.
    pub bad_lines: u64,
    /// The first [`KEPT_BAD_LINES`] bad lines.
    pub first_bad_lines: Vec<BadLine>,
    /// The first [`INTERFACES_KEPT`] interfaces in the order of their first frame.
    pub interfaces: Vec<Interface>,
    /// Frames of interfaces beyond [`Self::interfaces`].
    pub unlisted_interface_frames: u64,
    /// Inputs whose end, or another part with any number of frames, could not be read.
    pub damaged_inputs: u64,
    /// The first [`KEPT_DAMAGE`] reports of damage.
    pub damage: Vec<Damage>,
    /// The first [`KEPT_BARREN`] inputs without a frame.
    pub barren: Vec<Barren>,
}

/// An interface and its number of frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Interface {
    pub name: String,
    pub frames: u64,
}

impl std::fmt::Display for Interface {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let frames = if self.frames == 1 { "frame" } else { "frames" };
        write!(f, "{} ({} {frames})", self.name, self.frames)
    }
}

/// An input that could not be read to its end, or of which parts could not be found; the other frames were returned.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Name of the file as given, or "standard input".
    pub file: String,
    /// Description of the damage.
    pub reason: String,
}

impl std::fmt::Display for Damage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.file, self.reason)
    }
}

impl Statistics {
    /// Counts a bad line or record, which begins with `shown`.
    pub(super) fn add_bad(&mut self, file: &str, place: BadPlace, shown: &[u8], reason: Reason) {
        self.bad_lines += 1;
        if self.first_bad_lines.len() < KEPT_BAD_LINES {
            let text = match place {
                BadPlace::Line(_) => excerpt(shown),
                BadPlace::Byte(_) => hexadecimal(shown),
            };
            self.first_bad_lines.push(BadLine { file: file.to_owned(), place, text, reason });
        }
    }

    pub(super) fn add_damage(&mut self, file: &str, reason: String) {
        self.damaged_inputs += 1;
        if self.damage.len() < KEPT_DAMAGE {
            self.damage.push(Damage { file: file.to_owned(), reason });
        }
    }

    pub(super) fn add_barren(&mut self, barren: Barren) {
        if self.barren.len() < KEPT_BARREN {
            self.barren.push(barren);
        }
    }

    /// Adds those of another recording that was read beside this one.
    pub(super) fn add(&mut self, other: &Self) {
        self.lines += other.lines;
        self.frames += other.frames;
        self.error_frames += other.error_frames;
        self.remote_frames += other.remote_frames;
        self.other_interface_frames += other.other_interface_frames;
        self.bad_lines += other.bad_lines;
        self.unlisted_interface_frames += other.unlisted_interface_frames;
        self.damaged_inputs += other.damaged_inputs;
        for Interface { name, frames } in &other.interfaces {
            match self.interface(name.as_bytes()) {
                Some(place) => self.interfaces[place].frames += frames,
                None if self.interfaces.len() < INTERFACES_KEPT => {
                    self.interfaces.push(Interface { name: name.clone(), frames: *frames });
                }
                None => self.unlisted_interface_frames += frames,
            }
        }
        add_some(&mut self.first_bad_lines, &other.first_bad_lines, KEPT_BAD_LINES);
        add_some(&mut self.damage, &other.damage, KEPT_DAMAGE);
        add_some(&mut self.barren, &other.barren, KEPT_BARREN);
    }

    /// The interfaces with their numbers of frames, for people.
    pub fn interfaces_found(&self) -> String {
        let found = self.interfaces.iter().map(ToString::to_string);
        found.collect::<Vec<_>>().join(", ")
    }

    /// Index of an interface in the list, if it is there.
    pub(super) fn interface(&self, name: &[u8]) -> Option<usize> {
        self.interfaces.iter().position(|interface| interface.name.as_bytes() == name)
    }

    /// Counts a frame of this kind on the interface.
    pub(super) fn add_frame(&mut self, kind: Kind, interface: &[u8]) {
        self.lines += 1;
        self.frames += 1;
        self.error_frames += u64::from(kind == Kind::Error);
        self.remote_frames += u64::from(matches!(kind, Kind::Remote { .. }));
        self.add_interface_frame(interface);
    }

    /// Counts a frame of the interface, whose name is ASCII.
    fn add_interface_frame(&mut self, name: &[u8]) {
        if let Some(place) = self.interface(name) {
            self.interfaces[place].frames += 1;
        } else if self.interfaces.len() < INTERFACES_KEPT {
            let name = String::from_utf8_lossy(name).into_owned();
            self.interfaces.push(Interface { name, frames: 1 });
        } else {
            self.unlisted_interface_frames += 1;
        }
    }
}

/// Adds as many as may be kept.
fn add_some<T: Clone>(kept: &mut Vec<T>, more: &[T], most: usize) {
    let room = most.saturating_sub(kept.len());
    kept.extend(more.iter().take(room).cloned());
}

/// The beginning of a record as bytes in hexadecimal.
fn hexadecimal(record: &[u8]) -> String {
    let bytes = record.iter().take(SHOWN_BYTES).map(|byte| format!("{byte:02X}"));
    let dots = (record.len() > SHOWN_BYTES).then(|| "…".to_owned());
    bytes.chain(dots).collect::<Vec<_>>().join(" ")
}

/// The beginning of a line as text without effect on a terminal.
fn excerpt(line: &[u8]) -> String {
    let line = line.trim_ascii_end();
    let shown = &line[..line.len().min(EXCERPT)];
    let mut text = visible(&String::from_utf8_lossy(shown)).into_owned();
    if shown.len() < line.len() {
        text.push('…');
    }
    text
}
