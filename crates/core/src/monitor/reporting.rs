//! What the monitor reports: warnings, incidents, the frames about them, and Fd_Status, its report on itself.

use super::cylinder::{Cylinder, Evaluation};
use super::gate::Opening;
use super::sink::Notice;
use super::{Monitor, Sink};
use crate::alarm::own::Sending;
use crate::alarm::status::{Health, MAX_CYLINDERS, Mode, Status};
use crate::alarm::{OwnFrame, OwnMessage, State};
use crate::sample::Transducer;
use crate::sample::dispute::Doubt;
use crate::time::{Span, Timestamp};

/// Period of Fd_Status.
pub(super) const STATUS_PERIOD: Span = match OwnMessage::Status.sending() {
    Sending::Every(period) => period,
    Sending::Events | Sending::Cycles => panic!("it is the sign of life, and has a period"),
};

impl Monitor {
    /// Newest Fd_Status and its time.
    pub const fn last_status(&self) -> Option<&(Timestamp, Status)> {
        self.last_status.as_ref()
    }

    pub(super) fn send_status(&mut self, at: Timestamp, sink: &mut impl Sink) {
        let status = self.status(at);
        self.last_status = Some((at, status));
        sink.transmit(&self.encoder.status(at, &status));
        self.next_status = self.next_status.after(STATUS_PERIOD);
        self.judge_sync(at, sink);
    }

    /// Reports Sync that floods or is missing.
    fn judge_sync(&mut self, at: Timestamp, sink: &mut impl Sink) {
        let mut messages = self.subscriptions.all().iter().zip(&self.stations);
        let Some((sync, _)) = messages.find(|(_, station)| station.is_sync()) else { return };
        let judged = self.sync_watch.judge(at, self.clock.number(), self.counts.cycles);
        self.counts.sync_doubted += u64::from(judged.was_doubted);
        for (doubt, is_over) in [(judged.over, true), (judged.begins, false)] {
            let Some(doubt) = doubt else { continue };
            sink.notice(&Notice::Doubt { at, id: sync.id, bus: sync.bus, doubt, is_over });
        }
    }

    /// Passes on what is new of the cylinder of `index` in a cycle.
    #[cold]
    pub(super) fn report(&mut self, index: usize, now: Evaluation, sink: &mut impl Sink) {
        if self.cylinders[index].has_findings() || self.register.any(index) {
            self.warn(index, now.at, sink);
        }
        if self.cylinders[index].is_watched {
            self.follow_incidents(index, now, sink);
        }
    }

    /// Passes on what the detectors of the cylinder of `index` have found.
    pub(super) fn warn(&mut self, index: usize, at: Timestamp, sink: &mut impl Sink) {
        let findings = self.cylinders[index].findings();
        let Self { register, incidents, encoder, .. } = self;
        let is_news = register.update(at, index, &findings, |warning| {
            incidents.take(&warning);
            let raised = warning.state != State::Cleared;
            sink.warning(&warning);
            let frame =
                encoder.warning(at, warning.cylinder, warning.detector, &warning.finding, raised);
            sink.transmit(&frame);
        });
        if is_news {
            self.cylinders[index].is_watched = true;
            self.reckon_due();
        }
    }

    /// Passes on what became of the incidents of the cylinder of `index` in a cycle.
    pub(super) fn follow_incidents(&mut self, index: usize, now: Evaluation, sink: &mut impl Sink) {
        let Self { cylinders, incidents, .. } = self;
        let (cylinder, times) = (&mut cylinders[index], [now.opened, now.at]);
        cylinder.is_watched =
            incidents.follow(index, times, cylinder.quantities(), |it| sink.incident(it));
    }

    /// Passes on what became of the incidents of the machine in a cycle that ends at `at`.
    #[inline]
    pub(super) fn report_machine(&mut self, at: Timestamp, sink: &mut impl Sink) {
        self.incidents.follow_machine(at, |it| sink.incident(it));
    }

    pub(super) fn repeat_warnings(&mut self, at: Timestamp, sink: &mut impl Sink) {
        let Self { register, encoder, .. } = self;
        register.repeat(at, |cylinder, detector, finding| {
            sink.transmit(&encoder.warning(at, cylinder, detector, finding, true));
        });
    }

    /// The Fd_Status of a gateway that stops at `at`: the state of everything that is fitted is unknown from then on.
    pub fn stopping_status(&mut self, at: Timestamp) -> OwnFrame {
        let (level, active_warnings) = (self.register.level(), self.register.standing());
        let mut transducers = [[Health::Unknown; 2]; MAX_CYLINDERS];
        for (pair, cylinder) in transducers.iter_mut().zip(&self.cylinders) {
            if !cylinder.has(Transducer::C2) {
                pair[Transducer::C2 as usize] = Health::NotFitted;
            }
        }
        let status = Status { transducers, level, mode: Mode::Stopping, active_warnings };
        self.encoder.status(at, &status)
    }

    /// Reports what the devices of the cylinder of `index` have sent that is no fault.
    #[inline(always)]
    pub(super) fn report_devices(&mut self, index: usize, at: Timestamp, sink: &mut impl Sink) {
        if !self.cylinders[index].readings.has_devices() {
            return;
        }
        let cylinder = index as u8 + 1;
        self.cylinders[index].readings.take_news(|role, node, news| {
            sink.notice(&Notice::Device { at, cylinder, role, node, news });
        });
    }

    /// Reports bits that the status of a transducer of the cylinder of `index` has, and that mean nothing here.
    #[cold]
    pub(super) fn report_status_bits(&mut self, index: usize, at: Timestamp, sink: &mut impl Sink) {
        let cylinder = index as u8 + 1;
        for (transducer, bits) in self.cylinders[index].readings.take_unnamed() {
            self.counts.unnamed_status_bits += u64::from(bits.count_ones());
            sink.notice(&Notice::UnnamedStatus { at, cylinder, transducer, bits });
        }
    }

    /// What frames of C1 and of C2 of each cylinder lack of their configuration, now or as long ago as they are in doubt
    /// ([`crate::sample::parameters::ArrivalParameters::doubted`]): they are too short, which comes first, or their alive counter
    /// does not count.
    pub fn lacking(&self) -> [[Option<Doubt>; 2]; MAX_CYLINDERS] {
        let cycle = self.clock.number();
        let mut lacking = [[None; 2]; MAX_CYLINDERS];
        for page in self.stations.iter().flat_map(|station| &station.pages) {
            let Some(doubt) = page.slot.dispute.lacks(cycle) else { continue };
            for (bits, transducer) in page.transducers() {
                let of = |(index, _): &(usize, _)| bits >> index & 1 != 0;
                for (_, pair) in lacking.iter_mut().enumerate().filter(of) {
                    let place: &mut Option<Doubt> = &mut pair[transducer as usize];
                    *place = place.filter(|it| *it == Doubt::TooShort).or(Some(doubt));
                }
            }
        }
        lacking
    }

    /// The state of the whole monitor at `at`.
    pub fn status(&mut self, at: Timestamp) -> Status {
        let mut transducers = [[Health::Unknown; 2]; MAX_CYLINDERS];
        for (index, cylinder) in self.cylinders.iter().enumerate() {
            let stands = |suspect| self.register.blames(index, suspect);
            transducers[index] = cylinder.health(stands);
        }
        let (level, active_warnings) = (self.register.level(), self.register.standing());
        let all_judge = self.cylinders.iter().all(Cylinder::judges);
        let mode = match (self.gate.look(at).0, all_judge) {
            (Opening::Closed, _) => Mode::Gated,
            (Opening::Open, true) => Mode::Monitoring,
            // What is known to be wrong from the start on is not waited for.
            _ if self.monitored_once || active_warnings > 0 => Mode::Degraded,
            _ => Mode::Starting,
        };
        self.monitored_once |= mode == Mode::Monitoring;
        Status { transducers, level, mode, active_warnings }
    }
}
