//! A study: its trials on simulated machines, and how the results become figures.

use super::extent::{Extent, StudyName};
use super::stand::{Stand, StandError};
use super::workers::Workers;
use serde::Serialize;
use std::fmt::Debug;
use tertius_config::settings::Settings;

/// A study: its trials do not depend on each other, and everything random in one follows from the plan's seed and its job.
///
/// A product carries its own place among the others, so that it is gathered without its job: a product that does not match
/// its job, or belongs to another study, does not compile.
pub trait Study: Sized + Sync {
    /// The names by which it, or a part of it, is asked for.
    const NAMES: &'static [StudyName];
    /// One trial: a machine, and what happens to it.
    type Job: Copy + Send + Sync;
    /// What is learnt in one lesson before the first trial, for example a monitor.
    type Taught: Send + Sync;
    /// What became of a trial, and which one it was.
    type Product: Send;
    /// Products so far.
    type Gathered: Default;
    /// The result.
    type Figures: Clone + Debug + PartialEq + Serialize;

    /// The study, if `extent` asks for it.
    fn planned(seed: u64, extent: &Extent) -> Option<Self>;

    /// Whether it can be tried on the machine of `settings`; one that cannot is left out unless it is asked for by name.
    fn fits(_: &Settings) -> bool {
        true
    }

    /// Refuses, before anything is simulated, a study that cannot be carried out.
    ///
    /// # Errors
    /// It cannot be carried out on this machine.
    fn check(&self, _: &Stand) -> Result<(), StandError> {
        Ok(())
    }

    /// Number of lessons before the first trial.
    fn lessons(&self) -> usize {
        0
    }

    /// Does the lesson of this index.
    ///
    /// # Errors
    /// There is no such machine, or it teaches nothing.
    fn teach(&self, stand: &Stand, lesson: usize) -> Result<Self::Taught, StandError>;

    /// All trials, the longest first.
    fn jobs(&self) -> Vec<Self::Job>;

    /// Does one trial by what all lessons have `taught`, in their order.
    ///
    /// # Errors
    /// There is no such machine, or no place for such a fault on it.
    fn run(
        &self,
        stand: &Stand,
        taught: &[Self::Taught],
        job: Self::Job,
    ) -> Result<Self::Product, StandError>;

    /// Adds a product, in any order.
    fn gather(&self, stand: &Stand, gathered: &mut Self::Gathered, product: Self::Product);

    /// The figures of all products.
    fn figures(
        &self,
        stand: &Stand,
        taught: &[Self::Taught],
        gathered: Self::Gathered,
    ) -> Self::Figures;
}

/// A study at work: what it has been taught, and its trials.
pub struct TaughtStudy<'a, S: Study> {
    study: &'a S,
    stand: &'a Stand<'a>,
    taught: Vec<S::Taught>,
    jobs: Vec<S::Job>,
}

impl<'a, S: Study> TaughtStudy<'a, S> {
    /// Has `workers` teach `study` on `stand`.
    ///
    /// # Errors
    /// See [`Study::teach`].
    pub fn new(
        study: &'a S,
        stand: &'a Stand<'a>,
        workers: &impl Workers,
    ) -> Result<Self, StandError> {
        let mut taught = Vec::new();
        // A failure is a result here, so that the first lesson's is reported whichever comes first.
        let learn = |lesson| Ok(study.teach(stand, lesson));
        workers.each(study.lessons(), learn, |lesson, it| taught.push((lesson, it)))?;
        check_all(taught.len(), study.lessons())?;
        taught.sort_unstable_by_key(|(lesson, _)| *lesson);
        let taught: Result<_, StandError> = taught.into_iter().map(|(_, it)| it).collect();
        Ok(Self { study, stand, taught: taught?, jobs: study.jobs() })
    }

    /// Number of trials.
    pub const fn jobs(&self) -> usize {
        self.jobs.len()
    }

    /// Has `workers` do all trials, and gathers what they bring: the figures.
    ///
    /// # Errors
    /// See [`Study::run`].
    pub fn figures(&self, workers: &impl Workers) -> Result<S::Figures, StandError> {
        let Self { study, stand, taught, jobs } = self;
        let (mut done, mut gathered) = (0, S::Gathered::default());
        let run = |job: usize| study.run(stand, taught, jobs[job]);
        workers.each(jobs.len(), run, |_, product| {
            done += 1;
            study.gather(stand, &mut gathered, product);
        })?;
        check_all(done, jobs.len())?;
        Ok(study.figures(stand, taught, gathered))
    }
}

/// Figures of some of the trials must not pass for those of all.
const fn check_all(done: usize, of: usize) -> Result<(), StandError> {
    if done == of { Ok(()) } else { Err(StandError::Unfinished { done, of }) }
}
