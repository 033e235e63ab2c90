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

    /// See [`Flow::speed`].
    pub const fn speed(&self) -> Option<f64> {
        self.flow.speed()
    }

    pub fn forget(&mut self) {
        self.flow.reset();
        self.windows.clear();
        self.side.forget();
        self.was_held = false;
    }

    /// Forgets the blocks; the next one is evidence again.
    pub fn forget_evidence(&mut self) {
        self.windows.clear();
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
        let read = sample.filter(|it| it.lengths.is_some());
        let knows = |sample: &FlowSample| !of_gain || self.flow.design().knows(sample.supply);
        let known = read.filter(knows);
        if known.is_none() && (read.is_some() || !is_asked) {
            self.side.rest();
        }
        let oil = sample.map(|it| FlowSample { lengths: None, ..it });
        let block = self.flow.step(known.or(oil))?;
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
    /// to ask, or nothing does. Once the kind `is_known`, nothing else does that the newest blocks do not show, too: a
    /// fault that is over looks like another one.
    pub fn malfunction(&self, age: u32, is_known: bool) -> Option<(Malfunction, Option<f64>)> {
        let blocks = age / self.flow.block();
        let [often, until] = self.looks;
        if blocks == 0 || !blocks.is_multiple_of(often) || blocks > until {
            return None;
        }
        let width = (blocks as usize).min(self.windows.held());
        let FlowKind { direction, size } = self.windows.kind(&self.weighing, width)?;
        if is_known {
            let newest = self.windows.size(&self.weighing, often as usize, direction)?;
            if newest / size < ProcessParameters::DEFAULT.flow_lasting {
                return None;
            }
        }
        Some(match direction {
            Direction::Leakage | Direction::ValveLeakage => (Malfunction::Leakage, Some(size)),
            Direction::Null => (Malfunction::Null, Some(size / self.flow.design().slope())),
            Direction::DeadBand => (Malfunction::DeadBand, Some(size / self.flow.design().slope())),
            Direction::Gain | Direction::Pressing => (Malfunction::Unclassified, None),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{FlowBlock, FlowDesign};
    use super::*;
    use crate::process::Curve;
    use crate::process::parameters::DIRECTIONS;
    use alloc::vec;

    /// The way that a direction adds to a block, m for a size of 1 m/s.
    const WAY: f64 = 0.2;

    fn watch() -> FlowWatch {
        let scatter =
            core::array::from_fn(|i| core::array::from_fn(|j| if i == j { 4e-10 } else { 0.0 }));
        let design = FlowDesign {
            limit: 50.0,
            curve: Curve::new(50.0, vec![-0.5, 0.5]),
            taught: vec![true],
            between: 0.5,
            leakage: 0.0,
            compression: 0.0,
            area_ratio: 0.5,
            supplies: [0.0, f64::INFINITY],
            scatter: [scatter; 2],
        };
        FlowWatch::new(design, &ProcessParameters::DEFAULT, 0.02).expect("it is a covariance")
    }

    /// `count` blocks that leave a speed, m/s, and in which these directions occur.
    fn push(watch: &mut FlowWatch, count: u32, speed: f64, along: &[(Direction, f64)]) {
        for _ in 0..count {
            let mut directions = [0.0; DIRECTIONS];
            along.iter().for_each(|(direction, way)| directions[*direction as usize] = *way);
            watch.windows.push(&FlowBlock { left: [WAY * speed; 2], directions, parted: None });
        }
    }

    /// A null that had moved for half a minute: with the time after it, a wider dead band explains more.
    #[test]
    fn a_fault_that_is_over_is_not_called_another_one() {
        let mut watch = watch();
        let both = [(Direction::Null, WAY), (Direction::DeadBand, WAY)];
        push(&mut watch, 150, 4e-3, &both);
        assert!(watch.malfunction(1500, true).is_some(), "it lasts");
        push(&mut watch, 50, 0.0, &both[..1]);
        let found = watch.malfunction(2000, false);
        assert!(matches!(found, Some((Malfunction::DeadBand, Some(_)))), "{found:?}");
        assert_eq!(watch.malfunction(2000, true), None);
    }

    /// That of 1 % of the stroke by 40 % of it, which is 6 mm/s.
    #[test]
    fn a_dead_band_that_wanders_while_the_oil_warms_up_is_no_fault() {
        for (speed, is_fault) in [(6e-3, false), (-6e-3, false), (9e-3, true), (-9e-3, true)] {
            let mut watch = watch();
            push(&mut watch, 300, speed, &[(Direction::DeadBand, WAY)]);
            assert_eq!(watch.peak(20.0).width > 0, is_fault, "{speed}");
            let Some((Malfunction::DeadBand, Some(size))) = watch.malfunction(2000, false) else {
                panic!("something else explains {speed}");
            };
            assert!((size * watch.flow.design().slope() - speed).abs() < 1e-9, "{size}");
        }
    }

    #[test]
    fn a_leakage_below_zero_is_none() {
        for (speed, is_leakage) in [(5e-3, true), (-5e-3, false)] {
            let mut watch = watch();
            push(
                &mut watch,
                100,
                speed,
                &[(Direction::Leakage, WAY), (Direction::Gain, 0.3 * WAY)],
            );
            let (malfunction, _) = watch.malfunction(1000, false).expect("something explains it");
            assert_eq!(malfunction == Malfunction::Leakage, is_leakage, "{speed}");
        }
    }
}
