//! The names of a machine's signals as patterns over its cylinders.

use super::MOST_CYLINDERS;

/// Stands for the cylinder's number.
pub(super) const PLACE: &str = tertius_config::settings::PLACEHOLDER;

/// Runs of digits in a name that are tried as the cylinder's number, at most.
const MOST_RUNS: usize = 6;

/// Places and numbers of the digits in a name.
fn runs(name: &str) -> Vec<(std::ops::Range<usize>, u32)> {
    let mut runs: Vec<std::ops::Range<usize>> = Vec::new();
    for (at, letter) in name.char_indices() {
        match runs.last_mut() {
            _ if !letter.is_ascii_digit() => {}
            Some(run) if run.end == at => run.end = at + 1,
            _ => runs.push(at..at + 1),
        }
    }
    let number = |run: std::ops::Range<usize>| Some((run.clone(), name[run].parse().ok()?));
    runs.into_iter().filter_map(number).take(MOST_RUNS).collect()
}

/// Cylinder numbers that the names of one signal of each may say: `[2, 1]` if the first one is cylinder 2's. Each
/// place of digits in the names may be the number.
pub(super) fn numbers(names: &[&str]) -> Vec<Vec<u32>> {
    if !skeletons_agree(names) {
        return Vec::new();
    }
    let all: Vec<_> = names.iter().map(|name| runs(name)).collect();
    let places = all.iter().map(Vec::len).min().unwrap_or(0);
    let numbers = |place: usize| all.iter().map(|runs| runs[place].1).collect::<Vec<u32>>();
    let sound = |numbers: &Vec<u32>| {
        let distinct = |(place, n): (usize, &u32)| !numbers[..place].contains(n);
        numbers.iter().all(|n| (1..=MOST_CYLINDERS as u32).contains(n))
            && numbers.iter().enumerate().all(distinct)
    };
    (0..places).map(numbers).filter(sound).collect()
}

/// The pattern with `{n}` of names that are those of these cylinders; `None` if there is none.
pub(super) fn of_numbers(names: &[&str], numbers: &[u32]) -> Option<String> {
    let (first, n) = (names.first()?, *numbers.first()?);
    let fits = |pattern: &String| {
        let mut both = names.iter().zip(numbers);
        both.all(|(name, n)| pattern.replace(PLACE, &n.to_string()) == **name)
    };
    with_place(first, n).into_iter().find(fits)
}

/// Whether the names differ in digits only.
fn skeletons_agree(names: &[&str]) -> bool {
    let skeleton = |name: &str| name.replace(|c: char| c.is_ascii_digit(), "");
    names.windows(2).all(|two| skeleton(two[0]) == skeleton(two[1]))
}

/// The name of one signal of each cylinder, from 1 on, as the configuration writes it: with `{n}`, or as a list.
pub(super) fn pattern(names: &[&str]) -> String {
    let [first, rest @ ..] = names else { return String::new() };
    if rest.iter().all(|name| name == first) {
        return (*first).to_owned();
    }
    let numbers: Vec<u32> = (1..).take(names.len()).collect();
    of_numbers(names, &numbers).unwrap_or_else(|| listed(names))
}

/// The patterns that the name of cylinder `n` may be of.
pub(super) fn with_place(name: &str, n: u32) -> Vec<String> {
    let places: Vec<_> = runs(name).into_iter().filter(|(_, number)| *number == n).collect();
    let mut patterns = Vec::new();
    for chosen in 1_u32..1 << places.len() {
        let mut pattern = name.to_owned();
        for (place, (run, _)) in places.iter().enumerate().rev() {
            if chosen >> place & 1 == 1 {
                pattern.replace_range(run.clone(), PLACE);
            }
        }
        patterns.push(pattern);
    }
    patterns
}

/// The names as a list in braces, without the whole words that they have in common at both ends.
fn listed(names: &[&str]) -> String {
    let first = names[0];
    let is_end = |c: char| matches!(c, '.' | '_');
    let same = |one: &str, other: &str| {
        one.bytes().zip(other.bytes()).take_while(|(one, other)| one == other).count()
    };
    let head = names.iter().map(|name| same(first, name)).min().unwrap_or(0);
    let head = first[..first.floor_char_boundary(head)].rfind(is_end).map_or(0, |at| at + 1);
    let rest = |name: &str| name[head..].chars().rev().collect::<String>();
    let backwards = rest(first);
    let tail = names.iter().map(|name| same(&backwards, &rest(name))).min().unwrap_or(0);
    let tail =
        backwards[..backwards.floor_char_boundary(tail)].rfind(is_end).map_or(0, |at| at + 1);
    let middle: Vec<&str> = names.iter().map(|name| &name[head..name.len() - tail]).collect();
    format!("{}{{{}}}{}", &first[..head], middle.join(","), &first[first.len() - tail..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_numbers_are_a_pattern_and_others_a_list() {
        assert_eq!(pattern(&["Cyl1_C1.Position", "Cyl2_C1.Position"]), "Cyl{n}_C1.Position");
        assert_eq!(pattern(&["F1.X1", "F2.X2"]), "F{n}.X{n}");
        assert_eq!(pattern(&["W.FL", "W.FR", "W.RL"]), "W.{FL,FR,RL}");
        assert_eq!(pattern(&["M03.S07", "M04.S11"]), "{M03.S07,M04.S11}");
        assert_eq!(pattern(&["Rig.C1"]), "Rig.C1");
        assert_eq!(numbers(&["Cyl2_C1.P", "Cyl1_C1.P"]), [vec![2, 1]]);
        assert_eq!(numbers(&["W.FL", "W.FR"]), Vec::<Vec<u32>>::new());
        assert_eq!(of_numbers(&["A3.X", "A4.X"], &[3, 4]).as_deref(), Some("A{n}.X"));
    }
}
