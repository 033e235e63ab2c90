//! What is said of cylinders without a calibration, whose C1 and C2 differ by an amount that is not known.

use super::Episodes;
use tertius_core::text::{Millimetres, ranges};
use tertius_core::verdict::Fault;

/// What to do about it.
pub const RUN: &str = "not calibrated: run `tertius commission`";

/// What a configuration without a calibration of these cylinders leaves open; `None` where all are calibrated.
pub fn doubt(unaligned: &[u8]) -> Option<String> {
    (!unaligned.is_empty()).then(|| {
        format!(
            "{RUN}. By how much C1 and C2 of {} differ when they are healthy is not known, so that a difference that \
             is there from the start is no incident; if it grows, or reaches comparator.critical, it is one",
            cylinders(unaligned)
        )
    })
}

/// What the warnings of a recording show of it; `None` where no difference was there from the start.
pub fn remark(episodes: &Episodes) -> Option<String> {
    let unaligned = || episodes.kept().iter().filter(|it| it.first_fault == Fault::NotCalibrated);
    let mut of: Vec<u8> = unaligned().map(|it| it.cylinder).collect();
    of.sort_unstable();
    of.dedup();
    let most = unaligned().filter_map(|it| it.finding.residual).map(f64::abs).reduce(f64::max)?;
    let (whose, most) = (cylinders(&of), Millimetres(most));
    Some(format!(
        "`[[cylinder]]`, {RUN}. C1 and C2 of {whose} differed from the start, by up to {most}. Without a calibration \
         this says nothing of a transducer and is no incident"
    ))
}

/// `cylinder 3`, `cylinders 1–6`.
fn cylinders(all: &[u8]) -> String {
    format!("cylinder{} {}", if all.len() == 1 { "" } else { "s" }, numbers(all))
}

/// Numbers in ascending order, three or more in a row as a range: `1–3, 5, 6`.
pub fn numbers(all: &[u8]) -> String {
    ranges(all, "–").join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_in_a_row_are_a_range() {
        for (all, told) in [
            (&[1, 2, 3, 4, 5, 6][..], "1–6"),
            (&[1, 2, 3, 5, 6], "1–3, 5, 6"),
            (&[1, 3, 5], "1, 3, 5"),
            (&[2, 4, 5, 6], "2, 4–6"),
        ] {
            assert_eq!(numbers(all), told);
        }
    }
}
