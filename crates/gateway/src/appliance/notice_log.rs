//! Notices as lines of the log.

use tertius_config::MachineNames;
use tertius_core::monitor::Notice;
use tertius_core::sample::device::{DeviceNews, DeviceState};
use tertius_core::sequential::Apart;
use tertius_report::story;
use tracing::{info, warn};

/// Writes what is no warning, but has to be known, into the log.
pub(super) fn write(notice: &Notice, names: &MachineNames) {
    let what = story::notice_words(notice, names);
    match *notice {
        Notice::Gap { length, .. } => info!(seconds = length.as_seconds(), "{what}"),
        Notice::TimeJump { by, .. } => warn!(seconds = by.as_seconds(), "{what}"),
        Notice::Interruption { bus: None, .. } => warn!("{what}"),
        Notice::Interruption { bus: Some(bus), .. } | Notice::Silence { bus, silent: true, .. } => {
            warn!(%bus, "{what}");
        }
        Notice::Silence { bus, silent: false, .. } => info!(%bus, "{what}"),
        Notice::Doubt { id, bus, is_over, .. } => {
            let id = id.to_string();
            if is_over { info!(id, %bus, "{what}") } else { warn!(id, %bus, "{what}") }
        }
        Notice::Restart { cylinder, detector, reason, .. } => {
            let (detector, reason) = (detector.name(), reason.name());
            info!(cylinder, name = names.of_cylinder(cylinder), detector, reason, "{what}");
        }
        Notice::Timing { apart: Some(Apart { mean, spread, .. }), .. } => {
            warn!(skew = mean, jitter = spread, "{what}");
        }
        Notice::Timing { apart: None, .. } => info!("{what}"),
        Notice::UnnamedStatus { cylinder, transducer, .. } => {
            let transducer = names.transducer(cylinder, transducer);
            warn!(cylinder, name = names.of_cylinder(cylinder), transducer, "{what}");
        }
        Notice::Device { cylinder, role, node, news, .. } => {
            let (device, name) = (role.name(), names.of_cylinder(cylinder));
            match news {
                DeviceNews::State(DeviceState::Operational) => {
                    info!(cylinder, name, device, node, "{what}");
                }
                _ => warn!(cylinder, name, device, node, "{what}"),
            }
        }
    }
}
