//! Emergency messages of CANopen devices (EMCY, CiA 301) and their words.

use crate::state::whole;
use core::fmt;

/// An emergency message: what a device says is wrong with itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Emergency {
    /// Error code; 0x0000 means that an error is over.
    pub code: u16,
    /// Error register, object 0x1001: the kinds of all errors that the device still has.
    pub register: u8,
    /// Field of the maker's own.
    pub detail: [u8; 5],
}

whole! { Emergency { code, register, detail } }

/// What an emergency message means for the readings of its device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The device is faulty.
    Faulty,
    /// The device complains about the network and not about itself: its readings are as good as before.
    Network,
    /// An error is over, and others are left.
    Remaining,
    /// No error is left.
    Over,
}

/// Bits of the error register.
const GENERIC: u8 = 1 << 0;
const COMMUNICATION: u8 = 1 << 4;

impl Emergency {
    /// Reads the payload of an emergency message; `None` if it is too short for a code and a register, as
    /// the empty message is that some devices send when they start.
    pub fn read(data: &[u8]) -> Option<Self> {
        let (&[low, high, register], rest) = data.split_first_chunk()?;
        let mut detail = [0; 5];
        detail.iter_mut().zip(rest).for_each(|(to, from)| *to = *from);
        Some(Self { code: u16::from_le_bytes([low, high]), register, detail })
    }

    /// What it means for the device's readings. Codes 0x81xx and 0x82xx are of communication and protocol:
    /// frames that the device missed, or a heartbeat that it waits for in vain.
    pub const fn severity(&self) -> Severity {
        match self.code >> 8 {
            0x00 if self.left() == 0 => Severity::Over,
            0x00 => Severity::Remaining,
            0x81 | 0x82 => Severity::Network,
            _ => Severity::Faulty,
        }
    }

    /// Bits of the errors that are left beside one of communication, which sets the generic bit, too.
    const fn left(&self) -> u8 {
        let own = self.register & !COMMUNICATION;
        if self.register & COMMUNICATION != 0 { own & !GENERIC } else { own }
    }

    /// The error code in the words of CiA 301.
    pub const fn words(&self) -> &'static str {
        match (self.code, self.code >> 8) {
            (_, 0x00) => "an error is left",
            (0x7300, _) => "sensor",
            (0x8110, _) => "CAN overrun, frames lost",
            (0x8120, _) => "CAN controller error passive",
            (0x8130, _) => "life guard or heartbeat error",
            (0x8140, _) => "recovered from bus-off",
            (0x8150, _) => "identifier collision",
            (0x8210, _) => "PDO too short",
            (0x8220, _) => "PDO too long",
            (0x8240, _) => "SYNC of another length",
            (0x8250, _) => "PDO timeout",
            (_, 0x10..=0x1F) => "generic error",
            (_, 0x21) => "current on the input side",
            (_, 0x22) => "current inside the device",
            (_, 0x23) => "current on the output side",
            (_, 0x20..=0x2F) => "current",
            (_, 0x31) => "mains voltage",
            (_, 0x32) => "voltage inside the device",
            (_, 0x33) => "output voltage",
            (_, 0x30..=0x3F) => "voltage",
            (_, 0x41) => "ambient temperature",
            (_, 0x42) => "device temperature",
            (_, 0x40..=0x4F) => "temperature",
            (_, 0x50..=0x5F) => "device hardware",
            (_, 0x61) => "internal software",
            (_, 0x62) => "user software",
            (_, 0x63) => "data set",
            (_, 0x60..=0x6F) => "device software",
            (_, 0x70..=0x7F) => "additional modules",
            (_, 0x81) => "communication",
            (_, 0x82) => "protocol",
            (_, 0x80..=0x8F) => "monitoring",
            (_, 0x90..=0x9F) => "external error",
            (_, 0xF0) => "additional functions",
            (_, 0xFF) => "the maker's own error",
            _ => "reserved code",
        }
    }

    /// Names of the bits of the error register that are set, without the generic one, which is always set.
    pub fn kinds(&self) -> impl Iterator<Item = &'static str> {
        const KINDS: [&str; 8] = [
            "generic",
            "current",
            "voltage",
            "temperature",
            "communication",
            "device profile",
            "reserved",
            "maker's own",
        ];
        let register = self.register;
        KINDS.into_iter().enumerate().skip(1).filter_map(move |(bit, kind)| {
            let set = register & (1 << bit) != 0;
            set.then_some(kind)
        })
    }
}

/// `EMCY 0x5000: device hardware (maker's own)`, and the maker's field if it is not zero.
impl fmt::Display for Emergency {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "EMCY 0x{:04X}: {}", self.code, self.words())?;
        let mut before = " (";
        for kind in self.kinds() {
            write!(f, "{before}{kind}")?;
            before = ", ";
        }
        f.write_str(if before == ", " { ")" } else { "" })?;
        if self.detail != [0; 5] {
            f.write_str(", field ")?;
            self.detail.iter().try_for_each(|byte| write!(f, "{byte:02X}"))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    fn emergency(code: u16, register: u8) -> Emergency {
        Emergency { code, register, detail: [0; 5] }
    }

    #[test]
    fn the_bytes_are_those_of_cia_301() {
        let read = Emergency::read(&[0x00, 0x50, 0x81, 1, 2, 3, 4, 5]).expect("it is whole");
        assert_eq!(read, Emergency { code: 0x5000, register: 0x81, detail: [1, 2, 3, 4, 5] });
        let text = "EMCY 0x5000: device hardware (maker's own), field 0102030405";
        assert_eq!(read.to_string(), text);
        assert_eq!(Emergency::read(&[0x10, 0x42, 9]).map(|it| it.code), Some(0x4210));
        for length in 0..3 {
            assert_eq!(Emergency::read(&[0xFF; 8][..length]), None, "{length}");
        }
    }

    #[test]
    fn an_error_is_over_when_none_is_left() {
        for (code, register, severity) in [
            (0x0000, 0x00, Severity::Over),
            (0x0000, 0x11, Severity::Over),
            (0x0000, 0x01, Severity::Remaining),
            (0x0000, 0x81, Severity::Remaining),
            (0x0000, 0x91, Severity::Remaining),
            (0x5000, 0x81, Severity::Faulty),
            (0x4210, 0x09, Severity::Faulty),
            (0xFF01, 0x00, Severity::Faulty),
            (0x8000, 0x11, Severity::Faulty),
            (0x8130, 0x11, Severity::Network),
            (0x8210, 0x11, Severity::Network),
        ] {
            let found = emergency(code, register).severity();
            assert_eq!(found, severity, "0x{code:04X} with 0x{register:02X}");
        }
    }

    #[test]
    fn words_are_of_the_most_special_class() {
        for (code, words) in [
            (0x1000, "generic error"),
            (0x2200, "current inside the device"),
            (0x3100, "mains voltage"),
            (0x4210, "device temperature"),
            (0x5000, "device hardware"),
            (0x6320, "data set"),
            (0x7300, "sensor"),
            (0x7010, "additional modules"),
            (0x8120, "CAN controller error passive"),
            (0x8199, "communication"),
            (0xFF10, "the maker's own error"),
            (0xA000, "reserved code"),
        ] {
            assert_eq!(emergency(code, 1).words(), words, "0x{code:04X}");
        }
        let over_heated = emergency(0x4210, 0b1001).to_string();
        assert_eq!(over_heated, "EMCY 0x4210: device temperature (temperature)");
        assert_eq!(emergency(0x1000, 1).to_string(), "EMCY 0x1000: generic error");
    }
}
