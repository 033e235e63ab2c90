//! `[hexapod]`, the platform's geometry.

use crate::kinds::number;
use crate::schema::{Limits, table};

const SIZE: Limits = Limits::least(0.01, "a size of the platform in metres").most(100.0);
const ANGLE: Limits =
    Limits::least(0.0, "half of the angle between two gimbals in radians").most(1.0);

table! {
    /// Dimensions of the platform: three pairs of gimbals on a circle at each end, cylinder 1 at the right of the base's
    /// pair that points forward, the others counted round from there.
    pub struct Hexapod = HEXAPOD {
        base_radius: f64 => number(SIZE),
            "2.9", "the radius of the circle of the base's gimbals, m";
        base_half_angle: f64 => number(ANGLE),
            "0.12", "half of the angle between the two gimbals of a pair of the base, rad";
        top_radius: f64 => number(SIZE),
            "2.3", "the radius of the circle of the deck's gimbals, m";
        top_half_angle: f64 => number(ANGLE),
            "0.14", "half of the angle between the two gimbals of a pair of the deck, rad";
        neutral_height: f64 => number(SIZE),
            "4.2", "the height of the deck over the base where all strokes are 0, m";
        top_accuracy: f64 = 1.75e-4 =>
            number(Limits::least(1e-6, "what an attitude sensor is off by, in radians").most(0.1)),
            "1.75e-4", "the accuracy of the sensor on the deck, a standard deviation, rad; 1.75e-4 is 0.01 degrees";
    }
}
