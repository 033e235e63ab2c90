//! Notices in words.

use tertius_config::MachineNames;
use tertius_core::frame::Id;
use tertius_core::monitor::Notice;
use tertius_core::sample::device::{DeviceNews, DeviceState};
use tertius_core::sample::dispute::Doubt;
use tertius_core::sequential::Apart;

/// A notice as a line of its own, with its cylinder.
pub fn notice_line(notice: &Notice, names: &MachineNames) -> String {
    let words = notice_words(notice, names);
    match *notice {
        Notice::UnnamedStatus { cylinder, .. } => format!("{}, {words}", names.cylinder(cylinder)),
        Notice::Restart { cylinder, .. } | Notice::Device { cylinder, .. } => {
            format!("{}: {words}", names.cylinder(cylinder))
        }
        _ => words,
    }
}

/// A notice without its cylinder, which a log and an event have in a field.
pub fn notice_words(notice: &Notice, names: &MachineNames) -> String {
    match *notice {
        Notice::Gap { length, .. } => {
            format!("cycles again after {:.2} s without any", length.as_seconds())
        }
        Notice::TimeJump { by, .. } => {
            format!("time stamps jumped by {:+.3} s, everything restarts", by.as_seconds())
        }
        Notice::Interruption { bus: None, .. } => {
            "the bus was lost, everything restarts".to_owned()
        }
        Notice::Interruption { bus: Some(bus), .. } => {
            format!("the {bus} bus was lost, what it carries restarts")
        }
        Notice::Silence { bus, silent: true, .. } => {
            format!("the {bus} bus is silent: what it carries is unknown")
        }
        Notice::Silence { bus, silent: false, .. } => format!("the {bus} bus is heard again"),
        Notice::Doubt { id, doubt, is_over, .. } => self::doubt(id, doubt, is_over),
        Notice::Restart { detector, reason, .. } => {
            let reason = reason.name().replace('_', " ");
            format!("{}'s observer restarts ({reason})", detector.label())
        }
        Notice::Timing { apart: Some(apart), .. } => timing(&apart),
        Notice::Timing { apart: None, .. } => {
            "timing: C1 and C2 are sampled as they were calibrated again".to_owned()
        }
        Notice::UnnamedStatus { cylinder, transducer, bits, .. } => {
            format!("{}: {}", names.transducer(cylinder, transducer), unnamed_status(bits))
        }
        Notice::Device { role, node, news, .. } => {
            format!("node {node} ({}) {}", role.label(), self::news(news))
        }
    }
}

/// That these bits of a status have no meaning in the configuration.
fn unnamed_status(bits: u64) -> String {
    format!(
        "the status has 0x{bits:X}, which `plausibility.status_mask` does not have, so it is taken for no fault; look up what it \
         means, and add it to the mask if it means a broken wire"
    )
}

/// What is wrong with the frames of a message, or is no longer.
fn doubt(id: Id, doubt: Doubt, is_over: bool) -> String {
    match (doubt, is_over) {
        (Doubt::Contradiction, false) => format!(
            "frames 0x{id} contradict each other: a second device sends them, too, so what they carry is unknown; find it \
             on the bus, no transducer is to blame"
        ),
        (Doubt::Contradiction, true) => format!("frames 0x{id} no longer contradict each other"),
        (Doubt::TooShort, false) => format!(
            "frames 0x{id} are too short for the signals that are configured, and are left out; compare their sender with \
             the DBC, no transducer is to blame"
        ),
        (Doubt::TooShort, true) => format!("frames 0x{id} are no longer too short"),
        (Doubt::Uncounted, false) => format!(
            "the alive counter of frames 0x{id} does not count, so only their times show whether frames are late or repeated; \
             check their sender, or the counter in the configuration"
        ),
        (Doubt::Uncounted, true) => format!("the alive counter of frames 0x{id} counts again"),
        (Doubt::Flood, false) => format!(
            "Sync (0x{id}) arrives more often than once per cycle: a second device sends it. Readings open the cycles until it \
             stops; find that device on the bus, no transducer is at fault"
        ),
        (Doubt::Flood, true) => format!("Sync (0x{id}) arrives once per cycle again"),
        (Doubt::Absent, false) => format!(
            "Sync (0x{id}) is missing in more than half of the cycles: readings open them, with less exact times; check the \
             sender of Sync"
        ),
        (Doubt::Absent, true) => format!("Sync (0x{id}) arrives again"),
        (Doubt::Imitation, false) => format!(
            "another device sends frames 0x{id}, which only this gateway should send: receivers cannot tell them apart; find \
             that device, or give a second gateway another node number"
        ),
        (Doubt::Imitation, true) => format!("no other device sends frames 0x{id} any more"),
    }
}

/// What a device said that is no fault of its readings; its name goes before it.
fn news(news: DeviceNews) -> String {
    match news {
        DeviceNews::State(DeviceState::Operational) => "is operational again".to_owned(),
        DeviceNews::State(DeviceState::Initialising) => {
            "has started, and is not operational: it sends no readings".to_owned()
        }
        DeviceNews::State(state) => {
            format!("is {}, not operational: it sends no readings", state.name())
        }
        DeviceNews::Network(emergency) => format!("complains about the network: {emergency}"),
    }
}

/// Time between the samples of C1 and C2, in words.
fn timing(apart: &Apart) -> String {
    let Apart { mean, spread, .. } = apart;
    let skew = match mean {
        0.0 => String::new(),
        _ if *mean > 0.0 => format!("C2 {:.2} ms sooner than calibrated, ", 1e3 * mean),
        _ => format!("C2 {:.2} ms later than calibrated, ", -1e3 * mean),
    };
    let jitter = 1e3 * spread;
    format!(
        "timing: C1 and C2 are not sampled together: {skew}± {jitter:.2} ms by chance; no \
         transducer is at fault, look at Sync and the devices' clocks"
    )
}
