//! Numbers of cylinders in words.

use tertius_core::text::{listed, ranges};

/// Cylinders of these numbers, in ascending order, three or more in a row as a range: `cylinder 3`,
/// `cylinders 1 to 3 and 5`.
pub fn cylinders(numbers: &[u8]) -> String {
    match numbers {
        [] => "no cylinder".to_owned(),
        [one] => format!("cylinder {one}"),
        several => format!("cylinders {}", listed(&ranges(several, " to "))),
    }
}

/// Remarks on cylinders, a line for each with all the cylinders that it is of.
pub fn by_cylinders<'a>(remarks: impl IntoIterator<Item = (u8, &'a str)>) -> Vec<String> {
    let mut told: Vec<(&str, Vec<u8>)> = Vec::new();
    for (number, remark) in remarks {
        match told.iter_mut().find(|(known, _)| *known == remark) {
            Some((_, numbers)) => numbers.push(number),
            None => told.push((remark, vec![number])),
        }
    }
    told.into_iter().map(|(remark, of)| format!("{}: {remark}", cylinders(&of))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_in_a_row_are_a_range() {
        for (numbers, told) in [
            (&[3][..], "cylinder 3"),
            (&[1, 2], "cylinders 1 and 2"),
            (&[1, 2, 3, 4, 5, 6], "cylinders 1 to 6"),
            (&[1, 2, 3, 5, 6], "cylinders 1 to 3, 5 and 6"),
        ] {
            assert_eq!(cylinders(numbers), told);
        }
    }

    #[test]
    fn a_remark_on_several_cylinders_is_told_once() {
        let remarks = [(1, "it is warm"), (1, "it leaks"), (2, "it is warm")];
        let told = by_cylinders(remarks);
        assert_eq!(told, ["cylinders 1 and 2: it is warm", "cylinder 1: it leaks"]);
    }
}
