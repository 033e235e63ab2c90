//! Checks of the interface and its controller.

use super::facts::{InterfaceFacts, Wanted};
use super::finding::Finding;
use crate::bus::socket::{ControllerState, LinkState};

/// Longest send queue: more frames would burst out stale when a bus returns.
const LONG_QUEUE: u32 = 50;

pub(super) fn judge(wanted: &Wanted, interface: &InterfaceFacts) -> Vec<Finding> {
    let name = &wanted.interface;
    let mut findings = Vec::new();
    match &interface.no_can {
        Some(reason) => findings.push(Finding::fail(
            "can",
            format!("this kernel has no CAN sockets: {reason}"),
            "`modprobe can-raw` where the module is there, else a kernel with CONFIG_CAN and \
             CONFIG_CAN_RAW; without CAN, interface = \"virtual\" works on recordings",
        )),
        None => findings.push(Finding::ok("can", "this kernel has CAN sockets")),
    }
    let link = match &interface.link {
        Ok(link) => link,
        Err(reason) => {
            findings.push(Finding::fail(
                "interface",
                reason,
                format!("plug in or create {name}, or correct bus.interface"),
            ));
            return findings;
        }
    };
    if interface.is_can == Some(false) {
        findings.push(Finding::fail(
            "interface",
            format!("{name} is not a CAN interface"),
            "set bus.interface to one; `ip -details link` shows each's kind",
        ));
        return findings;
    }
    findings.push(up(name, interface, link));
    findings.extend(controller(name, link));
    findings.push(bit_rate(name, wanted.bit_rate, link));
    findings.extend(restart(name, link));
    findings.extend(queue(name, link));
    findings.push(frame_size(wanted, link));
    findings
}

/// Whether the interface has a controller; a virtual one (vcan) does not.
fn has_controller(link: &LinkState) -> bool {
    link.state.is_some()
}

fn up(name: &str, interface: &InterfaceFacts, link: &LinkState) -> Finding {
    let kind = if has_controller(link) { "CAN" } else { "virtual CAN" };
    if !link.up {
        let advice = format!("`ip link set {name} up`, or 80-can0.network for systemd-networkd");
        return Finding::fail("interface", format!("{name} ({kind}) is down"), advice);
    }
    match &interface.port {
        Err(reason) if interface.no_can.is_none() => {
            let found =
                format!("{name} ({kind}) is up, but no socket can be opened on it: {reason}");
            Finding::fail("interface", found, format!("look at `ip -details link show {name}`"))
        }
        _ => Finding::ok("interface", format!("{name} ({kind}) is up")),
    }
}

fn controller(name: &str, link: &LinkState) -> Option<Finding> {
    let state = link.state.filter(|_| link.up)?;
    let counter = |count: Option<u16>| count.map_or("?".to_owned(), |count| count.to_string());
    let found = format!(
        "{}, error counters {} (sent) and {} (received)",
        state.name(),
        counter(link.transmit_errors),
        counter(link.receive_errors)
    );
    let wires = "look at wires, connectors, termination (60 ohm between CAN_H and CAN_L) and at the \
                 bit rate of every node";
    Some(match state {
        ControllerState::ErrorActive => Finding::ok("controller", found),
        ControllerState::Warning => Finding::warn("controller", found, wires),
        ControllerState::Passive => Finding::fail("controller", found, wires),
        ControllerState::BusOff | ControllerState::Stopped | ControllerState::Sleeping => {
            let advice = format!("`ip link set {name} type can restart` once the cause is gone");
            Finding::fail("controller", found, format!("{wires}; {advice}"))
        }
    })
}

fn bit_rate(name: &str, wanted: u32, link: &LinkState) -> Finding {
    let set = format!("`ip link set {name} down; ip link set {name} up type can bitrate {wanted}`");
    let Some(rate) = link.bit_rate else {
        return match has_controller(link) {
            true => Finding::fail("bit rate", "none is set", set),
            false => Finding::ok(
                "bit rate",
                "none: a virtual interface is as fast as the \
                computer",
            ),
        };
    };
    let mut found = format!("{rate} bit/s");
    if let Some(point) = link.sample_point {
        found += &format!(", sample point {:.1} %", f64::from(point) / 10.0);
    }
    if let Some(data) = link.data_bit_rate {
        found += &format!(", {data} bit/s in CAN FD's data phase");
    }
    if rate == wanted {
        return Finding::ok("bit rate", found);
    }
    let found = format!("{found}, but bus.bitrate is {wanted}");
    Finding::fail("bit rate", found, format!("correct bus.bitrate, or {set}"))
}

fn restart(name: &str, link: &LinkState) -> Option<Finding> {
    has_controller(link).then_some(())?;
    Some(match link.restart_ms {
        Some(0) | None => Finding::warn(
            "restart",
            "restart-ms is not set: after bus-off the controller stays off until somebody restarts \
             it",
            format!(
                "`ip link set {name} type can restart-ms 100`, or RestartSec=100ms for networkd"
            ),
        ),
        Some(time) => Finding::ok("restart", format!("{time} ms after bus-off")),
    })
}

fn queue(name: &str, link: &LinkState) -> Option<Finding> {
    let length = link.queue_length?;
    Some(match length {
        ..=LONG_QUEUE => Finding::ok("send queue", format!("{length} frames")),
        _ => Finding::warn(
            "send queue",
            format!("{length} frames may wait in the kernel, and are sent stale"),
            format!("`ip link set {name} txqueuelen 16`, or 80-can0.link for systemd"),
        ),
    })
}

fn frame_size(wanted: &Wanted, link: &LinkState) -> Finding {
    let subject = "frame size";
    let longest = wanted.messages.iter().max_by_key(|message| message.needs);
    match (link.mtu, longest) {
        (Some(_), _) if link.is_fd() => Finding::ok(subject, "classic and CAN FD (MTU 72)"),
        (Some(16), Some(message)) if message.needs > 8 => {
            let Wanted { interface, .. } = wanted;
            Finding::fail(
                subject,
                format!("classic only (MTU 16), but {} has {} bytes", message.name, message.needs),
                format!(
                    "`ip link set {interface} mtu 72` for a virtual interface; for a controller \
                     dbitrate and `fd on`, if it has CAN FD"
                ),
            )
        }
        (Some(16), _) => Finding::ok(subject, "classic (MTU 16)"),
        (mtu, _) => Finding::warn(
            subject,
            mtu.map_or("not known".to_owned(), |mtu| format!("MTU {mtu}, neither 16 nor 72")),
            "look at `ip -details link`",
        ),
    }
}
