//! Choice among a frame's time stamps.

use crate::bus::port::Stamps;
use tertius_core::time::{Span, Timestamp};

/// Largest difference of a controller's stamp from the kernel's of the same frame. The kernel's is
/// later by the time of interrupt and driver; a larger difference means that the two clocks are
/// independent. Most controllers' clocks are set when the interface comes up and then drift by some
/// 20 µs per second.
pub const HARDWARE_TOLERANCE: Span = Span::from_nanos(1_000_000);

/// Uses the controller's stamps while they agree with the system's clock, to which all deadlines
/// refer, and the kernel's for good once they do not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Choice(Stamps);

impl Choice {
    pub(super) const SOFTWARE: Self = Self(Stamps::Software);

    pub(super) fn stamps(self) -> Stamps {
        self.0
    }

    /// The stamp of a frame that carries these two; `None` if neither can be used.
    pub(super) fn of(
        &mut self,
        software: Option<Timestamp>,
        hardware: Option<Timestamp>,
    ) -> Option<Timestamp> {
        let (Some(kernel), Some(controller)) = (software, hardware) else { return software };
        if let Stamps::SoftwareAsHardwareDiffers(_) = self.0 {
            return software;
        }
        let ahead = controller.since(kernel);
        if ahead.as_nanos().unsigned_abs() > HARDWARE_TOLERANCE.as_nanos().unsigned_abs() {
            self.0 = Stamps::SoftwareAsHardwareDiffers(ahead);
            return software;
        }
        self.0 = Stamps::Hardware;
        hardware
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(nanos: i64) -> Option<Timestamp> {
        Some(Timestamp::from_nanos(nanos))
    }

    const NOW: i64 = 1_700_000_000_000_000_000;
    const MS: i64 = 1_000_000;

    #[test]
    fn software_where_there_is_nothing_else() {
        let mut choice = Choice::SOFTWARE;
        assert_eq!(choice.of(at(NOW), None), at(NOW));
        assert_eq!(choice.of(None, None), None);
        assert_eq!(choice.stamps(), Stamps::Software);
    }

    #[test]
    fn hardware_while_the_clocks_go_together() {
        let mut choice = Choice::SOFTWARE;
        for late in [0, 30_000, MS, -MS] {
            assert_eq!(choice.of(at(NOW + late), at(NOW)), at(NOW));
            assert_eq!(choice.stamps(), Stamps::Hardware);
        }
    }

    #[test]
    fn a_clock_that_counts_from_power_on_is_never_taken() {
        let mut choice = Choice::SOFTWARE;
        assert_eq!(choice.of(at(NOW), at(12 * MS)), at(NOW));
        assert!(matches!(choice.stamps(), Stamps::SoftwareAsHardwareDiffers(_)));
    }

    #[test]
    fn a_clock_that_drifts_off_is_left_for_good_and_it_is_said_by_how_much() {
        let mut choice = Choice::SOFTWARE;
        assert_eq!(choice.of(at(NOW + MS), at(NOW)), at(NOW));
        assert_eq!(choice.of(at(NOW + MS + 1), at(NOW)), at(NOW + MS + 1));
        assert_eq!(choice.of(at(NOW + 2 * MS), at(NOW + 2 * MS)), at(NOW + 2 * MS));
        assert_eq!(choice.stamps(), Stamps::SoftwareAsHardwareDiffers(Span::from_nanos(-MS - 1)));
    }

    #[test]
    fn a_frame_with_a_controllers_stamp_only_has_none_to_compare() {
        let mut choice = Choice::SOFTWARE;
        assert_eq!(choice.of(None, at(NOW)), None);
    }
}
