//! Evaluation of a cylinder in a cycle, and what it gives: records, what its devices said, dwells, warnings and estimates.

use super::cylinder::{Cycle, Evaluation};
use super::gate::Opening;
use super::{Monitor, Notice, Sink};
use crate::alarm::Detector;
use crate::time::Timestamp;

impl Monitor {
    pub(super) fn evaluate(&mut self, index: usize, at: Timestamp, sink: &mut impl Sink) {
        let cylinder = &mut self.cylinders[index];
        self.pending -= usize::from(cylinder.pending);
        let (gate, at_stop) = self.gate.look(at);
        let now = Evaluation {
            at,
            cycle: self.clock.number(),
            opened: self.clock.opened().unwrap_or(at),
            heard: self.heard,
            gate,
            at_stop,
        };
        self.opened_once |= now.gate == Opening::Open;
        let number = index as u8 + 1;
        let mut cycle = Cycle::new(now);
        cylinder.evaluate(&mut cycle, |transducer, reason| {
            let detector = [Detector::Fde1, Detector::Fde2][transducer as usize];
            sink.notice(&Notice::Restart { at, cylinder: number, detector, reason });
        });
        if sink.wants_records() {
            sink.record(&cylinder.record(&cycle));
        }
        cylinder.inputs.clear();
        self.report_devices(index, at, sink);
        if self.cylinders[index].readings.has_unnamed() {
            self.report_status_bits(index, at, sink);
        }
        if let Some(dwell) = self.cylinders[index].take_dwell() {
            sink.dwell(number, &dwell);
            self.judge_stops(at);
        }
        if self.cylinders[index].is_busy() || self.register.any(index) {
            self.report(index, now, sink);
        }
        if let Some(estimate) = self.cylinders[index].estimated() {
            sink.estimate(now.opened, number, estimate);
            if self.sends_estimates {
                sink.transmit(&self.encoder.estimate(at, number, estimate));
            }
        }
    }
}
