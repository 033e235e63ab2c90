//! What `check` says of the attitude sensor on the deck.

use crate::cli::machine::Machine;
use crate::sample::Transducer;

/// Whether there is a detector by the deck's attitude, and by what it judges; empty for machines that are no hexapod.
pub fn describe(machine: &Machine) -> String {
    let signals = &machine.loaded.settings.signals;
    let names =
        [&signals.top_roll, &signals.top_pitch, &signals.vessel_roll, &signals.vessel_pitch];
    let Some(tilt) = &machine.design.tilt else {
        return "\nhexapod: not used: there is no attitude sensor on the deck (signals.top_roll)\n"
            .to_owned();
    };
    let names: Vec<&str> = names.into_iter().flatten().map(String::as_str).collect();
    let without = |has_c2: bool| {
        let blind = machine.design.cylinders.iter().filter(|it| it.sequential.is_none());
        let blind = blind.filter(|it| it.has(Transducer::C2) == has_c2);
        let numbers: Vec<String> = blind.map(|it| it.number.to_string()).collect();
        match numbers.as_slice() {
            [] => None,
            [one] => Some((format!("cylinder {one}"), "has")),
            numbers => Some((format!("cylinders {}", numbers.join(", ")), "have")),
        }
    };
    let blind = without(true).map_or(String::new(), |(which, has)| {
        format!("; not for {which}, which {has} no sequential detector to find a drift first")
    });
    let single = without(false).map_or(String::new(), |(which, has)| {
        format!("; by itself it finds an error of C1 of {which}, which {has} no C2")
    });
    format!(
        "\nhexapod: the deck's attitude names the reading that has moved, by {} (accuracy {:.3}°){blind}{single}\n",
        names.join(", "),
        tilt.accuracy.to_degrees()
    )
}
