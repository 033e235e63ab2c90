//! The standing warnings as CANopen has errors: codes, the error register, the history.

use tertius_core::alarm::frames::{fault_code, warning_bytes};
use tertius_core::alarm::register::PLACES;
use tertius_core::alarm::status::MAX_CYLINDERS;
use tertius_core::alarm::{State, Warning};
use tertius_core::verdict::Fault;

/// Most errors in the history.
pub(super) const HISTORY: usize = 16;

/// Class of the error codes that a device defines itself, CiA 301.
const DEVICE_SPECIFIC: u16 = 0xFF00;

/// Error code of an error that is gone.
const NO_ERROR: u16 = 0x0000;

/// Bits of the error register: any error, one of communication, one of the manufacturer's.
const GENERIC: u8 = 1 << 0;
const COMMUNICATION: u8 = 1 << 4;
const MANUFACTURER: u8 = 1 << 7;

/// Contents of an emergency message.
pub(super) struct Emergency {
    pub(super) code: u16,
    pub(super) register: u8,
    /// Bytes 3 to 7 of the Fd_Warning.
    pub(super) info: [u8; 5],
}

/// Errors that stand, and those that were.
#[derive(Clone, Debug, Default)]
pub(super) struct Errors {
    /// Bits of the error register by each warning that stands.
    standing: [[u8; PLACES]; MAX_CYLINDERS],
    /// Error codes and the first two bytes of the info, newest first.
    history: [u32; HISTORY],
    length: usize,
}

impl Errors {
    /// The error register, 0x1001.
    pub(super) fn register(&self) -> u8 {
        self.standing.iter().flatten().fold(0, |all, bits| all | bits)
    }

    /// The history, 0x1003, newest first.
    pub(super) fn history(&self) -> &[u32] {
        &self.history[..self.length]
    }

    /// Empties the history. What stands still stands.
    pub(super) fn clear_history(&mut self) {
        self.length = 0;
    }

    /// Takes a warning; returns the emergency message if it was raised or cleared.
    pub(super) fn take(&mut self, warning: &Warning) -> Option<Emergency> {
        let index = usize::from(warning.cylinder).wrapping_sub(1);
        let bits = self.standing.get_mut(index)?.get_mut(warning.place)?;
        let finding = &warning.finding;
        let stands = warning.state != State::Cleared;
        *bits = match (stands, finding.fault) {
            (false, _) => 0,
            (true, Fault::Stale) => GENERIC | COMMUNICATION,
            (true, _) => GENERIC | MANUFACTURER,
        };
        let info = warning_bytes(warning.cylinder, warning.detector, finding, stands);
        let register = self.register();
        let code = match warning.state {
            State::Raised => {
                let (table, fault) = fault_code(finding.fault);
                let fault = (table << 3 | fault) as u16;
                DEVICE_SPECIFIC | (warning.detector as u16) << 4 | fault
            }
            State::Changed => return None,
            State::Cleared => NO_ERROR,
        };
        if stands {
            self.remember(u32::from_le_bytes([code as u8, (code >> 8) as u8, info[0], info[1]]));
        }
        Some(Emergency { code, register, info })
    }

    fn remember(&mut self, error: u32) {
        self.length = (self.length + 1).min(HISTORY);
        self.history[..self.length].rotate_right(1);
        self.history[0] = error;
    }
}
