//! Writes archives on a thread of its own, since the data path must not wait for a disk.

use super::file::HistoryFile;
use crate::appliance::realtime;
use crate::appliance::telemetry::Telemetry;
use std::sync::mpsc::Receiver;
use tertius_core::sequential::{Archive, DriftLimits};
use tracing::{info, warn};

/// An order of what to do with the readings on the stops.
#[derive(Debug)]
pub(super) struct Order {
    pub archive: Archive,
    pub limits: DriftLimits,
    /// File to write; `None` where the readings are only reported.
    pub file: Option<HistoryFile>,
}

/// Carries out orders until no more can come. Of several orders for the same file the newest
/// contains everything.
pub(super) fn work(orders: &Receiver<Order>, telemetry: &Telemetry) {
    realtime::be_ordinary();
    let mut trouble = None;
    let mut next = orders.recv().ok();
    while let Some(order) = next {
        next = orders.try_recv().ok();
        if next.as_ref().is_some_and(|next| next.file == order.file) {
            continue;
        }
        telemetry.stops(&order.archive, order.limits);
        if let Some(file) = order.file.as_ref().filter(|_| !order.archive.is_empty()) {
            save(file, &order.archive, &mut trouble, telemetry);
        }
        next = next.or_else(|| orders.recv().ok());
    }
}

/// Writes an order. A persisting obstacle is logged once, since a full disk stays full for long.
fn save(
    file: &HistoryFile,
    archive: &Archive,
    trouble: &mut Option<String>,
    telemetry: &Telemetry,
) {
    let path = file.path().display();
    let written = file.write(archive).map_err(|error| format!("{path}: {error}"));
    telemetry.history_written(written.is_ok());
    match (written, trouble.as_ref()) {
        (Ok(()), None) => {}
        (Ok(()), Some(_)) => {
            info!("the history of the stops is written again, to {path}");
            *trouble = None;
        }
        (Err(told), before) if before != Some(&told) => {
            warn!(
                "the history of the stops cannot be written, {told}; it continues in memory and is \
                 tried again at the next stop"
            );
            *trouble = Some(told);
        }
        (Err(_), _) => {}
    }
}
