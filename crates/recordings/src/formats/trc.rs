//! PEAK's trace format TRC, versions 1.0 to 1.3, 2.0 and 2.1, by PEAK-System's *CAN TRC File Format*.
//!
//! Comments begin with a semicolon; some of them tell the version, the start and the columns. Every other
//! line is a message, in columns of words. Times are milliseconds since the start, which is counted in days
//! since 1899-12-30 and here taken as UTC; version 1.0 tells it in words only, so that its time stamps count
//! from zero.

use crate::format::{FD_LENGTHS, Format, Item, Numbered, Reader, Unread, is_fd_length};
use crate::reason::{Found, Reason};
use tertius_core::frame::{Frame, Id, Kind};
use tertius_core::time::Timestamp;

use super::decimal::number;
use super::hex::digit;
use super::token::token;

pub static FORMAT: Format = Format {
    name: "a PEAK trace in TRC",
    numbered: Numbered::Lines,
    is_whole: false,
    recognise: |head| Some(*head.trim_ascii_start().first()? == b';'),
    reader: |_| Box::new(Trc::default()),
    written: None,
};

const NANOS_PER_DAY: i128 = 86_400_000_000_000;
const NANOS_PER_MILLISECOND: i128 = 1_000_000;
/// Days from 1899-12-30 to 1970-01-01.
const DAYS_BEFORE_1970: i128 = 25_569;
/// Most columns.
const COLUMNS: usize = 12;
/// Classes of error frames in linux/can/error.h: a fault on the bus, and a controller that is bus-off.
const BUS_ERROR: u32 = 0x080;
const BUS_OFF: u32 = 0x040;
/// Flags of [`Kind::Fd`].
const BIT_RATE_SWITCH: u8 = 1;
const ERROR_STATE: u8 = 2;
/// The bit of a status message for bus-off.
const STATUS_BUS_OFF: u32 = 0x10;

/// What stands in a column, by its letter in `$COLUMNS`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    /// `O`.
    Offset,
    /// `T`: the kind of message; before version 2.0 its direction.
    Type,
    /// `B`.
    Bus,
    /// `I`.
    Id,
    /// `L`: data length code.
    Code,
    /// `l`: number of bytes.
    Length,
    /// `D`: the rest of the line.
    Data,
    /// `N`, `d`, `R` and others, which are not needed.
    Other,
}

impl Column {
    const fn of(letter: u8) -> Self {
        match letter {
            b'O' => Self::Offset,
            b'T' => Self::Type,
            b'B' => Self::Bus,
            b'I' => Self::Id,
            b'L' => Self::Code,
            b'l' => Self::Length,
            b'D' => Self::Data,
            _ => Self::Other,
        }
    }
}

/// The reader of one trace.
struct Trc {
    columns: Columns,
    /// Whether the version is one that is read.
    is_known: bool,
    /// Start since 1970, ns.
    start: Option<i128>,
    /// Name of the newest message's interface, for example `bus1`.
    interface: Vec<u8>,
}

/// The columns of a line, in order.
#[derive(Clone, Copy)]
struct Columns([Column; COLUMNS]);

impl Columns {
    fn of(letters: &[u8]) -> Self {
        let mut columns = [Column::Other; COLUMNS];
        let letters = letters.iter().filter(|letter| letter.is_ascii_alphabetic());
        columns.iter_mut().zip(letters).for_each(|(column, letter)| *column = Column::of(*letter));
        Self(columns)
    }
}

impl Default for Trc {
    /// Version 1.0, which does not tell its version.
    fn default() -> Self {
        Self { columns: Columns::of(b"NOILD"), is_known: true, start: None, interface: Vec::new() }
    }
}

/// The words of a message, by column.
#[derive(Default)]
struct Message<'a> {
    offset: &'a [u8],
    kind: &'a [u8],
    bus: &'a [u8],
    id: &'a [u8],
    code: Option<&'a [u8]>,
    length: Option<&'a [u8]>,
    data: &'a [u8],
}

/// What a message means.
enum Meaning {
    /// A data frame.
    Data(Kind),
    Remote,
    /// An error frame on the bus.
    Error,
    /// A change of the controller's state.
    Status,
    /// Anything else that is no frame.
    Other,
}

impl Reader for Trc {
    fn read<'a>(&'a mut self, unread: Unread<'a>, frame: &mut Frame) -> Item<'a> {
        let cut = match unread.line() {
            Ok(cut) => cut,
            Err(item) => return item,
        };
        let text = cut.text.trim_ascii();
        if text.is_empty() {
            return cut.nothing();
        }
        if let Some(comment) = text.strip_prefix(b";") {
            return match self.header(comment) {
                Ok(()) => cut.nothing(),
                Err(reason) => cut.bad(reason),
            };
        }
        match self.message(text, frame) {
            Ok(true) => cut.frame(&self.interface, self.start.is_some()),
            Ok(false) => cut.nothing(),
            Err(reason) => cut.bad(reason),
        }
    }
}

impl Trc {
    /// Takes what a comment tells of the lines after it.
    fn header(&mut self, comment: &[u8]) -> Result<(), Reason> {
        let Some(equals) = memchr::memchr(b'=', comment) else { return Ok(()) };
        let (name, value) = (&comment[..equals], comment[equals + 1..].trim_ascii());
        match name {
            b"$FILEVERSION" => {
                let columns = match value {
                    b"1.0" => b"NOILD".as_slice(),
                    b"1.1" => b"NOTILD",
                    b"1.2" => b"NOBTILD",
                    b"1.3" => b"NOBTIRLD",
                    b"2.0" => b"NOTIdlD",
                    b"2.1" => b"NOTBIdRLD",
                    _ => b"",
                };
                self.is_known = !columns.is_empty();
                self.columns = Columns::of(columns);
            }
            b"$STARTTIME" => {
                let value = value.strip_suffix(b";").unwrap_or(value);
                let days = number(value, NANOS_PER_DAY).ok_or(Reason::Expected {
                    found: Found::first(value),
                    expected: "the start in days since 1899-12-30, as in 45244.9259",
                })?;
                // Decimals of a day beyond a microsecond are what is left of converting it.
                let micros = (days - DAYS_BEFORE_1970 * NANOS_PER_DAY + 500).div_euclid(1000);
                self.start = Some(1000 * micros);
            }
            b"$COLUMNS" => self.columns = Columns::of(value),
            _ => {}
        }
        Ok(())
    }

    /// Reads a message into `frame`; returns whether it is a frame.
    fn message(&mut self, text: &[u8], frame: &mut Frame) -> Result<bool, Reason> {
        if !self.is_known {
            let expected =
                "a message of a trace of version 1.0 to 1.3, 2.0 or 2.1 after $FILEVERSION";
            return Err(Reason::Expected { found: Found::first(text), expected });
        }
        let message = self.split(text);
        let error = |class| Id::extended(class).ok_or(Reason::ExtendedRange(class));
        let (id, kind) = match meaning(&message)? {
            Meaning::Data(kind) => (identifier(message.id)?, kind),
            Meaning::Remote => {
                let length = announced(&message, Kind::Data)? as u8;
                (identifier(message.id)?, Kind::Remote { length })
            }
            Meaning::Error => (error(BUS_ERROR)?, Kind::Error),
            Meaning::Status if status(text) & STATUS_BUS_OFF != 0 => (error(BUS_OFF)?, Kind::Error),
            Meaning::Status | Meaning::Other => return Ok(false),
        };
        let length = match kind {
            Kind::Data | Kind::Fd { .. } => payload(&message, kind, frame)?,
            Kind::Remote { .. } | Kind::Error => 0,
        };
        (frame.id, frame.kind) = (id, kind);
        frame.set_length(length);
        frame.timestamp = self.instant(message.offset)?;
        self.name(message.bus)?;
        Ok(true)
    }

    /// Names the interface of the message after its bus.
    fn name(&mut self, bus: &[u8]) -> Result<(), Reason> {
        // A trace without this column is of one bus.
        let bus = if bus.is_empty() { b"1".as_slice() } else { bus };
        if bus.len() > 3 || !bus.iter().all(u8::is_ascii_digit) {
            return Err(Reason::Expected {
                found: Found::first(bus),
                expected: "the number of a bus",
            });
        }
        self.interface.clear();
        self.interface.extend_from_slice(b"bus");
        self.interface.extend_from_slice(bus);
        Ok(())
    }

    /// The words of the line in their columns; a line may be shorter than its columns.
    fn split<'a>(&self, text: &'a [u8]) -> Message<'a> {
        let (mut message, mut rest) = (Message::default(), text);
        for column in self.columns.0 {
            let (word, behind) = token(rest);
            match column {
                Column::Data => {
                    message.data = rest;
                    break;
                }
                Column::Offset => message.offset = word,
                Column::Type => message.kind = word,
                Column::Bus => message.bus = word,
                Column::Id => message.id = word,
                Column::Code => message.code = Some(word),
                Column::Length => message.length = Some(word),
                Column::Other => {}
            }
            rest = behind;
        }
        message
    }

    fn instant(&self, offset: &[u8]) -> Result<Timestamp, Reason> {
        let offset = number(offset, NANOS_PER_MILLISECOND).ok_or(Reason::Expected {
            found: Found::first(offset),
            expected: "the time since the start in milliseconds, as in 1059.900",
        })?;
        let nanos = i64::try_from(self.start.unwrap_or(0) + offset);
        nanos.map(Timestamp::from_nanos).map_err(|_| Reason::StampRange)
    }
}

fn meaning(message: &Message<'_>) -> Result<Meaning, Reason> {
    let fd = |flags| Ok(Meaning::Data(Kind::Fd { flags }));
    match message.kind {
        // Before version 2.0 the type is the direction, and a word among the data tells the rest.
        b"Rx" | b"Tx" | b"" => match token(message.data).0 {
            _ if message.id == b"FFFFFFFF" => Ok(Meaning::Status),
            b"RTR" => Ok(Meaning::Remote),
            b"ERROR" => Ok(Meaning::Error),
            _ => Ok(Meaning::Data(Kind::Data)),
        },
        b"DT" => Ok(Meaning::Data(Kind::Data)),
        b"RR" => Ok(Meaning::Remote),
        b"FD" => fd(0),
        b"FB" => fd(BIT_RATE_SWITCH),
        b"BI" => fd(ERROR_STATE),
        b"FE" => fd(BIT_RATE_SWITCH | ERROR_STATE),
        b"ER" | b"Error" => Ok(Meaning::Error),
        b"ST" | b"Warng" => Ok(Meaning::Status),
        b"EC" | b"EV" => Ok(Meaning::Other),
        other => Err(Reason::Expected {
            found: Found::first(other),
            expected: "the type of a message, such as Rx, Tx, DT, FD or RR",
        }),
    }
}

/// Status bits of a line: its last four bytes, the lowest last.
fn status(text: &[u8]) -> u32 {
    let words = text.split(|byte| byte.is_ascii_whitespace()).filter(|word| word.len() == 2);
    let bytes = words.filter_map(|word| Some(digit(word[0])? << 4 | digit(word[1])?));
    bytes.fold(0, |bits, byte| bits << 8 | u32::from(byte))
}

/// Identifier of four digits, or more for an extended one.
fn identifier(digits: &[u8]) -> Result<Id, Reason> {
    if digits.is_empty() || digits.len() > 8 {
        let expected = "an identifier of 4 hexadecimal digits, or 8 for an extended one";
        return Err(Reason::Expected { found: Found::first(digits), expected });
    }
    let mut value = 0;
    for byte in digits {
        let digit = digit(*byte).ok_or(Reason::IdentifierDigit(Found(Some(*byte))))?;
        value = value << 4 | u32::from(digit);
    }
    if digits.len() <= 4 {
        Id::standard(value).ok_or(Reason::StandardRange(value))
    } else {
        Id::extended(value).ok_or(Reason::ExtendedRange(value))
    }
}

/// Reads the payload of a data frame, and returns its length.
fn payload(message: &Message<'_>, kind: Kind, frame: &mut Frame) -> Result<usize, Reason> {
    let announced = announced(message, kind)?;
    let (bytes, mut rest) = (frame.buffer_mut(), message.data);
    for (found, byte) in bytes.iter_mut().take(announced).enumerate() {
        let (word, behind) = token(rest);
        let [high, low] = *word else {
            return Err(Reason::LengthMismatch { announced, found });
        };
        let value = |byte| digit(byte).ok_or(Reason::DataDigit(Found(Some(byte))));
        *byte = value(high)? << 4 | value(low)?;
        rest = behind;
    }
    match token(rest).0 {
        [] => Ok(announced),
        word => Err(Reason::Trailing(Found::first(word))),
    }
}

/// Number of bytes that the message announces.
fn announced(message: &Message<'_>, kind: Kind) -> Result<usize, Reason> {
    let word = message.length.or(message.code).unwrap_or(b"");
    let add = |value: usize, digit: &u8| {
        digit.is_ascii_digit().then(|| 10 * value + usize::from(digit - b'0'))
    };
    let number = Some(word).filter(|word| matches!(word.len(), 1..=2));
    let Some(number) = number.and_then(|word| word.iter().try_fold(0, add)) else {
        let expected = "the number of bytes of data, or its code";
        return Err(Reason::Expected { found: Found::first(word), expected });
    };
    let by_code = message.length.is_none();
    match kind {
        Kind::Fd { .. } if by_code && number > 8 => {
            FD_LENGTHS.get(number).copied().ok_or(Reason::FdTooLong)
        }
        Kind::Fd { .. } if !is_fd_length(number) => Err(Reason::FdLength(number)),
        Kind::Fd { .. } => Ok(number),
        _ if number > 8 => Err(Reason::ClassicLength),
        _ => Ok(number),
    }
}
