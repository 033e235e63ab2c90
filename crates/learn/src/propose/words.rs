//! What names say of signals, in several languages.

/// What a word in a signal's name stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Hint {
    Position,
    Velocity,
    Command,
    Status,
    Counter,
    State,
    Pressure,
    Bottom,
    Rod,
    Supply,
    Spool,
    /// A value that is wanted or computed instead of measured.
    Unmeasured,
}

/// Words with their meaning, in English, German, Dutch, French, Spanish and Norwegian.
const WORDS: [(Hint, &[&str]); 12] = [
    (
        Hint::Position,
        &[
            "position",
            "pos",
            "stroke",
            "length",
            "extension",
            "displacement",
            "lage",
            "weg",
            "hub",
            "laenge",
            "positie",
            "slag",
            "lengte",
            "longueur",
            "course",
            "posicion",
            "carrera",
            "posisjon",
            "lengde",
        ],
    ),
    (
        Hint::Velocity,
        &[
            "velocity",
            "vel",
            "speed",
            "geschwindigkeit",
            "geschw",
            "snelheid",
            "vitesse",
            "velocidad",
            "hastighet",
        ],
    ),
    (
        Hint::Command,
        &[
            "command",
            "cmd",
            "control",
            "ctrl",
            "demand",
            "setpoint",
            "valve",
            "soll",
            "sollwert",
            "stell",
            "stellwert",
            "ventil",
            "stuur",
            "klep",
            "consigne",
            "commande",
            "vanne",
            "mando",
            "paadrag",
        ],
    ),
    (
        Hint::Status,
        &[
            "status",
            "error",
            "err",
            "fault",
            "diag",
            "diagnosis",
            "diagnostics",
            "flags",
            "fehler",
            "storing",
            "fout",
            "erreur",
            "defaut",
            "feil",
        ],
    ),
    (
        Hint::Counter,
        &[
            "counter", "cnt", "ctr", "alive", "rolling", "sequence", "seq", "zaehler", "teller",
            "compteur", "contador",
        ],
    ),
    (
        Hint::State,
        &[
            "state",
            "mode",
            "zustand",
            "betriebsart",
            "toestand",
            "etat",
            "estado",
            "tilstand",
            "status",
        ],
    ),
    (Hint::Pressure, &["pressure", "press", "druck", "druk", "pression", "presion", "trykk"]),
    (
        Hint::Bottom,
        &["bottom", "bot", "cap", "piston", "blind", "boden", "kolben", "bodem", "fond", "a"],
    ),
    (Hint::Rod, &["rod", "annulus", "ring", "stange", "stang", "tige", "vastago", "b"]),
    (
        Hint::Supply,
        &[
            "supply",
            "ps",
            "pump",
            "accumulator",
            "accu",
            "akku",
            "speicher",
            "versorgung",
            "toevoer",
            "alimentation",
            "pompe",
            "pumpe",
            "accumulateur",
            "acumulador",
        ],
    ),
    (Hint::Spool, &["spool", "schieber", "schuif", "tiroir", "sleide", "lvdt"]),
    (
        Hint::Unmeasured,
        &[
            "reference",
            "ref",
            "target",
            "estimate",
            "desired",
            "soll",
            "setpoint",
            "consigne",
            "residual",
        ],
    ),
];

/// The words of a name in lower case: parted where letters change their case, at digits and signs.
pub(super) fn words(name: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut previous = '_';
    for letter in name.chars() {
        let begins = !previous.is_alphabetic() || previous.is_lowercase() && letter.is_uppercase();
        if letter.is_alphabetic() {
            if begins {
                words.push(String::new());
            }
            if let Some(word) = words.last_mut() {
                word.extend(letter.to_lowercase());
            }
        }
        previous = letter;
    }
    words
}

/// Whether a name has a word of that meaning.
pub(super) fn says(name: &str, hint: Hint) -> bool {
    let known = WORDS.iter().find(|(of, _)| *of == hint).map_or(&[][..], |(_, known)| known);
    words(name).iter().any(|word| known.contains(&word.as_str()))
}

/// A unit by what it measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Measure {
    Length,
    Speed,
    Pressure,
    /// No unit, a share, an angle or counts: it may stand for anything.
    Open,
    Other,
}

/// What a unit of a DBC measures.
pub(super) fn measure(unit: &str) -> Measure {
    match unit.trim().to_lowercase().as_str() {
        "m" | "mm" | "cm" | "um" | "µm" | "in" | "inch" => Measure::Length,
        "m/s" | "mm/s" | "cm/s" => Measure::Speed,
        "bar" | "pa" | "kpa" | "mpa" | "psi" => Measure::Pressure,
        "" | "-" | "%" | "deg" | "degree" | "degrees" | "°" | "rad" | "count" | "counts"
        | "inc" | "digit" | "1" => Measure::Open,
        _ => Measure::Other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_parted_into_words() {
        assert_eq!(words("Cyl1_C1.Position"), ["cyl", "c", "position"]);
        assert_eq!(words("zylinderLage2"), ["zylinder", "lage"]);
        assert!(says("Plc_State.PlatformState", Hint::State));
        assert!(!says("Estatement.X", Hint::State), "a word is whole");
        assert!(says("Ventil_3.Sollwert", Hint::Command));
    }
}
