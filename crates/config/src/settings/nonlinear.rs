//! `[cylinder.nonlinear]`: flow curve and friction of one cylinder, as `tertius identify --nonlinear` finds them.

use super::process::FlowTable;
use crate::kinds::number;
use crate::schema::{Kind, Limits, Scalar, WholeLimits, table};
use tertius_core::process::curve::knot;

/// What is expected of a value that nobody writes by hand.
const IDENTIFIED: &str = "`tertius identify --nonlinear` writes it";

table! {
    /// The non-linear model (3-15) of one cylinder. The monitor does not use it; `simulate` and `evaluate` take it as a plant.
    pub struct CylinderNonlinear = CYLINDER_NONLINEAR {
        flow: Option<ValveCurve> = None => Kind::Table(&VALVE_CURVE),
            "", "the flow curve of its valve";
        friction: Option<Stribeck> = None => Kind::Table(&STRIBECK),
            "", "the friction of its piston and rod";
    }
}

table! {
    /// ΔC = Ts Σ f(x̄) √((P_S ∓ P_L)/210 bar) + c₁ Ts Σ P_L + c₂ ΔP_L, with the keys of `[cylinder.process.flow]`.
    pub struct ValveCurve = VALVE_CURVE {
        limit: f64 => number(Limits::above(0.0, IDENTIFIED)),
            "45.0", "the position of the spool at the outermost knots";
        curve: Vec<f64> =>
            Kind::List { least: 3, most: 1001, of: Scalar::Number(Limits::finite(IDENTIFIED)) },
            "[-0.8, 0.0, 0.9]", "f at its knots, m/s";
        samples: Vec<u64> =>
            Kind::List { least: 2, most: 1000, of: Scalar::Whole(WholeLimits::new(0, i64::MAX as i128, IDENTIFIED)) },
            "[5000, 5000]", "samples that the recording had between each two knots";
        between: f64 => number(Limits::least(0.0, IDENTIFIED).most(2.0)),
            "0.6", "where the spool is in the mean between two cycles: 0 at the first, 1 at the second one";
        leakage: f64 => number(Limits::finite(IDENTIFIED)),
            "-0.00014", "c₁, m/s per bar";
        compression: f64 => number(Limits::finite(IDENTIFIED)),
            "-0.00014", "c₂, m per bar";
    }
}

table! {
    /// Friction (3-13) over the piston's area.
    pub struct Stribeck = STRIBECK {
        viscous: f64 => number(Limits::least(0.0, IDENTIFIED)),
            "20.0", "viscous friction, bar s/m";
        coulomb: f64 => number(Limits::least(0.0, IDENTIFIED)),
            "1.0", "Coulomb friction, bar";
        stiction: f64 = 0.0 => number(Limits::least(0.0, IDENTIFIED)),
            "0.6", "static friction beyond Coulomb's, bar";
        stribeck_speed: f64 = 0.02 => number(Limits::above(0.0, IDENTIFIED)),
            "0.02", "the speed at which static friction is down to a third, m/s";
    }
}

impl From<&FlowTable> for ValveCurve {
    /// The curve of the flow's relation, without its scatter.
    fn from(relation: &FlowTable) -> Self {
        let FlowTable { limit, between, leakage, compression, .. } = *relation;
        let (curve, samples) = (relation.curve.clone(), relation.samples.clone());
        Self { limit, curve, samples, between, leakage, compression }
    }
}

/// Samples beside a knot from which its value counts.
const LEAST_SAMPLES: u64 = 100;

/// f of a [`ValveCurve`] as a function: linear between the knots that the recording taught, and beyond them.
#[derive(Clone, Debug, PartialEq)]
pub struct ValveFlow {
    /// Positions of the spool and f, m/s, in order; at least one on either side of rest.
    knots: Vec<[f64; 2]>,
}

/// Pressure drop at which f holds, bar.
const DROP: f64 = 210.0;

/// Part of the way to the outermost knot whose slope holds beyond it.
const QUARTER: f64 = 0.25;

impl ValveCurve {
    /// The curve as a function; `None` where no knot was taught on one side of rest.
    pub fn flow(&self) -> Option<ValveFlow> {
        let pieces = self.samples.len();
        let count = |index: Option<usize>| index.and_then(|it| self.samples.get(it)).copied();
        let beside = |i: usize| {
            let [before, after] = [i.checked_sub(1), Some(i)].map(|it| count(it).unwrap_or(0));
            before.saturating_add(after)
        };
        let values = self.curve.iter().enumerate();
        let knots: Vec<[f64; 2]> = values
            .filter(|(i, value)| value.is_finite() && beside(*i) >= LEAST_SAMPLES)
            .map(|(i, value)| [knot(self.limit, pieces, i), *value])
            .collect();
        let reaches = knots.first()?[0] < 0.0 && knots.last()?[0] > 0.0;
        reaches.then_some(ValveFlow { knots })
    }
}

impl ValveFlow {
    /// The outermost positions that were taught, in and out.
    pub fn reach(&self) -> [f64; 2] {
        [self.knots.first(), self.knots.last()].map(|it| it.map_or(0.0, |knot| knot[0]))
    }

    /// f at the spool's position `x`: the piston's speed at a pressure drop of 210 bar, m/s.
    pub fn at(&self, x: f64) -> f64 {
        let [inward, outward] = self.reach();
        if x < inward {
            self.beyond(inward, x)
        } else if x > outward {
            self.beyond(outward, x)
        } else {
            self.within(x)
        }
    }

    /// f between the outermost knots; beyond them theirs.
    fn within(&self, x: f64) -> f64 {
        let after = self.knots.partition_point(|knot| knot[0] <= x);
        let before = after.checked_sub(1).map(|index| self.knots[index]);
        match (before, self.knots.get(after)) {
            (Some([x0, y0]), Some([x1, y1])) => y0 + (x - x0) / (x1 - x0) * (y1 - y0),
            (Some([_, value]), None) => value,
            (None, Some([_, value])) => *value,
            (None, None) => 0.0,
        }
    }

    /// f beyond the outermost knot `end`, with the mean slope of the quarter before it, which never falls.
    fn beyond(&self, end: f64, x: f64) -> f64 {
        let [last, before] = [end, (1.0 - QUARTER) * end].map(|x| self.within(x));
        last + (x - end) * ((last - before) / (QUARTER * end)).max(0.0)
    }

    /// (3-7) as a speed of the piston, m/s, at load and supply pressure, bar; no flow against a pressure difference.
    pub fn speed(&self, x: f64, load: f64, supply: f64) -> f64 {
        let drop = if x >= 0.0 { supply - load } else { supply + load };
        self.at(x) * (drop.max(0.0) / DROP).sqrt()
    }

    /// The same of a signal that counts `part` for 1.
    #[must_use]
    pub fn scaled(&self, part: f64) -> Self {
        Self { knots: self.knots.iter().map(|[x, value]| [x * part, *value]).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Knots at −40, −10, 0, 10 and 40, of which the last one was hardly visited.
    fn curve(samples: [u64; 4]) -> ValveCurve {
        ValveCurve {
            limit: 40.0,
            curve: vec![-0.8, -0.1, 7.0, 0.2, 9.0],
            samples: samples.to_vec(),
            between: 0.5,
            leakage: 0.0,
            compression: -1e-4,
        }
    }

    #[test]
    fn what_was_not_taught_follows_from_what_was() {
        let flow = curve([500, 60, 30, 80]).flow().expect("both sides were taught");
        assert_eq!(flow.reach(), [-40.0, 10.0]);
        for (x, expected) in
            [(-40.0, -0.8), (-25.0, -0.45), (-10.0, -0.1), (0.0, 0.05), (10.0, 0.2)]
        {
            assert!((flow.at(x) - expected).abs() < 1e-12, "{x}: {}", flow.at(x));
        }
        // Beyond it goes on as from 7.5 to 10, and from -40 to -30.
        assert!((flow.at(30.0) - 0.5).abs() < 1e-12 && (flow.at(-70.0) + 1.5).abs() < 1e-12);
        let scaled = flow.scaled(0.01);
        assert!((scaled.at(0.05) - flow.at(5.0)).abs() < 1e-12);
    }

    #[test]
    fn the_flow_goes_with_the_root_of_the_drop_and_never_against_it() {
        let flow = curve([500; 4]).flow().expect("all was taught");
        assert!((flow.speed(10.0, 20.0, 230.0) - 0.2).abs() < 1e-12);
        assert!((flow.speed(10.0, 177.5, 230.0) - 0.1).abs() < 1e-12);
        assert!((flow.speed(-10.0, -177.5, 230.0) + 0.05).abs() < 1e-12);
        assert_eq!(flow.speed(10.0, 240.0, 230.0), 0.0);
    }

    #[test]
    fn a_side_without_samples_is_no_curve() {
        assert_eq!(curve([500, 500, 0, 0]).flow(), None);
        assert_eq!(curve([0; 4]).flow(), None);
    }
}
