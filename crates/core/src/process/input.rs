//! What a process detector takes of a cycle, and what each relation needs of it.

use super::flow::FlowSample;
use super::friction::ForceSample;
use crate::state::whole;
use crate::time::Timestamp;

/// Inputs of a cycle; `None` where nothing came.
#[derive(Clone, Copy, Debug)]
pub struct ProcessInput {
    /// u(k) as sent, m/s.
    pub command: Option<f64>,
    /// Position of the spool, in the unit of its signal.
    pub spool: Option<f64>,
    /// P_bot and P_rod, bar.
    pub chambers: [Option<f64>; 2],
    /// P_L as the machine sends it, and P_S, bar.
    pub load: Option<f64>,
    pub supply: Option<f64>,
    /// C1 and the corrected C2, m.
    pub lengths: [Option<f64>; 2],
    /// Whether the platform is in a monitored state.
    pub monitored: bool,
    /// C1 beyond what C2 has it at, m, where a calibration along the stroke tells.
    pub apart: Option<f64>,
    /// Whether C1 or C2 has no good reading in this cycle.
    pub is_lost: bool,
    /// Whether a transducer is under suspicion: what the controller then commands proves nothing.
    pub held: bool,
    /// Whether it is asked whose reading has moved.
    pub asked: bool,
    /// Whether it looks like a gain that is off.
    pub is_gain: bool,
    pub at: Timestamp,
}

/// What a cylinder tells of the supply in a cycle; `None` where nothing came.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OilReading {
    /// P_S, bar.
    pub pressure: Option<f64>,
    /// Length of its rod by C1, or else by the corrected C2, m; `None` while one of them is under suspicion or many of
    /// their readings are lost, since the controller may then take oil that no reading shows.
    pub length: Option<f64>,
}

whole! { OilReading { pressure, length } }

impl ProcessInput {
    /// Pressure of the supply and length of the rod; no length while the cylinder `is_held`.
    pub(super) fn oil(&self, is_held: bool) -> OilReading {
        let [c1, c2] = self.lengths;
        let length = c1.or(c2).filter(|_| !is_held);
        OilReading { pressure: self.supply, length }
    }

    /// What the balance of forces needs, beside [`Self::load`]; `None` without all of it. A single C1 stands for C2, too.
    pub(super) fn forces(&self, load: Option<f64>, is_pair: bool) -> Option<ForceSample> {
        let [c1, c2] = self.lengths;
        let c2 = if is_pair { c2 } else { c1 };
        Some(ForceSample { length: 0.5 * (c1? + c2?), load: load? })
    }

    /// What the balance of oil and rod needs, beside [`Self::load`]; `None` without the oil.
    pub(super) fn passage(&self, load: Option<f64>) -> Option<FlowSample> {
        let load = load?;
        let [c1, c2] = self.lengths;
        let (lengths, apart) = (c1.zip(c2).map(<[f64; 2]>::from), self.apart);
        Some(FlowSample { lengths, spool: self.spool?, load, supply: self.supply?, apart })
    }

    /// P_L as the machine sends it, or by the chambers' pressures on a cylinder with α of (3-5), bar.
    pub(super) fn load(&self, area_ratio: f64) -> Option<f64> {
        let [bottom, rod] = self.chambers;
        self.load.or_else(|| Some(bottom? - area_ratio * rod?))
    }
}
