//! The recorder's thread: packs what comes, and writes recordings.

use super::block::Block;
use super::folder::RecordingFolder;
use super::packer::Packer;
use super::plan::FlightPlan;
use super::recording::Recording;
use super::ring::Ring;
use super::tap::Work;
use crate::appliance::realtime;
use crate::appliance::telemetry::Telemetry;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};
use tertius_core::incident::{Incident, Progress};
use tertius_core::time::{Span, Timestamp};
use tracing::{info, warn};

/// Most recordings in progress: one for each cylinder, and some.
const AT_ONCE: usize = 8;

/// Longest wait for a block; the data path hands one over every second while a bus is there.
const PATIENCE: Duration = Duration::from_secs(2);

/// Time that the ring keeps beyond the configured one: the time between two states, a block, and an incident that is
/// opened a little after its begin.
const MARGIN: Span = Span::from_nanos(15_000_000_000);

struct Worker {
    plan: FlightPlan,
    packer: Packer,
    ring: Ring,
    open: Vec<Recording>,
    folder: RecordingFolder,
    /// Time of the data path.
    now: Timestamp,
    /// The obstacle that was logged last.
    trouble: Option<String>,
    telemetry: Arc<Telemetry>,
}

/// Works by `plan` until the data path has let go of its tap, and then writes what is in progress.
pub(super) fn work(
    plan: FlightPlan,
    work: Work,
    is_new: bool,
    demand: Arc<AtomicBool>,
    telemetry: Arc<Telemetry>,
) {
    realtime::be_ordinary();
    let mut worker = match Worker::new(plan, telemetry) {
        Ok(worker) => worker,
        Err(error) => {
            warn!("incidents are not recorded: {error}");
            return;
        }
    };
    if is_new {
        worker.tidy();
    }
    // A bus that is lost has no time of its own.
    let longest = Duration::from_nanos(worker.plan.after.as_nanos().unsigned_abs()) + PATIENCE;
    let mut heard = Instant::now();
    loop {
        match work.full.recv_timeout(PATIENCE) {
            Ok(mut block) => {
                heard = Instant::now();
                let (incidents, demanded) = (worker.take(&mut block), block.demanded);
                // Before anything is written, which may take long.
                block.clear();
                _ = work.empty.try_send(block);
                worker.follow(&incidents);
                if demanded {
                    worker.write_ring();
                }
            }
            Err(RecvTimeoutError::Timeout) => {
                if heard.elapsed() > longest {
                    worker.conclude_all();
                }
                // No block will bring it.
                if demand.swap(false, Ordering::Relaxed) {
                    worker.write_ring();
                }
            }
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    if demand.swap(false, Ordering::Relaxed) {
        worker.write_ring();
    }
    worker.conclude_all();
}

impl Worker {
    fn new(plan: FlightPlan, telemetry: Arc<Telemetry>) -> io::Result<Self> {
        let keep = plan.before.as_nanos().saturating_add(MARGIN.as_nanos());
        Ok(Self {
            packer: Packer::new(&plan.interfaces, plan.design)?,
            ring: Ring::new(Span::from_nanos(keep)),
            open: Vec::new(),
            folder: RecordingFolder::new(plan.folder.clone(), plan.size),
            now: Timestamp::default(),
            trouble: None,
            telemetry,
            plan,
        })
    }

    fn tidy(&mut self) {
        let path = self.folder.path().display();
        match self.folder.tidy() {
            Ok(0) => info!("incidents are recorded in {path}"),
            Ok(removed) => {
                info!(removed, "incidents are recorded in {path}; half recordings were there")
            }
            Err(error) => self.complain(&error),
        }
    }

    /// Packs a block, and returns its incidents.
    fn take(&mut self, block: &mut Block) -> Vec<Incident> {
        self.now = block.until;
        match self.packer.pack(block) {
            Ok(None) => {}
            Ok(Some(piece)) => {
                let piece = Arc::new(piece);
                self.open.iter_mut().for_each(|recording| recording.take(&piece));
                self.ring.push(piece);
            }
            Err(error) => {
                self.telemetry.recorder_written(false);
                self.complain(&error);
            }
        }
        self.telemetry.recorder_left_out(block.left_out);
        // Their memory stays in the block.
        block.incidents.drain(..).collect()
    }

    /// Begins, continues and ends recordings.
    fn follow(&mut self, incidents: &[Incident]) {
        for incident in incidents {
            if incident.progress == Progress::Opened {
                self.begin(incident);
            }
            let mut open = self.open.iter_mut();
            if let Some(recording) = open.find(|it| it.number() == Some(incident.number)) {
                recording.note(incident);
            }
        }
        let now = self.now;
        let over: Vec<_> = self.open.extract_if(.., |recording| recording.is_over(now)).collect();
        over.into_iter().for_each(|recording| self.write(&recording));
    }

    fn begin(&mut self, incident: &Incident) {
        if self.open.len() == AT_ONCE {
            self.telemetry.recorder_left_out(1);
            let (number, cylinder) = (incident.number, incident.scope.cylinder());
            warn!(
                incident = number,
                cylinder, "not recorded: {AT_ONCE} incidents are being recorded"
            );
            return;
        }
        self.open.push(Recording::of(incident, &self.ring, &self.plan));
    }

    fn conclude_all(&mut self) {
        let open = std::mem::take(&mut self.open);
        open.into_iter().for_each(|recording| self.write(&recording));
    }

    fn write_ring(&mut self) {
        self.write(&Recording::on_demand(self.now, &self.ring));
    }

    fn write(&mut self, recording: &Recording) {
        let manifest = match recording.manifest(&self.plan, self.now) {
            Ok(Some(manifest)) => manifest,
            Ok(None) => {
                info!("there is nothing to record: no frame has come");
                return;
            }
            Err(error) => return self.complain(&error),
        };
        let files = recording.files(&self.plan, &manifest);
        let written = self.folder.write(&recording.name(), &files);
        self.telemetry.recorder_written(written.is_ok());
        match written {
            Ok(path) => {
                self.trouble = None;
                info!("recorded in {}", path.display());
            }
            Err(error) => self.complain(&error),
        }
    }

    /// Logs an obstacle once, since a full disk stays full for long.
    fn complain(&mut self, error: &io::Error) {
        let told = format!("{}: {error}", self.folder.path().display());
        if self.trouble.as_ref() != Some(&told) {
            warn!("a recording cannot be written, {told}; it is tried again at the next incident");
            self.trouble = Some(told);
        }
    }
}
