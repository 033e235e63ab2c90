//! Checks of the disks on which the gateway keeps something.

use super::facts::{DiskFacts, Wear};
use super::finding::Finding;

/// Free space below which a disk is soon full: as a part of it, and bytes.
const LITTLE: f64 = 0.05;
const LEAST: u64 = 200 << 20;

/// Part of an eMMC's life, in tenths, from which it is to be replaced, and the states of its reserve.
const WORN: u8 = 9;
const OVER: u8 = 11;
const FEW: u8 = 2;
const URGENT: u8 = 3;

const SUBJECT: &str = "disk";

pub(super) fn judge(disks: &[DiskFacts]) -> Vec<Finding> {
    if disks.is_empty() {
        return vec![Finding::ok(SUBJECT, "nothing is kept on one")];
    }
    disks.iter().flat_map(|disk| [Some(space(disk)), wear(disk)]).flatten().collect()
}

fn space(disk: &DiskFacts) -> Finding {
    let DiskFacts { keeps, folder, free, size, .. } = disk;
    let (keeps, folder) = (keeps.join(", "), folder.display());
    if disk.is_read_only {
        return Finding::fail(
            SUBJECT,
            format!("{folder} ({keeps}) is on a file system that is mounted read-only"),
            "`dmesg` says whether errors of the disk are the reason; mount it for writing, or name another folder",
        );
    }
    let mut found = format!("{} of {} free in {folder} ({keeps})", bytes(*free), bytes(*size));
    if let Some(rate) = disk.written_per_day {
        found += &format!("; {} a day are written, by all programs", bytes(rate as u64));
    }
    match *free < LEAST || (*free as f64) < LITTLE * *size as f64 {
        true => Finding::warn(
            SUBJECT,
            found,
            "make room, or limit what is kept (store.size, recorder.size): the gateway judges on without it",
        ),
        false => Finding::ok(SUBJECT, found),
    }
}

fn wear(disk: &DiskFacts) -> Option<Finding> {
    let Wear { tenths, reserve } = disk.wear?;
    let mut found = match tenths {
        0 => "the flash memory does not say how far it is used up".to_owned(),
        OVER.. => "the flash memory is used up beyond its promised life".to_owned(),
        _ => format!("the flash memory is used up by {} to {} %", 10 * (tenths - 1), 10 * tenths),
    };
    match reserve {
        FEW => found += ", and four fifths of its blocks in reserve",
        URGENT.. => found += ", and nearly all of its blocks in reserve",
        _ => {}
    }
    Some(match tenths > WORN || reserve >= FEW {
        true => Finding::warn(
            SUBJECT,
            found,
            "replace it before it fails, and save events, recordings and the history of the stops",
        ),
        false => Finding::ok(SUBJECT, found),
    })
}

/// A number of bytes with three digits.
fn bytes(count: u64) -> String {
    let mut value = count as f64;
    let units = ["B", "KiB", "MiB", "GiB", "TiB"];
    let mut unit = 0;
    while value >= 1000.0 && unit + 1 < units.len() {
        value /= 1024.0;
        unit += 1;
    }
    let digits = if value < 10.0 && unit > 0 { 1 } else { 0 };
    format!("{value:.digits$} {}", units[unit])
}
