//! What a longer recording would add, and where on the stroke.

use super::taught::Taught;
use tertius_core::sequential::Reference;
use tertius_core::sequential::reference::LARGEST_DOUBT;
use tertius_core::sequential::wild::Outliers;
use tertius_core::text::Millimetres;
use tertius_learn::calibrate::{CylinderCalibration, LEAST_BOUND};
use tertius_learn::extremes::{HOURS_PER_YEAR, four_digits, times};
use tertius_learn::tables::cylinders::cylinders;
use tertius_learn::tables::tuning::length;
use tertius_learn::tune::LEAST_HIGH;

/// Where on its stroke a cylinder has been.
#[derive(Clone, Debug, PartialEq)]
pub struct Coverage {
    /// Cylinder number, counted from 1.
    pub cylinder: u8,
    /// The part of the stroke that the sequential detector knows.
    pub seen: f64,
    /// Ends of the part of the stroke that is judged, from and to, m.
    pub stroke: [f64; 2],
    /// Parts of the stroke that the detector does not know, from and to, m: where the cylinder
    /// never was, or not for long enough.
    pub unseen: Vec<[f64; 2]>,
}

/// A required level is worth mentioning when it exceeds the minimum by this factor.
const WORTH: f64 = 1.05;

/// Coverage of every cylinder that has a profile.
pub fn of(taught: &Taught) -> Vec<Coverage> {
    let cylinders = taught.calibration.iter().flat_map(|it| &it.cylinders);
    let profiles = cylinders.filter_map(|it| Some((it.number, &it.sequential.as_ref()?.0)));
    profiles.map(|(number, profile)| Coverage::new(number, &profile.reference)).collect()
}

impl Coverage {
    fn new(cylinder: u8, reference: &Reference) -> Self {
        let begin = reference.first;
        let end = begin + reference.covered.len() as f64 * reference.spacing;
        let known = reference.spans(-1.0, LARGEST_DOUBT);
        let from = [begin].into_iter().chain(known.iter().map(|place| place[1]));
        let to = known.iter().map(|place| place[0]).chain([end]);
        let unseen = from.zip(to).map(|(from, to)| [from, to]);
        let unseen = unseen.filter(|[from, to]| to - from > 1e-9).collect();
        let seen: f64 = known.iter().map(|[from, to]| to - from).sum();
        Self { cylinder, seen: seen / (end - begin), stroke: [begin, end], unseen }
    }

    /// Parts of the stroke that the profile knows, from and to, m.
    pub fn known(&self) -> Vec<[f64; 2]> {
        let [begin, end] = self.stroke;
        let from = [begin].into_iter().chain(self.unseen.iter().map(|place| place[1]));
        let to = self.unseen.iter().map(|place| place[0]).chain([end]);
        from.zip(to).map(|(from, to)| [from, to]).filter(|[from, to]| to - from > 1e-9).collect()
    }

    fn places(&self) -> String {
        let place = |[from, to]: &[f64; 2]| format!("{from:.1} to {to:.1} m");
        self.unseen.iter().map(place).collect::<Vec<_>>().join(", ")
    }
}

/// What a longer recording would add, in sentences, one line for each point.
pub fn wins(taught: &Taught, coverage: &[Coverage]) -> Vec<String> {
    let mut wins = places(coverage);
    wins.extend(levels(taught));
    let bound = taught.calibration.as_ref().and_then(|it| it.bound);
    wins.extend(bound.filter(|bound| bound.level > WORTH * LEAST_BOUND).map(|bound| {
        format!(
            "R3's bound is {} instead of the thesis's {:.1} because it is extrapolated to {} times the evidence. With \
             more evidence it falls, at best to {}: 1.2 times the largest difference, and no less than the thesis's.",
            length(four_digits(bound.level)),
            Millimetres(LEAST_BOUND),
            times(HOURS_PER_YEAR / bound.per_year / bound.hours),
            length((1.2 * bound.worst).max(LEAST_BOUND))
        )
    }));
    let tuning = taught.tuning.as_ref();
    let thresholds = tuning.map(|it| it.thresholds);
    wins.extend(thresholds.filter(|it| it.high > WORTH * LEAST_HIGH).map(|it| {
        format!(
            "δ_h is {} instead of the thesis's {:.0} because it is extrapolated to {} times the evidence. With more \
             evidence it may fall.",
            length(four_digits(it.high)),
            Millimetres(LEAST_HIGH),
            times(HOURS_PER_YEAR / it.per_year / it.hours)
        )
    }));
    let rare = tuning.and_then(|it| Some((it.settle, it.thresholds.commands?)));
    wins.extend(rare.map(|(settle, commands)| {
        format!(
            "Commands of more than {:.3} m/s, or that change by more than {:.4} m/s from one cycle to the next, are too \
             rare in the recording to teach a threshold. For {settle} s (observer.settle) after such a command a residual \
             that R1 and R2 both show is not taken for a fault.",
            commands.size, commands.change
        )
    }));
    wins
}

/// Where no cylinder has been; cylinders that missed the same places share a line.
fn places(coverage: &[Coverage]) -> Vec<String> {
    let mut alike: Vec<(String, Vec<u8>)> = Vec::new();
    for one in coverage.iter().filter(|one| !one.unseen.is_empty()) {
        let (places, number) = (one.places(), one.cylinder);
        match alike.iter_mut().find(|(known, _)| *known == places) {
            Some((_, numbers)) => numbers.push(number),
            None => alike.push((places, vec![number])),
        }
    }
    let told = alike.into_iter().map(|(places, numbers)| {
        let which = cylinders(&numbers);
        let (were, detector) = match numbers.len() {
            1 => ("was", "its sequential detector says"),
            _ => ("were", "their sequential detectors say"),
        };
        format!(
            "The stroke from {places}: {which} {were} not there, or not long enough, and {detector} unknown there."
        )
    });
    told.collect()
}

/// Levels that the recording has raised.
fn levels(taught: &Taught) -> Option<String> {
    let cylinders = taught.calibration.iter().flat_map(|it| &it.cylinders);
    let leasts = cylinders.clone().filter_map(|it| Some(it.sequential.as_ref()?.1.outliers));
    let least = leasts.map(Outliers::least_level).reduce(f64::max)?;
    // Where transducers fluctuate the level is that of the wanted rate, and not the recording's.
    let by_tail = |it: &&CylinderCalibration| {
        it.sequential.as_ref().is_some_and(|(_, scatter)| scatter.excursions.is_none())
    };
    let cylinders = cylinders.filter(by_tail);
    let raised: Vec<String> = cylinders
        .filter_map(|it| Some((it.number, it.level.filter(|level| *level > WORTH * least)?)))
        .map(|(number, level)| format!("{level:.1} nats of cylinder {number}"))
        .collect();
    (!raised.is_empty()).then(|| {
        format!(
            "This recording requires levels above the least, {least:.1} nats ({}). A longer one shows whether they may be \
             lower.",
            raised.join(", ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_beside_each_other_are_one_place() {
        let reference = Reference {
            first: -0.2,
            spacing: 0.1,
            nodes: vec![0.0; 6],
            doubts: vec![0.0; 6],
            covered: vec![false, false, true, true, false],
            velocity: 0.0,
        };
        let coverage = Coverage::new(2, &reference);
        assert_eq!(coverage.places(), "-0.2 to 0.0 m, 0.2 to 0.3 m");
        assert!(coverage.cylinder == 2 && (coverage.seen - 0.4).abs() < 1e-9, "{coverage:?}");
        let [known] = coverage.known()[..] else { panic!("{:?}", coverage.known()) };
        assert!(known[0].abs() < 1e-9 && (known[1] - 0.2).abs() < 1e-9);
        let like = Coverage { cylinder: 5, ..coverage.clone() };
        let told = places(&[coverage, like]);
        assert_eq!(told.len(), 1);
        assert!(
            told[0].contains("-0.2 to 0.0 m, 0.2 to 0.3 m: cylinders 2 and 5 were not there"),
            "{told:?}"
        );
    }
}
