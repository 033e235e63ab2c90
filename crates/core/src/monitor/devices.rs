//! Frames that devices send by themselves: readings by a timer of their own, emergency messages and
//! heartbeats; and what is told of these.

use super::Monitor;
use super::page::StationKind;
use super::sink::{Notice, Sink};
use super::subscriptions::DeviceService;
use crate::frame::Frame;
use crate::sample::device::DeviceState;
use crate::sample::emergency::Emergency;
use crate::time::Timestamp;

impl Monitor {
    /// Takes a frame at `place` that a device has sent by itself; returns whether it was one. A reading waits
    /// for the next Sync. An error of a device is warned of at once; all else has its effect in the next
    /// cycle, so that no flood of frames is one of warnings or notices.
    pub(super) fn hear(
        &mut self,
        place: usize,
        now: Timestamp,
        frame: &Frame,
        sink: &mut impl Sink,
    ) -> bool {
        let service = match &mut self.stations[place].kind {
            StationKind::Usual | StationKind::Sync => return false,
            StationKind::Timed(newest) => {
                self.heard.insert(frame.bus);
                newest.keep(frame);
                return true;
            }
            StationKind::Service(service) => service,
        };
        match service.service {
            DeviceService::Heartbeat => match DeviceState::read(frame.data()) {
                Some(state) => {
                    for (index, role) in &service.devices {
                        self.cylinders[usize::from(*index)].readings.hear_heartbeat(*role, state);
                    }
                }
                None => self.counts.bad_signals += 1,
            },
            DeviceService::Emergency => match Emergency::read(frame.data()) {
                Some(emergency) => self.hear_emergency(place, now, emergency, sink),
                None => self.counts.bad_signals += 1,
            },
        }
        true
    }

    fn hear_emergency(
        &mut self,
        place: usize,
        now: Timestamp,
        emergency: Emergency,
        sink: &mut impl Sink,
    ) {
        let mut next = 0;
        while let StationKind::Service(service) = &self.stations[place].kind
            && let Some(&(index, role)) = service.devices.get(next)
        {
            next += 1;
            let index = usize::from(index);
            if self.cylinders[index].readings.hear_emergency(role, now, emergency) {
                self.warn(index, now, sink);
            }
        }
    }

    /// Tells what the devices of the cylinder of `index` have said that is no fault.
    #[inline(always)]
    pub(super) fn tell_devices(&mut self, index: usize, at: Timestamp, sink: &mut impl Sink) {
        if !self.cylinders[index].readings.has_devices() {
            return;
        }
        let cylinder = index as u8 + 1;
        self.cylinders[index].readings.take_news(|role, node, news| {
            sink.notice(&Notice::Device { at, cylinder, role, node, news });
        });
    }
}
