//! What the machine's CANopen devices say of themselves: heartbeats, and emergency messages under a fault.

use super::arrivals::Arrivals;
use crate::inject::{Injector, Placed};
use tertius_config::settings::Settings;
use tertius_core::frame::{Frame, Id, Kind};
use tertius_core::time::{Span, Timestamp};
use tertius_dbc::Database;

/// Heartbeat of a device that is operational.
const OPERATIONAL: u8 = 5;

/// Time between the heartbeats of devices that were switched on together, for each node-ID.
const APART: Span = Span::from_nanos(1_000_000);

/// Identifier of what was not said yet.
const NO_ID: Id = Id::standard(0).expect("0 has at most 11 bits");

/// Services of all devices.
#[derive(Clone, Debug)]
pub struct Services {
    /// Heartbeats, in the order of the configuration.
    beats: Vec<Beat>,
    /// The newest emergency message of each device that a fault may make say one.
    emergencies: Vec<Frame>,
    /// The next emergency message of the same devices.
    scratch: Frame,
}

#[derive(Clone, Debug)]
struct Beat {
    frame: Frame,
    period: Span,
    due: Timestamp,
}

impl Services {
    /// The services of the devices of `settings` that have a heartbeat time in their EDS, or one of `faults`.
    /// The first heartbeats come after `epoch`.
    pub fn new(
        settings: &Settings,
        database: &Database,
        faults: &[Placed],
        epoch: Timestamp,
    ) -> Self {
        let frame = |id, data: &[u8]| Frame::new(Timestamp::default(), id, Kind::Data, data);
        let (mut beats, mut emergencies): (Vec<Beat>, Vec<Frame>) = (Vec::new(), Vec::new());
        for device in settings.devices() {
            let Some(services) = database.device_services(&device.name()) else { continue };
            if let (Some(id), Some(period)) = (services.heartbeat, services.period)
                // One node with several sensors has one heartbeat.
                && beats.iter().all(|beat| beat.frame.id != id)
            {
                let first = Span::from_nanos(APART.as_nanos() * i64::from(device.node));
                let (frame, due) = (frame(id, &[OPERATIONAL]), epoch.after(first));
                beats.push(Beat { frame, period: Span::from_seconds(period), due });
            }
            if let Some(id) = services.emergency
                && faults.iter().any(|fault| fault.id == id)
                && emergencies.iter().all(|known| known.id != id)
            {
                emergencies.push(frame(id, &[0; 8]));
            }
        }
        let scratch = Frame::new(epoch, NO_ID, Kind::Data, &[]);
        Self { beats, emergencies, scratch }
    }

    /// Sends what is due before `end`: after everything else of the cycle, in the order of the devices.
    pub fn send(
        &mut self,
        end: Timestamp,
        arrivals: &mut Arrivals,
        injector: &mut Injector,
        sink: &mut impl FnMut(&Frame),
    ) {
        for newest in &mut self.emergencies {
            // What it would say now; it says it if that is something else than before.
            self.scratch.clone_from(newest);
            self.scratch.buffer_mut().fill(0);
            self.scratch.timestamp = arrivals.free();
            let Some(said) = injector.take(&self.scratch) else { continue };
            if said.data() != newest.data() {
                newest.clone_from(said);
                newest.timestamp = arrivals.next(newest.length());
                sink(newest);
            }
        }
        for beat in self.beats.iter_mut().filter(|beat| beat.due < end) {
            beat.due = beat.due.after(beat.period);
            beat.frame.timestamp = arrivals.next(beat.frame.length());
            if let Some(frame) = injector.take(&beat.frame) {
                sink(frame);
            }
        }
    }
}
