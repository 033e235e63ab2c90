//! Checks of the path of frames from the interface to the gateway.

use super::facts::{InterfaceFacts, Receiving, Rights};
use super::finding::Finding;
use crate::bus::Stamps;

/// A second less the kernel's rounding, s.
const A_SECOND: f64 = 0.99;

pub(super) fn judge(interface: &InterfaceFacts, rights: &Rights) -> Vec<Finding> {
    let Ok(receiving) = &interface.port else { return Vec::new() };
    vec![buffer(receiving, interface.rmem_max, rights), stamps(receiving, interface)]
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

fn stamps(receiving: &Receiving, interface: &InterfaceFacts) -> Finding {
    let heard = interface.hearing.as_ref().is_some_and(|hearing| hearing.frames > 0);
    let found = match (receiving.stamps, heard) {
        (Stamps::Software, false) => {
            "the kernel's (software), as far as known without a frame".to_owned()
        }
        (stamps, _) => stamps.to_string(),
    };
    Finding::ok("time stamps", found)
}
