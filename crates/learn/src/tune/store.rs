//! Stretches of a recording in a bounded number of cycles.

use super::cycle::Cycle;
use super::drawn::Drawn;
use super::model::CylinderModel;
use super::pause::Pause;
use crate::survey::{Row, Surveyor};
use tertius_core::observe::observer::{Observer, ObserverDesign};

/// Length of a stretch, cycles: half a minute at 50 Hz, so that settling is a small part of it.
const LENGTH: usize = 1500;

/// Most cycles, all cylinders together.
const MOST: usize = 400_000;

/// Stretches of each cylinder, drawn from all of the recording; a stretch may lack a few cycles.
#[derive(Clone, Debug)]
pub struct Store {
    offsets: Vec<f64>,
    /// Most missing cycles that are predicted over, by cylinder.
    max_gaps: Vec<u32>,
    pauses: Vec<Pause>,
    open: Vec<Vec<Cycle>>,
    stretches: Vec<Drawn>,
}

impl Store {
    pub fn new(cylinders: &[CylinderModel]) -> Self {
        let count = cylinders.len().max(1);
        Self {
            offsets: cylinders.iter().map(|cylinder| cylinder.command_offset).collect(),
            max_gaps: cylinders.iter().map(|cylinder| cylinder.max_gap).collect(),
            pauses: vec![Pause::default(); count],
            open: vec![Vec::new(); count],
            stretches: vec![Drawn::new(MOST / LENGTH / count); count],
        }
    }

    /// Stretches of the cylinder of `index` (from 0). Within one, cycles follow each other.
    pub fn stretches(&self, index: usize) -> impl Iterator<Item = &[Cycle]> {
        self.stretches[index].stretches().iter().map(Vec::as_slice)
    }

    /// Number of stored cycles, all cylinders together.
    pub fn cycles(&self) -> usize {
        let stretches = self.stretches.iter().flat_map(Drawn::stretches);
        stretches.map(Vec::len).sum()
    }

    /// Ends every stretch, because nothing more comes.
    pub fn finish(&mut self) {
        (0..self.open.len()).for_each(|index| self.close(index));
    }

    fn close(&mut self, index: usize) {
        let stretch = std::mem::take(&mut self.open[index]);
        if !stretch.is_empty() {
            self.stretches[index].add(stretch);
        }
    }

    /// The residuals of one stretch by `design`, as they are judged.
    pub fn residuals<'a>(
        stretch: &'a [Cycle],
        design: &ObserverDesign,
        transducer: usize,
    ) -> impl Iterator<Item = Option<f64>> + 'a {
        let mut observer = Observer::new(design.clone());
        stretch.iter().map(move |cycle| cycle.step(&mut observer, transducer))
    }
}

impl Surveyor for Store {
    fn row(&mut self, row: &Row) {
        let index = usize::from(row.cylinder) - 1;
        let cycle = Cycle::new(row, self.offsets[index]);
        match self.pauses[index].before(row.cycle, self.max_gaps[index]) {
            Some(missing) => {
                let missing = std::iter::repeat_n(Cycle::NONE, missing as usize);
                self.open[index].extend(missing);
            }
            None => self.close(index),
        }
        self.open[index].push(cycle);
        if self.open[index].len() >= LENGTH {
            self.close(index);
        }
    }

    fn gap(&mut self, cylinder: u8) {
        self.pauses[usize::from(cylinder) - 1].tell();
    }
}
