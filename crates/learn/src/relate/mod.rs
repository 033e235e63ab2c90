//! Learning what spool and pressures say of each other, for the process detectors.
//!
//! The relations are linear in their coefficients, and found by least squares on a healthy recording. The detector's
//! own prediction then runs over the same recording: what it leaves gives the scatter and the dependence of its samples,
//! and evidence as strong as that of a fault refuses the relation.

mod chambers;
pub mod flow;
mod friction;
mod kept;
mod long_run;
mod pieces;
mod refusal;
mod rows;
mod scatter;
mod spool;
mod supply;

use crate::survey::Ranking;
pub use refusal::{LEAST_TIME, ProcessRefusal};
pub use rows::{ProcessRow, ProcessRows};
pub use supply::SupplyRows;
use tertius_config::settings::{
    ChambersTable, CylinderProcess, FlowTable, FrictionTable, Settings, SpoolTable,
};

/// What was learnt of one cylinder.
#[derive(Clone, Debug)]
pub struct LearntProcess {
    /// Cylinder number, counted from 1.
    pub number: u8,
    /// `None` where the configuration names no spool.
    pub spool: Option<Result<SpoolTable, ProcessRefusal>>,
    /// `None` where the configuration does not name all three pressures.
    pub chambers: Option<Result<ChambersTable, ProcessRefusal>>,
    /// `None` where the configuration does not name the spool, the load pressure or the supply's. Without C2 it gives the
    /// rod's speed alone.
    pub flow: Option<Result<FlowTable, ProcessRefusal>>,
    /// `None` where the configuration does not name the load pressure.
    pub friction: Option<Result<FrictionTable, ProcessRefusal>>,
}

impl LearntProcess {
    /// The table, where there is one.
    pub fn table(&self, sample_time: f64) -> Option<CylinderProcess> {
        let spool = self.spool.as_ref().and_then(|it| it.as_ref().ok()).cloned();
        let chambers = self.chambers.as_ref().and_then(|it| it.as_ref().ok()).cloned();
        let flow = self.flow.as_ref().and_then(|it| it.as_ref().ok()).cloned();
        let friction = self.friction.as_ref().and_then(|it| it.as_ref().ok()).cloned();
        let any = spool.is_some() || chambers.is_some() || flow.is_some() || friction.is_some();
        any.then_some(CylinderProcess { sample_time, spool, chambers, flow, friction })
    }

    /// What was not learnt, and why.
    pub fn remarks(&self) -> Vec<String> {
        let refused = |what: &str, why: Option<&ProcessRefusal>| {
            why.map(|why| format!("no process detector by {what}: {why}"))
        };
        let of_spool = refused("the spool", self.spool.as_ref().and_then(|it| it.as_ref().err()));
        let of_chambers =
            refused("the pressures", self.chambers.as_ref().and_then(|it| it.as_ref().err()));
        let of_flow = refused("the flow", self.flow.as_ref().and_then(|it| it.as_ref().err()));
        let of_friction =
            refused("the friction", self.friction.as_ref().and_then(|it| it.as_ref().err()));
        of_spool.into_iter().chain(of_chambers).chain(of_flow).chain(of_friction).collect()
    }
}

impl ProcessRows {
    /// Whether `settings` name what a relation of a cylinder is made of.
    pub fn are_named(settings: &Settings) -> bool {
        has_spool(settings) || has_chambers(settings) || has_load(settings)
    }

    /// What the rows of all cylinders teach. They are taken in the order of the recording's
    /// `ranking`, so that the same files teach the same whichever came first; `gains` are a of (5-20)
    /// of each cylinder.
    pub fn learn(
        mut self,
        settings: &Settings,
        ranking: &Ranking,
        gains: &[f64],
    ) -> Vec<LearntProcess> {
        self.rank(ranking);
        let level = settings.process_level();
        let time = settings.machine.sample_time;
        let learn = |n: u8| LearntProcess {
            number: n,
            spool: has_spool(settings).then(|| spool::learn(self.of(n), time, level)),
            chambers: has_chambers(settings)
                .then(|| chambers::learn(self.of(n), has_spool(settings), time, level)),
            flow: has_flow(settings).then(|| {
                let geometry = [gains[usize::from(n) - 1], settings.machine.area_ratio];
                flow::learn(self.of(n), geometry, time, level)
            }),
            friction: has_load(settings).then(|| {
                let geometry = [gains[usize::from(n) - 1], settings.machine.area_ratio];
                friction::learn(self.of(n), geometry, time, level)
            }),
        };
        (1..=settings.machine.cylinders).map(learn).collect()
    }
}

impl SupplyRows {
    /// Whether `settings` name the supply's pressure.
    pub const fn are_named(settings: &Settings) -> bool {
        settings.signals.supply.is_some()
    }
}

const fn has_spool(settings: &Settings) -> bool {
    settings.signals.cylinder.spool.is_some()
}

const fn has_flow(settings: &Settings) -> bool {
    has_spool(settings) && has_load(settings) && settings.signals.supply.is_some()
}

const fn has_load(settings: &Settings) -> bool {
    let own = &settings.signals.cylinder;
    own.load_pressure.is_some() || own.pressure_bottom.is_some() && own.pressure_rod.is_some()
}

const fn has_chambers(settings: &Settings) -> bool {
    let own = &settings.signals.cylinder;
    let both = own.pressure_bottom.is_some() && own.pressure_rod.is_some();
    both && settings.signals.supply.is_some()
}
