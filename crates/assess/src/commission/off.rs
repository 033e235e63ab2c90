//! Detectors that are left out of a configuration, because the threshold that the recording asks for would be too large to
//! find a fault. That says nothing against the others.

use super::stages::{Stage, Taught};
use super::trial::{FalseAlarm, Trial};
use std::fmt;
use tertius_config::edit;
use tertius_core::alarm::Detector;
use tertius_core::verdict::Fault;
use tertius_learn::calibrate::{Calibration, CylinderCalibration};

/// Detectors that judge by the same threshold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Threshold {
    /// δ_h of R1 and R2.
    OfObservers,
    /// The bound of R3.
    OfDifference,
}

/// Detectors that were left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    pub threshold: Threshold,
    pub by: Stage,
    pub why: String,
}

impl Threshold {
    pub const ALL: [Self; 2] = [Self::OfObservers, Self::OfDifference];

    /// The detectors that judge by it.
    pub const fn detectors(self) -> &'static str {
        match self {
            Self::OfObservers => "FDE1 and FDE2",
            Self::OfDifference => "FDE3",
        }
    }

    /// That of `detector`, if it has one of these.
    pub const fn of(detector: Detector) -> Option<Self> {
        match detector {
            Detector::Fde1 | Detector::Fde2 => Some(Self::OfObservers),
            Detector::Fde3 => Some(Self::OfDifference),
            _ => None,
        }
    }

    /// The detectors of all `thresholds`, in words.
    pub fn listed(thresholds: &[Self]) -> String {
        match thresholds {
            [Self::OfObservers, Self::OfDifference] => "FDE1, FDE2 and FDE3".to_owned(),
            one => one.iter().map(|it| it.detectors()).collect(),
        }
    }

    /// Tables that switch its detectors off.
    const fn off(self) -> &'static str {
        match self {
            Self::OfObservers => "[fde]\nenabled = false\n",
            Self::OfDifference => "[comparator]\nenabled = false\n",
        }
    }
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { threshold, by, why } = self;
        write!(f, "{} left out ({by}): {why}", threshold.detectors())
    }
}

impl Taught {
    pub fn is_left_out(&self, threshold: Threshold) -> bool {
        self.left_out.iter().any(|it| it.threshold == threshold)
    }

    /// Switches the detectors of `threshold` off in the configuration, where they are not yet.
    ///
    /// # Errors
    /// Then a cylinder has no detector left by which its transducers are healthy: `why`. Or the configuration cannot be edited.
    pub(super) fn leave_out(
        &mut self,
        threshold: Threshold,
        by: Stage,
        why: String,
    ) -> Result<(), String> {
        if self.is_left_out(threshold) {
            return Ok(());
        }
        let refused = self.refused_cylinders();
        let cylinders = self.calibration.iter().flat_map(|it| &it.cylinders);
        let mut used = cylinders.filter(|it| !refused.contains(&it.number));
        let observes =
            threshold == Threshold::OfDifference && !self.is_left_out(Threshold::OfObservers);
        // By R3 alone no transducer is healthy.
        if !observes && used.any(|it| it.sequential.is_none()) {
            return Err(why);
        }
        self.left_out.push(LeftOut { threshold, by, why });
        self.keep_left_out()
    }

    /// Switches the detectors that are left out off again: a later stage may have learnt their threshold.
    ///
    /// # Errors
    /// The configuration cannot be edited.
    pub(super) fn keep_left_out(&mut self) -> Result<(), String> {
        for it in &self.left_out {
            let text = edit::put(&self.text, it.threshold.off(), &[]);
            self.text =
                text.map_err(|error| format!("the configuration cannot be edited: {error}"))?;
        }
        Ok(())
    }

    /// Leaves out the process detectors that warn in the trial, which may be wrong with a valve that is not like itself
    /// for long; the transducers are watched all the same.
    pub(super) fn without_process(&mut self, trial: &Trial) {
        let Some(calibration) = &mut self.calibration else { return };
        let mut alarms = trial.of_process.clone();
        if let Some(t) = trial.of_supply {
            leave_out_supply(&mut self.text, calibration, t);
            alarms.retain(|alarm| alarm.fault != Fault::Supply);
        }
        leave_out_process(&mut self.text, &mut calibration.cylinders, &alarms);
    }

    /// Leaves out what the `rehearsal` leaves out, since the trial does not try it, and the other way round.
    ///
    /// # Errors
    /// Then nothing is left that compares readings, and why.
    pub(super) fn agree_with(&mut self, rehearsal: &mut Self) -> Result<(), String> {
        for LeftOut { threshold, by, why } in rehearsal.left_out.clone() {
            self.leave_out(threshold, by, format!("without the third that is held back, {why}"))?;
        }
        for LeftOut { threshold, by, why } in self.left_out.clone() {
            rehearsal.leave_out(threshold, by, why)?;
        }
        Ok(())
    }
}

/// Takes the process detectors that raised these `alarms` out of the configuration's `text`, and says so in the
/// remarks of their cylinders.
fn leave_out_process(
    text: &mut String,
    cylinders: &mut [CylinderCalibration],
    alarms: &[FalseAlarm],
) {
    for FalseAlarm { t, cylinder, .. } in alarms {
        let of_n = |it: &&mut CylinderCalibration| it.number == *cylinder && it.process.is_some();
        let taught = cylinders.iter_mut().find(of_n);
        let (Some(taught), Ok(without)) = (taught, edit::without(text, *cylinder, "process"))
        else {
            continue;
        };
        *text = without;
        taught.process = None;
        taught.remarks.push(format!(
            "no process detector: the one of the trial, which does not know that block, warns {t:.1} s after the \
             first frame; is there a fault in the recording?"
        ));
    }
}

/// Takes the relation of the supply, which fell short of it at `t`, s, out of the configuration's `text`, and says so.
fn leave_out_supply(text: &mut String, calibration: &mut Calibration, t: f64) {
    let Ok(without) = edit::without_supply(text) else { return };
    *text = without;
    calibration.supply = None;
    calibration.remarks.push(format!(
        "no process detector by the supply: that of the trial, which does not know that block, warns {t:.1} s after the \
         first frame; is there a fault in the recording?"
    ));
}

#[cfg(test)]
mod tests {
    use super::super::stages::tests::{calibration, cylinder};
    use super::Threshold::{OfDifference, OfObservers};
    use super::*;
    use tertius_learn::relate::ProcessRefusal;

    /// A machine of one cylinder without a sequential detector.
    fn taught() -> Taught {
        Taught { calibration: Some(calibration(vec![cylinder(1)])), ..Taught::default() }
    }

    fn left_out(threshold: Threshold) -> LeftOut {
        LeftOut { threshold, by: Stage::Tune, why: "6 mm".to_owned() }
    }

    #[test]
    fn the_last_detectors_by_which_a_transducer_is_healthy_are_not_left_out() {
        let mut taught = taught();
        let why = || "6 mm".to_owned();
        assert_eq!(taught.leave_out(OfObservers, Stage::Tune, why()), Err(why()));
        assert!(taught.text.is_empty() && taught.left_out.is_empty());
        assert_eq!(taught.leave_out(OfDifference, Stage::Calibrate, why()), Ok(()));
        assert_eq!(taught.text.trim(), "[comparator]\nenabled = false");
        assert_eq!(taught.left_out[0].to_string(), "FDE3 left out (calibrate): 6 mm");
        assert_eq!(taught.leave_out(OfObservers, Stage::Tune, why()), Err(why()));
    }

    #[test]
    fn a_threshold_that_a_later_stage_learns_does_not_bring_it_back() {
        let mut taught = Taught { left_out: vec![left_out(OfObservers)], ..taught() };
        taught.put("[fde]\nhigh = 0.113\n", &[]).expect("it is TOML");
        assert!(taught.text.contains("high = 0.113") && taught.text.contains("enabled = false"));
    }

    /// What the trial cannot try is not promised.
    #[test]
    fn what_either_leaves_out_both_do() {
        let [mut whole, mut rehearsal] = [taught(), taught()];
        let of_the_rehearsal =
            rehearsal.leave_out(OfDifference, Stage::Calibrate, "14 mm".to_owned());
        of_the_rehearsal.expect("the observers are left");
        whole.agree_with(&mut rehearsal).expect("they are left here, too");
        assert_eq!(whole.left_out[0].why, "without the third that is held back, 14 mm");
        assert_eq!(whole.text, rehearsal.text);
        let mut rehearsal = taught();
        whole.agree_with(&mut rehearsal).expect("they are left here, too");
        assert!(rehearsal.is_left_out(OfDifference));
        let mut rehearsal = Taught { left_out: vec![left_out(OfObservers)], ..taught() };
        assert!(whole.agree_with(&mut rehearsal).is_err(), "then nothing is left");
    }

    /// One fault of the supply, which all cylinders tell: they keep their detectors.
    #[test]
    fn a_supply_that_warns_in_the_trial_is_left_out_and_the_cylinders_are_not() {
        let own = "[[cylinder]]\nn = 2\n[cylinder.process]\nlevel = 2\n";
        let text =
            format!("[process]\nlevel = 30.0\n\n[process.supply]\nreference = 230.0\n\n{own}");
        let supply = Some(Err(ProcessRefusal::Undetermined));
        let calibration = Calibration { supply, ..calibration(vec![cylinder(1), cylinder(2)]) };
        let mut taught = Taught { text, calibration: Some(calibration), ..Taught::default() };
        let alarm = |cylinder, fault| FalseAlarm {
            t: 61.25,
            cylinder,
            detector: Detector::Process,
            fault,
            stands: false,
        };
        taught.without_process(&Trial {
            held: 300.0,
            false_alarms: Vec::new(),
            of_process: vec![alarm(1, Fault::Supply), alarm(2, Fault::Supply)],
            of_supply: Some(61.25),
            known: Vec::new(),
            kinds: Vec::new(),
        });
        assert_eq!(taught.text, format!("[process]\nlevel = 30.0\n\n{own}"));
        let calibration = taught.calibration.expect("it is there");
        assert!(calibration.supply.is_none());
        assert!(
            calibration.cylinders.iter().all(|it| it.process.is_some() && it.remarks.is_empty())
        );
        let [remark] = &calibration.remarks[..] else { panic!("{:?}", calibration.remarks) };
        assert!(remark.contains("by the supply") && remark.contains("61.2 s"), "{remark}");
    }

    #[test]
    fn what_warns_in_the_trial_is_left_out_of_its_cylinder_alone_and_said_once() {
        let own =
            |n: u8| format!("[[cylinder]] # the {n}\nn = {n}\n[cylinder.process]\nlevel = {n}\n\n");
        let mut text = own(1) + &own(2);
        let mut cylinders = [cylinder(1), cylinder(2)];
        let alarm = |t| FalseAlarm {
            t,
            cylinder: 2,
            detector: Detector::Process,
            fault: Fault::Leakage,
            stands: false,
        };
        leave_out_process(&mut text, &mut cylinders, &[alarm(61.25), alarm(75.0)]);
        assert!(text.starts_with(&own(1)), "{text}");
        assert!(text.contains("\nn = 2") && !text.contains("level = 2"), "{text}");
        assert!(cylinders[0].process.is_some() && cylinders[0].remarks.is_empty());
        assert!(cylinders[1].process.is_none());
        let [remark] = &cylinders[1].remarks[..] else { panic!("{:?}", cylinders[1].remarks) };
        assert!(remark.contains("61.2 s"), "{remark}");
    }
}
