//! From the fitted tables to the process detectors.

use super::connector::Connector;
use super::flaw::Flaw;
use crate::settings::Settings;
use crate::settings::{
    ChambersTable, CylinderProcess, FlowTable, FrictionTable, SpoolTable, SupplyTable,
};
use tertius_core::alarm::Deadlines;
use tertius_core::process::curve::knot;
use tertius_core::process::flow::FlowWeighing;
use tertius_core::process::flow::directions::{HALF, upper};
use tertius_core::process::friction::FrictionWeighing;
use tertius_core::process::parameters::DIRECTIONS;
use tertius_core::process::{
    ChambersDesign, Curve, FlowDesign, FrictionDesign, ProcessDesign, ProcessParameters,
    SpoolDesign, SupplyDesign, SupplyRelation,
};

/// Least number of samples with which the commands between two knots are taught.
const LEAST_SAMPLES: u64 = 100;

/// What to do about a table that nothing can be made of.
const ANEW: &str = "let `tertius calibrate` write the table anew, or leave it out";

impl Connector<'_> {
    /// The process detector of cylinder `n`; `None` where nothing of it was fitted.
    pub(super) fn process(&mut self, n: u8) -> Option<ProcessDesign> {
        let settings = self.settings;
        let (fitted, supply) = (settings.process_of(n), settings.process.supply.is_some());
        if let Some(fitted) = fitted {
            self.refuse_absent(n, fitted);
            self.refuse_falling(n, fitted);
        }
        (fitted.is_some() || supply).then(|| ProcessDesign {
            spool: fitted.and_then(|it| it.spool.as_ref()).map(spool),
            chambers: fitted.and_then(|it| it.chambers.as_ref()).map(chambers),
            flow: fitted.and_then(|it| it.flow.as_ref()).and_then(|it| self.flow(n, it)),
            friction: fitted
                .and_then(|it| it.friction.as_ref())
                .and_then(|it| self.friction(n, it)),
            is_pair: settings.has_c2(n),
            supply,
            level: settings.process_level(),
            sample_time: settings.machine.sample_time,
            clear: settings.warning_cycles(),
            parameters: &ProcessParameters::DEFAULT,
        })
    }

    /// The supply of all cylinders; `None` where nothing of it was fitted.
    pub(super) fn supply(&mut self) -> Option<SupplyDesign> {
        let settings = self.settings;
        let fitted = settings.process.supply.as_ref()?;
        let SupplyTable { reference, taught, taken, deviation, mean_dependence, .. } = *fitted;
        if settings.signals.supply.is_none() {
            self.flaws.push(Flaw::new(
                "process.supply",
                "the table is for a signal that is not named: signals.supply",
                "name it as signals.supply, or leave the table out",
            ));
        }
        if taught[0] >= taught[1] {
            let found = format!("its pressures do not rise: {taught:?}");
            self.flaws.push(Flaw::new("process.supply.taught", found, ANEW));
        }
        Some(SupplyDesign {
            relation: SupplyRelation {
                reference,
                taught,
                pump: fitted.pump.clone(),
                taken,
                deviation: deviation.max(ProcessParameters::DEFAULT.supply_deviation),
                dependence: [mean_dependence; 2],
            },
            least: settings
                .process
                .least_supply
                .unwrap_or(ProcessParameters::DEFAULT.supply_least * reference),
            deadlines: deadlines(settings),
            level: settings.process_level(),
            sample_time: settings.machine.sample_time,
            clear: settings.warning_cycles(),
        })
    }

    /// Refuses relations of signals that are not named.
    fn refuse_absent(&mut self, n: u8, fitted: &CylinderProcess) {
        let signals = &self.settings.signals;
        let own = &signals.cylinder;
        let of_chambers = [
            ("signals.cylinder.pressure_bottom", own.pressure_bottom.is_some()),
            ("signals.cylinder.pressure_rod", own.pressure_rod.is_some()),
            ("signals.supply", signals.supply.is_some()),
        ];
        let of_spool = [("signals.cylinder.spool", own.spool.is_some())];
        let has_load = own.load_pressure.is_some() || of_chambers[0].1 && of_chambers[1].1;
        let of_friction =
            [("signals.cylinder.pressure_bottom and pressure_rod, or load_pressure", has_load)];
        let of_flow = [of_spool[0], of_friction[0], of_chambers[2]];
        let wanted = [
            (fitted.spool.is_some(), &of_spool[..]),
            (fitted.chambers.is_some(), &of_chambers),
            (fitted.flow.is_some(), &of_flow),
            (fitted.friction.is_some(), &of_friction),
        ];
        for (_, keys) in wanted.into_iter().filter(|(is_there, _)| *is_there) {
            for (key, _) in keys.iter().filter(|(_, is_named)| !is_named) {
                self.flaws.push(Flaw::new(
                    "cylinder.process",
                    format!("cylinder {n} has a table for a signal that is not named: {key}"),
                    format!("name it as {key}, or leave the table out"),
                ));
            }
        }
    }

    /// Refuses supply pressures of which the least is above the largest.
    fn refuse_falling(&mut self, n: u8, fitted: &CylinderProcess) {
        let supplies = [
            ("cylinder.process.chambers", fitted.chambers.as_ref().and_then(|it| it.supplies)),
            ("cylinder.process.flow", fitted.flow.as_ref().and_then(|it| it.supplies)),
        ];
        for (table, supplies) in supplies {
            let Some([least, largest]) = supplies.filter(|[least, largest]| least > largest) else {
                continue;
            };
            let found = format!("cylinder {n}: `supplies` do not rise: [{least}, {largest}]");
            self.flaws.push(Flaw::new(table, found, ANEW));
        }
    }

    fn flow(&mut self, n: u8, fitted: &FlowTable) -> Option<FlowDesign> {
        let design = FlowDesign {
            limit: fitted.limit,
            curve: Curve::new(fitted.limit, fitted.curve.clone()),
            taught: FlowDesign::taught(&fitted.samples),
            between: fitted.between,
            leakage: fitted.leakage,
            compression: fitted.compression,
            area_ratio: self.settings.machine.area_ratio,
            supplies: fitted.supplies.unwrap_or(ANY_SUPPLY),
            scatter: [&fitted.scatter_c1, &fitted.scatter_c2].map(symmetric),
        };
        let is_sound = design.slope() > 0.0 && FlowWeighing::new(&design).is_some();
        if !is_sound {
            self.flaws.push(Flaw::new(
                "cylinder.process.flow",
                format!("cylinder {n}: `curve` does not rise, or `scatter_c1` or `scatter_c2` is no covariance"),
                ANEW,
            ));
        }
        is_sound.then_some(design)
    }

    fn friction(&mut self, n: u8, fitted: &FrictionTable) -> Option<FrictionDesign> {
        let design = FrictionDesign {
            coefficients: fitted.coefficients,
            scatter: fitted.scatter,
            area_ratio: self.settings.machine.area_ratio,
        };
        let is_sound = FrictionWeighing::new(&design).is_some();
        if !is_sound {
            self.flaws.push(Flaw::new(
                "cylinder.process.friction",
                format!("cylinder {n}: `scatter` is no covariance"),
                ANEW,
            ));
        }
        is_sound.then_some(design)
    }
}

fn symmetric(half: &[f64; HALF]) -> [[f64; DIRECTIONS]; DIRECTIONS] {
    let mut whole = [[0.0; DIRECTIONS]; DIRECTIONS];
    for (value, (i, j)) in half.iter().zip(upper()) {
        whole[i][j] = *value;
        whole[j][i] = *value;
    }
    whole
}

/// How far two curves together may be off in each piece of the first one, from the number of its samples. The pieces next
/// to rest are the shortest, so a sea leaves few samples in them; but a command that stays at zero lies there all the time,
/// and was never judged.
fn doubts(samples: &[u64], curves: [&Curve; 2]) -> Vec<Option<f64>> {
    let mut doubts: Vec<Option<f64>> =
        samples.iter().map(|samples| (*samples >= LEAST_SAMPLES).then_some(0.0)).collect();
    let taught: Vec<usize> = (0..doubts.len()).filter(|i| doubts[*i].is_some()).collect();
    for pair in taught.windows(2) {
        // From the last knot of the one to the first knot of the other.
        let (from, to) = (pair[0] + 1, pair[1]);
        let [low, high] = [from, to].map(|index| knot(curves[0].limit(), samples.len(), index));
        let rise: f64 = curves.iter().map(|curve| (curve.at(high) - curve.at(low)).abs()).sum();
        doubts[from..to].fill(Some(rise));
    }
    doubts
}

fn spool(fitted: &SpoolTable) -> SpoolDesign {
    let [least, _] = ProcessParameters::DEFAULT.least_deviations;
    let SpoolTable { retained, limit, deviation, timing, largest, .. } = *fitted;
    let [curve, before] = [&fitted.curve, &fitted.before].map(|it| Curve::new(limit, it.clone()));
    SpoolDesign {
        retained,
        limit,
        doubts: doubts(&fitted.samples, [&curve, &before]),
        curve,
        before,
        noise: deviation,
        deviation: deviation.max(least * largest),
        timing,
        largest,
        dependence: [fitted.mean_dependence, fitted.square_dependence],
    }
}

/// P_S where a table does not say what was taught, bar.
const ANY_SUPPLY: [f64; 2] = [0.0, f64::INFINITY];

fn chambers(fitted: &ChambersTable) -> ChambersDesign {
    let [_, least] = ProcessParameters::DEFAULT.least_deviations;
    ChambersDesign {
        coefficients: fitted.coefficients,
        supplies: fitted.supplies.unwrap_or(ANY_SUPPLY),
        deviation: fitted.deviation.max(least),
        growth: fitted.growth,
        dependence: [fitted.mean_dependence, fitted.square_dependence],
    }
}

/// Times to a limit at which an alarm is of another level.
pub(super) const fn deadlines(settings: &Settings) -> Deadlines {
    Deadlines { soon: settings.alarm.soon, at_once: settings.alarm.at_once }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six pieces of the first curve, and three of the second, whose knots stand at ±1 and ±1/9, as some of the first do.
    #[test]
    fn a_command_that_is_rare_between_two_that_are_not_is_doubted_by_what_the_curves_rise() {
        let curve = Curve::new(1.0, vec![-9.0, -6.0, -4.0, 0.5, 2.0, 5.0, 9.0]);
        let before = Curve::new(1.0, vec![0.0, 1.0, 3.0, 4.0]);
        // Pieces 2 and 3 lie between knots 2 and 4: 6 and 2 of rise.
        let found = doubts(&[99, 500, 49, 71, 100, 0], [&curve, &before]);
        let rounded: Vec<_> = found.into_iter().map(|it| it.map(f64::round)).collect();
        assert_eq!(rounded, [None, Some(0.0), Some(8.0), Some(8.0), Some(0.0), None]);
        assert_eq!(doubts(&[3, 4, 0, 0, 0, 9], [&curve, &before]), [None; 6]);
    }
}
