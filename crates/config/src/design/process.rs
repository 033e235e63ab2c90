//! From the fitted tables to a process detector.

use super::{Connector, Flaw};
use crate::settings::{ChambersTable, CylinderProcess, SpoolTable};
use tertius_core::process::{ChambersDesign, Curve, ProcessDesign, ProcessParameters, SpoolDesign};

/// Least number of samples with which the commands between two knots are taught.
const LEAST_SAMPLES: u64 = 100;

impl Connector<'_> {
    /// The process detector of cylinder `n`; `None` where nothing of it was fitted.
    pub(super) fn process(&mut self, n: u8) -> Option<ProcessDesign> {
        let settings = self.settings;
        let fitted = settings.process_of(n)?;
        self.refuse_absent(n, fitted);
        Some(ProcessDesign {
            spool: fitted.spool.as_ref().map(spool),
            chambers: fitted.chambers.as_ref().map(chambers),
            level: settings.process_level(),
            sample_time: settings.machine.sample_time,
            clear: settings.warning_cycles(),
            parameters: &ProcessParameters::DEFAULT,
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
        let wanted =
            [(fitted.spool.is_some(), &of_spool[..]), (fitted.chambers.is_some(), &of_chambers)];
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
}

fn spool(fitted: &SpoolTable) -> SpoolDesign {
    let [least, _] = ProcessParameters::DEFAULT.least_deviations;
    let SpoolTable { retained, limit, deviation, timing, largest, .. } = *fitted;
    SpoolDesign {
        retained,
        limit,
        curve: Curve::new(limit, fitted.curve.clone()),
        before: Curve::new(limit, fitted.before.clone()),
        taught: fitted.samples.iter().map(|samples| *samples >= LEAST_SAMPLES).collect(),
        noise: deviation,
        deviation: deviation.max(least * largest),
        timing,
        largest,
        dependence: [fitted.mean_dependence, fitted.square_dependence],
    }
}

fn chambers(fitted: &ChambersTable) -> ChambersDesign {
    let [_, least] = ProcessParameters::DEFAULT.least_deviations;
    ChambersDesign {
        coefficients: fitted.coefficients,
        deviation: fitted.deviation.max(least),
        dependence: [fitted.mean_dependence, fitted.square_dependence],
    }
}
