//! Rod and oil of one cylinder, watched: blocks in, evidence out.

use super::super::alarm::Malfunction;
use super::super::parameters::ProcessParameters;
use super::directions::Direction;
use super::{Flow, FlowDesign, FlowKind, FlowSample, FlowSide, FlowWeighing, FlowWindows};
use crate::sequential::statistic::Peak;
use crate::state::state;
use crate::time;

/// The balance of oil and rod, with its newest blocks and by what their evidence is weighed.
#[derive(Clone, Debug)]
pub struct FlowWatch {
    flow: Flow,
    windows: FlowWindows,
    side: FlowSide,
    /// Whether a transducer was under suspicion in the cycle before.
    was_held: bool,
    weighing: FlowWeighing,
    /// Blocks after which a kind is sought anew, and after which it stands.
    looks: [u32; 2],
}

state! {
    FlowWatch { flow, windows, side, was_held }
    but { weighing, looks }
}

impl FlowWatch {
    /// `None` if the scatter of `design` is no covariance.
    pub fn new(design: FlowDesign, by: &ProcessParameters, sample_time: f64) -> Option<Self> {
        let weighing = FlowWeighing::new(&design)?;
        let flow = Flow::new(design, sample_time);
        let looks =
            by.flow_looks.map(|seconds| (time::cycles(seconds, sample_time) / flow.block()).max(1));
        let side = FlowSide::new(f64::from(flow.block()) * sample_time);
        Some(Self { flow, windows: FlowWindows::default(), side, was_held: false, weighing, looks })
    }

    /// Cycles of a block.
    pub const fn block(&self) -> u32 {
        self.flow.block()
    }

    /// Whether the newest cycle was judged.
    pub fn is_judging(&self) -> bool {
        self.flow.is_judging()
    }

    pub fn forget(&mut self) {
        self.flow.reset();
        self.windows.clear();
        self.side.forget();
        self.was_held = false;
    }

    /// Takes a cycle; `None` without all of it. Returns whether a block was completed with it.
    #[inline]
    pub fn step(&mut self, sample: Option<FlowSample>) -> bool {
        if self.was_held {
            // A block is either before or after.
            self.flow.reset();
            self.was_held = false;
        }
        let Some(block) = self.flow.step(sample) else { return false };
        self.windows.push(&block);
        self.side.learn(&block);
        true
    }

    /// Takes a cycle in which a transducer is under suspicion, which proves nothing of the hydraulics. If it `is_asked`
    /// whose reading has moved, returns the evidence of it; see [`FlowSide::weigh`]. Until then what cannot be read ends
    /// what is remembered. At a P_S far from what was taught f may be off by as much as a gain is, so that there it says
    /// nothing `of_gain`.
    pub fn step_held(
        &mut self,
        sample: Option<FlowSample>,
        is_asked: bool,
        of_gain: bool,
    ) -> Option<f64> {
        self.was_held = true;
        self.windows.clear();
        let knows = |sample: &FlowSample| !of_gain || self.flow.design().knows(sample.supply);
        let known = sample.filter(knows);
        if known.is_none() && (sample.is_some() || !is_asked) {
            self.side.rest();
        }
        let block = self.flow.step(known)?;
        self.side.weigh(&block, is_asked)
    }

    /// See [`FlowWindows::peak`].
    pub fn peak(&self, least: f64) -> Peak {
        self.windows.peak(&self.weighing, least)
    }

    /// See [`FlowWindows::peak_in_turn`].
    pub fn peak_in_turn(&self, least: f64) -> Peak {
        self.windows.peak_in_turn(&self.weighing, least)
    }

    /// What explains the oil and the rod since an alarm was raised `age` cycles ago; `None` where it is not the time
    /// to ask, or nothing does.
    pub fn malfunction(&self, age: u32) -> Option<(Malfunction, Option<f64>)> {
        let blocks = age / self.flow.block();
        let [often, until] = self.looks;
        if blocks == 0 || !blocks.is_multiple_of(often) || blocks > until {
            return None;
        }
        let width = (blocks as usize).min(self.windows.held());
        let FlowKind { direction, size } = self.windows.kind(&self.weighing, width)?;
        Some(match direction {
            Direction::Leakage | Direction::ValveLeakage => (Malfunction::Leakage, Some(size)),
            Direction::Null => (Malfunction::Null, Some(size / self.flow.design().slope())),
            Direction::DeadBand => (Malfunction::DeadBand, None),
            Direction::Gain | Direction::Pressing => (Malfunction::Unclassified, None),
        })
    }
}
