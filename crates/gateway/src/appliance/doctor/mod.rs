//! Checks whether the computer suits the gateway, with advice where it does not.
//!
//! [`gather`] collects [`facts`] from kernel, bus and files, and changes nothing; [`examine`]
//! judges them without further access to the system.

mod disk;
pub mod facts;
mod finding;
pub mod gather;
pub mod hearing;
mod host;
mod interface;
mod kernel;
pub mod load;
mod logins;
mod process;
mod receiving;
mod traffic;

pub use facts::Facts;
pub use finding::{Finding, Verdict};

use facts::{Bus, Host, InterfaceFacts, Wanted};
use tertius_report::story;

/// Judges the facts; one finding for each subject.
pub fn examine(facts: &Facts) -> Vec<Finding> {
    let wanted = &facts.wanted;
    let mut findings = vec![configuration(wanted, &facts.host)];
    findings.push(dbc(wanted));
    match &facts.bus {
        Bus::Embedded => findings.push(Finding::ok(
            "interface",
            "the embedded bus, inside the program: there is no interface to check, and `tertius \
             run --play LOG` plays a recording on it",
        )),
        Bus::Socket(interface) => findings.extend(socket(wanted, interface, facts)),
    }
    for (wanted, interface) in wanted.of_others().zip(&facts.others) {
        let of_it = |finding: Finding| Finding {
            found: format!("{}: {}", wanted.interface, finding.found),
            ..finding
        };
        findings.extend(socket(&wanted, interface, facts).into_iter().map(of_it));
    }
    findings.extend(host::judge(wanted, &facts.host));
    findings
}

fn socket(wanted: &Wanted, interface: &InterfaceFacts, facts: &Facts) -> Vec<Finding> {
    let mut findings = interface::judge(wanted, interface);
    findings.extend(receiving::judge(wanted, interface, &facts.host.rights));
    if let Some(hearing) = &interface.hearing {
        let newly = interface.counts.map(|[before, after]| after.since(&before));
        let rights = &facts.host.rights;
        findings.extend(traffic::judge(wanted, hearing, newly.unwrap_or_default(), rights));
    }
    findings
}

fn configuration(wanted: &Wanted, host: &Host) -> Finding {
    let mut found = format!("{} is sound", wanted.config.display());
    if let Some(age) = host.ages.configuration {
        found += &format!(", changed {} ago", story::span(age));
        if host.ages.gateway.is_some_and(|running| running > age) {
            found += ", after the gateway was started, which knows it if it was reloaded since";
        }
    }
    if let Some(day) = &wanted.calibrated {
        found += &format!("; calibrated by recordings of {day}");
    }
    Finding::ok("configuration", found)
}

fn dbc(wanted: &Wanted) -> Finding {
    match wanted.dbc_findings {
        0 => Finding::ok("dbc", format!("{} is sound", wanted.dbc)),
        count => Finding::warn(
            "dbc",
            format!("{}: {count} things are worth a look", wanted.dbc),
            format!("`tertius check {}` lists them", wanted.config.display()),
        ),
    }
}
