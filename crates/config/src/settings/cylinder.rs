//! `[[cylinder]]`.

use super::nonlinear::{CYLINDER_NONLINEAR, CylinderNonlinear};
use super::process::{CYLINDER_PROCESS, CylinderProcess};
use super::sequential::{CYLINDER_SEQUENTIAL, CylinderSequential};
use crate::kinds::{DURATION, FINITE, MOST_CYLINDERS, number, numbers, text, whole};
use crate::schema::{Kind, Limits, Scalar, table};
use crate::text::TextRule;

table! {
    /// Overrides for one cylinder.
    pub struct Cylinder = CYLINDER {
        n: u8 => whole(1, MOST_CYLINDERS as i128, "cylinders are numbered from 1 to machine.cylinders"),
            "1", "which cylinder";
        name: Option<String> = None => text(TextRule::Tag),
            "\"FwdPort\"", "what people call the cylinder, at most 32 characters; it is shown beside its number";
        c1_name: Option<String> = None => text(TextRule::Tag),
            "\"LT-101A\"", "the tag of its transducer C1, at most 32 characters";
        c2_name: Option<String> = None => text(TextRule::Tag),
            "\"LT-101B\"", "the tag of its transducer C2, at most 32 characters";
        c2: bool = true => Kind::One(Scalar::Switch),
            "true", "whether it has a C2; false: C1 is its only transducer, although other cylinders have both";
        c2_gain: f64 = 1.0 =>
            number(Limits::least(0.5, "both transducers measure the same stroke, so a is close to 1").most(2.0)),
            "1.0", "a of (5-20)";
        c2_offset: f64 = 0.0 => number(Limits::finite(FINITE)),
            "0.0", "b of (5-20), m";
        theta: Option<[f64; 5]> = None => numbers(5, Limits::finite(FINITE)),
            "[-0.0101, -0.1231, -1.6891e-5, -10.7104, -0.0023]", "theta of (4-1) for this cylinder";
        gamma: Option<[f64; 2]> = None => numbers(2, Limits::finite(FINITE)),
            "[0.0926, 6.5427]", "gamma of (4-1) for this cylinder";
        command_offset: Option<f64> = None => number(Limits::finite(FINITE)),
            "0.0", "the command at which this cylinder rests, m/s";
        sample_time: Option<f64> = None => number(Limits::above(0.0, DURATION)),
            "0.02", "the sample time of theta and gamma of this cylinder, s; absent: not known";
        sequential: Option<CylinderSequential> = None => Kind::Table(&CYLINDER_SEQUENTIAL),
            "", "what `calibrate` has fitted for the sequential detector";
        process: Option<CylinderProcess> = None => Kind::Table(&CYLINDER_PROCESS),
            "", "what `calibrate` has fitted for the process detector";
        nonlinear: Option<CylinderNonlinear> = None => Kind::Table(&CYLINDER_NONLINEAR),
            "", "flow curve and friction, as `identify --nonlinear` finds them";
    }
}

impl Cylinder {
    /// Nothing of cylinder `n` differs from the machine.
    pub const fn new(n: u8) -> Self {
        Self {
            n,
            name: None,
            c1_name: None,
            c2_name: None,
            c2: true,
            c2_gain: 1.0,
            c2_offset: 0.0,
            theta: None,
            gamma: None,
            command_offset: None,
            sample_time: None,
            sequential: None,
            process: None,
            nonlinear: None,
        }
    }
}
