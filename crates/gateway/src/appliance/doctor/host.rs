//! Checks of the computer apart from the bus: rights, clock, HTTP, service.

use super::disk;
use super::facts::{Ages, ClockFacts, Host, Rights, Service, Wanted};
use super::finding::Finding;
use super::logins;
use std::net::SocketAddr;
use tertius_report::story;

/// Largest difference between readings of two clocks, s, apart from [`STEERING`].
const READING: f64 = 2e-3;
/// Largest steering of a clock, as a part of the time.
const STEERING: f64 = 5e-4;

/// Uncertainty of a clock beyond which warnings of two computers can no longer be put into order, s.
const UNCERTAIN: f64 = 0.1;

const DROP_IN: &str = "tertius-realtime.conf";

pub(super) fn judge(wanted: &Wanted, host: &Host) -> Vec<Finding> {
    let rights = &host.rights;
    let mut findings = vec![self::rights(rights)];
    findings.extend(priority(wanted, rights));
    findings.extend(memory(wanted, rights));
    findings.extend(clock(&host.clock));
    findings.push(match &host.http {
        None => Finding::ok("http", "off"),
        Some((address, trouble)) => http(*address, trouble.as_deref(), rights),
    });
    findings.extend(logins::judge(host.logins.as_ref()));
    findings.push(service(&host.service));
    findings.push(program(&host.ages, rights));
    findings.extend(disk::judge(&host.disks));
    findings
}

/// Name of the process whose rights were checked.
fn whose(rights: &Rights) -> String {
    match rights.gateway {
        Some(process) => format!("the gateway that is running here (process {process})"),
        None => "this call".to_owned(),
    }
}

fn rights(rights: &Rights) -> Finding {
    let admin = if rights.net_admin { "has" } else { "has not" };
    let whose = whose(rights);
    let found = format!(
        "a CAN socket needs none; {whose} {admin} CAP_NET_ADMIN, which a receive buffer beyond \
         net.core.rmem_max needs"
    );
    Finding::ok("rights", found)
}

fn priority(wanted: &Wanted, rights: &Rights) -> Option<Finding> {
    let (subject, priority) = ("real time", wanted.realtime.priority);
    (priority > 0).then(|| {
        let whose = whose(rights);
        let limit = rights.priority;
        if rights.sys_nice || limit.is_none_or(|limit| limit >= u64::from(priority)) {
            return Finding::ok(subject, format!("{whose} may have priority {priority}"));
        }
        Finding::warn(
            subject,
            format!(
                "{whose} may not have priority {priority}: its limit is {}",
                limit.unwrap_or(0)
            ),
            format!("install {DROP_IN} (LimitRTPRIO), or `ulimit -r {priority}`"),
        )
    })
}

fn memory(wanted: &Wanted, rights: &Rights) -> Option<Finding> {
    let subject = "locked memory";
    wanted.realtime.lock_memory.then(|| {
        let whose = whose(rights);
        match rights.locked_memory.filter(|_| !rights.ipc_lock) {
            None => Finding::ok(subject, format!("{whose} may lock as much memory as it needs")),
            Some(bytes) => Finding::warn(
                subject,
                format!(
                    "{whose} may lock only {} KiB, which must hold all of its memory",
                    bytes / 1024
                ),
                format!("install {DROP_IN} (LimitMEMLOCK), or `ulimit -l unlimited`"),
            ),
        }
    })
}

fn clock(clock: &ClockFacts) -> Vec<Finding> {
    let subject = "clock";
    let keep = "enable systemd-timesyncd, chrony or PTP: warnings and recordings are compared by \
                time";
    let source = clock.source.as_ref();
    let by = source.map_or(String::new(), |source| {
        format!(
            " with {} (chrony, stratum {}), wrong by {:.1} ms at most",
            source.name,
            source.stratum,
            source.bound * 1e3
        )
    });
    let is_vague = source.is_some_and(|source| source.bound > UNCERTAIN);
    let mut findings = vec![match clock.synchronised {
        Some(true) if is_vague => Finding::warn(
            subject,
            format!("synchronised{by}"),
            "give chrony a nearer source: warnings and recordings are compared by time",
        ),
        Some(true) => Finding::ok(subject, format!("synchronised{by}")),
        Some(false) => Finding::warn(subject, "not synchronised", keep),
        None => Finding::warn(subject, "not known to be synchronised", keep),
    }];
    let step = clock.step.as_seconds();
    if step.abs() > READING + STEERING * clock.watched {
        findings.push(Finding::warn(
            subject,
            format!("was set by {step:+.3} s during this check of {:.1} s", clock.watched),
            "have it slewed, not stepped: the gateway starts to judge again after each step",
        ));
    }
    findings
}

fn http(address: SocketAddr, trouble: Option<&str>, rights: &Rights) -> Finding {
    match (trouble, rights.gateway) {
        (None, _) => Finding::ok("http", format!("{address} is free")),
        (Some(_), Some(process)) => Finding::ok(
            "http",
            format!("{address} is in use, because the gateway is running (process {process})"),
        ),
        (Some(reason), None) => Finding::fail(
            "http",
            format!("cannot listen on {address}: {reason}"),
            "set http.listen to another port, or \"off\"; `ss -ltnp` shows who has it",
        ),
    }
}

fn program(ages: &Ages, rights: &Rights) -> Finding {
    let subject = "program";
    let mut found = concat!("tertius ", env!("CARGO_PKG_VERSION")).to_owned();
    if let Some(age) = ages.program {
        found += &format!(", installed {} ago", story::span(age));
    }
    let (Some(process), Some(running)) = (rights.gateway, ages.gateway) else {
        return Finding::ok(subject, found);
    };
    found +=
        &format!("; the gateway (process {process}) has been running for {}", story::span(running));
    match ages.is_replaced {
        true => Finding::warn(
            subject,
            format!("{found}, and its program has been replaced since"),
            "`systemctl restart tertius`, so that the new one watches",
        ),
        false => Finding::ok(subject, found),
    }
}

fn service(service: &Service) -> Finding {
    let subject = "service";
    if !service.systemd {
        return Finding::warn(
            subject,
            "no systemd here: no watchdog restarts the gateway",
            "have its starter restart it, and watch the counter of its status frames",
        );
    }
    let Some(unit) = &service.unit else {
        return Finding::warn(
            subject,
            "there is no tertius.service",
            "install the package, or config/systemd/tertius.service by hand: docs/INSTALL.md",
        );
    };
    match service.watchdog.as_deref() {
        Some(time) if !matches!(time, "" | "0" | "infinity") => {
            Finding::ok(subject, format!("{unit}, with a watchdog (WatchdogSec={time})"))
        }
        _ => Finding::warn(
            subject,
            format!("{unit} has no watchdog: a gateway that hangs is not restarted"),
            "WatchdogSec=2, as in config/systemd/tertius.service",
        ),
    }
}
