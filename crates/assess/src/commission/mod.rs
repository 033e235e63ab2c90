//! From a healthy recording to a configuration that can be used, or the reasons why there is none.
//!
//! ```text
//! frames ─→ identify ─→ calibrate ─→ tune ─→ configuration ─┐
//!      └──→ the same without every third block ─→ trial ────┴─→ verdict
//! ```
//!
//! - [`stages`]: the three rooms that learn, each with the tables of the one before ([`Taught`]).
//! - [`holding`]: what is left out of a recording: the blocks of the trial, and places with a fault.
//! - [`trial`]: the monitor on the blocks that its tables do not know: what it says of a healthy machine,
//!   and of [`faults`] that are put into them.
//! - [`coverage`]: what a longer recording would win, and where on the stroke.
//! - [`verdict`]: fit for use or not, in a sentence.
//!
//! The room writes nothing: it gives the text of a configuration, which the caller puts where it belongs.

pub mod coverage;
pub mod faults;
pub mod holding;
pub mod stages;
pub mod trial;
pub mod verdict;

pub use coverage::Coverage;
pub use stages::{Refused, Stage, Taught};
pub use trial::Trial;
pub use verdict::{Fitness, Verdict};

use holding::Blocks;
use stages::Lesson;
use tertius_dbc::Database;
use tertius_learn::calibrate::Cuts;
use tertius_learn::survey::{Frames, Origin};

/// A machine that is to be commissioned.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// What problems call the configuration.
    pub name: &'a str,
    /// The configuration as it is.
    pub text: &'a str,
    pub database: &'a Database,
    pub origin: &'a Origin,
    /// What is known to be no healthy machine, s of each cylinder: nothing is learnt from it.
    pub cuts: &'a Cuts,
    /// False alarms that a year may bring: of R1 and R2, of R3, and of the sequential detectors.
    pub per_year: f64,
    /// The program's, for the tables.
    pub version: &'a str,
}

/// What came of a [`Task`].
#[derive(Clone, Debug)]
pub struct Commissioned {
    pub machine: String,
    pub inputs: String,
    /// Of the recording, s.
    pub length: f64,
    /// Taught by all of the recording: what is written.
    pub taught: Taught,
    /// What the tables are worth that were taught without the blocks it is made on; `None` where there
    /// are none.
    pub trial: Option<Trial>,
    pub coverage: Vec<Coverage>,
    pub verdict: Verdict,
}

/// What is done now, for who waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Taught by all of the recording.
    Learn(Stage),
    /// Taught by what is not held back.
    Rehearse(Stage),
    Try,
}

impl Task<'_> {
    /// Learns from `frames`, tries what can be learnt without a part of them, and judges; `tell` hears of
    /// each step before it is done.
    ///
    /// # Errors
    /// The frames cannot be read any more. What they do not teach is in the verdict.
    pub fn run<F: Frames>(
        &self,
        frames: &F,
        mut tell: impl FnMut(Step),
    ) -> Result<Commissioned, F::Error> {
        let lesson = |blocks| Lesson { task: self, frames, blocks };
        let taught = lesson(None).teach(self.cuts, |stage| tell(Step::Learn(stage)))?;
        let cuts = &taught.cuts().with(self.cuts);
        let mut rehearsed = None;
        if taught.is_whole() {
            let blocks = Blocks::of(self.origin.window);
            let told = |stage| tell(Step::Rehearse(stage));
            rehearsed = Some((lesson(Some(blocks)).teach(cuts, told)?, blocks));
        }
        let trial = match &rehearsed {
            Some((rehearsal, blocks)) if rehearsal.is_whole() => {
                tell(Step::Try);
                let (refused, blocks) = (&taught.refused_cylinders()[..], *blocks);
                trial::Course { task: self, rehearsal, blocks, refused, cuts }.run(frames)?
            }
            _ => None,
        };
        let coverage = coverage::of(&taught);
        let verdict = Verdict::of(&taught, rehearsed.map(|(it, _)| it).as_ref(), trial.as_ref());
        Ok(Commissioned {
            machine: taught.machine.clone(),
            inputs: self.origin.inputs.clone(),
            length: self.origin.window.length(),
            taught,
            trial,
            coverage,
            verdict,
        })
    }
}
