//! What a recording format is: how an input of the format is recognised, and how its bytes become frames.
//!
//! A format need not have lines. A [`Reader`] takes what it can use of the bytes that were read so far, and
//! says what they are. [`super::Recording`] reads the files, counts, and chooses the interface.

use tertius_core::frame::{Frame, Id, Kind};
use tertius_core::time::Timestamp;

use super::encoder::Written;
use super::limits::MAX_LINE;
use super::reason::Reason;

/// A recording format: a row of the table in [`super::formats`].
pub struct Format {
    /// Name for people, as in "it seems to be …".
    pub name: &'static str,
    /// How places in an input are numbered.
    pub numbered: Numbered,
    /// Whether there is no frame before the last byte was read.
    pub is_whole: bool,
    /// Whether an input that begins with these bytes has this format; `None` where they are too few to
    /// tell. At most 512 bytes are shown.
    pub recognise: fn(head: &[u8]) -> Option<bool>,
    /// A reader for one input.
    pub reader: fn(stamps: TimeStamps) -> Box<dyn Reader>,
    /// How recordings of the format are written, where they are.
    pub written: Option<Written>,
}

/// Whether places in an input are lines or bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Numbered {
    /// Text, in lines counted from 1.
    Lines,
    /// Anything else, by the number of bytes before the place, after decompression.
    Bytes,
}

/// Interpretation of short time stamps, those that do not count from 1970.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TimeStamps {
    /// In candump's console form: [`Self::Delta`] if one of the first 64 lines is earlier than its
    /// predecessor, else [`Self::Zero`]. In its log form, and in other formats: [`Self::Absolute`].
    #[default]
    Auto,
    /// As they stand in the recording.
    Absolute,
    /// Each counts from the previous line (`candump -td`), the first line of the input from zero.
    Delta,
    /// Counted from the recording's start (`candump -tz`), as they stand.
    Zero,
}

/// Turns the bytes of one input into frames.
pub trait Reader: Send {
    /// Reads what the bytes begin with. A frame is written into `frame`, which is undefined afterwards if
    /// there was none. The result must depend on the input's bytes alone, and not on how many of them are
    /// there yet.
    fn read<'a>(&'a mut self, unread: Unread<'a>, frame: &mut Frame) -> Item<'a>;
}

/// The bytes of an input that were read and not yet taken.
#[derive(Clone, Copy, Debug)]
pub struct Unread<'a> {
    pub bytes: &'a [u8],
    pub end: End,
}

/// What comes after the bytes that were read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// There may be more.
    Open,
    /// Nothing: the input ends here.
    Whole,
    /// The rest of the input is lost, since it is damaged.
    Lost,
}

/// What the next bytes of an input are.
#[derive(Clone, Copy, Debug)]
pub enum Item<'a> {
    /// A frame, which ends after `taken` bytes.
    Frame {
        taken: usize,
        /// Name of the interface, of printable ASCII.
        interface: &'a [u8],
        /// Whether its time stamp counts from 1970.
        absolute: bool,
    },
    /// A line or record that is no frame, and need not be one.
    Nothing { taken: usize },
    /// A line or record that should be a frame; its first `shown` bytes may be shown.
    Bad { shown: usize, taken: usize, reason: Reason },
    /// Something bad `at` a place of the input that was taken before, which begins with `shown`.
    BadAt {
        at: u64,
        shown: &'a [u8],
        reason: Reason,
        /// Whether more frames than that one cannot be found for it.
        loses: bool,
    },
    /// A line longer than [`MAX_LINE`], which is dropped up to its end.
    LongLine,
    /// More bytes are needed, of [`MAX_RECORD`](super::limits::MAX_RECORD) at the most. At the end of the input: nothing is left, or
    /// what is left is incomplete.
    More,
}

/// A line without its newline.
#[derive(Clone, Copy, Debug)]
pub struct CutLine<'a> {
    pub text: &'a [u8],
    /// Number of its bytes with the newline.
    taken: usize,
}

impl<'a> Unread<'a> {
    /// The next line, for formats of lines.
    ///
    /// # Errors
    /// What to return from [`Reader::read`] where there is no whole line.
    pub fn line(self) -> Result<CutLine<'a>, Item<'a>> {
        let head = &self.bytes[..self.bytes.len().min(MAX_LINE + 1)];
        match memchr::memchr(b'\n', head) {
            Some(length) => Ok(CutLine { text: &head[..length], taken: length + 1 }),
            None if head.len() > MAX_LINE => Err(Item::LongLine),
            // What is there of it may be a frame with half its data.
            None if self.end == End::Whole && !head.is_empty() => {
                Ok(CutLine { text: head, taken: head.len() })
            }
            None => Err(Item::More),
        }
    }
}

impl<'a> CutLine<'a> {
    /// The result for a line that is a frame.
    pub fn frame(self, interface: &'a [u8], absolute: bool) -> Item<'a> {
        Item::Frame { taken: self.taken, interface, absolute }
    }

    /// The result for a line that need not be a frame.
    pub fn nothing(self) -> Item<'a> {
        Item::Nothing { taken: self.taken }
    }

    /// The result for a line that should be a frame.
    pub fn bad(self, reason: Reason) -> Item<'a> {
        Item::Bad { shown: self.text.len(), taken: self.taken, reason }
    }
}

/// A frame for a reader to fill.
pub fn blank_frame() -> Frame {
    const ZERO: Id = match Id::standard(0) {
        Some(id) => id,
        None => panic!("0 is an 11-bit identifier"),
    };
    Frame::new(Timestamp::default(), ZERO, Kind::Data, &[])
}

/// Payload length of CAN FD by data length code, bytes.
pub const FD_LENGTHS: [usize; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];

/// Whether a CAN FD frame can have this length, bytes.
pub fn is_fd_length(length: usize) -> bool {
    FD_LENGTHS.contains(&length)
}

/// The data length code of a CAN FD frame: the least with room for this length, bytes.
pub fn fd_code(length: usize) -> u8 {
    FD_LENGTHS.iter().position(|room| *room >= length).unwrap_or(FD_LENGTHS.len() - 1) as u8
}
