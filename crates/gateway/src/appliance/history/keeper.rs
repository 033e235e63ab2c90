//! Keeps the readings on the stops across restarts and reloads.

use super::file::{HistoryFile, ReadError};
use super::worker::{self, Order};
use crate::appliance::telemetry::Telemetry;
use std::sync::Arc;
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use tertius_core::alarm::status::MAX_CYLINDERS;
use tertius_core::monitor::Monitor;
use tertius_core::sequential::{Archive, DriftLimits};
use tracing::{info, warn};

/// Most orders that wait for the disk: all rods come to rest at nearly the same time, and two more. An order that
/// does not fit is dropped, and the next one includes its data.
const WAITING: usize = MAX_CYLINDERS + 2;

/// What is kept, and in which file.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    /// Name of the machine.
    pub machine: String,
    pub cylinders: u8,
    pub limits: DriftLimits,
    /// File of the history; `None`: in memory only.
    pub file: Option<HistoryFile>,
}

/// The data path's side of the history. It waits only at the start and at the end.
#[derive(Debug)]
pub struct Keeper {
    /// Archive as it was read; for cylinders that are no longer read it is all there is.
    base: Archive,
    limits: DriftLimits,
    /// File that is written; `None` if it must not be.
    file: Option<HistoryFile>,
    /// Whether there is something not yet handed to the worker.
    pending: bool,
    orders: Option<SyncSender<Order>>,
    worker: Option<JoinHandle<()>>,
    telemetry: Arc<Telemetry>,
}

/// Result of reading a file.
enum Loaded {
    Archive(Archive),
    /// There is nothing; the file may be written.
    Nothing,
    /// The file must not be overwritten.
    Unusable,
}

impl Keeper {
    /// A keeper without data.
    pub fn new(telemetry: &Arc<Telemetry>) -> Self {
        let mut keeper = Self {
            base: Archive::default(),
            limits: DriftLimits { maintenance: f64::INFINITY, critical: f64::INFINITY },
            file: None,
            pending: false,
            orders: None,
            worker: None,
            telemetry: Arc::clone(telemetry),
        };
        keeper.start();
        keeper
    }

    /// Starts the worker thread; without one everything stays in memory.
    fn start(&mut self) {
        let (orders, ordered) = sync_channel(WAITING);
        let told = Arc::clone(&self.telemetry);
        let builder = std::thread::Builder::new().name("history".to_owned());
        match builder.spawn(move || worker::work(&ordered, &told)) {
            Ok(worker) => (self.orders, self.worker) = (Some(orders), Some(worker)),
            Err(error) => warn!("readings on the stops are kept in memory only: {error}"),
        }
    }

    /// Keeps `kept` from now on, and returns what its monitor restores: the content of its file, or
    /// the data of `before`, if that belongs to the same machine and the file is the same or new.
    pub fn open(&mut self, kept: Kept, before: Option<&Monitor>) -> &Archive {
        let Kept { machine, cylinders, limits, file } = kept;
        if let Some(monitor) = before {
            self.turned(monitor);
            monitor.save(&mut self.base);
        }
        let size = self.base.cylinders.len();
        let same = self.base.machine == machine && size == usize::from(cylinders);
        let moved = self.file != file;
        if before.is_some() && (moved || !same) {
            // What was ordered is on the disk before anything is read from it.
            self.join();
            self.start();
        }
        let loaded = match &file {
            Some(file) if moved || !same => load(file, &machine, cylinders),
            _ => Loaded::Nothing,
        };
        // What is in memory alone is to be written to the new file.
        self.pending = same && moved && matches!(loaded, Loaded::Nothing);
        self.file = file.filter(|_| !matches!(loaded, Loaded::Unusable));
        self.limits = limits;
        match loaded {
            Loaded::Archive(archive) => self.base = archive,
            _ if same => {}
            _ => self.base = Archive::new(&machine, cylinders),
        }
        // Told at once; it is written as soon as there is something new.
        self.order(Order { archive: self.base.clone(), limits, file: None });
        &self.base
    }

    /// Notes that a rod was read on its stop.
    pub const fn dwelt(&mut self) {
        self.pending = true;
    }

    /// Hands the readings of a turn of the data path to the worker. In a turn without a dwell this
    /// is a comparison, in one with a dwell a copy of at most 30 kB; the machine stands still then.
    pub fn turned(&mut self, monitor: &Monitor) {
        if std::mem::take(&mut self.pending) {
            let order = self.snapshot(monitor);
            self.order(order);
        }
    }

    /// Waits until everything is written, after the gateway has stopped.
    pub fn finish(&mut self, monitor: &Monitor) {
        let order = self.snapshot(monitor);
        if let Some(orders) = self.orders.take() {
            // A worker that panicked writes nothing any more.
            _ = orders.send(order);
        }
        self.join();
    }

    fn snapshot(&self, monitor: &Monitor) -> Order {
        let mut archive = self.base.clone();
        monitor.save(&mut archive);
        Order { archive, limits: self.limits, file: self.file.clone() }
    }

    fn order(&self, order: Order) {
        let refused = self.orders.as_ref().map(|orders| orders.try_send(order));
        if matches!(refused, Some(Err(TrySendError::Full(_)))) {
            self.telemetry.history_crowded();
        }
    }

    fn join(&mut self) {
        self.orders = None;
        if let Some(worker) = self.worker.take() {
            // It may have panicked; the gateway stops either way.
            _ = worker.join();
        }
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        self.join();
    }
}

/// Reads `file` and logs the result. A file that is not a history of this machine is set aside.
fn load(file: &HistoryFile, machine: &str, cylinders: u8) -> Loaded {
    let path = file.path().display();
    let refusal = match file.read(machine, cylinders) {
        Ok(Some(archive)) => {
            let dwells: usize = archive.cylinders.iter().map(|it| it.dwells().len()).sum();
            info!(dwells, "continuing the history of the stops in {path}");
            return Loaded::Archive(archive);
        }
        Ok(None) => {
            info!("there is no history of the stops in {path} yet");
            return Loaded::Nothing;
        }
        Err(ReadError::Refused(refusal)) => refusal,
        Err(ReadError::Io(error)) => {
            warn!(
                "{path} cannot be read: {error}. It stays as it is, and the history of the stops is \
                 kept in memory only; give the gateway access to it, then reload"
            );
            return Loaded::Unusable;
        }
    };
    match file.set_aside() {
        Ok(aside) => {
            let aside = aside.display();
            warn!("{path}: {refusal}. It was set aside as {aside}; the history restarts");
            Loaded::Nothing
        }
        Err(error) => {
            warn!(
                "{path}: {refusal}. It cannot be set aside ({error}) and stays as it is; the \
                 history restarts and is kept in memory only"
            );
            Loaded::Unusable
        }
    }
}
