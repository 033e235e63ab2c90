//! What incidents are told apart by: every number of the family, with its unit and source.

use crate::time::Span;

/// All of them. They were chosen on simulated machines.
#[derive(Clone, Debug, PartialEq)]
pub struct IncidentParameters {
    /// Cycles within which what several cylinders show has one cause, and for which an incident is held back until it is
    /// known whether others show the same, 1 to 10: a frame that is late is missed in this cycle or in the next one.
    pub moment: u32,
    /// Least number of cylinders that have something in common, …
    pub least: usize,
    /// … and the part of the machine's cylinders that has to be exceeded, 0 to 1: most of them.
    pub most: f64,
    /// Time after which what a single cylinder is left with is its own, s: that of a warning to clear.
    pub alone: f64,
    /// The same of a slow drift, s: transducers warm within minutes of each other, and cool likewise.
    pub alone_drift: f64,
    /// A fault near a threshold may be visible in a part of the motion only, and then again within this time, s: the period
    /// of a long wave.
    pub wave: f64,
    /// After a fault was seen to go it comes again within this time, s: a loose contact does so sooner.
    pub come_again: f64,
    /// Time after the begin within which the plausibility checks find out what is wrong with a reading, s.
    pub fact_within: f64,
    /// Part of R3 that may be left when the fault behind it has gone, 0 to 1.
    pub left: f64,
    /// Time after the begin within which a detector still sees the onset, s. What is raised later sees the fault's course or
    /// its end, and does not name its kind.
    pub onset: f64,
    /// An incident has grown when its largest value exceeds the reported one by this factor; above 1. A drift from a quarter of
    /// its limit to the trip at thirty times the limit is reported 22 times.
    pub growth: f64,
    /// Part of its limit up to which a size is not worth a report, 0 to 1.
    pub small: f64,
    /// Shortest time between two reports, if the second one is about growth or a further detector only, s: what a person can
    /// follow.
    pub pause: f64,
}

/// Times by which the warnings of a cylinder are one event, as the machine's owner has them in `[alarm]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EventTiming {
    /// Time within which findings are of one event.
    pub coincidence: Span,
    /// Time after which a warning clears.
    pub clear: Span,
}

impl EventTiming {
    /// Time after the last warning has cleared within which a fault near a threshold may show itself again.
    pub fn shown_again(&self) -> Span {
        let since_shown = IncidentParameters::DEFAULT.wave - self.clear.as_seconds();
        Span::from_seconds(since_shown.max(IncidentParameters::DEFAULT.come_again))
    }
}

impl IncidentParameters {
    pub const DEFAULT: Self = Self {
        moment: 2,
        least: 2,
        most: 0.5,
        alone: 1.0,
        alone_drift: 300.0,
        wave: 9.0,
        come_again: 4.0,
        fact_within: 2.0,
        left: 0.5,
        onset: 0.5,
        growth: 1.25,
        small: 0.25,
        pause: 5.0,
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A warning that takes longer to clear has been shown for as much of the wave's period longer.
    #[test]
    fn a_fault_shows_itself_again_within_a_wave_whatever_time_a_warning_takes_to_clear() {
        let shown_again = |clear: f64| {
            let [coincidence, clear] = [0.2, clear].map(Span::from_seconds);
            EventTiming { coincidence, clear }.shown_again().as_seconds()
        };
        assert_eq!([shown_again(1.0), shown_again(3.0), shown_again(60.0)], [8.0, 6.0, 4.0]);
    }
}
