//! What a full bus can bring in a second, and what the kernel needs to hold it.

/// What the kernel charges to the receive queue for one frame, bytes: the socket buffer's
/// structures, hardly the frame. 576 to 768 were measured; drivers that let the kernel round a
/// frame's memory up to 1 KiB come to this.
const CHARGE: u64 = 1280;

/// Shortest classic frame: no data, 11-bit identifier, no stuff bit, interframe space.
const CLASSIC_BITS: f64 = 47.0;
/// Shortest CAN FD frame: what goes at the nominal bit rate, and what at that of the data phase.
const FD_NOMINAL_BITS: f64 = 29.0;
const FD_DATA_BITS: f64 = 32.0;

/// Where the interface does not say (vcan): the fastest that CAN and usual CAN FD controllers go.
const ASSUMED_NOMINAL: u32 = 1_000_000;
const ASSUMED_DATA: u32 = 8_000_000;

/// The bit rates of a bus, bit/s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct BitRates {
    nominal: u32,
    /// Of the data phase; `None` on a classic bus.
    data: Option<u32>,
    assumed: bool,
}

impl BitRates {
    /// Those that the interface says, with an assumption where it does not.
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

    /// The most frames that the bus can carry in a second.
    pub(super) fn frames_per_second(self) -> f64 {
        let nominal = f64::from(self.nominal);
        let classic = nominal / CLASSIC_BITS;
        let fd = |data: u32| 1.0 / (FD_NOMINAL_BITS / nominal + FD_DATA_BITS / f64::from(data));
        self.data.map_or(classic, |data| classic.max(fd(data)))
    }

    /// What the kernel charges for a second of a full bus, bytes.
    pub(super) fn second(self) -> u64 {
        self.frames_per_second().ceil() as u64 * CHARGE
    }

    /// How long a full bus takes to fill a receive queue of `bytes`, s.
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
        f.write_str(if self.assumed { ", assumed as the interface says none" } else { "" })
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
