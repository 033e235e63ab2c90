//! Checks of the traffic on the bus against the configuration.

use super::facts::{LinkCounts, Message, Rights, Wanted};
use super::finding::Finding;
use super::hearing::{Errors, Hearing, Intervals};
use tertius_core::error_frame::ControllerState;

/// What a computer needs that is too slow for its bus.
pub(super) const OVERLOAD: &str = "this computer is too slow for the frames, not the bus at fault: set [realtime], run \
                                   less beside the gateway, or give the controller's interrupt a core of its own";

/// Most messages that are named in a line.
const NAMED: usize = 20;

/// Largest deviation of the cycle, as a part of it.
const CYCLE_TOLERANCE: f64 = 0.02;
/// Deviation beyond which the cycle is that of another machine.
const CYCLE_LIMIT: f64 = 0.1;

/// Largest jitter of a cycle's opening, as a part of the cycle.
const JITTER_TOLERANCE: f64 = 0.2;

/// Rate of a cyclic message per cycle below which it comes too seldom, and above which too often.
const ONCE: [f64; 2] = [0.9, 1.1];

/// Load of the bus beyond which low priorities wait long.
const BUSY: f64 = 0.7;

/// `newly` is what the kernel counted of the interface in this time.
pub(super) fn judge(
    wanted: &Wanted,
    hearing: &Hearing,
    newly: LinkCounts,
    rights: &Rights,
) -> Vec<Finding> {
    let mut findings = frames(wanted, hearing);
    findings.extend(cycle(wanted, hearing));
    findings.extend(load(hearing));
    findings.push(errors(&hearing.errors, newly.errors));
    if hearing.dropped > 0 {
        findings.push(Finding::warn(
            "lost",
            format!("{} frames: the receive queue was full", hearing.dropped),
            "provide a larger receive buffer, or run less beside the gateway",
        ));
    }
    findings.push(node(wanted, hearing, rights));
    findings
}

/// Names of the messages, shortened to a few.
fn named<'a>(messages: impl Iterator<Item = &'a Message>) -> String {
    let mut names: Vec<String> =
        messages.map(|message| format!("{} ({})", message.name, message.id)).collect();
    let more = names.len().saturating_sub(NAMED);
    names.truncate(NAMED);
    let text = names.join(", ");
    if more > 0 { format!("{text} and {more} more") } else { text }
}

fn frames(wanted: &Wanted, hearing: &Hearing) -> Vec<Finding> {
    let subject = "frames";
    let seconds = hearing.seconds;
    let mut findings = Vec::new();
    if let Some(reason) = &hearing.ended {
        findings.push(Finding::fail(
            subject,
            format!("listening ended after {seconds:.1} s: {reason}"),
            "see the interface above, and run the check again",
        ));
    }
    let messages = &wanted.messages;
    let all = messages.len();
    if hearing.frames == 0 {
        findings.push(Finding::fail(
            subject,
            format!("none in {seconds:.1} s, of the {all} messages that the monitor uses"),
            "switch the machine on; look at wires, termination and bit rate",
        ));
        return findings;
    }
    let is_missing = |message: &&Message| hearing.of(message.id).is_none();
    let missing = messages.iter().filter(is_missing).count();
    if missing > 0 {
        findings.push(Finding::fail(
            subject,
            format!(
                "{missing} of {all} messages did not come in {seconds:.1} s: {}",
                named(messages.iter().filter(is_missing))
            ),
            "switch their nodes on, or correct [signals] and the DBC",
        ));
    } else {
        let others = hearing.ids().filter(|id| messages.iter().all(|message| message.id != *id));
        let others = others.filter(|id| !wanted.own.contains(id)).count();
        findings.push(Finding::ok(
            subject,
            format!(
                "all {all} messages came in {seconds:.1} s ({} frames, {others} other identifiers)",
                hearing.frames
            ),
        ));
    }
    findings.extend(short(wanted, hearing));
    findings.extend(not_once(wanted, hearing));
    findings
}

fn short(wanted: &Wanted, hearing: &Hearing) -> Option<Finding> {
    let is_short = |message: &&Message| {
        hearing.of(message.id).is_some_and(|heard| heard.shortest < message.needs)
    };
    wanted.messages.iter().any(|message| is_short(&message)).then(|| {
        Finding::fail(
            "frames",
            format!(
                "too short for their signals in the DBC: {}",
                named(wanted.messages.iter().filter(is_short))
            ),
            "correct the DBC; `candump` shows the frames",
        )
    })
}

fn not_once(wanted: &Wanted, hearing: &Hearing) -> Option<Finding> {
    let cycles = hearing.seconds / wanted.sample_time;
    if cycles < 10.0 || hearing.ended.is_some() {
        return None;
    }
    let is_odd = |message: &&Message| {
        let per_cycle = hearing.of(message.id).map(|heard| heard.count as f64 / cycles);
        // Of a message with pages one may come in each cycle, or all of them.
        let [least, most] = [ONCE[0], ONCE[1] * message.pages.max(1) as f64];
        message.cyclic && per_cycle.is_some_and(|times| !(least..=most).contains(&times))
    };
    wanted.messages.iter().any(|message| is_odd(&message)).then(|| {
        Finding::warn(
            "frames",
            format!(
                "not once each {} ms: {}",
                wanted.sample_time * 1e3,
                named(wanted.messages.iter().filter(is_odd))
            ),
            "look at their nodes' cycle, and whether two nodes send the same",
        )
    })
}

/// The message that opens cycles, or else one that comes in each, with its intervals.
pub(super) fn opening<'a>(
    wanted: &'a Wanted,
    hearing: &Hearing,
) -> Option<(&'a Message, Intervals)> {
    let opens = wanted.messages.iter().find(|message| message.sync);
    let reads = |message: &&Message| message.reading && message.pages <= 1;
    let message = opens.or_else(|| wanted.messages.iter().find(reads))?;
    Some((message, hearing.of(message.id)?.intervals()?))
}

fn cycle(wanted: &Wanted, hearing: &Hearing) -> Option<Finding> {
    let (message, intervals) = opening(wanted, hearing)?;
    let Intervals { mean, jitter, largest_deviation } = intervals;
    let found = format!(
        "{} each {:.3} ms, jitter {:.3} ms (at most {:.3} ms)",
        message.name,
        mean * 1e3,
        jitter * 1e3,
        largest_deviation * 1e3
    );
    let time = wanted.sample_time;
    let off = (mean / time - 1.0).abs();
    if off > CYCLE_TOLERANCE {
        let found = format!("{found}, but machine.sample_time is {} ms", time * 1e3);
        let advice = "correct machine.sample_time, and identify the model again, which depends on \
            it";
        let limit = if off > CYCLE_LIMIT { Finding::fail } else { Finding::warn };
        return Some(limit("cycle", found, advice.to_owned()));
    }
    Some(match largest_deviation / time > JITTER_TOLERANCE {
        true => Finding::warn(
            "cycle",
            found,
            "look at the sender's cycle and the load of the bus; [realtime] if it is this computer",
        ),
        false => Finding::ok("cycle", found),
    })
}

fn load(hearing: &Hearing) -> Option<Finding> {
    let load = hearing.load()?;
    let found = format!("{:.1} % at most", load * 100.0);
    Some(match load > BUSY {
        true => Finding::warn("bus load", found, "send less often, or at a higher bit rate"),
        false => Finding::ok("bus load", found),
    })
}

/// Error frames, and `counted` errors on the wire, of which a driver may tell nobody else.
fn errors(errors: &Errors, counted: u64) -> Finding {
    let subject = "error frames";
    if errors.frames == 0 && counted == 0 {
        return Finding::ok(subject, "none");
    }
    let mut found = vec![format!("{}", errors.frames)];
    for (count, what) in [
        (errors.protocol, "frames that were wrong on the bus"),
        (errors.unacknowledged, "frames that nobody acknowledged"),
        (errors.transceiver, "faults of the line"),
        (errors.receive_overflows, "overflows of the controller"),
        (counted, "errors on the wire that the driver counted"),
    ] {
        if count > 0 {
            found.push(format!("{count} {what}"));
        }
    }
    found.extend(errors.state.map(|state| format!("the controller came to {}", state.name())));
    let found = found.join(", ");
    let of_bus = errors.protocol + errors.unacknowledged + errors.transceiver + counted;
    let is_overload = errors.receive_overflows > 0 && of_bus == 0 && errors.state.is_none();
    let advice = if is_overload {
        OVERLOAD
    } else if errors.receive_overflows == 0 && errors.protocol + counted > 0 {
        "not overload, but the wire: look at its ends and termination, and whether all nodes have one bit rate and \
         sample point"
    } else {
        "look at wires, termination and the bit rate of every node"
    };
    match errors.state {
        Some(ControllerState::BusOff) => Finding::fail(subject, found, advice),
        _ => Finding::warn(subject, found, advice),
    }
}

/// Whether another node sends what only the gateway may.
fn node(wanted: &Wanted, hearing: &Hearing, rights: &Rights) -> Finding {
    let (subject, node) = ("node", wanted.node);
    let heard = wanted.own.iter().filter(|id| hearing.of(**id).is_some());
    let ids = heard.map(ToString::to_string).collect::<Vec<_>>().join(", ");
    let another = "give each gateway a node of its own (gateway.node), and no other device these \
                   identifiers";
    if ids.is_empty() {
        return Finding::ok(subject, format!("no other device sends as node {node}"));
    }
    match rights.gateway {
        _ if hearing.status.is_mixed() => Finding::fail(
            subject,
            format!(
                "more than one device sends as node {node}: the counters of its status are \
                mixed"
            ),
            another,
        ),
        Some(process) => Finding::ok(
            subject,
            format!("{ids}: one sender, the gateway that is running here (process {process})"),
        ),
        None => Finding::fail(
            subject,
            format!(
                "{ids} of node {node} come, but no gateway of this configuration is running here: \
                 another device sends them"
            ),
            another,
        ),
    }
}
