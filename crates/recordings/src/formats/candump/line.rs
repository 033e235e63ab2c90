//! A line split into time stamp, interface, and the frame's text in one of two forms.

use tertius_core::frame::Frame;

use super::stamp::Stamp;
use super::{Extent, Found, Reason, console, log};
use crate::formats::token::token;
use crate::limits::MAX_INTERFACE;

/// Form of the frame's text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// Log form, `181#E02D`.
    Log,
    /// Console form, `181   [2]  E0 2D`.
    Console,
}

/// A line whose time stamp and interface were read.
#[derive(Clone, Copy, Debug)]
pub struct Line<'a> {
    pub stamp: Stamp,
    pub interface: &'a [u8],
    form: Form,
    frame: &'a [u8],
}

impl<'a> Line<'a> {
    /// Reads up to the interface; `None` for a line without content.
    pub fn parse(text: &'a [u8]) -> Result<Option<Self>, Reason> {
        // Editors put a byte order mark before the first line.
        let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text);
        // candump -e explains error frames in lines that begin with a tab.
        let explains =
            text.first() == Some(&b'\t') && text.get(1).is_some_and(u8::is_ascii_lowercase);
        let text = text.trim_ascii();
        if text.is_empty() || explains {
            return Ok(None);
        }
        let Some(rest) = text.strip_prefix(b"(") else {
            let drops = text.starts_with(b"DROPCOUNT:");
            let none = Reason::NoStamp(Found::first(text));
            return Err(if drops { Reason::DropCount } else { none });
        };
        let end = memchr::memchr(b')', rest).ok_or(Reason::OpenStamp)?;
        let stamp = Stamp::parse(rest[..end].trim_ascii())?;
        let (interface, frame) = token(&rest[end + 1..]);
        check_interface(interface)?;
        let (first, _) = token(frame);
        let form = if memchr::memchr(b'#', first).is_some() { Form::Log } else { Form::Console };
        Ok(Some(Self { stamp, interface, form, frame }))
    }

    /// Whether its time stamp may count from the previous line, as written by `-td` and `-tz`.
    pub fn is_short_console(&self) -> bool {
        self.form == Form::Console && self.stamp.extent == Extent::Short
    }

    /// Reads everything except the time stamp into `frame`. After an error `frame` is undefined.
    pub fn read_frame(&self, frame: &mut Frame) -> Result<(), Reason> {
        match self.form {
            Form::Log => log::read(self.frame, frame),
            Form::Console => console::read(self.frame, frame),
        }
    }
}

fn check_interface(name: &[u8]) -> Result<(), Reason> {
    if name.len() > MAX_INTERFACE {
        return Err(Reason::InterfaceTooLong(name.len()));
    }
    let strange = name.iter().copied().find(|byte| !byte.is_ascii_graphic() || *byte == b'#');
    match strange {
        Some(byte) => Err(Reason::Interface(Found(Some(byte)))),
        None if name.is_empty() => Err(Reason::Interface(Found(None))),
        None => Ok(()),
    }
}
