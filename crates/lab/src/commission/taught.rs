//! What the stages have taught so far, and the detectors that are left out, because the threshold that the recording asks
//! for would be too large to find a fault. That says nothing against the others.

use std::fmt;
use tertius_config::{MachineNames, edit};
use tertius_core::alarm::Detector;
use tertius_learn::calibrate::{Calibration, Cuts};
use tertius_learn::identify::Outcome;
use tertius_learn::tune::Tuning;

/// One of the three stages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    Identify,
    Calibrate,
    Tune,
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Identify => "identify",
            Self::Calibrate => "calibrate",
            Self::Tune => "tune",
        })
    }
}

/// A cylinder from which nothing is learnt.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// Cylinder number, counted from 1.
    pub cylinder: u8,
    pub by: Stage,
    pub why: String,
}

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

/// Result of the stages.
#[derive(Clone, Debug, Default)]
pub struct Taught {
    pub machine: String,
    /// How its cylinders are called.
    pub names: MachineNames,
    /// Text of the configuration with all tables up to the stage that failed.
    pub text: String,
    pub identification: Option<Outcome>,
    pub calibration: Option<Calibration>,
    pub tuning: Option<Tuning>,
    pub refused: Vec<Refused>,
    pub left_out: Vec<LeftOut>,
    /// Why the model says nothing of this machine, so that no observer can judge by it.
    pub does_not_follow: Option<String>,
    /// The stage that failed, and why; later stages were not tried.
    pub failed: Option<(Stage, String)>,
}

impl Taught {
    /// Whether every stage succeeded.
    pub const fn is_whole(&self) -> bool {
        self.failed.is_none() && self.tuning.is_some()
    }

    /// Times that the calibration left out because no healthy cylinder reads so.
    pub fn cuts(&self) -> Cuts {
        self.calibration.as_ref().map(Calibration::cuts).unwrap_or_default()
    }

    /// The cylinders that were refused, in order, each once.
    pub fn refused_cylinders(&self) -> Vec<u8> {
        let mut cylinders: Vec<u8> = self.refused.iter().map(|refused| refused.cylinder).collect();
        cylinders.sort_unstable();
        cylinders.dedup();
        cylinders
    }

    pub(super) fn refuse(&mut self, by: Stage, refusals: Vec<(u8, String)>) {
        let refused = refusals.into_iter().map(|(cylinder, why)| Refused { cylinder, by, why });
        self.refused.extend(refused);
    }

    pub(super) fn put(&mut self, tables: &str, anew: &[&str]) -> Result<(), String> {
        let text = edit::put(&self.text, tables, anew);
        self.text = text.map_err(|error| format!("the configuration cannot be edited: {error}"))?;
        self.keep_left_out()
    }

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

#[cfg(test)]
pub(super) mod tests {
    use super::Threshold::{OfDifference, OfObservers};
    use super::*;
    use tertius_learn::calibrate::{CalibrationRefusal, CylinderCalibration};
    use tertius_learn::relate::LearntProcess;
    use tertius_learn::survey::{Timeline, Window};

    pub fn cylinder(number: u8) -> CylinderCalibration {
        CylinderCalibration {
            sample_time: 0.02,
            number,
            result: Err(CalibrationRefusal::NoSecond),
            tried: None,
            sequential: None,
            level: None,
            contradiction: None,
            process: Some(LearntProcess {
                number,
                spool: None,
                chambers: None,
                flow: None,
                friction: None,
            }),
            left_out: Vec::new(),
            remarks: Vec::new(),
        }
    }

    pub fn calibration(cylinders: Vec<CylinderCalibration>) -> Calibration {
        Calibration {
            machine: String::new(),
            inputs: String::new(),
            timeline: Timeline::default(),
            fitted: Window::ALL,
            tried: Window::ALL,
            cylinders,
            bound: None,
            supply: None,
            remarks: Vec::new(),
        }
    }

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
}
