//! Extremes of the tuned observers' residuals in the whole recording.

use super::cycle::Cycle;
use super::model::CylinderModel;
use super::pause::Pause;
use crate::extremes::{Maxima, Sketch, Tail};
use crate::identify::moments::Spread;
use crate::survey::{Lull, Row, Surveyor};
use tertius_core::observe::commands::{CommandWatch, LearntCommands};
use tertius_core::observe::observer::{Observer, ObserverDesign, Restart};

/// The residuals of one observer.
#[derive(Clone, Debug)]
struct Witness {
    /// The observer before it has seen anything.
    fresh: Observer,
    observer: Observer,
    residuals: Spread,
    magnitudes: Sketch,
    maxima: Maxima,
    /// Residual of the newest row, m, where it is judged.
    newest: Option<f64>,
}

/// Results of one transducer's observer.
#[derive(Clone, Debug)]
pub struct Detector {
    /// Cylinder number, counted from 1.
    pub cylinder: u8,
    /// Transducer: 0 is C1, 1 is C2.
    pub transducer: usize,
    pub residuals: Spread,
    pub magnitudes: Sketch,
    /// Largest magnitudes of the blocks, in descending order: a thousand, or all.
    pub peaks: Vec<f64>,
    /// Residual after a unit step of the reading, cycle by cycle.
    pub response: Vec<f64>,
    /// Level that the residual does not exceed in about nineteen of twenty seconds, m.
    pub calm: f64,
    /// Tail of the residual; `None` where too little was judged.
    pub tail: Option<Tail>,
    /// Smallest step that is found in time in nineteen of twenty places, m.
    pub step: Option<f64>,
    /// Smallest amplitude of (5-17) that is found in time in nineteen of twenty trials, m.
    pub noise: Option<f64>,
}

/// The pass over the whole recording.
#[derive(Clone, Debug)]
pub struct Evidence {
    cylinders: Vec<(CylinderModel, [Option<Witness>; 2])>,
    pauses: Vec<Pause>,
    lulls: Vec<Lull>,
    commands: Vec<CommandWatch>,
}

impl Evidence {
    /// A pass with observers by `designs`; `block` is the number of cycles that count as one
    /// warning. What follows a command beyond `learnt` is left out.
    pub fn new(
        cylinders: &[CylinderModel],
        designs: &[[ObserverDesign; 2]],
        block: u32,
        learnt: Option<LearntCommands>,
    ) -> Self {
        let learnt = learnt.unwrap_or(LearntCommands::ANY);
        let commands = designs.iter().map(|[c1, _]| CommandWatch::new(learnt, c1.settle)).collect();
        let witnesses = |(cylinder, designs): (&CylinderModel, &[ObserverDesign; 2])| {
            let witness = |i: usize| {
                let fresh = Observer::new(designs[i].clone());
                cylinder.transducers[i].then(|| Witness {
                    observer: fresh.clone(),
                    fresh,
                    residuals: Spread::default(),
                    magnitudes: Sketch::new(),
                    maxima: Maxima::new(block),
                    newest: None,
                })
            };
            (*cylinder, [witness(0), witness(1)])
        };
        let pauses = vec![Pause::default(); cylinders.len()];
        let lulls = vec![Lull::default(); cylinders.len()];
        let cylinders = cylinders.iter().zip(designs).map(witnesses).collect();
        Self { cylinders, pauses, lulls, commands }
    }

    /// Residuals R1 and R2 of the newest row of this cylinder, m, where they are judged.
    pub fn newest(&self, cylinder: u8) -> [Option<f64>; 2] {
        let (_, witnesses) = &self.cylinders[usize::from(cylinder) - 1];
        witnesses.each_ref().map(|witness| witness.as_ref()?.newest)
    }

    /// Results of every observer; with a tail where there are enough data.
    pub fn detectors(&self, sample_time: f64) -> Vec<Detector> {
        let mut detectors = Vec::new();
        for (cylinder, witnesses) in &self.cylinders {
            for (transducer, witness) in witnesses.iter().enumerate() {
                let Some(witness) = witness else { continue };
                detectors.push(Detector {
                    cylinder: cylinder.number,
                    transducer,
                    residuals: witness.residuals,
                    magnitudes: witness.magnitudes.clone(),
                    peaks: witness.maxima.largest(),
                    response: Vec::new(),
                    calm: witness.maxima.quantile(0.95).unwrap_or(0.0),
                    tail: Tail::fit(&witness.maxima, sample_time),
                    step: None,
                    noise: None,
                });
            }
        }
        detectors
    }
}

impl Surveyor for Evidence {
    fn row(&mut self, row: &Row) {
        let index = usize::from(row.cylinder) - 1;
        let (cylinder, witnesses) = &mut self.cylinders[index];
        let cycle = Cycle::new(row, cylinder.command_offset);
        let missing = self.pauses[index].before(row.cycle, cylinder.max_gap);
        let begins_anew = self.lulls[index].ends(row.t);
        let commands = &mut self.commands[index];
        if begins_anew || missing.is_none() {
            commands.reset();
        }
        let is_taught = !commands.is_beyond();
        commands.take(cycle.command);
        for (transducer, witness) in witnesses.iter_mut().enumerate() {
            let Some(witness) = witness else { continue };
            if begins_anew {
                witness.observer.clone_from(&witness.fresh);
                witness.maxima.pause();
            }
            match missing {
                Some(missing) => (0..missing).for_each(|_| {
                    _ = Cycle::NONE.step(&mut witness.observer, transducer);
                }),
                None => witness.observer.stop(Restart::Gap),
            }
            let residual = cycle.step(&mut witness.observer, transducer);
            witness.newest = residual.filter(|_| is_taught);
            if let Some(residual) = witness.newest {
                witness.residuals.add(residual);
                witness.magnitudes.add(residual);
                witness.maxima.add(residual);
            }
        }
    }

    fn gap(&mut self, cylinder: u8) {
        self.pauses[usize::from(cylinder) - 1].tell();
    }
}
