//! The flight recorder: a ring of the last frames in memory, and a folder on disk for each incident, with the
//! frames around it and the configuration by which it was judged.
//!
//! ```text
//! data path                       worker                                     disk
//! frame → tap ── full block ────→ packer → ring ── opened ──→ recording ──→ folder
//!          ↑                         │
//!          └───── empty block ───────┘
//! ```
//!
//! The data path only copies a frame into a block that it already has (`tap`). Whatever takes time is the
//! worker's: it packs blocks (`packer`), keeps the last ones (`ring`), and writes a recording (`recording`)
//! once all of its frames have come (`folder`). Every ten seconds a copy of the monitor goes the same way, so that a
//! recording begins with what the monitor knew, and its replay says the same to the byte. If the worker falls behind,
//! frames are left out of the recording and counted, and nobody waits.

mod block;
mod folder;
mod manifest;
mod packer;
mod plan;
mod recording;
mod ring;
mod tap;
mod worker;

pub use folder::is_recording;
pub use plan::{FRAMES_FILE, FlightPlan, MANIFEST, STATE_FILE};
pub use ring::MOST_BYTES;

use super::telemetry::Telemetry;
use crate::live::gateway::Gateway;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use tap::Tap;
use tertius_core::alarm::OwnFrame;
use tertius_core::frame::Frame;
use tertius_core::incident::Incident;
use tertius_core::monitor::Monitor;
use tertius_core::time::Timestamp;
use tracing::warn;

/// The flight recorder as the data path knows it. Without a plan it does nothing.
#[derive(Debug)]
pub struct FlightRecorder {
    tap: Option<Tap>,
    /// The worker, and before it those of earlier configurations that may still write.
    workers: Vec<JoinHandle<()>>,
    /// Whether somebody has asked for the ring as it is.
    demand: Arc<AtomicBool>,
    telemetry: Arc<Telemetry>,
    /// Folder of the newest plan.
    folder: Option<PathBuf>,
}

impl FlightRecorder {
    /// A recorder without a plan, which counts in `telemetry`.
    pub fn new(telemetry: &Arc<Telemetry>) -> Self {
        Self {
            tap: None,
            workers: Vec::new(),
            demand: Arc::default(),
            telemetry: Arc::clone(telemetry),
            folder: None,
        }
    }

    /// A flag that, when set, has what is in the ring written to a folder, within about a second.
    pub fn demand(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.demand)
    }

    /// Records by `plan` from now on, beginning with `monitor`; `None` to record no more. Recordings that wait for further frames are written
    /// with those that they have, since a new configuration judges the next ones.
    pub fn follow(&mut self, plan: Option<FlightPlan>, monitor: &Monitor) {
        self.tap = None;
        self.workers.retain(|worker| !worker.is_finished());
        let Some(plan) = plan else { return };
        // What an earlier worker of this program is writing there is no leftover.
        let is_new = self.folder.replace(plan.folder.clone()).as_ref() != Some(&plan.folder);
        let (tap, work) = tap::connect(&self.telemetry, &self.demand, monitor);
        let (demand, telemetry) = (Arc::clone(&self.demand), Arc::clone(&self.telemetry));
        let builder = std::thread::Builder::new().name("recorder".to_owned());
        let run = move || worker::work(plan, work, is_new, demand, telemetry);
        match builder.spawn(run) {
            Ok(worker) => {
                self.workers.push(worker);
                self.tap = Some(tap);
            }
            Err(error) => warn!("incidents are not recorded: {error}"),
        }
    }

    /// Takes a frame from the bus.
    #[inline]
    pub fn frame(&mut self, frame: &Frame) {
        if let Some(tap) = &mut self.tap {
            tap.frame(frame.timestamp, frame);
        }
    }

    /// Takes a frame of the gateway's own that was handed to the bus at `at`.
    pub fn sent(&mut self, frame: &OwnFrame, at: Timestamp) {
        if let Some(tap) = &mut self.tap {
            tap.frame(at, frame.as_frame());
        }
    }

    /// Takes an incident that was opened, revised or closed.
    pub fn incident(&mut self, incident: &Incident) {
        if let Some(tap) = &mut self.tap {
            tap.incident(incident);
        }
    }

    /// Notes that `gateway` had a turn: about once a second a block is handed to the worker.
    pub fn turned(&mut self, gateway: &Gateway) {
        match &mut self.tap {
            Some(tap) => tap.turned(gateway.now(), gateway.monitor()),
            None if self.demand.load(Ordering::Relaxed) => {
                self.demand.store(false, Ordering::Relaxed);
                warn!("there is no recording to be written: `recorder.folder` is not configured");
            }
            None => {}
        }
    }

    /// Waits until everything is written, after the gateway has stopped.
    pub fn finish(&mut self) {
        self.tap = None;
        for worker in self.workers.drain(..) {
            // It may have panicked; the gateway stops either way.
            _ = worker.join();
        }
    }
}

impl Drop for FlightRecorder {
    fn drop(&mut self) {
        self.finish();
    }
}
