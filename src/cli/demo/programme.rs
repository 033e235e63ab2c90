//! Programme of the demonstration.

use crate::inject::{Fault, SpecError};

/// A fault of the demonstration.
#[derive(Clone, Copy, Debug)]
pub struct Act {
    /// The fault in the syntax of `--fault`, without its time, which the programme sets.
    spec: &'static str,
    pub title: &'static str,
    /// Hint at what to watch.
    pub hint: &'static str,
    /// Suspect that the gateway should name, as in Fd_Warning.Suspect.
    pub suspect: &'static str,
}

/// One fault of each kind: those of the thesis, Table 5-1, and two that need no model.
pub const ACTS: [Act; 5] = [
    Act {
        spec: "step,cylinder=3,sensor=c1,size=0.002",
        title: "C1 of cylinder 3 jumps by 2 mm",
        hint: "R1 and R3 jump, R2 does not: so it is C1",
        suspect: "c1",
    },
    Act {
        spec: "noise,cylinder=5,sensor=c2,size=0.0017",
        title: "C2 of cylinder 5 gets noise of 1.7 mm",
        hint: "R2 crosses its limit again and again, R1 does not: so it is C2",
        suspect: "c2",
    },
    Act {
        spec: "drift,cylinder=2,sensor=c1,rate=0.001",
        title: "C1 of cylinder 2 drifts by 1 mm/s",
        hint: "observers follow a drift: only R3 grows, the suspect stays undecided",
        suspect: "undecided",
    },
    Act {
        spec: "freeze,cylinder=6,sensor=c2",
        title: "C2 of cylinder 6 freezes",
        hint: "the command moves, the reading does not: this needs no model to see",
        suspect: "c2",
    },
    Act {
        spec: BROKEN_WIRE[0],
        title: "the wire of C1 of cylinder 4 breaks",
        hint: "this reading is not a length any more, and no observer gets it",
        suspect: "c1",
    },
];

/// Time from the start to the first fault, s: the platform is engaged at 26 s, and observers take a
/// second to settle.
const FIRST: f64 = 30.0;
/// Interval between faults, s.
const EVERY: f64 = 6.0;
/// Duration of each fault, s, after which warnings clear.
const LASTS: f64 = 4.0;

/// Time from the start at which there is something to watch, s.
pub const CURTAIN: f64 = 28.0;

/// End of the demonstration, s from the start.
pub const END: f64 = FIRST + ACTS.len() as f64 * EVERY;

/// Beginning and end of fault `index`, from 0, s from the start.
pub const fn window(index: usize) -> [f64; 2] {
    let from = FIRST + index as f64 * EVERY;
    [from, from + LASTS]
}

/// A CANopen device has no code for a broken wire in its reading: it says so in an emergency message.
const BROKEN_WIRE: [&str; 2] =
    ["broken_wire,cylinder=4,sensor=c1", "broken_wire,cylinder=4,sensor=c1_emergency"];

/// The fault of the act `index`, from 0; of a machine with CANopen devices if `canopen`.
///
/// # Errors
/// None, since a test reads each.
pub fn fault(index: usize, canopen: bool) -> Result<Fault, SpecError> {
    let [from, until] = window(index);
    let spec = match ACTS[index].spec {
        spec if canopen && spec == BROKEN_WIRE[0] => BROKEN_WIRE[1],
        spec => spec,
    };
    Fault::parse(&format!("{spec},at={from},until={until}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_fault_is_one_and_its_words_fit_into_a_line() {
        for (index, act) in ACTS.iter().enumerate() {
            let fault = fault(index, false).expect(act.spec);
            assert!(act.title.contains(&format!("cylinder {}", fault.cylinder)));
            assert!(act.title.contains(&fault.sensor.to_uppercase()));
            assert!(act.title.len() <= 38 && act.hint.len() <= 69, "{}", act.hint);
        }
        assert_eq!(fault(4, true).map(|fault| fault.sensor), Ok("c1_emergency"));
        assert!(window(0)[0] > CURTAIN && window(ACTS.len() - 1)[1] < END);
    }
}
