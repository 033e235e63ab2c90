//! Process detectors that are left out of a configuration, because they warn in the trial.

use super::taught::Taught;
use super::trial::{FalseAlarm, Trial};
use tertius_config::edit;
use tertius_core::verdict::Fault;
use tertius_learn::calibrate::{Calibration, CylinderCalibration};

impl Taught {
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
    use super::super::taught::tests::{calibration, cylinder};
    use super::*;
    use tertius_core::alarm::Detector;
    use tertius_learn::relate::ProcessRefusal;

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
