//! What `check` says of the attitude sensor on the deck.

use crate::cli::machine::Machine;

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
    let blind = machine.design.cylinders.iter().filter(|it| it.sequential.is_none());
    let blind: Vec<String> = blind.map(|it| it.number.to_string()).collect();
    let blind = match blind.as_slice() {
        [] => String::new(),
        numbers => format!(
            "; not for cylinders {}, which have no sequential detector to find a drift first",
            numbers.join(", ")
        ),
    };
    format!(
        "\nhexapod: the deck's attitude names the reading that has moved, by {} (accuracy {:.3}°){blind}\n",
        names.join(", "),
        tilt.accuracy.to_degrees()
    )
}
