//! Notices as lines of the log.

use crate::config::MachineNames;
use crate::monitor::Notice;
use crate::report::jsonl::restart_name;
use crate::sample::device::{DeviceNews, DeviceState};
use crate::sequential::Apart;
use crate::story;
use tracing::{info, warn};

/// Writes what is no warning, but has to be known, into the log.
pub(super) fn write(notice: &Notice, names: &MachineNames) {
    match *notice {
        Notice::Gap { length, .. } => {
            info!(seconds = length.as_seconds(), "cycles again after none");
        }
        Notice::TimeJump { by, .. } => {
            warn!(seconds = by.as_seconds(), "time stamps jumped, everything restarts");
        }
        Notice::Interruption { bus: None, .. } => {
            warn!("the bus was lost, everything restarts");
        }
        Notice::Interruption { bus: Some(bus), .. } => {
            warn!(%bus, "a bus was lost, what it carries restarts");
        }
        Notice::Silence { bus, silent: true, .. } => {
            warn!(%bus, "a bus is silent, what it carries is unknown");
        }
        Notice::Silence { bus, silent: false, .. } => info!(%bus, "a bus is heard again"),
        Notice::Doubt { id, bus, doubt, is_over, .. } => {
            let (id, what) = (id.to_string(), story::doubt(id, doubt, is_over));
            if is_over { info!(id, %bus, "{what}") } else { warn!(id, %bus, "{what}") }
        }
        Notice::Restart { cylinder, detector, reason, .. } => {
            let (detector, reason) = (detector.name(), restart_name(reason));
            let name = names.of_cylinder(cylinder);
            info!(cylinder, name, detector, reason, "observer restarts");
        }
        Notice::Timing { apart: Some(Apart { mean, spread, .. }), .. } => {
            warn!(skew = mean, jitter = spread, "C1 and C2 are not sampled together");
        }
        Notice::Timing { apart: None, .. } => {
            info!("C1 and C2 are sampled as they were calibrated again");
        }
        Notice::UnnamedStatus { cylinder, transducer, bits, .. } => {
            let (name, what) = (names.of_cylinder(cylinder), story::unnamed_status(bits));
            let transducer = names.transducer(cylinder, transducer);
            warn!(cylinder, name, transducer, "{what}");
        }
        Notice::Device { cylinder, role, node, news, .. } => {
            let what = story::news(news);
            let (device, name) = (role.name(), names.of_cylinder(cylinder));
            match news {
                DeviceNews::State(DeviceState::Operational) => {
                    info!(cylinder, name, device, node, "the device {what}");
                }
                _ => warn!(cylinder, name, device, node, "the device {what}"),
            }
        }
    }
}
