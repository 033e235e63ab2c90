//! Writes the events of the data path to the telemetry.

use super::clock::Clock;
use super::trend::Filling;
use super::{DETECTORS, NO_STATE, Telemetry, mark};
use crate::bus::{Port, PortCounts};
use crate::live::gateway::Gateway;
use crate::live::outbox::{OutboxCounts, OutboxLimits};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use tertius_core::alarm::status::{MAX_CYLINDERS, Status};
use tertius_core::alarm::{OwnFrame, OwnMessage, State, Warning};
use tertius_core::estimate::Estimate;
use tertius_core::incident::Incident;
use tertius_core::monitor::{Counts, Monitor, Notice, Record};
use tertius_core::sample::device::{DeviceNews, DeviceRole, DeviceState};
use tertius_core::time::Timestamp;

/// Most warnings whose frame may still wait to be sent.
const ON_THEIR_WAY: usize = OutboxLimits::WAITING;

/// Writes to a [`Telemetry`]. Each has exactly one recorder, since its totals allow only one
/// writer.
pub struct Recorder {
    telemetry: Arc<Telemetry>,
    clock: Arc<dyn Clock>,
    port: PortCounts,
    outbox: OutboxCounts,
    /// Frames of other devices with an own identifier that are counted already.
    imitated: u64,
    monitor: Counts,
    /// Whether a port was lost and none has been opened since.
    is_lost: bool,
    /// Time of the newest status that was taken over.
    status_at: Option<Timestamp>,
    /// Times of the newest warnings, by which their frames are recognised.
    warned: [Option<Timestamp>; ON_THEIR_WAY],
    next: usize,
    /// Bins of the trends that are not complete.
    filling: [Filling; MAX_CYLINDERS],
}

impl Recorder {
    pub fn new(clock: Arc<dyn Clock>) -> Self {
        Self {
            telemetry: Arc::new(Telemetry::new(&*clock)),
            clock,
            port: PortCounts::default(),
            outbox: OutboxCounts::default(),
            imitated: 0,
            monitor: Counts::default(),
            is_lost: false,
            status_at: None,
            warned: [None; ON_THEIR_WAY],
            next: 0,
            filling: Default::default(),
        }
    }

    pub const fn telemetry(&self) -> &Arc<Telemetry> {
        &self.telemetry
    }

    pub const fn clock(&self) -> &Arc<dyn Clock> {
        &self.clock
    }

    /// Takes a cycle of one cylinder.
    pub fn record(&mut self, record: &Record) {
        let index = usize::from(record.cylinder).wrapping_sub(1);
        let Some(cylinder) = self.telemetry.cylinders.get(index) else { return };
        for (i, residual) in record.residuals.iter().enumerate() {
            let size = residual.map(f64::abs).filter(|size| size.is_finite());
            cylinder.residuals[i].set(size);
            if let Some(size) = size {
                cylinder.sizes[i].observe(size);
            }
        }
        let apart = record.c1.zip(record.c2).map(|(c1, c2)| (c1 - c2).abs());
        cylinder.measured.set(apart.filter(|apart| apart.is_finite()));
        cylinder.incidents.reach(|| cylinder.quantities());
        self.filling[index].record(record, &cylinder.trend);
    }

    /// Takes the estimated length of a cylinder, after the record of its cycle.
    pub fn estimate(&mut self, cylinder: u8, estimate: Option<&Estimate>) {
        let index = usize::from(cylinder).wrapping_sub(1);
        let Some(of) = self.telemetry.cylinders.get(index) else { return };
        let valid = estimate.filter(|estimate| estimate.valid);
        of.estimate.set(valid.map(|estimate| estimate.position));
        of.sigma.set(valid.map(|estimate| estimate.sigma));
        self.filling[index].estimate(valid);
    }

    /// Takes what a device said of itself.
    pub fn notice(&self, notice: &Notice) {
        let Notice::Device { cylinder, role, news: DeviceNews::State(state), .. } = notice else {
            return;
        };
        let which = match role {
            DeviceRole::C1 => 0,
            DeviceRole::C2 => 1,
            DeviceRole::Valve => return,
        };
        let index = usize::from(*cylinder).wrapping_sub(1);
        if let Some(of) = self.telemetry.cylinders.get(index) {
            let idle = *state != DeviceState::Operational;
            of.idle[which].store(idle, Ordering::Relaxed);
        }
    }

    pub fn warning(&mut self, warning: &Warning) {
        self.warned[self.next] = Some(warning.timestamp);
        self.next = (self.next + 1) % ON_THEIR_WAY;
        let index = usize::from(warning.cylinder).wrapping_sub(1);
        let (Some(cylinder), State::Raised) = (self.telemetry.cylinders.get(index), warning.state)
        else {
            return;
        };
        let detector = warning.detector as usize - 1;
        debug_assert!(detector < DETECTORS, "the numbers of Fd_Warning begin with 1");
        cylinder.raised[detector].add(1);
    }

    /// Takes an incident that was opened, revised or closed.
    pub fn incident(&mut self, incident: &Incident) {
        let Some(number) = incident.scope.cylinder() else {
            return self.telemetry.shared.take(incident);
        };
        if let Some(cylinder) = self.telemetry.cylinders.get(usize::from(number).wrapping_sub(1)) {
            cylinder.incidents.take(incident);
        }
    }

    /// Notes that `frame` was handed to the interface. A warning's frame bears the time of the
    /// frame or the deadline that caused it; repetitions and statuses are caused by the clock and
    /// do not count.
    pub fn sent(&mut self, frame: &OwnFrame) {
        let at = frame.as_frame().timestamp;
        if frame.message() == Some(OwnMessage::Warning) && self.warned.contains(&Some(at)) {
            // Below zero only if the clock was set in between.
            let latency = self.clock.system().since(at).as_seconds().max(0.0);
            self.telemetry.latency.observe(latency);
        }
    }

    /// Notes that a port is open.
    pub fn opened(&mut self) {
        let telemetry = &self.telemetry;
        telemetry.totals.opens.add(1);
        telemetry.totals.reconnects.add(u64::from(self.is_lost));
        telemetry.open.store(true, Ordering::Relaxed);
        self.is_lost = false;
        self.port = PortCounts::default();
    }

    /// Notes that `port` is lost.
    pub fn closed(&mut self, gateway: &Gateway, port: &dyn Port) {
        self.catch_up(gateway, port);
        self.lost();
    }

    /// Notes that the port is lost, of which everything was counted.
    pub fn lost(&mut self) {
        self.telemetry.totals.losses.add(1);
        self.telemetry.open.store(false, Ordering::Relaxed);
        self.telemetry.forget_evidence();
        self.is_lost = true;
    }

    /// Notes a turn of the data path.
    pub fn turned(&mut self, gateway: &Gateway, port: &dyn Port) {
        let used = self.monitor.used;
        self.catch_up(gateway, port);
        self.look(gateway.monitor(), used);
    }

    /// Notes a turn of a monitor that only listens.
    pub fn listened(&mut self, monitor: &Monitor, port: PortCounts) {
        let used = self.monitor.used;
        self.count(monitor, port);
        self.look(monitor, used);
    }

    /// Takes over the state of `monitor`, which had used so many frames before this turn.
    fn look(&mut self, monitor: &Monitor, used: u64) {
        let now = self.clock.uptime();
        let heard = monitor.counts().used != used;
        let telemetry = &self.telemetry;
        telemetry.totals.turns.add(1);
        mark(&telemetry.turned, now);
        if heard {
            mark(&telemetry.heard, now);
        }
        let platform = monitor.platform().unwrap_or(NO_STATE);
        telemetry.platform.store(platform, Ordering::Relaxed);
        // One from before a loss says nothing of now: only a new one is taken over.
        if let Some((at, status)) = monitor.last_status()
            && self.status_at != Some(*at)
        {
            self.status_at = Some(*at);
            telemetry.publish(status, monitor.lacking());
        }
    }

    /// Notes that a new configuration is in force: another gateway, which knows nothing yet.
    pub fn reloaded(&mut self) {
        let telemetry = &self.telemetry;
        telemetry.totals.reloads_accepted.add(1);
        telemetry.publish(&Status::default(), Default::default());
        telemetry.forget_evidence();
        telemetry.cylinders.iter().for_each(|cylinder| cylinder.incidents.clear());
        telemetry.shared.clear();
        telemetry.open.store(false, Ordering::Relaxed);
        (self.outbox, self.monitor) = (OutboxCounts::default(), Counts::default());
        self.imitated = 0;
        self.status_at = None;
        self.warned = [None; ON_THEIR_WAY];
    }

    /// Notes that a new configuration was refused.
    pub fn refused(&mut self) {
        self.telemetry.totals.reloads_refused.add(1);
    }

    fn catch_up(&mut self, gateway: &Gateway, port: &dyn Port) {
        let outbox = *gateway.outbox().counts();
        self.telemetry.totals.outbox(&self.outbox, &outbox);
        self.outbox = outbox;
        self.telemetry.totals.imitated.follow(self.imitated, gateway.imitated());
        self.imitated = gateway.imitated();
        self.count(gateway.monitor(), port.counts());
    }

    fn count(&mut self, monitor: &Monitor, port: PortCounts) {
        let (telemetry, counts) = (&self.telemetry, *monitor.counts());
        telemetry.totals.port(&self.port, &port);
        telemetry.totals.monitor(&self.monitor, &counts);
        (self.port, self.monitor) = (port, counts);
        let cylinders = monitor.tallies().count().min(MAX_CYLINDERS) as u8;
        telemetry.used.store(cylinders, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appliance::telemetry::clock::SystemClock;
    use tertius_core::alarm::register::{DETECTORS, PLACES};
    use tertius_core::alarm::{Encoder, Finding, Level};
    use tertius_core::blame::Rule;
    use tertius_core::verdict::{Fault, Suspect};

    /// Every place is raised and cleared in one turn, and all of it is sent after that.
    #[test]
    fn the_way_of_every_warning_that_can_wait_is_timed() {
        let mut recorder = Recorder::new(Arc::new(SystemClock::new()));
        let mut encoder = Encoder::new(81).expect("81 is a node");
        let finding = Finding {
            fault: Fault::Abrupt,
            suspect: Suspect::C1,
            rule: Rule::OneObserver,
            level: Level::Yellow,
            residual: None,
            threshold: None,
            evidence: None,
            device: None,
        };
        let mut frames = Vec::new();
        for (turn, state) in [State::Raised, State::Cleared].into_iter().enumerate() {
            for cylinder in 1..=MAX_CYLINDERS as u8 {
                for (place, detector) in DETECTORS.into_iter().enumerate() {
                    let nanos = (turn * MAX_CYLINDERS + usize::from(cylinder)) * PLACES + place;
                    let timestamp = Timestamp::from_nanos(nanos as i64);
                    recorder.warning(&Warning {
                        timestamp,
                        cylinder,
                        detector,
                        place,
                        state,
                        finding,
                    });
                    frames.push(encoder.warning(timestamp, cylinder, detector, &finding, true));
                }
            }
        }
        frames.iter().for_each(|frame| recorder.sent(frame));
        let count: u64 = recorder.telemetry.latency.buckets().iter().map(|bucket| bucket.1).sum();
        assert_eq!(count, 2 * (MAX_CYLINDERS * PLACES) as u64);
    }
}
