//! Frames that a full bus brings in a second, and the buffer that the kernel needs for them.

/// Bytes that the kernel charges to the receive queue for one frame, mostly for the socket buffer's
/// structures. 576 to 768 were measured; drivers that let the kernel round a frame's memory up to 1
/// KiB reach this value.
const CHARGE: u64 = 1280;

/// Length of the shortest classic frame, bits: no data, 11-bit identifier, no stuff bit, interframe
/// space.
const CLASSIC_BITS: f64 = 47.0;
/// Length of the shortest CAN FD frame, bits: the part at the nominal bit rate.
const FD_NOMINAL_BITS: f64 = 29.0;
/// Length of the shortest CAN FD frame, bits: the part at the bit rate of the data phase.
const FD_DATA_BITS: f64 = 32.0;

/// Nominal bit rate assumed where the interface does not tell it (vcan), bit/s: that of the fastest
/// controllers, like [`ASSUMED_DATA`].
const ASSUMED_NOMINAL: u32 = 1_000_000;
/// Bit rate of the data phase assumed where the interface does not tell it, bit/s.
const ASSUMED_DATA: u32 = 8_000_000;

/// Bit rates of a bus, bit/s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct BitRates {
    nominal: u32,
    /// Bit rate of the data phase; `None` on a classic bus.
    data: Option<u32>,
    assumed: bool,
}

impl BitRates {
    /// Bit rates of an interface, with assumptions where it does not tell them.
    pub(super) fn new(nominal: Option<u32>, data: Option<u32>, is_fd: bool) -> Self {
        match nominal {
            Some(nominal) => Self { nominal, data, assumed: false },
            None => Self {
                nominal: ASSUMED_NOMINAL,
                data: is_fd.then_some(ASSUMED_DATA),
                assumed: true,
            },
        }
    }

    /// Most frames that the bus can carry in a second.
    pub(super) fn frames_per_second(self) -> f64 {
        let nominal = f64::from(self.nominal);
        let classic = nominal / CLASSIC_BITS;
        let fd = |data: u32| 1.0 / (FD_NOMINAL_BITS / nominal + FD_DATA_BITS / f64::from(data));
        self.data.map_or(classic, |data| classic.max(fd(data)))
    }

    /// Bytes that the kernel charges for a second of a full bus.
    pub(super) fn second(self) -> u64 {
        self.frames_per_second().ceil() as u64 * CHARGE
    }

    /// Time in which a full bus fills a receive queue of `bytes`, s.
    pub(super) fn lasts(self, bytes: u64) -> f64 {
        bytes as f64 / CHARGE as f64 / self.frames_per_second()
    }
}

impl std::fmt::Display for BitRates {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} kbit/s", f64::from(self.nominal) / 1e3)?;
        if let Some(data) = self.data {
            write!(f, " ({} kbit/s data)", f64::from(data) / 1e3)?;
        }
        f.write_str(if self.assumed { ", assumed because the interface does not tell" } else { "" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_classic_bus() {
        let bus = BitRates::new(Some(500_000), None, false);
        assert_eq!(bus.frames_per_second().ceil(), 10_639.0);
        assert_eq!(bus.second(), 10_639 * CHARGE);
        assert!((bus.lasts(bus.second()) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_fast_data_phase_brings_more_frames() {
        let bus = BitRates::new(Some(1_000_000), Some(8_000_000), true);
        // 29 µs + 4 µs.
        assert!((bus.frames_per_second() - 30_303.0).abs() < 1.0);
        // A data phase no faster than the rest brings fewer than a classic bus may.
        let slow = BitRates::new(Some(1_000_000), Some(1_000_000), true);
        assert!((slow.frames_per_second() - 1e6 / 47.0).abs() < 1.0);
    }

    #[test]
    fn an_unknown_rate_is_the_fastest_and_is_said() {
        let bus = BitRates::new(None, None, true);
        assert_eq!(bus.second(), BitRates::new(Some(1_000_000), Some(8_000_000), true).second());
        assert!(bus.to_string().contains("assumed"), "{bus}");
        let classic = BitRates::new(None, None, false);
        assert_eq!(classic.second(), BitRates::new(Some(1_000_000), None, false).second());
    }
}
