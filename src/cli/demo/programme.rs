//! Programme of the demonstration.

use crate::config::Settings;
use crate::config::settings::Role;
use crate::inject::{Fault, SpecError};
use crate::simulator::Tables;
use crate::text::Millimetres;

/// A fault of the demonstration.
#[derive(Clone, Debug)]
pub struct Act {
    /// The fault in the syntax of `--fault`, without its time.
    spec: String,
    pub title: String,
    /// Hint at what to watch.
    pub hint: &'static str,
    /// Cylinder number, counted from 1.
    pub cylinder: i64,
    /// Suspect that the gateway should name, as in Fd_Warning.Suspect.
    pub suspect: &'static str,
    /// The faulty transducer; to name it is never wrong.
    pub faulty: &'static str,
}

/// The faults, one of each kind: those of the thesis, Table 5-1, and two that need no model. Their times follow from the
/// machine's, and their sizes from the thresholds that have to find them.
#[derive(Clone, Debug)]
pub struct Programme {
    pub acts: Vec<Act>,
    /// Time from the start to the first fault, s.
    first: f64,
    /// Time after a fault's end in which a warning still counts for it, s: the end of a fault is a jump in itself, and
    /// standing warnings clear.
    pub aftermath: f64,
}

/// Duration of each fault, s.
const LASTS: f64 = 4.0;
/// Time from the clearing of a fault's warnings to the next fault, s.
const BETWEEN: f64 = 1.0;
/// The part of it in which a warning may still be of the fault before, s.
const STILL: f64 = 0.9;
/// Time that observers have been at work before the first fault, s.
const AT_WORK: f64 = 3.0;
/// Time before the first fault from which there is something to watch, s.
const CURTAIN: f64 = 2.0;

impl Programme {
    /// The programme for the machine of `settings` and `tables`.
    pub fn new(settings: &Settings, tables: &Tables) -> Self {
        // Safe and settled differ in what holds the rods, not in where they are.
        let engaged = 3.0 * tables.controller.dwell + 2.0 * tables.controller.transition;
        Self {
            acts: acts(settings),
            first: engaged + settings.observer.settle + AT_WORK,
            aftermath: settings.alarm.clear + STILL,
        }
    }

    /// Beginning and end of fault `index`, from 0, s from the start.
    pub fn window(&self, index: usize) -> [f64; 2] {
        let every = LASTS + (self.aftermath - STILL) + BETWEEN;
        let from = self.first + index as f64 * every;
        [from, from + LASTS]
    }

    /// Time from the start at which there is something to watch, s.
    pub fn curtain(&self) -> f64 {
        self.first - CURTAIN
    }

    /// End of the demonstration, s from the start.
    pub fn end(&self) -> f64 {
        self.window(self.acts.len())[0]
    }

    /// The fault of the act `index`, from 0.
    ///
    /// # Errors
    /// None, since a test reads each.
    pub fn fault(&self, index: usize) -> Result<Fault, SpecError> {
        let [from, until] = self.window(index);
        Fault::parse(&format!("{},at={from},until={until}", self.acts[index].spec))
    }
}

/// A cylinder of a machine of so many `cylinders`: the one of this `number` where there are six.
const fn of_six(number: u8, cylinders: u8) -> u8 {
    (number - 1) % cylinders + 1
}

/// `size` to a hundredth of a millimetre: what a person is told is what the fault is, m.
fn rounded(size: f64) -> f64 {
    (size * 1e5).round() / 1e5
}

fn acts(settings: &Settings) -> Vec<Act> {
    let (high, bound) = (settings.fde.high, settings.comparator.bound);
    let sizes = [(2.0 * high).max(1.25 * bound), 1.7 * high, bound / 1.5];
    let [step, noise, rate] = sizes.map(rounded);
    let [jump, rough, slow] = [step, noise, rate].map(|it| Millimetres(it).chosen());
    let of_six = |number| of_six(number, settings.machine.cylinders);
    let act = |number, faulty, title: String, hint, spec: String| {
        let cylinder = of_six(number);
        let title = title.replace("{n}", &cylinder.to_string());
        let spec = spec.replace("{n}", &cylinder.to_string());
        Act { spec, title, hint, cylinder: i64::from(cylinder), suspect: faulty, faulty }
    };
    let wire = broken_wire(settings, of_six(4));
    vec![
        act(
            3,
            "c1",
            format!("C1 of cylinder {{n}} jumps by {jump}"),
            "R1 and R3 jump, R2 does not: so it is C1",
            format!("step,cylinder={{n}},sensor=c1,size={step}"),
        ),
        act(
            5,
            "c2",
            format!("C2 of cylinder {{n}} gets noise of {rough}"),
            "R2 crosses its limit again and again, R1 does not: so it is C2",
            format!("noise,cylinder={{n}},sensor=c2,size={noise}"),
        ),
        Act {
            suspect: "undecided",
            ..act(
                2,
                "c1",
                format!("C1 of cylinder {{n}} drifts by {slow}/s"),
                "observers follow a drift: only R3 grows, the suspect stays undecided",
                format!("drift,cylinder={{n}},sensor=c1,rate={rate}"),
            )
        },
        act(
            6,
            "c2",
            "C2 of cylinder {n} freezes".to_owned(),
            "the command moves, the reading does not: this needs no model to see",
            "freeze,cylinder={n},sensor=c2".to_owned(),
        ),
        act(
            4,
            "c1",
            "the wire of C1 of cylinder {n} breaks".to_owned(),
            "this reading is not a length any more, and no observer gets it",
            format!("broken_wire,cylinder={{n}},sensor={wire}"),
        ),
    ]
}

/// The sensor whose wire breaks. A CANopen device has no code for that in its reading: it says so in an emergency message.
fn broken_wire(settings: &Settings, cylinder: u8) -> &'static str {
    let is_it = |role: Option<Role>, of| role == Some(Role::C1) && of == cylinder;
    let is_device = settings.devices().iter().any(|it| is_it(it.role, it.cylinder));
    if is_device { "c1_emergency" } else { "c1" }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// The programme for the built-in machine with so many cylinders.
    pub fn programme(cylinders: u8) -> Programme {
        let text = include_str!("../../../config/e-type-simulated.toml");
        let (mut settings, _) = crate::config::parse("e-type.toml", text).expect("it is sound");
        settings.machine.cylinders = cylinders;
        Programme::new(&settings, &Tables::default())
    }

    #[test]
    fn each_fault_is_one_and_its_words_fit_into_a_line() {
        for cylinders in 1..=6 {
            let programme = programme(cylinders);
            for (index, act) in programme.acts.iter().enumerate() {
                let fault = programme.fault(index).expect(&act.title);
                assert!((1..=cylinders).contains(&fault.cylinder), "{fault:?}");
                assert!(act.title.contains(&format!("cylinder {}", fault.cylinder)));
                assert!(act.title.contains(&act.faulty.to_uppercase()));
                assert_eq!(fault.sensor, act.faulty);
                assert!(act.title.len() <= 38 && act.hint.len() <= 69, "{}", act.hint);
            }
            assert!(programme.window(0)[0] > programme.curtain());
            assert!(programme.window(programme.acts.len() - 1)[1] < programme.end());
        }
    }

    /// The faults of the built-in machine have the thesis's sizes: its thresholds are the thesis's.
    #[test]
    fn sizes_and_times_follow_from_the_machine() {
        let of_six = programme(6);
        assert_eq!((of_six.window(0), of_six.end()), ([30.0, 34.0], 60.0));
        let titles: Vec<&str> = of_six.acts.iter().map(|act| &*act.title).collect();
        let drift = "C1 of cylinder 2 drifts by 1 mm/s";
        assert_eq!(titles[..1], ["C1 of cylinder 3 jumps by 2 mm"]);
        assert_eq!(titles[1..3], ["C2 of cylinder 5 gets noise of 1.7 mm", drift]);
        assert_eq!(programme(3).acts[1].cylinder, 2);
        let text = include_str!("../../../config/a-type-simulated.toml");
        let (mut settings, _) = crate::config::parse("a-type.toml", text).expect("it is sound");
        settings.fde.high = 1.35e-3;
        let plant = include_str!("../../../config/a-type-plant.toml");
        let tables = Tables::parse(plant).expect("it is sound");
        let other = Programme::new(&settings, &tables);
        assert_eq!(other.acts[0].title, "C1 of cylinder 3 jumps by 2.7 mm");
        assert_eq!(other.window(0)[0], 29.0, "engaged after 3 dwells and 2 transitions");
    }
}
