//! Cylinders by names alone, where no recording shows them.

use super::catalogue::Catalogue;
use super::cylinders::{Assembled, KEYS, Pick, Picks, beside_positions, complete, pressures};
use super::naming::TWINS;
use super::pattern;
use super::tally::BusTally;
use super::words::{Hint, Measure, measure, says, words};
use super::{Certainty, MOST_CYLINDERS};

/// The cylinders whose two transducers and command are told by names and units; `None` if there are none.
pub(super) fn by_names(catalogue: &Catalogue<'_>, tally: &BusTally) -> Option<Assembled> {
    let positions: Vec<usize> =
        (0..catalogue.signals()).filter(|signal| is_position(catalogue, *signal)).collect();
    let pairs: Vec<[usize; 2]> = positions
        .iter()
        .enumerate()
        .flat_map(|(place, first)| {
            positions[place + 1..].iter().map(move |second| [*first, *second])
        })
        .filter(|[first, second]| are_twins(catalogue, *first, *second))
        .collect();
    let candidates = pairs.iter().flat_map(|pair| sets(catalogue, *pair));
    let set = candidates.max_by_key(|set| set.len())?;
    let mut cylinders: Vec<Picks> =
        set.into_iter().map(|signals| picks(catalogue, signals)).collect();
    for picks in &mut cylinders {
        if let Some(command) = picks.get("control_speed").map(|pick| pick.signal) {
            pressures(catalogue, (command, None), picks);
            spool(catalogue, command, picks);
        }
        beside_positions(catalogue, tally, picks);
    }
    complete(catalogue, &mut cylinders);
    debug_assert!(cylinders.iter().all(|it| it.keys().all(|key| KEYS.contains(key))));
    let lacks = vec![
        "no recording shows which signals agree and move: every signal is a guess by its name"
            .to_owned(),
    ];
    Some(Assembled { cylinders, lacks })
}

fn is_position(catalogue: &Catalogue<'_>, signal: usize) -> bool {
    let (name, unit) = (catalogue.name(signal), measure(catalogue.unit(signal)));
    let other = [Hint::Unmeasured, Hint::Velocity, Hint::Spool, Hint::Command];
    let own = &catalogue.signals[signal].signal.name;
    unit == Measure::Length
        && !other.iter().any(|hint| says(own, *hint))
        && (says(name, Hint::Position) || words(own) == ["c"])
}

/// Whether two names differ as those of two transducers of one length do: in one number, 1 and 2, or one word.
fn are_twins(catalogue: &Catalogue<'_>, first: usize, second: usize) -> bool {
    let (one, two) = (catalogue.name(first), catalogue.name(second));
    if catalogue.unit(first) != catalogue.unit(second) {
        return false;
    }
    let patterns = pattern::with_place(one, 1);
    let numbered = patterns.iter().any(|it| it.replace(pattern::PLACE, "2") == two);
    let (left, right) = (words(one), words(two));
    let differing: Vec<_> = left.iter().zip(&right).filter(|(one, two)| one != two).collect();
    let worded = left.len() == right.len()
        && matches!(differing.as_slice(), [(one, two)] if TWINS.contains(&[one.as_str(), two.as_str()]));
    numbered || worded
}

/// The sets of cylinders that the names of one pair may belong to, each cylinder with C1, C2 and its command.
fn sets(catalogue: &Catalogue<'_>, [first, second]: [usize; 2]) -> Vec<Vec<[usize; 3]>> {
    let (one, two) = (catalogue.name(first), catalogue.name(second));
    let commands = (0..catalogue.signals()).filter(|signal| is_command(catalogue, *signal));
    let mut sets = Vec::new();
    for command in commands {
        let of_one = pattern::with_place(one, 1);
        let of_two = pattern::with_place(two, 1);
        for command_pattern in pattern::with_place(catalogue.name(command), 1) {
            for (c1, c2) in of_one.iter().flat_map(|c1| of_two.iter().map(move |c2| (c1, c2))) {
                let name = |pattern: &str, n: usize| {
                    catalogue.find(&pattern.replace(pattern::PLACE, &n.to_string()))
                };
                let of = |n: usize| Some([name(c1, n)?, name(c2, n)?, name(&command_pattern, n)?]);
                let set: Vec<[usize; 3]> = (1..=MOST_CYLINDERS).map_while(of).collect();
                let mut all: Vec<usize> = set.iter().flatten().copied().collect();
                all.sort_unstable();
                let distinct = all.windows(2).all(|two| two[0] != two[1]);
                if set.len() > 1 && distinct {
                    sets.push(set);
                }
            }
        }
        sets.push(vec![[first, second, command]]);
    }
    sets
}

fn is_command(catalogue: &Catalogue<'_>, signal: usize) -> bool {
    let own = &catalogue.signals[signal].signal.name;
    let (name, unit) = (catalogue.name(signal), measure(catalogue.unit(signal)));
    unit == Measure::Speed
        && says(name, Hint::Command)
        && !says(own, Hint::Spool)
        && !says(own, Hint::Unmeasured)
}

fn picks(catalogue: &Catalogue<'_>, signals: [usize; 3]) -> Picks {
    let why = |signal: usize| match catalogue.unit(signal) {
        "" => "by its name".to_owned(),
        unit => format!("by its name and unit, {unit}"),
    };
    let keys = ["c1", "c2", "control_speed"];
    let pick = |signal| Pick { signal, certainty: Certainty::Guessed, why: why(signal) };
    keys.into_iter().zip(signals.map(pick)).collect()
}

fn spool(catalogue: &Catalogue<'_>, command: usize, picks: &mut Picks) {
    let is_spool = |signal: &usize| {
        says(&catalogue.signals[*signal].signal.name, Hint::Spool) && *signal != command
    };
    if let Some(signal) = catalogue.answering(command, None).into_iter().find(is_spool) {
        let why = "by its name".to_owned();
        picks.insert("spool", Pick { signal, certainty: Certainty::Guessed, why });
    }
}
