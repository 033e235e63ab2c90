//! Time for which frames occupy a bus.

use tertius_core::frame::{Frame, Kind};

/// Bit rates of a bus, bit/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rates {
    pub nominal: f64,
    /// Bit rate of CAN FD's data phase, bit/s; the nominal one where it does not differ.
    pub data: f64,
}

/// CAN FD's switch to the faster rate (CANFD_BRS), as candump shows it.
const BIT_RATE_SWITCH: u8 = 0x01;

/// Longest time for which `frame` occupies the bus, s: with interframe space, and a stuff bit
/// wherever the worst payload has one. The real time is up to a fifth less.
pub fn seconds_on_bus(frame: &Frame, rates: Rates) -> f64 {
    let extended = frame.id.is_extended();
    let payload = 8 * frame.length() as u64;
    match frame.kind {
        Kind::Data | Kind::Remote { .. } | Kind::Error => {
            // ISO 11898-1: of 47 (67) bits besides the payload, 34 (54) are stuffed, a bit each four.
            let (bits, stuffed) = if extended { (67, 54) } else { (47, 34) };
            (bits + payload + (stuffed + payload - 1) / 4) as f64 / rates.nominal
        }
        Kind::Fd { flags } => {
            let arbitration = if extended { 48 } else { 29 };
            // A CRC of 17 or 21 bits with its fixed stuff bits, the stuff count, ESI and DLC.
            let closing = if frame.length() <= 16 { 32 } else { 37 };
            let data = closing + payload + payload / 4;
            let rate = if flags & BIT_RATE_SWITCH != 0 { rates.data } else { rates.nominal };
            (arbitration + arbitration / 4) as f64 / rates.nominal + data as f64 / rate
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tertius_core::frame::Id;
    use tertius_core::time::Timestamp;

    fn bits(id: Option<Id>, kind: Kind, length: usize) -> f64 {
        let id = id.expect("it is in range");
        let frame = Frame::new(Timestamp::default(), id, kind, &[0; 64][..length]);
        seconds_on_bus(&frame, Rates { nominal: 1.0, data: 4.0 })
    }

    #[test]
    fn classic_frames_are_as_long_as_davis_and_burns_have_them() {
        // Davis et al. 2007: 55 + 10 n bits for 11-bit identifiers, 80 + 10 n for 29.
        for length in 0..=8 {
            let n = length as f64;
            assert_eq!(bits(Id::standard(0x181), Kind::Data, length), 55.0 + 10.0 * n);
            assert_eq!(bits(Id::extended(0x181), Kind::Data, length), 80.0 + 10.0 * n);
        }
    }

    #[test]
    fn a_fast_data_phase_is_shorter() {
        let slow = bits(Id::standard(1), Kind::Fd { flags: 0 }, 64);
        let fast = bits(Id::standard(1), Kind::Fd { flags: BIT_RATE_SWITCH }, 64);
        assert_eq!(slow, 36.0 + 677.0);
        assert_eq!(fast, 36.0 + 677.0 / 4.0);
    }
}
