//! What is read of each cylinder, and by what it is judged; cylinders that are judged alike are told once.

use super::super::machine::Machine;
use super::objects;
use crate::config::{MachineNames, Settings};
use crate::frame::BusNumber;
use crate::monitor::cylinder::WaySource;
use crate::monitor::subscriptions::{Subscription, Target};
use crate::observe::model::Model;
use crate::report::alignment::numbers;
use crate::sample::Transducer;

/// A block for each cylinder that is judged as no other one is. Of others there is one block for all that are alike,
/// and then for each of them the lines that are its own.
pub(super) fn describe(machine: &Machine) -> String {
    let names = machine.loaded.settings.names();
    let mut groups: Vec<(String, Vec<u8>)> = Vec::new();
    for n in 1..=machine.loaded.settings.machine.cylinders {
        let judged = judged(machine, n);
        match groups.iter_mut().find(|(told, _)| *told == judged) {
            Some((_, alike)) => alike.push(n),
            None => groups.push((judged, vec![n])),
        }
    }
    let blocks = groups.iter().map(|(judged, alike)| match alike.as_slice() {
        [n] => format!("\n{}\n{}{judged}", names.cylinder(*n), read(machine, &names, *n)),
        alike => {
            let each = alike
                .iter()
                .map(|n| format!("{}\n{}", names.cylinder(*n), read(machine, &names, *n)));
            format!("\ncylinders {}\n{judged}\n{}", numbers(alike), each.collect::<String>())
        }
    });
    blocks.collect()
}

/// The tags, frames, objects and devices of cylinder `n`.
fn read(machine: &Machine, names: &MachineNames, n: u8) -> String {
    tags(names, n)
        + &identifiers(n, machine.design.subscriptions.all())
        + &objects::of_cylinder(machine, n)
        + &objects::devices(machine, n)
}

/// How the transducers of cylinder `n` are called; empty where they have numbers alone.
fn tags(names: &MachineNames, n: u8) -> String {
    let named = [Transducer::C1, Transducer::C2].into_iter();
    let named = named.filter(|it| names.of_transducer(n, *it).is_some());
    let named: Vec<String> = named.map(|it| names.transducer(n, it)).collect();
    if named.is_empty() { String::new() } else { format!("  names     {}\n", named.join(", ")) }
}

/// The model, the observers and the comparator of cylinder `n`, and its estimate.
fn judged(machine: &Machine, n: u8) -> String {
    let settings = &machine.loaded.settings;
    let (theta, gamma) = settings.model_of(n);
    let model = Model::new(settings.machine.sample_time, theta, gamma);
    let cylinder = &machine.design.cylinders[usize::from(n) - 1];
    let mut text = format!("  model     {}\n", poles(&model));
    let has_c2 = cylinder.has(Transducer::C2);
    let names = if has_c2 { &["FDE1", "FDE2"][..] } else { &["FDE1"] };
    for (observer, name) in cylinder.observers.iter().zip(names) {
        let l = observer.l.column(0);
        let gain = format!("{:.4}, {:.4}, {:.1}", l[0], l[1], l[2]);
        let off = if cylinder.observes { "" } else { "off (fde.enabled); " };
        text += &format!("  {name}      {off}gain of the position's innovation {gain}\n");
    }
    let (gain, offset) = (cylinder.comparator.gain, cylinder.comparator.offset);
    let off = if cylinder.compares { "" } else { "off (comparator.enabled); " };
    text += &match has_c2 {
        true => format!("  FDE3      {off}C1 − {}\n", corrected(gain, offset)),
        false => "  C2        not fitted, so nothing is compared: no FDE2, no FDE3, no sequential detector\n"
            .to_owned(),
    };
    if !has_c2 && settings.sequential.stop_states.is_some() {
        text += "  stop      C1 is compared with what it read there before, day by day\n";
    }
    if let Some(process) = process(machine, n) {
        text += &format!("  process   {process}\n");
    }
    if let Some(source) = WaySource::of(cylinder) {
        let of = if has_c2 { "a transducer that is left alone" } else { "C1" };
        let by = match source {
            WaySource::Oil => "the oil that passes the valve",
            WaySource::Drive => "the fitted drive",
            WaySource::Model => "the model",
        };
        text += &format!("  reckoning {of} is compared with the way by {by}\n");
    }
    text + &format!("  estimate  {}\n", estimate(settings, n))
}

/// C2 with the correction of (5-20), whose `offset` is in m: `(0.998502 C2 − 3.403 mm)`, or `C2` where nothing is
/// corrected.
fn corrected(gain: f64, offset: f64) -> String {
    let gain = (gain * 1e6).round() / 1e6;
    let micrometres = (offset * 1e6).round();
    if gain == 1.0 && micrometres == 0.0 {
        return "C2".to_owned();
    }
    let sign = if micrometres < 0.0 { '−' } else { '+' };
    format!("({gain} C2 {sign} {} mm)", micrometres.abs() / 1e3)
}

/// What the process detector judges by; `None` where the machine reads neither spools nor pressures.
fn process(machine: &Machine, n: u8) -> Option<String> {
    let own = &machine.loaded.settings.signals.cylinder;
    let design = machine.design.cylinders[usize::from(n) - 1].process.as_ref();
    let is_read = own.spool.is_some() || own.pressure_bottom.is_some();
    let Some(design) = design else {
        let absent = "not judged, as `tertius commission` or `calibrate` has not taught it";
        return is_read.then(|| absent.to_owned());
    };
    let parts = [
        ("spool", design.spool.is_some()),
        ("chambers' pressures", design.chambers.is_some()),
        ("flow", design.flow.is_some()),
        ("friction", design.friction.is_some()),
        ("supply", design.supply),
    ];
    let known = parts.into_iter().zip(design.levels()).filter(|((_, is_known), _)| *is_known);
    let known = known.map(|((name, _), level)| format!("{name} (level {level:.1} nats)"));
    Some(known.collect::<Vec<_>>().join(", "))
}

fn estimate(settings: &Settings, n: u8) -> String {
    let drive = settings.sequential_of(n).and_then(|fitted| fitted.drive);
    let by = drive.map_or("the model", |_| "the fitted drive");
    let bound = settings.estimate.bound * 1e3;
    let sent = if settings.estimate.send { "sent" } else { "not sent" };
    let of = if settings.has_c2(n) { "both transducers" } else { "C1" };
    format!("{of} and {by}; valid up to σ = {bound} mm; {sent}")
}

fn poles(model: &Model) -> String {
    let poles = model.poles().map_or("not finite".to_owned(), |poles| {
        poles.map(|pole| format!("{:.5}", pole.norm())).join(", ")
    });
    let gain = model.velocity_gain().map_or("none".to_owned(), |gain| format!("{gain:.3}"));
    format!("moduli of the poles {poles}; steady speed per commanded speed {gain}")
}

fn identifiers(n: u8, lines: &[Subscription]) -> String {
    let of_cylinder = |line: &&Subscription| {
        line.signals
            .iter()
            .any(|signal| matches!(signal.target, Target::Cylinder(i, _) if i + 1 == n))
    };
    let name = |line: &Subscription| {
        let bus = match line.bus {
            BusNumber::First => String::new(),
            other => format!("{other}:"),
        };
        match line.pages() {
            0 | 1 => format!("{bus}0x{}", line.id),
            pages => format!("{bus}0x{} ({pages} pages)", line.id),
        }
    };
    let ids: Vec<String> = lines.iter().filter(of_cylinder).map(name).collect();
    format!("  frames    {}\n", ids.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_correction_of_c2_has_a_unit_and_one_kind_of_minus() {
        let told = corrected(0.998_502_165_608_634_6, -0.003_403_062_527_381_372_6);
        assert_eq!(told, "(0.998502 C2 − 3.403 mm)");
        assert_eq!(corrected(1.002, 0.0), "(1.002 C2 + 0 mm)");
        assert_eq!(corrected(1.0, 0.0), "C2");
    }
}
