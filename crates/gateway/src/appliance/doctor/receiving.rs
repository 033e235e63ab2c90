//! Checks of the path of frames from the interface to the gateway.

use super::facts::{InterfaceFacts, LinkCounts, Receiving, Rights, Wanted};
use super::finding::Finding;
use super::traffic::{self, OVERLOAD};
use crate::bus::Stamps;

/// A second less the kernel's rounding, s.
const A_SECOND: f64 = 0.99;

pub(super) fn judge(wanted: &Wanted, interface: &InterfaceFacts, rights: &Rights) -> Vec<Finding> {
    let Ok(receiving) = &interface.port else { return Vec::new() };
    let mut findings =
        vec![buffer(receiving, interface.rmem_max, rights), stamps(wanted, receiving, interface)];
    findings.extend(interface.counts.as_ref().map(|[before, after]| overload(before, after)));
    findings
}

fn overload(before: &LinkCounts, after: &LinkCounts) -> Finding {
    let subject = "overload";
    let newly = after.since(before);
    let parts = |counts: &LinkCounts| {
        let LinkCounts { frames, overruns, dropped, .. } = counts;
        format!(
            "{overruns} in the controller, which was not emptied in time, and {dropped} in the kernel, of {frames}"
        )
    };
    if newly.lost() > 0 {
        let found = format!("{} frames were lost while listening: {}", newly.lost(), parts(&newly));
        return Finding::warn(subject, found, OVERLOAD);
    }
    match after.lost() {
        0 => Finding::ok(subject, "no frame was lost since the interface appeared"),
        _ => Finding::ok(
            subject,
            format!(
                "no frame was lost while listening; since the interface appeared {} were: {}",
                after.lost(),
                parts(after)
            ),
        ),
    }
}

fn buffer(receiving: &Receiving, rmem_max: Option<u64>, rights: &Rights) -> Finding {
    let subject = "receive buffer";
    let Receiving { buffer, lasts, .. } = *receiving;
    let found = format!("{} KiB, {lasts:.2} s of a full bus", buffer / 1024);
    // The kernel doubles what it is asked for, and limits what is asked for.
    let second = (buffer as f64 / lasts).ceil();
    let advice = format!(
        "net.core.rmem_max = {:.0} in /etc/sysctl.d, or CAP_NET_ADMIN, for a whole second",
        second / 2.0
    );
    if lasts.is_nan() || lasts < A_SECOND {
        return Finding::warn(subject, found, advice);
    }
    let allowed = rmem_max.map(|most| 2.0 * most as f64 / second);
    match allowed.filter(|&lasts| lasts < A_SECOND) {
        Some(lasts) if rights.net_admin && rights.gateway.is_none() => Finding::warn(
            subject,
            format!("{found}, by CAP_NET_ADMIN; a service without it gets {lasts:.2} s"),
            advice,
        ),
        Some(_) | None => Finding::ok(subject, found),
    }
}

fn stamps(wanted: &Wanted, receiving: &Receiving, interface: &InterfaceFacts) -> Finding {
    let heard = interface.hearing.as_ref().filter(|hearing| hearing.frames > 0);
    let mut found = receiving.stamps.to_string();
    if receiving.stamps == Stamps::Software {
        found += match (interface.hardware_stamps, heard) {
            (Some(true), Some(_)) => {
                "; the controller has its own, which are turned off (`hwstamp_ctl`, of linuxptp, may turn them on)"
            }
            (Some(false), _) => "; the controller has none",
            (None, Some(_)) => "",
            (Some(true) | None, None) => ", as far as known without a frame",
        };
    }
    let opening = heard.and_then(|hearing| traffic::opening(wanted, hearing));
    if let Some((message, intervals)) = opening {
        found += &format!("; those of {} vary by {:.3} ms", message.name, intervals.jitter * 1e3);
    }
    Finding::ok("time stamps", found)
}
