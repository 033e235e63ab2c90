//! Look-up of names in a DBC.

/// Why a name leads to no message or signal.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LookupError {
    #[error("{given:?} is not of the form MESSAGE.SIGNAL")]
    Form { given: String },
    #[error("there is no message {given:?} in the DBC{}", nearest_text(.nearest))]
    Message {
        given: String,
        /// Up to three known names, the most similar first.
        nearest: Vec<String>,
    },
    #[error("message {message} has no signal {given:?}{}", nearest_text(.nearest))]
    Signal {
        message: String,
        given: String,
        /// Up to three known names, the most similar first.
        nearest: Vec<String>,
    },
    #[error("no PDO of {device} carries object {given}{}", told(.carried, .note))]
    Object {
        device: String,
        given: String,
        /// Objects that the device's PDOs carry.
        carried: Vec<String>,
        /// What else is known of the device's PDOs; may be empty.
        note: String,
    },
    /// The message exists, but has an error.
    #[error("message {message} cannot be used: {reason}")]
    Refused {
        message: String,
        /// The first of its findings, with its line.
        reason: String,
    },
}

fn told(carried: &[String], note: &str) -> String {
    let carried = match carried {
        [] => "; none carries an object".to_owned(),
        carried => format!("; they carry {}", carried.join(", ")),
    };
    if note.is_empty() { carried } else { format!("{carried}; {note}") }
}

fn nearest_text(nearest: &[String]) -> String {
    if nearest.is_empty() { String::new() } else { format!("; nearest: {}", nearest.join(", ")) }
}

/// Up to three of `known` that `given` may have been intended for, the most similar first.
pub(super) fn nearest<'a>(given: &str, known: impl Iterator<Item = &'a str>) -> Vec<String> {
    const MOST: usize = 3;
    const SIMILAR: f64 = 0.75;
    // Similarity takes time with the product of both lengths; known names are bounded.
    if given.len() > 2 * super::MAX_NAME {
        return Vec::new();
    }
    let given = given.to_lowercase();
    let mut similar: Vec<(f64, &str)> = known
        .map(|name| (strsim::jaro_winkler(&given, &name.to_lowercase()), name))
        .filter(|&(similarity, _)| similarity >= SIMILAR)
        .collect();
    similar.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(b.1)));
    similar.truncate(MOST);
    similar.into_iter().map(|(_, name)| name.to_owned()).collect()
}
