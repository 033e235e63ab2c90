//! From a healthy recording to a configuration that can be used, or the reasons why there is none.
//!
//! ```text
//! frames ─→ identify ─→ calibrate ─→ tune ─→ configuration ─┐
//!      └──→ the same without every third block ─→ trial ────┴─→ verdict
//! ```
//!
//! - `stages.rs`: the three rooms that learn, each with the tables of the one before ([`Taught`]), which also has the
//!   detectors that are left out, because no threshold of them would be of use.
//! - [`holding`]: what is held back from learning: the blocks of the trial, and places with a fault.
//! - `off.rs`: process detectors that are left out, because they warn in the trial.
//! - [`trial`]: the monitor on blocks that its tables do not know: what it reports of a healthy machine,
//!   and of [`faults`] that are put into them.
//! - [`coverage`]: what a longer recording would add, and where on the stroke.
//! - [`verdict`]: fit for use or not, in a sentence.
//!
//! The room writes nothing. It returns the text of a configuration, which the caller stores.

pub mod coverage;
pub mod faults;
pub mod holding;
mod off;
mod shortness;
mod stages;
mod task;
mod taught;
pub mod trial;
pub mod verdict;

pub use coverage::Coverage;
pub use task::Task;
pub use taught::{LeftOut, Refused, Stage, Taught, Threshold};
pub use trial::Trial;
pub use verdict::{Fitness, Verdict};

use holding::Blocks;
use stages::Lesson;
use tertius_learn::survey::Frames;

/// Result of a [`Task`].
#[derive(Clone, Debug)]
pub struct Commissioned {
    pub machine: String,
    pub inputs: String,
    /// Recorded time, s, without the pauses between recordings.
    pub recorded: f64,
    /// Tables learnt from the whole recording: these are written.
    pub taught: Taught,
    /// Trial of tables that were learnt without the blocks held back for it; `None` where there are
    /// no such tables.
    pub trial: Option<Trial>,
    pub coverage: Vec<Coverage>,
    pub verdict: Verdict,
}

/// The step that is about to begin, for progress messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// A stage learns from the whole recording.
    Learn(Stage),
    /// A stage learns from what is not held back.
    Rehearse(Stage),
    Try,
}

impl Task<'_> {
    /// Learns from `frames`, tries the tables on blocks that were held back, and judges the result;
    /// `tell` is called before each step.
    ///
    /// # Errors
    /// The frames can no longer be read. What could not be learnt from them is stated in
    /// the verdict.
    pub fn run<F: Frames>(
        &self,
        frames: &F,
        mut tell: impl FnMut(Step),
    ) -> Result<Commissioned, F::Error> {
        let lesson = |blocks| Lesson { task: self, frames, blocks };
        let mut taught = lesson(None).teach(self.cuts, |stage| tell(Step::Learn(stage)))?;
        let cuts = &taught.cuts().with(self.cuts);
        let mut rehearsed = None;
        if taught.is_whole() {
            let blocks = Blocks::of(self.origin.window, self.origin.timeline.ranking());
            let told = |stage| tell(Step::Rehearse(stage));
            let mut rehearsal = lesson(Some(blocks.clone())).teach(cuts, told)?;
            if rehearsal.is_whole()
                && let Err(why) = taught.agree_with(&mut rehearsal)
            {
                rehearsal.failed = Some((Stage::Tune, why));
            }
            rehearsed = Some((rehearsal, blocks));
        }
        let trial = match &rehearsed {
            Some((rehearsal, blocks)) if rehearsal.is_whole() => {
                tell(Step::Try);
                let refused = &taught.refused_cylinders()[..];
                trial::Course { task: self, rehearsal, blocks, refused, cuts }.run(frames)?
            }
            _ => None,
        };
        trial.iter().for_each(|trial| taught.without_process(trial));
        let coverage = coverage::of(&taught);
        let verdict = Verdict::of(&taught, rehearsed.map(|(it, _)| it).as_ref(), trial.as_ref());
        Ok(Commissioned {
            machine: taught.machine.clone(),
            inputs: self.origin.inputs.clone(),
            recorded: self.origin.timeline.recorded(self.origin.window),
            taught,
            trial,
            coverage,
            verdict,
        })
    }
}
