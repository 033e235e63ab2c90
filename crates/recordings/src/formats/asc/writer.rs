//! Writes Vector's logging format ASC, in UTC, with hexadecimal numbers and times since the start.

use std::io::Write;

use crate::encoder::{FrameEncoder, Unsayable};
use crate::format::fd_code;
use crate::formats::channels::Channels;
use crate::formats::civil::{CivilTime, start_of};
use tertius_core::frame::{Frame, Kind};

use super::flags::{BIT_RATE_SWITCH, ERROR_STATE};

const NANOS_PER_SECOND: u64 = 1_000_000_000;
const WEEKDAYS: [&str; 7] = ["Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"];
const MONTHS: [&str; 12] =
    ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];
/// Flags of a CAN FD frame: that it is one, bit rate switch, error state.
const FD: u32 = 0x1000;
const BRS: u32 = 0x2000;
const ESI: u32 = 0x4000;

/// The encoder of one log.
#[derive(Default)]
pub struct AscEncoder {
    /// Start since 1970, ns, once there was a frame.
    start: Option<i64>,
    channels: Channels,
}

impl FrameEncoder for AscEncoder {
    fn add(
        &mut self,
        interface: &str,
        frame: &Frame,
        bytes: &mut Vec<u8>,
    ) -> Result<(), Unsayable> {
        let nanos = frame.timestamp.as_nanos();
        let start = match self.start {
            Some(start) => start,
            None => self.begin(nanos, bytes),
        };
        if nanos < start {
            return Err(Unsayable::BeforeStart);
        }
        let channel = self.channels.number(interface).ok_or(Unsayable::Channel)?;
        let since = nanos.abs_diff(start);
        let (seconds, fraction) = (since / NANOS_PER_SECOND, since % NANOS_PER_SECOND);
        // As in candump's logs, nine decimals only where six are not exact.
        if fraction % 1000 == 0 {
            put(bytes, format_args!("{seconds:4}.{:06} ", fraction / 1000));
        } else {
            put(bytes, format_args!("{seconds:4}.{fraction:09} "));
        }
        event(channel, frame, bytes);
        Ok(())
    }

    fn finish(&mut self, bytes: &mut Vec<u8>) -> Option<Vec<u8>> {
        bytes.extend_from_slice(b"End TriggerBlock\n");
        None
    }

    fn channels(&self) -> &[(String, u16)] {
        self.channels.all()
    }
}

impl AscEncoder {
    /// Writes the head; returns the start.
    fn begin(&mut self, nanos: i64, bytes: &mut Vec<u8>) -> i64 {
        let start = start_of(nanos);
        self.start = Some(start);
        let date = date(start);
        put(
            bytes,
            format_args!(
                "date {date}\nbase hex  timestamps absolute\ninternal events logged\n\
                 // version 9.0.0\nBegin Triggerblock {date}\n   0.000000 Start of measurement\n"
            ),
        );
        start
    }
}

/// Appends text.
fn put(bytes: &mut Vec<u8>, text: std::fmt::Arguments<'_>) {
    bytes.write_fmt(text).expect("a vector takes all bytes");
}

/// A date such as `Tue Nov 14 10:13:20.000 pm 2023`, in English and by twelve hours as Vector's tools write it.
fn date(nanos: i64) -> String {
    let CivilTime { year, month, day, weekday, hour, minute, second, milli } = CivilTime::of(nanos);
    let (weekday, month) = (WEEKDAYS[weekday as usize], MONTHS[month as usize - 1]);
    let half = if hour < 12 { "am" } else { "pm" };
    let hour = if hour % 12 == 0 { 12 } else { hour % 12 };
    format!("{weekday} {month} {day:02} {hour:02}:{minute:02}:{second:02}.{milli:03} {half} {year}")
}

/// Appends what follows the time of a frame.
fn event(channel: u16, frame: &Frame, bytes: &mut Vec<u8>) {
    let extended = if frame.id.is_extended() { "x" } else { "" };
    let id = format!("{:X}{extended}", frame.id.value());
    match frame.kind {
        Kind::Error => put(bytes, format_args!("{channel}  ErrorFrame")),
        Kind::Remote { length } => {
            put(bytes, format_args!("{channel}  {id:<15} Rx   r {length:x}"));
        }
        Kind::Data => {
            put(bytes, format_args!("{channel}  {id:<15} Rx   d {:x}", frame.data().len()));
            payload(frame, bytes);
        }
        Kind::Fd { flags } => {
            let (switch, state) = (flags & BIT_RATE_SWITCH != 0, flags & ERROR_STATE != 0);
            let (code, length) = (fd_code(frame.data().len()), frame.data().len());
            let name = "";
            put(
                bytes,
                format_args!(
                    "CANFD {channel:>3} Rx   {id:>8}  {name:>32} {} {} {code:x} {length:>2}",
                    u8::from(switch),
                    u8::from(state)
                ),
            );
            payload(frame, bytes);
            let set = |is: bool, flag| if is { flag } else { 0 };
            let flags = FD | set(switch, BRS) | set(state, ESI);
            // Duration, bits, flags, check sum, and the timing of bits: what is not known is 0.
            let none = 0;
            put(
                bytes,
                format_args!(
                    " {none:>8} {none:>4} {flags:>8X} {none:>8} {none:>8} {none:>8} {none:>8} {none:>8}"
                ),
            );
        }
    }
    bytes.push(b'\n');
}

fn payload(frame: &Frame, bytes: &mut Vec<u8>) {
    frame.data().iter().for_each(|byte| put(bytes, format_args!(" {byte:02X}")));
}
