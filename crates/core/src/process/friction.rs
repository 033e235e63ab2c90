//! Friction of the rod, by the pressure that has to overcome it.
//!
//! P_L = P₀ + c₁ l + c₂ v̇ + c₃ v + c₄ tanh(v/v₀) in the means over blocks of cycles: the balance of forces (3-9) with
//! the friction (3-13) over the piston's area, the c being learnt. The load P₀ moves on slowly with the machine's pose, so that
//! of pressures and terms only what is faster than some seconds counts. Coulomb's friction c₄ is the one that tells of
//! worn seals and a bent rod; the viscous one comes and goes with the oil's temperature.

mod design;
mod evidence;
mod forces;

use super::parameters::ProcessParameters;
use crate::sequential::statistic::Peak;
use crate::state::state;
use crate::time;
pub use design::{FrictionBlock, FrictionDesign, SCATTERS};
pub use evidence::{FrictionWeighing, FrictionWindows};
pub use forces::{FORCE_TERMS, ForceBlock, ForceSample, Forces};

/// The friction of one rod, watched: cycles in, evidence out.
#[derive(Clone, Debug)]
pub struct FrictionWatch {
    design: FrictionDesign,
    forces: Forces,
    windows: FrictionWindows,
    weighing: FrictionWeighing,
    /// Blocks after which its size is sought anew, and after which it stands.
    looks: [u32; 2],
}

state! {
    FrictionWatch { forces, windows }
    but { design, weighing, looks }
}

impl FrictionWatch {
    /// `None` if the scatter of `design` is no covariance.
    pub fn new(design: FrictionDesign, by: &ProcessParameters, sample_time: f64) -> Option<Self> {
        let weighing = FrictionWeighing::new(&design)?;
        let forces = Forces::new(sample_time);
        let blocks = |seconds| (time::cycles(seconds, sample_time) / forces.block()).max(1);
        let looks = by.flow_looks.map(blocks);
        Some(Self { design, forces, windows: FrictionWindows::default(), weighing, looks })
    }

    /// Cycles of a block.
    pub const fn block(&self) -> u32 {
        self.forces.block()
    }

    /// Whether the newest cycle belongs to a block that will be judged.
    pub const fn is_judging(&self) -> bool {
        self.forces.is_settled()
    }

    pub fn forget(&mut self) {
        self.forces.reset();
        self.windows.clear();
    }

    /// Forgets the blocks; the next one is evidence again.
    pub fn forget_evidence(&mut self) {
        self.windows.clear();
    }

    /// Takes a cycle; `None` without all of it. Returns whether another block is judged with it.
    pub fn step(&mut self, sample: Option<ForceSample>) -> bool {
        let Some(block) = self.forces.step(sample) else { return false };
        self.windows.push(&self.design.block(&block), &self.weighing);
        true
    }

    /// See [`FrictionWindows::peak`].
    pub fn peak(&self) -> Peak {
        self.windows.peak(&self.weighing)
    }

    /// See [`FrictionWindows::peak_in_turn`].
    pub fn peak_in_turn(&self) -> Peak {
        self.windows.peak_in_turn(&self.weighing)
    }

    /// The friction that has come since an alarm was raised `age` cycles ago, bar; `None` where it is not the time to ask.
    pub fn size(&self, age: u32) -> Option<f64> {
        let blocks = age / self.forces.block();
        let [often, until] = self.looks;
        if blocks == 0 || !blocks.is_multiple_of(often) || blocks > until {
            return None;
        }
        self.windows.size(&self.weighing, blocks as usize)
    }
}
