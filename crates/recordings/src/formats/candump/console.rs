//! A frame in the console form: `181   [2]  E0 2D`, `12345678  [03]  11 22 33`.

use tertius_core::frame::{Frame, Kind, MAX_DATA};

use super::log::identifier;
use super::{Found, Reason};
use crate::format::is_fd_length;
use crate::formats::hex;
use crate::formats::token::token;

/// CANFD_BRS and CANFD_ESI of linux/can.h.
const BIT_RATE_SWITCH: u8 = 1;
const ERROR_STATE: u8 = 2;

/// The announced number of bytes.
#[derive(Clone, Copy)]
enum Length {
    Classic(usize),
    Fd(usize),
}

/// Reads the frame, with the flags that `-x` adds before it and the text that `-a` adds after it.
pub fn read(text: &[u8], frame: &mut Frame) -> Result<(), Reason> {
    let (flags, text) = message_flags(text)?;
    let (digits, text) = token(text);
    if digits.is_empty() {
        return Err(Reason::NoFrame);
    }
    let (word, rest) = token(text);
    let length = announced(word)?;
    let (id, is_error) = identifier(digits)?;
    if let (b"remote", behind) = token(rest) {
        let Length::Classic(length) = length else { return Err(Reason::ErrorKind) };
        if is_error {
            return Err(Reason::ErrorKind);
        }
        only(behind, b"request")?;
        (frame.id, frame.kind) = (id, Kind::Remote { length: length as u8 });
        frame.set_length(0);
        return Ok(());
    }
    let (kind, count) = match length {
        Length::Fd(_) if is_error => return Err(Reason::ErrorKind),
        Length::Fd(count) => (Kind::Fd { flags }, count),
        Length::Classic(count) if is_error => (Kind::Error, count),
        Length::Classic(count) => (Kind::Data, count),
    };
    let behind = data(rest, count, frame.buffer_mut())?;
    ending(behind, count, is_error)?;
    (frame.id, frame.kind) = (id, kind);
    frame.set_length(count);
    Ok(())
}

/// Reads `RX - -`, `TX B E` and so on, if present.
fn message_flags(text: &[u8]) -> Result<(u8, &[u8]), Reason> {
    let (direction, rest) = token(text);
    if !matches!(direction, b"RX" | b"TX") {
        return Ok((0, text));
    }
    let (switch, rest) = token(rest);
    let (state, rest) = token(rest);
    let flag = |word: &[u8], letter: &[u8], flag| match word {
        b"-" => Ok(0),
        _ if word == letter => Ok(flag),
        _ => Err(Reason::Trailing(Found::first(word))),
    };
    Ok((flag(switch, b"B", BIT_RATE_SWITCH)? | flag(state, b"E", ERROR_STATE)?, rest))
}

/// Reads `[8]`, `{B}` (a raw length code, `candump -8`) or `[08]`.
fn announced(word: &[u8]) -> Result<Length, Reason> {
    match *word {
        [b'[', digit @ b'0'..=b'8', b']'] => Ok(Length::Classic(usize::from(digit - b'0'))),
        [b'[', b'9', b']'] => Err(Reason::ClassicLength),
        [b'{', digit, b'}'] => match hex::digit(digit) {
            Some(code) => Ok(Length::Classic(usize::from(code.min(8)))),
            None => Err(Reason::Length(Found(Some(digit)))),
        },
        [b'[', tens @ b'0'..=b'9', ones @ b'0'..=b'9', b']'] => {
            let length = usize::from(tens - b'0') * 10 + usize::from(ones - b'0');
            if is_fd_length(length) {
                Ok(Length::Fd(length))
            } else {
                Err(Reason::FdLength(length))
            }
        }
        [b'[', b'0'..=b'9', b'0'..=b'9', b'0'..=b'9', b'0'..=b'9', b']'] => Err(Reason::Xl),
        _ => Err(Reason::Length(Found::first(word))),
    }
}

/// Reads exactly `count` bytes and returns the text after them.
fn data<'a>(
    mut text: &'a [u8],
    count: usize,
    bytes: &mut [u8; MAX_DATA],
) -> Result<&'a [u8], Reason> {
    for (found, byte) in bytes.iter_mut().take(count).enumerate() {
        let (word, rest) = token(text);
        *byte = match *word {
            [high, low] => {
                let value = |byte| hex::digit(byte).ok_or(Reason::DataDigit(Found(Some(byte))));
                value(high)? << 4 | value(low)?
            }
            [] => return Err(Reason::LengthMismatch { announced: count, found }),
            [one] if one.is_ascii_hexdigit() => return Err(Reason::HalfByte),
            // ERRORFRAME or the characters come early.
            _ if !word[0].is_ascii_hexdigit() || word == b"ERRORFRAME" => {
                return Err(Reason::LengthMismatch { announced: count, found });
            }
            _ => return Err(Reason::DataWord(word.len())),
        };
        text = rest;
    }
    Ok(text)
}

/// Checks the end of the line: nothing, `ERRORFRAME` after an error frame, or `count` characters in
/// quotes.
fn ending(text: &[u8], count: usize, is_error: bool) -> Result<(), Reason> {
    let text = text.trim_ascii();
    match text {
        [] => Ok(()),
        b"ERRORFRAME" if is_error => Ok(()),
        [b'\'', .., b'\''] if text.len() == count + 2 => Ok(()),
        _ if is_byte(token(text).0) => {
            let words = text.split(|byte| matches!(byte, b' ' | b'\t'));
            let found = count + words.filter(|word| is_byte(word)).count();
            Err(Reason::LengthMismatch { announced: count, found })
        }
        _ => Err(Reason::Trailing(Found::first(text))),
    }
}

fn is_byte(word: &[u8]) -> bool {
    word.len() == 2 && word.iter().all(u8::is_ascii_hexdigit)
}

fn only(text: &[u8], expected: &[u8]) -> Result<(), Reason> {
    let (word, rest) = token(text);
    if word != expected {
        return Err(Reason::Trailing(Found::first(word)));
    }
    match token(rest).0 {
        [] => Ok(()),
        more => Err(Reason::Trailing(Found::first(more))),
    }
}
