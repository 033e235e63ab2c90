//! `tertius check`: validates a configuration and its DBC.

mod cylinders;
mod deck;
mod objects;

use super::Failure;
use super::history;
use super::machine::Machine;
use super::overriding::SetOptions;
use super::run;
use crate::config::Settings;
use crate::config::settings::{CylinderSignals, bus_of};
use crate::config::units::Converted;
use crate::decode::Raw;
use crate::failure::print;
use crate::report::alignment;
use crate::sequential::SequentialParameters;
use crate::sequential::samples::NEWEST;
use crate::text::{Millimetres, counted};
use clap::Args;
use std::path::PathBuf;

/// Times that differ by less are the same, s.
const SAME_TIME: f64 = 1e-9;

/// Checks a configuration and its DBC, and tells what the monitor would do with them.
#[derive(Args, Debug)]
#[command(after_help = "Example:\n  tertius check config/e-type.toml")]
pub struct Check {
    /// The machine's configuration
    #[arg(value_name = "FILE")]
    config: PathBuf,
    #[command(flatten)]
    set: SetOptions,
}

impl Check {
    /// Runs the command.
    ///
    /// # Errors
    /// Every error in the configuration and its DBC.
    pub fn run(self) -> Result<(), Failure> {
        let machine = Machine::load_checking(&self.config, &self.set.overrides()?)?;
        print(&describe(&machine))
    }
}

fn describe(machine: &Machine) -> String {
    let settings = &machine.loaded.settings;
    let subscriptions = machine.design.subscriptions.all();
    let mut text = format!(
        "{}: sound{}\n{}: {} messages{}, of which {} are used\n\n",
        machine.loaded.document.name(),
        if foreign_time(machine).is_some() {
            ", but `tertius commission` has to learn its model before it can be used"
        } else {
            ""
        },
        machine.loaded.dbc_path.display(),
        machine.database.messages().len() - machine.database.device_messages(),
        objects::messages(machine),
        subscriptions.iter().filter(|line| line.service.is_none()).count(),
    );
    let any_c2 = (1..=settings.machine.cylinders).any(|n| settings.has_c2(n));
    let (observers, judge) = if any_c2 { ("FDE1 and FDE2", "judge") } else { ("FDE1", "judges") };
    text += &format!(
        "{}: {}, every {} s; {}\n",
        settings.machine.name,
        counted(settings.machine.cylinders.into(), "cylinder"),
        settings.machine.sample_time,
        match &settings.machine.monitored_states {
            Some(states) => format!("{observers} {judge} when {}", states.join(" or ")),
            None => format!("{observers} always {judge}"),
        }
    );
    text += &buses(machine);
    text += &format!("judged by {}\n", machine.loaded.fingerprints());
    text += &units(machine);
    text += &overrides(machine);
    text += &cylinders::describe(machine);
    text += &deck::describe(machine);
    text += &canopen(settings);
    text += &logins(settings);
    text += &stops(machine);
    text += &doubts(machine);
    text += &findings(machine);
    text += &objects::findings(machine);
    text
}

/// The buses and what is on them; empty for a machine with one.
fn buses(machine: &Machine) -> String {
    let bus = &machine.loaded.settings.bus;
    if !bus.is_several() {
        return String::new();
    }
    let buses = bus.interfaces().map(|(bus, interface)| {
        let all = machine.design.subscriptions.all();
        let messages = all.iter().filter(|line| line.bus == bus && line.service.is_none()).count();
        format!("the {bus} bus, {interface}, has {messages} of them")
    });
    format!("{}\n", buses.collect::<Vec<_>>().join("; "))
}

/// The signals that are read in another unit than the DBC gives them; empty without.
fn units(machine: &Machine) -> String {
    let line = |it: &Converted| {
        let more = match it.signals.len() {
            1 => String::new(),
            all => format!(" and {} more", all - 1),
        };
        let first = it.signals.first().map_or("", String::as_str);
        format!("{first}{more} in {:?} are read in {:?}\n", it.from, it.to)
    };
    machine.converted.iter().map(line).collect()
}

/// The values that come from outside the file; empty without.
fn overrides(machine: &Machine) -> String {
    let overrides = machine.loaded.document.overrides();
    if overrides.is_empty() {
        return String::new();
    }
    let lines = overrides.all().iter().map(|one| format!("  {one}\n"));
    format!("\noverrides in force, which are not in the file\n{}", lines.collect::<String>())
}

/// Settings that are valid, but hardly intended, since a healthy machine would not be healthy with
/// them.
fn doubts(machine: &Machine) -> String {
    let settings = &machine.loaded.settings;
    let mut doubts = broken_wire_doubts(machine);
    doubts.extend((1..=settings.machine.cylinders).filter_map(|n| critical_doubt(settings, n)));
    doubts.extend(fast_doubt(settings));
    doubts.extend(command_doubt(machine));
    doubts.extend(model_doubt(machine));
    doubts.extend(off_doubt(machine));
    doubts.extend(alignment::doubt(&settings.unaligned()).map(|it| format!("cylinder: {it}")));
    doubts.extend(run::not_built(settings));
    if doubts.is_empty() {
        return String::new();
    }
    let lines = doubts.iter().map(|doubt| format!("  {doubt}\n"));
    format!("\n{}: worth a look\n{}", machine.loaded.document.name(), lines.collect::<String>())
}

/// A broken-wire code that is also a valid length. The cylinders' signals are alike, so the first
/// of C1 and of C2 are checked.
fn broken_wire_doubts(machine: &Machine) -> Vec<String> {
    let settings = &machine.loaded.settings;
    let signals = &settings.signals.cylinder;
    let mut doubts = Vec::new();
    let second = (1..=settings.machine.cylinders).find(|n| settings.has_c2(*n));
    let second = second.and_then(|n| Some((signals.c2.as_ref()?, n)));
    for (name, n) in [Some((&signals.c1, 1)), second].into_iter().flatten() {
        let name = CylinderSignals::of_cylinder(name, n);
        let Some((_, bare)) = bus_of(&name) else { continue };
        let Ok((_, signal)) = machine.database.signal(bare) else { continue };
        let [lowest, highest] = signal.range.unwrap_or(settings.machine.stroke);
        for code in settings.broken_wire_codes(signal) {
            let length = signal.plan.physical(Raw::Signed(code));
            if !signal.plan.is_float() && (lowest..=highest).contains(&length) {
                doubts.push(format!(
                    "plausibility.broken_wire_codes: {code} is {length:.4} m of {name}, within its \
                     range of {lowest} to {highest} m: a healthy reading there would be taken for \
                     a broken wire"
                ));
            }
        }
    }
    doubts
}

/// A command that is a speed in a unit that is not known.
fn command_doubt(machine: &Machine) -> Option<String> {
    let signals = &machine.loaded.settings.signals.cylinder;
    let name = CylinderSignals::of_cylinder(&signals.control_speed, 1);
    let (_, signal) = machine.database.signal(bus_of(&name)?.1).ok()?;
    let unit = &*signal.unit;
    (unit.contains('/') && unit != "m/s").then(|| {
        format!(
            "signals.cylinder.control_speed: {name} is in {unit:?}, which is not known, and its numbers are taken for \
             m/s: scale factor, offset and range of the DBC to \"m/s\""
        )
    })
}

/// A machine that is faster than the rings were made for.
fn fast_doubt(settings: &Settings) -> Option<String> {
    let sample_time = settings.machine.sample_time;
    let (wanted, held) = (SequentialParameters::DEFAULT.kind.newest, NEWEST as f64 * sample_time);
    (held < wanted - SAME_TIME).then(|| {
        format!(
            "machine.sample_time: above 100 Hz the kind of a fault and whose it is are told from less time: \
             at {sample_time} s the newest {NEWEST} samples are {held:.2} s, not {wanted} s"
        )
    })
}

/// Sample time of the default model, s, where a cylinder has no other one and the machine's sample time is another: no
/// command that judges takes such a configuration.
fn foreign_time(machine: &Machine) -> Option<f64> {
    let settings = &machine.loaded.settings;
    let ours = settings.machine.sample_time;
    let mut times = (1..=settings.machine.cylinders).filter_map(|n| settings.model_time_of(n));
    times.find(|time| (time - ours).abs() > SAME_TIME)
}

/// Detectors that the configuration switches off.
fn off_doubt(machine: &Machine) -> Option<String> {
    let off = machine.loaded.settings.switched_off()?;
    Some(format!(
        "fde.enabled, comparator.enabled: switched off: {off}. `tertius commission` switches detectors off whose threshold would \
         be too large to find a fault, and on again when a recording gives a smaller one"
    ))
}

/// A machine without a model of its own, which R1 and R2 judge by that of another one.
fn model_doubt(machine: &Machine) -> Option<String> {
    if let Some(time) = foreign_time(machine) {
        let ours = machine.loaded.settings.machine.sample_time;
        let who = if machine.loaded.has_model() {
            "not every cylinder has one"
        } else {
            "this file has none"
        };
        return Some(format!(
            "model: {who}, and that of another machine (thesis, Table 4-1) is for a \
             sample time of {time} s, not {ours} s, so that `replay` and `run` refuse this configuration; \
             `tertius commission` takes it as it is, and learns this machine's model from a healthy recording"
        ));
    }
    (!machine.loaded.has_model()).then(|| {
        "model: this file has none, so that R1 and R2 judge by the model of another machine (thesis, Table 4-1); \
         `tertius commission` learns this machine's from a healthy recording"
            .to_owned()
    })
}

/// Transducers that the machine's own rule would find apart although they agree with a and b of (5-20).
fn critical_doubt(settings: &Settings, n: u8) -> Option<String> {
    if !settings.has_c2(n) {
        return None;
    }
    let (gain, offset) = settings.comparator_of(n);
    let apart = |c1: f64| (c1 - (c1 - offset) / gain).abs();
    let [most, at] = settings
        .machine
        .stroke
        .map(|c1| [apart(c1), c1])
        .into_iter()
        .max_by(|one, two| one[0].total_cmp(&two[0]))?;
    let critical = settings.comparator.critical;
    (most > critical).then(|| {
        format!(
            "comparator.critical: C1 − C2 of a healthy {} is {most:.4} m at {at} m, by a \
             and b of (5-20), which exceeds {critical} m: there it is always critical",
            settings.names().cylinder(n)
        )
    })
}

/// Which dwells are read, and where they are kept; empty where this is not configured.
fn stops(machine: &Machine) -> String {
    let settings = &machine.loaded.settings;
    let states = settings.sequential.stop_states.as_deref().unwrap_or_default();
    let kept = match &machine.loaded.history_path {
        Some(path) => format!("the history is kept in {}", path.display()),
        None => "the history is kept in memory only".to_owned(),
    };
    match history::lack(machine) {
        None => {
            let limit = Millimetres(settings.drift_limits().maintenance).chosen();
            let states = states.join(" or ");
            format!("\nend stops   read when {states}; due after {limit}; {kept}\n")
        }
        Some(lack) if machine.loaded.history_path.is_some() => {
            format!("\nend stops   not read: {lack}\n")
        }
        Some(_) => String::new(),
    }
}

/// The gateway as a CANopen node; empty if it is none.
fn canopen(settings: &Settings) -> String {
    let Some(canopen) = settings.canopen_node() else { return String::new() };
    let heartbeat = match canopen.heartbeat {
        0.0 => "no heartbeat".to_owned(),
        seconds => format!("heartbeat every {seconds} s"),
    };
    let start = if canopen.autostart { "by itself" } else { "when a master starts it" };
    format!("\nCANopen    node {}, {heartbeat}, operational {start}\n", settings.gateway.node)
}

/// What wrong tokens lead to; empty where there is no token.
fn logins(settings: &Settings) -> String {
    let http = &settings.http;
    match http.token {
        Some(_) => format!(
            "\nlogins     an address waits after each wrong token, and is locked out for {} s after {}\n",
            http.lockout, http.login_failures
        ),
        None => String::new(),
    }
}

fn findings(machine: &Machine) -> String {
    let findings = machine.database.findings();
    if findings.is_empty() {
        return String::new();
    }
    let mut text = format!("\n{}: worth a look\n", machine.loaded.dbc_path.display());
    for finding in findings {
        text += &format!("  {finding}\n");
    }
    let left_out = machine.database.findings_left_out();
    if left_out > 0 {
        text += &format!("  … and {left_out} more\n");
    }
    text
}
