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
    let blind = |has_c2: bool, why: &str| {
        let blind = machine.design.cylinders.iter().filter(|it| it.sequential.is_none());
        let blind = blind.filter(|it| it.has(Transducer::C2) == has_c2);
        let numbers: Vec<String> = blind.map(|it| it.number.to_string()).collect();
        match numbers.as_slice() {
            [] => String::new(),
            [one] => format!("; not for cylinder {one}, which has no {why}"),
            numbers => format!("; not for cylinders {}, which have no {why}", numbers.join(", ")),
        }
    };
    let blind = blind(true, "sequential detector to find a drift first")
        + &blind(false, "C2, so that no sequential detector finds a drift first");
    format!(
        "\nhexapod: the deck's attitude names the reading that has moved, by {} (accuracy {:.3}°){blind}\n",
        names.join(", "),
        tilt.accuracy.to_degrees()
    )
}
