//! Words for incidents of the machine: what several cylinders have in common.

use tertius_core::incident::Cylinders;
use tertius_core::text::listed;
use tertius_core::verdict::Fault;

/// What a person should do about what most cylinders show together.
pub(super) const fn advice(kind: Fault) -> &'static str {
    match kind {
        Fault::Incipient => {
            "Look at what these transducers share: the temperature, their supply, the controller that reads them. If one \
            of them still differs when that is over, drive its cylinder to its end stop."
        }
        _ => {
            "Check what these cylinders share: the bus and its load, the Sync, the controller. The transducers are not \
            suspected."
        }
    }
}

/// Whose an incident is: `machine (cylinders 1 to 6)`.
pub fn of_machine(cylinders: Cylinders) -> String {
    format!("machine (cylinders {})", numbers(cylinders))
}

/// Numbers of cylinders: `1 to 6`, `2`, `1, 3 and 4`.
pub fn numbers(cylinders: Cylinders) -> String {
    let all: Vec<u8> = cylinders.numbers().collect();
    match all[..] {
        [] => "unknown".to_owned(),
        [first, .., last] if all.len() > 2 && usize::from(last - first) + 1 == all.len() => {
            format!("{first} to {last}")
        }
        ref all => listed(&all.iter().map(u8::to_string).collect::<Vec<_>>()),
    }
}

/// What is wrong with the machine.
pub const fn in_common(kind: Fault) -> &'static str {
    match kind {
        Fault::Stale => "no messages in time",
        Fault::Incipient => "C1 and C2 drift apart on most cylinders at once",
        other => super::fault(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cylinders_are_counted_as_a_person_counts_them() {
        let said = |all: &[usize]| {
            let mut cylinders = Cylinders::NONE;
            all.iter().for_each(|number| cylinders.insert(number - 1));
            numbers(cylinders)
        };
        assert_eq!(said(&[1, 2, 3, 4, 5, 6]), "1 to 6");
        assert_eq!(said(&[3, 4, 5, 6]), "3 to 6");
        assert_eq!(said(&[1, 3, 4]), "1, 3 and 4");
        assert_eq!([said(&[5, 6]), said(&[2]), said(&[])], ["5 and 6", "2", "unknown"]);
    }
}
