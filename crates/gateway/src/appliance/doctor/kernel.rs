//! What kernel, chrony and ethtool say, read from their texts.

use super::facts::{ClockSource, LinkCounts, Wear};
use std::path::{Path, PathBuf};
use tertius_core::time::Span;

impl LinkCounts {
    /// The counts of an interface; `count` gives the content of a file of its folder `statistics`.
    pub fn read(count: impl Fn(&str) -> Option<String>) -> Option<Self> {
        let count = |name: &str| count(name)?.trim().parse::<u64>().ok();
        let overruns = ["rx_over_errors", "rx_fifo_errors", "rx_missed_errors"];
        // A driver counts one loss in one of them, or in several.
        let overruns = overruns.into_iter().filter_map(&count).max()?;
        Some(Self {
            frames: count("rx_packets")?,
            overruns,
            dropped: count("rx_dropped")?,
            // It has the overruns, too.
            errors: count("rx_errors")?.saturating_sub(overruns),
        })
    }
}

impl ClockSource {
    /// From a line of `chronyc -c tracking`; `None` if chrony follows nothing.
    pub fn read(line: &str) -> Option<Self> {
        let fields: Vec<&str> = line.trim().split(',').collect();
        let [_, name, stratum, _, offset, .., delay, dispersion, _, leap] = fields[..] else {
            return None;
        };
        let seconds = |field: &str| field.parse::<f64>().ok().filter(|it| it.is_finite());
        let stratum = stratum.parse().ok().filter(|stratum| *stratum > 0)?;
        // As chrony's manual has it: half of the way to the reference, and what may have been lost on it.
        let bound = seconds(offset)?.abs() + seconds(dispersion)? + 0.5 * seconds(delay)?;
        (leap != "Not synchronised").then(|| Self { name: name.to_owned(), stratum, bound })
    }
}

impl Wear {
    /// From what an eMMC says of its `life_time`, as `0x01 0x02`, and `pre_eol_info`, as `0x01`; `None` where it says
    /// nothing of either.
    pub fn read(life_time: &str, pre_eol_info: &str) -> Option<Self> {
        let number = |text: &str| u8::from_str_radix(text.trim_start_matches("0x"), 16).ok();
        let tenths = life_time.split_whitespace().filter_map(number).max()?;
        let reserve = pre_eol_info.split_whitespace().find_map(number)?;
        (tenths > 0 || reserve > 0).then_some(Self { tenths, reserve })
    }
}

/// Whether the controller can stamp received frames, by the text of `ethtool -T`.
pub(super) fn stamps_by_itself(text: &str) -> Option<bool> {
    let mut lines = text.lines().map(str::trim).skip_while(|line| *line != "Capabilities:");
    lines.next()?;
    Some(lines.any(|line| line.split_whitespace().next() == Some("hardware-receive")))
}

/// A mounted file system.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Mount {
    /// Number of the device, as `179:2`.
    pub device: String,
    pub is_read_only: bool,
}

impl Mount {
    /// That on which `folder` lies, by the text of /proc/self/mountinfo.
    pub fn of(folder: &Path, mountinfo: &str) -> Option<Self> {
        let mounts = mountinfo.lines().filter_map(|line| {
            let fields: Vec<&str> = line.split(' ').collect();
            let [_, _, device, _, point, options, ..] = fields[..] else { return None };
            let point = PathBuf::from(point.replace("\\040", " "));
            folder.starts_with(&point).then_some((point, device, options))
        });
        // Of several on the same point the last one covers the others.
        let (_, device, options) = mounts.max_by_key(|(point, ..)| point.as_os_str().len())?;
        let is_read_only = options.split(',').any(|option| option == "ro");
        Some(Self { device: device.to_owned(), is_read_only })
    }
}

/// Bytes written, by the text of a block device's file `stat`.
pub(super) fn written(stat: &str) -> Option<u64> {
    // Sectors of 512 bytes, whatever those of the disk are.
    stat.split_whitespace().nth(6)?.parse::<u64>().ok()?.checked_mul(512)
}

/// Time since the start of a process, by the text of /proc/…/stat, on a computer that was started `uptime` seconds ago.
pub(super) fn running(stat: &str, uptime: f64) -> Option<Span> {
    /// USER_HZ, which is the same on all processors that Linux has now.
    const TICKS: f64 = 100.0;
    // The name, in brackets, may have anything in it.
    let (_, fields) = stat.rsplit_once(')')?;
    let started: f64 = fields.split_whitespace().nth(19)?.parse().ok()?;
    Some(Span::from_seconds((uptime - started / TICKS).max(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn losses_are_told_from_errors_of_the_wire() {
        let file = |name: &str| {
            let text = match name {
                "rx_packets" => "1000\n",
                "rx_over_errors" | "rx_fifo_errors" => "7\n",
                "rx_missed_errors" => "0\n",
                "rx_dropped" => "3\n",
                "rx_errors" => "19\n",
                _ => return None,
            };
            Some(text.to_owned())
        };
        let counts = LinkCounts { frames: 1000, overruns: 7, dropped: 3, errors: 12 };
        assert_eq!(LinkCounts::read(file), Some(counts));
        assert_eq!(LinkCounts::read(|_| None), None);
    }

    #[test]
    fn what_chrony_follows() {
        let line = "C0000202,192.0.2.2,3,1700000000.1,-0.000100000,0.00001,0.00002,-12.3,0.001,0.1,\
                    0.004000000,0.000500000,64.2,Normal\n";
        let source = ClockSource::read(line).expect("it follows one");
        assert_eq!((source.name.as_str(), source.stratum), ("192.0.2.2", 3));
        assert!((source.bound - 2.6e-3).abs() < 1e-12, "{}", source.bound);
        let none = line.replace("Normal", "Not synchronised");
        assert_eq!(ClockSource::read(&none), None);
        assert_eq!(ClockSource::read("506 Cannot talk to daemon"), None);
    }

    #[test]
    fn an_emmc_says_how_far_it_is_used_up() {
        assert_eq!(Wear::read("0x02 0x05\n", "0x01\n"), Some(Wear { tenths: 5, reserve: 1 }));
        // Not defined by this device.
        assert_eq!(Wear::read("0x00 0x00\n", "0x00\n"), None);
        assert_eq!(Wear::read("", ""), None);
    }

    #[test]
    fn what_ethtool_says_of_time_stamps() {
        let text = "Time stamping parameters for can0:\nCapabilities:\n\thardware-receive\n\
                    \tsoftware-receive\nPTP Hardware Clock: none\n";
        assert_eq!(stamps_by_itself(text), Some(true));
        assert_eq!(stamps_by_itself(&text.replace("\thardware-receive\n", "")), Some(false));
        assert_eq!(stamps_by_itself("netlink error: No such device"), None);
    }

    #[test]
    fn the_mount_of_a_folder_is_the_innermost() {
        let text = "22 1 179:2 / / rw,relatime - ext4 /dev/mmcblk0p2 rw\n\
                    31 22 179:3 / /var/lib rw,noatime - ext4 /dev/mmcblk0p3 rw\n\
                    32 22 0:20 / /var/lib2 ro - tmpfs tmpfs rw\n\
                    33 31 8:1 / /var/lib/my\\040disk ro,nosuid - ext4 /dev/sda1 ro\n";
        let of = |folder: &str| Mount::of(Path::new(folder), text).expect("there is a root");
        assert_eq!(of("/etc").device, "179:2");
        let inner = Mount { device: "179:3".to_owned(), is_read_only: false };
        assert_eq!(of("/var/lib/tertius"), inner);
        assert!(of("/var/lib/my disk/tertius").is_read_only);
    }

    #[test]
    fn bytes_and_times_of_the_kernel() {
        let stat = "  100 0 800 5 200 0 4096 9 0 10 11 0 0 0 0";
        assert_eq!(written(stat), Some(4096 * 512));
        let process = "77 (a (strange) name) S 1 77 77 0 -1 0 0 0 0 0 0 0 0 0 20 0 4 0 250000 1 2";
        assert_eq!(running(process, 9000.25), Some(Span::from_seconds(6500.25)));
        assert_eq!(running("77", 9000.25), None);
    }
}
