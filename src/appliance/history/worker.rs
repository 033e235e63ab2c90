//! Writes archives beside the data path, which waits for no disk.

use super::file::HistoryFile;
use crate::appliance::realtime;
use crate::appliance::telemetry::Telemetry;
use crate::sequential::{Archive, Limits};
use std::sync::mpsc::Receiver;
use tracing::{info, warn};

/// What is to be done with what was read on the stops.
#[derive(Debug)]
pub(super) struct Order {
    pub archive: Archive,
    pub limits: Limits,
    /// `None` where it is told and not kept.
    pub file: Option<HistoryFile>,
}

/// Does what is ordered until nobody can order anything any more. Of several orders for the same file
/// the newest has everything.
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

/// Each change of what hinders it is told once: a full disk stays full for long.
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
                "the history of the stops cannot be written, {told}; it goes on in memory and is \
                 tried again at the next stop"
            );
            *trouble = Some(told);
        }
        (Err(_), _) => {}
    }
}
