//! What is left out of a recording, since no healthy machine reads so.

use crate::survey::{Row, Surveyor};

/// Times, s, of each cylinder that neither teach nor judge.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cuts {
    /// By cylinder: from, and up to.
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

    /// What was cut out of the cylinder of `index` (from 0), s.
    pub fn of(&self, index: usize) -> &[[f64; 2]] {
        &self.spans[index]
    }

    /// The same, for a person; `None` where nothing was.
    pub fn told(&self, index: usize) -> Option<String> {
        let place = |[from, to]: &[f64; 2]| format!("{:.0} to {to:.0} s", from.max(0.0));
        let places: Vec<String> = self.spans[index].iter().map(place).collect();
        (!places.is_empty()).then(|| {
            format!(
                "no healthy cylinder reads what it did in {}, which was left out: look there for a \
                 fault",
                places.join(", ")
            )
        })
    }

    /// What the cylinder (from 1) reads at `t`, s, neither teaches nor is judged.
    pub fn hold(&self, cylinder: u8, t: f64) -> bool {
        let spans = self.spans.get(usize::from(cylinder).wrapping_sub(1));
        spans.into_iter().flatten().any(|[from, to]| *from <= t && t < *to)
    }
}

/// Shows all rows to a surveyor but those that are cut out.
#[derive(Debug)]
pub struct Cutting<'a, S> {
    pub cuts: &'a Cuts,
    pub surveyor: S,
}

impl<S: Surveyor> Surveyor for Cutting<'_, S> {
    fn row(&mut self, row: &Row) {
        if self.cuts.hold(row.cylinder, row.t) {
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
