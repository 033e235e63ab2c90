//! What the pressures of both chambers add up to.
//!
//! P_bot + P_rod = c₀ + c₁ P_S + c₂ (P_bot − P_rod) + c₃ x. With ideal chambers it is P_S; leakage of the valve's edges,
//! ports that do not match the areas, and the lag of the supply's signal are what the coefficients are for. Of a sum
//! that is off, which of both sensors is wrong does not follow.

use super::parameters::ProcessParameters;
use crate::sequential::windows::WIDTHS;

/// Number of coefficients.
pub const TERMS: usize = 4;

/// What is known of the chambers.
#[derive(Clone, Debug, PartialEq)]
pub struct ChambersDesign {
    /// c₀, bar, c₁, c₂, and c₃, bar per unit of the spool's position (0 without one).
    pub coefficients: [f64; TERMS],
    /// Least and largest P_S that were taught, bar.
    pub supplies: [f64; 2],
    /// Standard deviation of the sum beside it at rest, bar, and its growth with the square of the spool's position,
    /// bar per squared unit: at high speed the ports and the oil's lag are not linear.
    pub deviation: f64,
    pub growth: f64,
    /// Numbers of dependent samples of mean and spread, see [`super::Weighing`].
    pub dependence: [[f64; WIDTHS.len()]; 2],
}

/// What the sum is compared with: 1, P_S, P_bot − P_rod and x.
pub fn terms([bottom, rod]: [f64; 2], supply: f64, spool: f64) -> [f64; TERMS] {
    [1.0, supply, bottom - rod, spool]
}

impl ChambersDesign {
    /// The sum less what it should be, bar; `None` where it depends on a spool that was not read. At a P_S that was not
    /// taught, what the coefficients may be off is none of it.
    pub fn residual(&self, chambers: [f64; 2], supply: f64, spool: Option<f64>) -> Option<f64> {
        let [.., by_spool] = self.coefficients;
        let spool = if by_spool == 0.0 { 0.0 } else { spool? };
        let terms = terms(chambers, supply, spool);
        let expected: f64 = terms.iter().zip(self.coefficients).map(|(term, of)| term * of).sum();
        let residual = chambers[0] + chambers[1] - expected;
        let [lowest, highest] = self.supplies;
        if supply >= lowest && supply <= highest {
            Some(residual)
        } else {
            Some(self.beyond(residual, supply))
        }
    }

    /// What of a residual is evidence at a P_S that was not taught, bar.
    #[cold]
    fn beyond(&self, residual: f64, supply: f64) -> f64 {
        let [lowest, highest] = self.supplies;
        let allowed =
            ProcessParameters::DEFAULT.chambers_untaught * (lowest - supply).max(supply - highest);
        (residual.abs() - allowed).max(0.0).copysign(residual)
    }

    /// Variance of the residual with the spool there, bar².
    pub fn variance(&self, spool: Option<f64>) -> f64 {
        let grown = self.growth * spool.map_or(0.0, |spool| spool * spool);
        self.deviation * self.deviation + grown * grown
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spool_that_is_needed_and_not_read_leaves_nothing_to_say() {
        let of = |by_spool| ChambersDesign {
            coefficients: [1.0, 1.0, 0.5, by_spool],
            supplies: [180.0, 220.0],
            deviation: 0.3,
            growth: 0.01,
            dependence: [[1.0; WIDTHS.len()]; 2],
        };
        let read = |by_spool, spool| of(by_spool).residual([110.0, 90.0], 190.0, spool);
        assert_eq!(read(0.1, Some(20.0)), Some(-3.0));
        assert_eq!(read(0.1, None), None);
        let deviation = |spool| libm::sqrt(of(0.1).variance(spool));
        let deviations = [None, Some(0.0)].map(deviation);
        assert!(deviations.iter().all(|it| (it - 0.3).abs() < 1e-12));
        assert!((deviation(Some(-libm::sqrt(40.0))) - 0.5).abs() < 1e-12);
        assert_eq!([read(0.0, None), read(0.0, Some(20.0))], [Some(-1.0); 2]);
    }

    /// A coefficient of P_S that was learnt where that hardly moved tells little of one far away.
    #[test]
    fn a_supply_that_was_not_taught_leaves_less_to_say_and_a_sensor_far_off_still_enough() {
        let design = ChambersDesign {
            coefficients: [0.0, 1.0, 0.0, 0.0],
            supplies: [220.0, 240.0],
            deviation: 0.3,
            growth: 0.0,
            dependence: [[1.0; WIDTHS.len()]; 2],
        };
        let left =
            |sum: f64, supply| design.residual([sum, 0.0], supply, None).expect("it is read");
        assert_eq!(left(231.5, 230.0), 1.5);
        // 0.05 bar a bar: 1.5 bar at 190 bar.
        for off in [-1.4, 0.0, 1.4] {
            assert_eq!(left(190.0 + off, 190.0), 0.0, "{off}");
        }
        assert!((left(188.0, 190.0) + 0.5).abs() < 1e-9 && (left(252.0, 250.0) - 1.5).abs() < 1e-9);
        assert!((left(230.0, 210.0) - 19.5).abs() < 1e-9);
    }
}
