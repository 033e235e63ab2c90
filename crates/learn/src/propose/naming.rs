//! The words by which the names of a machine's signals say which cylinder they are of, where they have no numbers.

use super::words::words;

/// Words by which the names of two transducers of one length differ, that of C1 first.
pub(super) const TWINS: [[&str; 2]; 8] = [
    ["a", "b"],
    ["main", "redundant"],
    ["primary", "secondary"],
    ["main", "backup"],
    ["haupt", "redundant"],
    ["main", "back"],
    ["main", "spare"],
    ["primary", "redundant"],
];

/// Letters that one of the words has at least: single ones stand for anything.
const LEAST_LETTERS: usize = 2;

/// The words that all `names` of a cylinder have in a row, and no name of another cylinder: `fwd`, `port` of
/// `FwdPort_Main.Position`. `None` of a cylinder whose names have no such words, and of one alone.
pub(super) fn of_cylinders(names: &[Vec<&str>]) -> Vec<Option<Vec<String>>> {
    let all: Vec<Vec<Vec<String>>> =
        names.iter().map(|own| own.iter().map(|name| words(name)).collect()).collect();
    let of = |place: usize| {
        let (first, rest) = all[place].split_first()?;
        let others = || all.iter().enumerate().filter(|(other, _)| *other != place);
        let is_own = |run: &&[String]| {
            rest.iter().all(|name| has(name, run))
                && others().all(|(_, names)| names.iter().all(|name| !has(name, run)))
                && run.iter().any(|word| word.chars().count() >= LEAST_LETTERS)
        };
        let lengths = (1..=first.len()).rev();
        let mut runs = lengths.flat_map(|length| first.windows(length));
        runs.find(is_own).map(<[String]>::to_vec)
    };
    (0..all.len()).map(|place| of(place).filter(|_| all.len() > 1)).collect()
}

/// The words as `name` spells them: `FwdPort` of `FwdPort_Main.Position`. `None` if the name does not have them.
pub(super) fn spelled<'a>(name: &'a str, cylinder: &[String]) -> Option<&'a str> {
    let ends =
        |from: usize| name[from..].char_indices().map(move |(at, c)| from + at + c.len_utf8());
    let parts = name.char_indices().flat_map(|(from, _)| ends(from).map(move |to| &name[from..to]));
    let is_it = |part: &&str| words(part) == cylinder;
    // A longer part has what is around the words.
    parts.filter(is_it).min_by_key(|part| part.len())
}

/// The places of two transducers by their names, that of C1 first: by what they are called, or else C1 before C2.
pub(super) fn in_order(names: [&str; 2]) -> [usize; 2] {
    let [left, right] = names.map(words);
    let called = |one: &[String], two: &[String]| {
        one.iter().zip(two).any(|(one, two)| TWINS.contains(&[one.as_str(), two.as_str()]))
    };
    match (called(&left, &right), called(&right, &left)) {
        (true, _) => [0, 1],
        (false, true) => [1, 0],
        (false, false) if names[0] <= names[1] => [0, 1],
        (false, false) => [1, 0],
    }
}

/// Whether a name has these words in a row.
pub(super) fn is_of(name: &str, cylinder: &[String]) -> bool {
    has(&words(name), &cylinder)
}

fn has(name: &[String], run: &&[String]) -> bool {
    name.windows(run.len()).any(|words| words == *run)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(names: &[Vec<&str>]) -> Vec<Option<String>> {
        of_cylinders(names).into_iter().map(|it| it.map(|words| words.join(" "))).collect()
    }

    #[test]
    fn a_name_is_spelled_as_the_signals_spell_it() {
        let run = ["fwd".to_owned(), "port".to_owned()];
        for (name, own) in [
            ("FwdPort_Main.Position", Some("FwdPort")),
            ("Rod.FWD_PORT_2", Some("FWD_PORT")),
            ("Hydraulics.fwdPortCapPress", Some("fwdPort")),
            ("Hydraulics.FwdStbdCapPress", None),
        ] {
            assert_eq!(spelled(name, &run), own, "{name}");
        }
    }

    #[test]
    fn the_main_one_is_c1_and_else_the_first_by_its_name() {
        for (names, order) in [
            (["Cyl1_C1.Position", "Cyl1_C2.Position"], [0, 1]),
            (["Cyl1_C2.Position", "Cyl1_C1.Position"], [1, 0]),
            (["FwdPort_Back.Position", "FwdPort_Main.Position"], [1, 0]),
            (["Rod.PosRedundant", "Rod.PosPrimary"], [1, 0]),
            (["RodA.Pos", "RodB.Pos"], [0, 1]),
        ] {
            assert_eq!(in_order(names), order, "{names:?}");
        }
    }

    #[test]
    fn a_cylinder_is_named_by_the_words_that_its_names_alone_have() {
        let of = |cylinder: &str| -> Vec<String> {
            ["Main.Position", "Back.Position", "Cmd.Demand"]
                .map(|it| format!("{cylinder}_{it}"))
                .to_vec()
        };
        let all = ["FwdPort", "FwdStbd", "AftPort", "AFT_STBD"].map(of);
        let names: Vec<Vec<&str>> =
            all.iter().map(|own| own.iter().map(String::as_str).collect()).collect();
        assert_eq!(
            told(&names),
            ["fwd port", "fwd stbd", "aft port", "aft stbd"].map(|it| Some(it.to_owned()))
        );
        assert!(is_of("Hydraulics.FwdPortCapPress", &["fwd".to_owned(), "port".to_owned()]));
        assert!(!is_of("Hydraulics.FwdStbdCapPress", &["fwd".to_owned(), "port".to_owned()]));
        // Numbers are no words, and nor is a letter that happens to be there.
        assert_eq!(told(&[vec!["Ram1.X", "Ram1.Y"], vec!["Ram2.X", "Ram2.Y"]]), [None, None]);
        assert_eq!(told(&[vec!["A.X", "A.Y"], vec!["B.X", "B.Y"]]), [None, None]);
        assert_eq!(told(&[vec!["Rig.X", "Rig.Y"]]), [None]);
    }
}
