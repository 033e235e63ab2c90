//! Parts of a recording that are left out because no healthy machine reads so.

use crate::survey::{Row, Surveyor};

/// Time that is cut out on either side of what exceeds the level, s.
const BESIDE: f64 = 20.0;

/// Most places that a fault occurs in.
const MOST_PLACES: usize = 2;

/// Largest part of a recording that may be cut out.
const MOST_CUT: f64 = 0.1;

/// The places with evidence beyond a level, from and to, s, given the times of that evidence in
/// order.
pub(crate) fn places(times: impl Iterator<Item = f64>) -> Vec<[f64; 2]> {
    let mut places: Vec<[f64; 2]> = Vec::new();
    for t in times {
        let [from, to] = [t - BESIDE, t + BESIDE];
        match places.last_mut() {
            Some(last) if from <= last[1] => last[1] = to,
            _ => places.push([from, to]),
        }
    }
    places
}

/// Whether `places`, s, are few enough to be left out of a recording of `length`, s.
pub(crate) fn are_few(places: &[[f64; 2]], length: f64) -> bool {
    let cut: f64 = places.iter().map(|[from, to]| to - from).sum();
    places.len() <= MOST_PLACES && cut <= MOST_CUT * length
}

/// Times of each cylinder, s, that are used neither for learning nor for judging.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cuts {
    /// Spans of each cylinder: from, and up to, s.
    spans: Vec<Vec<[f64; 2]>>,
}

impl From<Vec<Vec<[f64; 2]>>> for Cuts {
    fn from(spans: Vec<Vec<[f64; 2]>>) -> Self {
        Self { spans }
    }
}

impl Cuts {
    pub fn none(cylinders: usize) -> Self {
        Self { spans: vec![Vec::new(); cylinders] }
    }

    pub fn add(&mut self, index: usize, span: [f64; 2]) {
        self.spans[index].push(span);
    }

    /// Union of these cuts and `other`.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        let count = self.spans.len().max(other.spans.len());
        let of = |cuts: &Self, index: usize| cuts.spans.get(index).cloned().unwrap_or_default();
        let spans = |index| [of(self, index), of(other, index)].concat();
        Self { spans: (0..count).map(spans).collect() }
    }

    /// These cuts in another time scale, to which `place` converts.
    #[must_use]
    pub fn moved(&self, place: impl Fn(f64) -> f64) -> Self {
        let moved = |spans: &Vec<[f64; 2]>| spans.iter().map(|span| span.map(&place)).collect();
        Self { spans: self.spans.iter().map(moved).collect() }
    }

    /// Whether any cylinder has a cut between `from` and `to`, s, both included.
    pub fn any(&self, from: f64, to: f64) -> bool {
        self.spans.iter().flatten().any(|[begin, end]| *begin <= to && from < *end)
    }

    /// Cuts of the cylinder of `index` (from 0), s.
    pub fn of(&self, index: usize) -> &[[f64; 2]] {
        &self.spans[index]
    }

    /// Cuts of the cylinder of `index` (from 0) in words; `None` where there are none.
    pub fn told(&self, index: usize) -> Option<String> {
        let place = |[from, to]: &[f64; 2]| format!("{:.0} to {to:.0} s", from.max(0.0));
        let places: Vec<String> = self.spans[index].iter().map(place).collect();
        (!places.is_empty()).then(|| {
            format!(
                "no healthy cylinder has such readings as those of {}, which were left out: look \
                 there for a fault",
                places.join(", ")
            )
        })
    }

    /// Whether the cylinder (from 1) is cut out at `t`, s.
    pub fn hold(&self, cylinder: u8, t: f64) -> bool {
        let spans = self.spans.get(usize::from(cylinder).wrapping_sub(1));
        spans.into_iter().flatten().any(|[from, to]| *from <= t && t < *to)
    }

    /// A surveyor that shows `surveyor` only what is not cut out.
    pub fn around<S: Surveyor>(&self, surveyor: S) -> impl Surveyor {
        Cutting { out: |cylinder, t| self.hold(cylinder, t), surveyor }
    }
}

/// Passes on all rows except those for which `out` holds, by cylinder (from 1) and time, s. The gap
/// is reported as for missing cycles.
#[derive(Debug)]
pub struct Cutting<F, S> {
    pub out: F,
    pub surveyor: S,
}

impl<F: Fn(u8, f64) -> bool, S: Surveyor> Surveyor for Cutting<F, S> {
    fn row(&mut self, row: &Row) {
        if (self.out)(row.cylinder, row.t) {
            self.surveyor.gap(row.cylinder);
        } else {
            self.surveyor.row(row);
        }
    }

    fn gap(&mut self, cylinder: u8) {
        self.surveyor.gap(cylinder);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cuts_are_of_one_cylinder() {
        let cuts = Cuts::from(vec![vec![], vec![[1.0, 2.0]]]);
        assert!(cuts.hold(2, 1.0) && !cuts.hold(2, 2.0));
        assert!(!cuts.hold(1, 1.5) && !cuts.hold(3, 1.5) && !cuts.hold(0, 1.5));
    }
}
