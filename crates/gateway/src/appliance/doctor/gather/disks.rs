//! The disks on which something is kept.

use super::super::facts::{DiskFacts, Wear};
use super::super::kernel::{Mount, written};
use super::computer::uptime;
use nix::sys::statvfs::statvfs;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Time since the start below which a day's writing cannot be told, s.
const SHORT: f64 = 3600.0;

const DAY: f64 = 86_400.0;

/// The disks of these files and folders, each once; what does not exist yet is where its nearest folder is.
pub(super) fn of(keeps: &[(&'static str, PathBuf)]) -> Vec<DiskFacts> {
    let mounts = fs::read_to_string("/proc/self/mountinfo").unwrap_or_default();
    let mut disks: BTreeMap<String, DiskFacts> = BTreeMap::new();
    for (what, path) in keeps {
        let Some(folder) = path.ancestors().find_map(|folder| fs::canonicalize(folder).ok()) else {
            continue;
        };
        let mount = Mount::of(&folder, &mounts);
        let device = mount.as_ref().map_or_else(String::new, |mount| mount.device.clone());
        let disk = disks.entry(device.clone()).or_insert_with(|| {
            let is_read_only = mount.is_some_and(|mount| mount.is_read_only);
            disk(folder, &device, is_read_only)
        });
        disk.keeps.push(what);
    }
    disks.into_values().filter(|disk| disk.size > 0).collect()
}

fn disk(folder: PathBuf, device: &str, is_read_only: bool) -> DiskFacts {
    let space = statvfs(&folder).ok();
    let [free, size] = space.map_or([0; 2], |space| {
        let block = space.fragment_size();
        [space.blocks_available() * block, space.blocks() * block]
    });
    let of_device = Path::new("/sys/dev/block").join(device);
    let written = fs::read_to_string(of_device.join("stat")).ok().and_then(|stat| written(&stat));
    let rate = |(bytes, seconds): (u64, f64)| bytes as f64 * DAY / seconds;
    DiskFacts {
        keeps: Vec::new(),
        folder,
        free,
        size,
        is_read_only,
        written_per_day: written.zip(uptime().filter(|seconds| *seconds > SHORT)).map(rate),
        wear: wear(&of_device),
    }
}

/// How far a flash memory is used up, of a device or of the one that it is a part of.
fn wear(device: &Path) -> Option<Wear> {
    let device = fs::canonicalize(device).ok()?;
    let whole = if device.join("partition").exists() { device.parent()? } else { &device };
    let said = |name| fs::read_to_string(whole.join("device").join(name)).ok();
    Wear::read(&said("life_time")?, &said("pre_eol_info")?)
}
