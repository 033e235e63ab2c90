//! Whether a calibration can be used.

use super::{
    Bound, Calibrated, Calibration, CalibrationCourse, Cuts, CylinderCalibration, LARGEST_BOUND,
    LEAST_BOUND,
};
use crate::extremes::false_alarms;
use crate::survey::{Origin, Recording};
use tertius_core::text::Millimetres;

impl Calibration {
    /// The calibration of the `recording` by `course`, with its `origin`.
    ///
    /// # Errors
    /// The recording's own.
    pub fn of<R: Recording>(
        course: &CalibrationCourse,
        recording: &R,
        origin: &Origin,
    ) -> Result<Self, R::Error> {
        let settings = course.settings;
        let Calibrated { cylinders, bound, supply } = course.run(recording)?;
        let own = cylinders.iter().any(|cylinder| cylinder.level.is_some());
        let configured = settings.sequential.level.filter(|_| own).map(|level| {
            format!(
                "sequential.level of the configuration, {level} nats, takes precedence over the \
                 level of each cylinder; remove it"
            )
        });
        let refused = supply.as_ref().and_then(|it| it.as_ref().err());
        let unsupplied = refused.map(|why| format!("no process detector by the supply: {why}"));
        Ok(Self {
            machine: settings.machine.name.clone(),
            inputs: origin.inputs.clone(),
            timeline: origin.timeline.clone(),
            fitted: course.fitted,
            tried: course.tried,
            cylinders,
            bound: bound.map(|bound| Bound { level: bound.level.max(LEAST_BOUND), ..bound }),
            remarks: origin.remarks.iter().cloned().chain(configured).chain(unsupplied).collect(),
            supply,
        })
    }

    /// Refuses a bound that would not warn before the machine itself trips, at `critical` m.
    ///
    /// # Errors
    /// The reason, in words; nothing may be written then.
    pub fn usable(&self, critical: f64) -> Result<(), String> {
        let most = LARGEST_BOUND * critical;
        let Some(bound) = self.bound.filter(|bound| bound.level > most) else { return Ok(()) };
        Err(format!(
            "for {} R3 would need a bound of {:.2}, and above {:.2}, a \
             tenth of comparator.critical, it hardly warns before the machine trips. The largest |C1 - \
             C2| beyond the line is {:.2}; with the thesis's {:.2}, this recording suggests \
             about {:.0} a year (--false-alarms-per-year). Was the machine healthy? Look at C1 - \
             C2 over time \
             (`replay --residuals`)",
            false_alarms(bound.per_year),
            Millimetres(bound.level),
            Millimetres(most),
            Millimetres(bound.worst),
            Millimetres(LEAST_BOUND),
            bound.often.ceil(),
        ))
    }

    /// Parts that were left out because no healthy cylinder reads so.
    pub fn cuts(&self) -> Cuts {
        let spans: Vec<_> =
            self.cylinders.iter().map(|cylinder| cylinder.left_out.clone()).collect();
        spans.into()
    }

    /// Whether any cylinder has a C2.
    pub fn has_c2(&self) -> bool {
        self.cylinders.iter().any(CylinderCalibration::has_c2)
    }

    /// Cylinders without a calibration although they have a C2, or without one for their sequential detector, and the
    /// reasons.
    pub fn refusals(&self) -> Vec<(u8, String)> {
        let with_c2 = self.cylinders.iter().filter(|cylinder| cylinder.has_c2());
        let refused = with_c2.filter_map(|cylinder| {
            let refusal = cylinder.result.as_ref().err().map(ToString::to_string);
            let told = refusal.or_else(|| cylinder.contradiction.map(|it| it.to_string()))?;
            Some((cylinder.number, told))
        });
        refused.collect()
    }
}
