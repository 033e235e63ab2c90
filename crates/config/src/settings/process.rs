//! `[process]`, and the tables that `tertius calibrate` has fitted for the process detectors.

use super::fitted::{FITTED, dependence, fitted};
use crate::kinds::{number, numbers};
use crate::schema::{Kind, Limits, Scalar, WholeLimits, table};
use tertius_core::process::chambers::TERMS;
use tertius_core::process::flow::directions::HALF;
use tertius_core::process::friction::{FORCE_TERMS, SCATTERS};
use tertius_core::sequential::windows::WIDTHS;

table! {
    /// Settings of the process detectors of all cylinders that are calibrated for one, and the supply of all of them.
    pub struct ProcessSettings = PROCESS {
        level: Option<f64> = None =>
            number(Limits::above(0.0, "evidence in nats, at which a detector warns").most(1000.0)),
            "26.0",
            "the level of the process detectors of all cylinders, nats; absent: by \
             sequential.false_alarms_per_year";
        least_supply: Option<f64> = None => number(Limits::above(0.0, FITTED)),
            "100.0",
            "the supply's pressure below which it no longer carries the load, bar, which tells how long an \
             accumulator lasts; absent: 0.4 of supply.reference";
        supply: Option<SupplyTable> = None => Kind::Table(&SUPPLY),
            "", "what the supply's pressure does by what all rods take";
    }
}

table! {
    /// P² (1/P_S − 1/P_S′) = T q(P_S) + c₁ w₁ + c₂ w₂ over T = 0.2 s, w being the ways of all rods out and in.
    pub struct SupplyTable = SUPPLY {
        sample_time: f64 => number(Limits::above(0.0, FITTED)),
            "0.02", "the sample time that it was fitted at, s";
        reference: f64 => number(Limits::above(0.0, FITTED)),
            "230.0", "P, bar";
        taught: [f64; 2] => numbers(2, Limits::above(0.0, FITTED)),
            "[220.0, 238.0]", "the least and the largest pressure that were taught, bar";
        pump: Vec<f64> => fitted(2, 1001),
            "[16.0, 8.0, 1.6]", "q: what the pump adds, bar/s, at even distances between them";
        taken: [f64; 2] => numbers(2, Limits::finite(FITTED)),
            "[-7.5, -3.5]", "c₁ and c₂: what the rods add on their ways out and in, bar/m";
        deviation: f64 => number(Limits::above(0.0, FITTED)),
            "0.15", "the standard deviation of the pressure beside it after T, bar";
        mean_dependence: [f64; WIDTHS.len()] => dependence(),
            "[1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1]",
            "samples of the mean that carry as much information as one, by the width of the window";
    }
}

table! {
    /// What the spool and the pressures of one cylinder say of each other.
    pub struct CylinderProcess = CYLINDER_PROCESS {
        sample_time: f64 => number(Limits::above(0.0, FITTED)),
            "0.02", "the sample time that it was fitted at, s";
        spool: Option<SpoolTable> = None => Kind::Table(&SPOOL),
            "", "where the spool stands by the command";
        chambers: Option<ChambersTable> = None => Kind::Table(&CHAMBERS),
            "", "what the pressures of both chambers add up to";
        flow: Option<FlowTable> = None => Kind::Table(&FLOW),
            "", "how far the oil that passes the valve moves the rod";
        friction: Option<FrictionTable> = None => Kind::Table(&FRICTION),
            "", "what pressure it takes to move the rod";
    }
}

table! {
    /// x(k+1) = a x(k) + g(u(k)) + g₂(u(k−1)), positions in the unit of the spool's signal.
    pub struct SpoolTable = SPOOL {
        retained: f64 => number(Limits::least(0.0, FITTED).most(0.9999)),
            "0.7", "a: what of the position is left after a cycle";
        limit: f64 => number(Limits::above(0.0, FITTED)),
            "0.9", "the command at the outermost knots, m/s";
        curve: Vec<f64> => fitted(3, 1001),
            "[-20.0, 0.0, 20.0]", "g at its knots";
        before: Vec<f64> => fitted(3, 1001),
            "[-5.0, 0.0, 5.0]", "the part of the command of the cycle before, at its knots";
        samples: Vec<u64> =>
            Kind::List { least: 2, most: 1000, of: Scalar::Whole(WholeLimits::new(0, i64::MAX as i128, FITTED)) },
            "[5000, 5000]", "samples that the calibration had between each two knots of `curve`";
        deviation: f64 => number(Limits::above(0.0, FITTED)),
            "0.06", "the standard deviation of the position beside it, at rest";
        timing: f64 => number(Limits::least(0.0, FITTED)),
            "0.05", "its growth with a movement within a cycle";
        largest: f64 => number(Limits::above(0.0, FITTED)),
            "45.0", "the largest position that was taught";
        mean_dependence: [f64; WIDTHS.len()] => dependence(),
            "[1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1]",
            "samples of the mean that carry as much information as one, by the width of the window";
        square_dependence: [f64; WIDTHS.len()] => dependence(),
            "[1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1]",
            "samples of the mean square that carry as much information as one, by the width of the window";
    }
}

table! {
    /// P_bot + P_rod by 1, P_S, P_bot − P_rod and the spool's position.
    pub struct ChambersTable = CHAMBERS {
        coefficients: [f64; TERMS] => fitted(TERMS, TERMS),
            "[0.0, 1.0, 0.02, 0.0]", "what each of them counts, bar, bar/bar, bar/bar, bar per unit of the spool";
        supplies: Option<[f64; 2]> = None => numbers(2, Limits::least(0.0, FITTED)),
            "[220.0, 238.0]", "the least and the largest P_S that were taught, bar; absent: any";
        deviation: f64 => number(Limits::above(0.0, FITTED)),
            "0.5", "the standard deviation of the sum beside it, bar";
        growth: f64 = 0.0 => number(Limits::least(0.0, FITTED)),
            "0.0002", "its growth with the square of the spool's position, bar per squared unit";
        mean_dependence: [f64; WIDTHS.len()] => dependence(),
            "[1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1]",
            "samples of the mean that carry as much information as one, by the width of the window";
        square_dependence: [f64; WIDTHS.len()] => dependence(),
            "[1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1]",
            "samples of the mean square that carry as much information as one, by the width of the window";
    }
}

table! {
    /// ΔC = Ts Σ f(x̄) √((P_S ∓ P_L)/210 bar) + c₁ Ts Σ P_L + c₂ ΔP_L, positions of the spool in the unit of its signal.
    pub struct FlowTable = FLOW {
        limit: f64 => number(Limits::above(0.0, FITTED)),
            "45.0", "the position of the spool at the outermost knots";
        curve: Vec<f64> => fitted(3, 1001),
            "[-0.8, 0.0, 0.9]", "f at its knots, m/s";
        samples: Vec<u64> =>
            Kind::List { least: 2, most: 1000, of: Scalar::Whole(WholeLimits::new(0, i64::MAX as i128, FITTED)) },
            "[5000, 5000]", "samples that the calibration had between each two knots";
        between: f64 => number(Limits::least(0.0, FITTED).most(2.0)),
            "0.6", "where the spool is in the mean between two cycles: 0 at the first, 1 at the second one";
        leakage: f64 => number(Limits::finite(FITTED)),
            "-0.00014", "c₁, m/s per bar";
        compression: f64 => number(Limits::finite(FITTED)),
            "-0.00014", "c₂, m per bar";
        supplies: Option<[f64; 2]> = None => numbers(2, Limits::least(0.0, FITTED)),
            "[220.0, 238.0]", "the least and the largest P_S that were taught, bar; absent: any";
        scatter_c1: [f64; HALF] => fitted(HALF, HALF),
            "[1e-9, 0, 0, 0, 0, 0, 1e-9, 0, 0, 0, 0, 1e-9, 0, 0, 0, 1e-9, 0, 0, 1e-9, 0, 1e-9]",
            "the scatter of what is left by C1 along each two directions of a fault: the upper half, row by row";
        scatter_c2: [f64; HALF] => fitted(HALF, HALF),
            "[1e-9, 0, 0, 0, 0, 0, 1e-9, 0, 0, 0, 0, 1e-9, 0, 0, 0, 1e-9, 0, 0, 1e-9, 0, 1e-9]",
            "the same by C2";
    }
}

table! {
    /// P_L by l, v̇, v and tanh(v / 10 mm/s) in means over 0.2 s, without what is slower than 3 s.
    pub struct FrictionTable = FRICTION {
        coefficients: [f64; FORCE_TERMS] => fitted(FORCE_TERMS, FORCE_TERMS),
            "[1.0, 0.5, 20.0, 1.0]", "what each of them counts, bar/m, bar s²/m, bar s/m, bar";
        scatter: [f64; SCATTERS] => fitted(SCATTERS, SCATTERS),
            "[2.6, 4.0, 30.0]",
            "the scatter of what is left along Coulomb's and the viscous friction: the upper half, row by row, bar⁴";
    }
}
