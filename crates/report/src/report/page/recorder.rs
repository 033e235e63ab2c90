//! Gathers the data of a replay's page during the replay, in bounded memory.

use super::histogram::Histogram;
use super::traces::Trace;
use super::zoom::{Moment, Zooms};
use crate::report::episode;
use tertius_core::alarm::{Detector, Level, State, Warning};
use tertius_core::compare::Comparator;
use tertius_core::monitor::{MonitorDesign, Notice, Record};
use tertius_core::time::{Span, Timestamp};

/// Most jumps in time, and losses of the bus, that are marked; further ones are counted.
const MARKED: usize = 100;

/// Thresholds of one residual, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lower threshold δ_l, below which the residual counts towards clearing.
    pub low: f64,
    /// Upper threshold δ_h, or the bound of R3.
    pub high: f64,
}

/// Data that are drawn of one cylinder.
#[derive(Clone, Debug)]
pub struct Gathered {
    /// Bounds of R1, R2 and R3.
    pub bounds: [Bounds; 3],
    /// R1 and R2 where they are judged, and R3; shaded where neither FDE1 nor FDE2 judges.
    pub residuals: Trace<3>,
    pub histograms: [Histogram; 3],
    comparator: Comparator,
}

/// A raised warning on the figures' time axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Raised {
    pub t: f64,
    pub cylinder: u8,
    pub detector: Detector,
    /// Highest level that it has reached.
    pub level: Level,
}

/// Time axis of the figures: seconds since the first frame; where the time stamps jump it continues
/// as if no time had passed.
#[derive(Clone, Debug, Default)]
struct Axis {
    skipped: Span,
    jumps: u64,
    /// Times of the jumps.
    at: Vec<f64>,
}

/// Takes the monitor's output.
#[derive(Clone, Debug)]
pub struct PageRecorder {
    axis: Axis,
    cylinders: Vec<Gathered>,
    zooms: Zooms,
    raised: Vec<Raised>,
    count: usize,
    /// Times at which the bus was lost.
    lost_at: Vec<f64>,
}

/// Everything that was gathered.
#[derive(Clone, Debug)]
pub struct Recorded {
    pub cylinders: Vec<Gathered>,
    pub zooms: Vec<super::zoom::Zoom>,
    /// Number of warnings that no zoom shows.
    pub not_zoomed: u64,
    /// The first warnings, as many as are kept for the page's table.
    pub raised: Vec<Raised>,
    /// Number of jumps of the time stamps.
    pub jumps: u64,
    /// Times of the first jumps of the time stamps.
    pub jumped_at: Vec<f64>,
    /// Times at which the bus was lost (the first ones).
    pub lost_at: Vec<f64>,
}

impl Axis {
    fn place(&self, first: Timestamp, at: Timestamp) -> f64 {
        let nanos = at.since(first).as_nanos().saturating_sub(self.skipped.as_nanos());
        Span::from_nanos(nanos).as_seconds()
    }

    fn jump(&mut self, first: Timestamp, at: Timestamp, by: Span) {
        let skipped = self.skipped.as_nanos().saturating_add(by.as_nanos());
        self.skipped = Span::from_nanos(skipped);
        self.jumps += 1;
        if self.at.len() < MARKED {
            self.at.push(self.place(first, at));
        }
    }
}

impl PageRecorder {
    /// A recorder for a monitor of `design`.
    pub fn new(design: &MonitorDesign) -> Self {
        let sample_time = design.timing.sample_time.as_seconds();
        let gathered = |cylinder: &tertius_core::monitor::cylinder::CylinderDesign| {
            let [observer, difference] = [cylinder.bank.observer, cylinder.bank.difference]
                .map(|thresholds| Bounds { low: thresholds.low, high: thresholds.high });
            let bounds = [observer, observer, difference];
            Gathered {
                bounds,
                residuals: Trace::new(sample_time),
                histograms: bounds.map(|bounds| Histogram::new(bounds.high)),
                comparator: cylinder.comparator,
            }
        };
        Self {
            axis: Axis::default(),
            cylinders: design.cylinders.iter().map(gathered).collect(),
            zooms: Zooms::new(design.cylinders.len()),
            raised: Vec::new(),
            count: 0,
            lost_at: Vec::new(),
        }
    }

    /// Takes a cycle of one cylinder; `first` is the time stamp of the recording's first frame.
    pub fn record(&mut self, first: Timestamp, record: &Record) {
        let t = self.axis.place(first, record.timestamp);
        let Some(cylinder) = self.cylinders.get_mut(usize::from(record.cylinder).wrapping_sub(1))
        else {
            return;
        };
        let [r1, r2, r3] = record.residuals;
        let judged = record.judged;
        let residuals = [r1.filter(|_| judged[0]), r2.filter(|_| judged[1]), r3];
        cylinder.residuals.add(t, residuals, record.gated);
        for (histogram, residual) in cylinder.histograms.iter_mut().zip(residuals) {
            residual.into_iter().for_each(|residual| histogram.add(residual));
        }
        let comparator = cylinder.comparator;
        let moment = Moment::new(t, record, residuals, |c2| comparator.corrected(c2));
        self.zooms.moment(record.cylinder, moment);
    }

    pub fn warning(&mut self, first: Timestamp, warning: &Warning) {
        match warning.state {
            State::Raised => {}
            State::Changed => return self.worsen(warning),
            State::Cleared => return,
        }
        let t = self.axis.place(first, warning.timestamp);
        let Warning { cylinder, detector, finding, .. } = *warning;
        if self.raised.len() < episode::KEPT {
            self.raised.push(Raised { t, cylinder, detector, level: finding.level });
        }
        self.zooms.warning(cylinder, self.count, t);
        self.count += 1;
    }

    /// Marks a warning by the highest level that it has reached.
    fn worsen(&mut self, warning: &Warning) {
        let Warning { cylinder, detector, finding, .. } = *warning;
        let is = |raised: &&mut Raised| (raised.cylinder, raised.detector) == (cylinder, detector);
        if let Some(raised) = self.raised.iter_mut().rfind(is) {
            raised.level = raised.level.max(finding.level);
        }
    }

    pub fn notice(&mut self, first: Timestamp, notice: &Notice) {
        match *notice {
            Notice::TimeJump { at, by } => {
                self.axis.jump(first, at, by);
                self.interrupt(self.axis.place(first, at));
            }
            Notice::Interruption { at, bus: None } => {
                let t = self.axis.place(first, at);
                if self.lost_at.len() < MARKED {
                    self.lost_at.push(t);
                }
                self.interrupt(t);
            }
            Notice::Gap { .. }
            | Notice::Interruption { bus: Some(_), .. }
            | Notice::Silence { .. }
            | Notice::Doubt { .. }
            | Notice::Restart { .. }
            | Notice::Timing { .. }
            | Notice::UnnamedStatus { .. }
            | Notice::Device { .. } => {}
        }
    }

    /// Separates the values before and after `t`, which do not belong together.
    fn interrupt(&mut self, t: f64) {
        self.cylinders.iter_mut().for_each(|cylinder| cylinder.residuals.interrupt());
        self.zooms.interrupt(t);
    }

    pub fn finish(self) -> Recorded {
        Recorded {
            cylinders: self.cylinders,
            not_zoomed: self.zooms.left_out(),
            zooms: self.zooms.finish(),
            raised: self.raised,
            jumps: self.axis.jumps,
            jumped_at: self.axis.at,
            lost_at: self.lost_at,
        }
    }
}

impl Recorded {
    /// Newest time on the figures' axis, s.
    pub fn end(&self) -> f64 {
        self.cylinders.iter().map(|cylinder| cylinder.residuals.end()).fold(0.0, f64::max)
    }
}
