//! All studies, and what they are together: the plan, the campaign that carries it out, and the evaluation that results.

use super::extent::{Extent, PlanError, StudyName};
use super::stand::{Stand, StandError};
use super::study::{Study, TaughtStudy};
use super::workers::Workers;
use serde::Serialize;
use tertius_config::settings::Settings;
use tertius_machine::simulator::Options;

/// Registers the studies: by the key that the result of each has in JSON, in that order.
macro_rules! studies {
    ($($key:ident: $study:ty,)*) => {
        /// Everything that is to be tried.
        #[derive(Clone, Debug, PartialEq)]
        pub struct Plan {
            pub seed: u64,
            pub extent: Extent,
            $(pub $key: Option<$study>,)*
        }

        /// A plan whose studies have been taught.
        pub struct Campaign<'a> {
            machine: &'a str,
            seed: u64,
            $($key: Option<TaughtStudy<'a, $study>>,)*
        }

        /// The whole result.
        #[derive(Clone, Debug, PartialEq, Serialize)]
        pub struct Evaluation {
            /// Name of the machine, which stands before what it was judged by in a report.
            #[serde(skip)]
            pub machine: String,
            pub seed: u64,
            $(
                #[serde(skip_serializing_if = "Option::is_none")]
                pub $key: Option<<$study as Study>::Figures>,
            )*
        }

        /// The names of all studies, each with whether it fits a machine.
        pub fn study_names() -> Vec<(StudyName, fn(&Settings) -> bool)> {
            let mut names: Vec<(StudyName, fn(&Settings) -> bool)> = Vec::new();
            $(names.extend(<$study>::NAMES.iter().map(|name| (*name, <$study>::fits as fn(&_) -> _)));)*
            names
        }

        impl Plan {
            /// The plan of all studies that `extent` asks for.
            ///
            /// # Errors
            /// The extent exceeds a limit.
            pub fn new(seed: u64, extent: Extent) -> Result<Self, PlanError> {
                let known: Vec<StudyName> = study_names().into_iter().map(|(it, _)| it).collect();
                extent.check(&known)?;
                Ok(Self { seed, $($key: <$study>::planned(seed, &extent),)* extent })
            }

            /// Refuses, before anything is simulated, a plan that cannot be carried out.
            ///
            /// # Errors
            /// If the configuration's machine cannot be simulated, or not in a sea of the plan; or see [`Study::check`].
            pub fn check(&self, stand: &Stand) -> Result<(), StandError> {
                for cell in self.extent.cells() {
                    let options = Options { sea: Some(cell.sea), ..Options::default() };
                    stand.simulator(cell, &options)?;
                }
                $(self.$key.as_ref().map_or(Ok(()), |study| study.check(stand))?;)*
                Ok(())
            }

            /// Has `workers` teach all studies.
            ///
            /// # Errors
            /// See [`Study::teach`].
            pub fn teach<'a>(
                &'a self,
                stand: &'a Stand<'a>,
                workers: &impl Workers,
            ) -> Result<Campaign<'a>, StandError> {
                $(
                    let $key = self.$key.as_ref().map(|study| TaughtStudy::new(study, stand, workers));
                    let $key = $key.transpose()?;
                )*
                Ok(Campaign {
                    machine: &stand.settings.machine.name,
                    seed: self.seed,
                    $($key,)*
                })
            }
        }

        impl Campaign<'_> {
            /// Number of trials.
            pub fn jobs(&self) -> usize {
                [$(self.$key.as_ref().map_or(0, TaughtStudy::jobs)),*].into_iter().sum()
            }

            /// Has `workers` do all trials: the result.
            ///
            /// # Errors
            /// See [`Study::run`].
            pub fn evaluate(&self, workers: &impl Workers) -> Result<Evaluation, StandError> {
                Ok(Evaluation {
                    machine: self.machine.to_owned(),
                    seed: self.seed,
                    $($key: self.$key.as_ref().map(|it| it.figures(workers)).transpose()?,)*
                })
            }
        }
    };
}

studies! {
    rows: super::rows::RowStudy,
    healthy: super::healthy::HealthyStudy,
    contest: super::contest::Contest,
    estimates: super::estimate::EstimateStudy,
    weights: super::weights::Weighing,
    process: super::process::ProcessStudy,
    handover: super::handover::HandoverStudy,
    side: super::side::SideStudy,
    hexapod: super::hexapod::HexapodStudy,
    last: super::last::LastStudy,
    accommodate: super::accommodate::AccommodateStudy,
}
