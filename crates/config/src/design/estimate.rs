//! From settings to a virtual sensor.

use super::connector::Connector;
use crate::settings::Settings;
use tertius_core::compare::Comparator;
use tertius_core::estimate::{
    AccommodationDesign, Drive, Dynamics, EstimateParameters, LengthScale, SensorDesign,
};
use tertius_core::observe::model::Model;
use tertius_core::sequential;

/// When a step is subtracted that has stood still for `after`, s.
pub fn accommodation(settings: &Settings, after: f64) -> AccommodationDesign {
    AccommodationDesign {
        settle: settings.cycles(settings.observer.settle),
        after: settings.cycles(after).max(2),
        most: settings.cycles(settings.estimate.accommodate_for),
    }
}

impl Connector<'_> {
    /// The virtual sensor of cylinder `n`, with what its `sequential` detector was calibrated to, if it
    /// was; valid `lengths`, m.
    pub(super) fn estimate(
        &self,
        n: u8,
        sequential: Option<&sequential::Design>,
        lengths: (f64, f64),
    ) -> SensorDesign {
        let settings = self.settings;
        let sample_time = settings.machine.sample_time;
        let parameters = &EstimateParameters::DEFAULT;
        let (gain, offset) = settings.comparator_of(n);
        let fitted = settings.sequential_of(n).filter(|_| sequential.is_some());
        let dynamics = match fitted.and_then(|fitted| Some((fitted, fitted.drive?))) {
            Some((fitted, drive)) => {
                Dynamics::fitted(Drive(drive), sample_time, fitted.deviation, parameters)
            }
            None => {
                let (theta, gamma) = settings.model_of(n);
                let model = Model::new(sample_time, theta, gamma);
                let (q, r) = (settings.observer.q, settings.observer.r[0]);
                let offset = settings.command_offset_of(n);
                Dynamics::model(&model, offset, q, r, sample_time, parameters)
            }
        };
        SensorDesign {
            dynamics,
            scale: LengthScale {
                comparator: Comparator { gain, offset },
                reference: sequential.map(|design| design.reference.clone()),
            },
            sample_time,
            settle: settings.cycles(settings.observer.settle),
            max_gap: settings.cycles(settings.machine.max_gap),
            difference: settings.comparator.bound,
            bound: settings.estimate.bound,
            lengths,
            accommodation: settings
                .estimate
                .accommodate_after
                .map(|after| accommodation(settings, after)),
            parameters,
        }
    }
}
