//! What each cylinder takes over from all cylinders together.

use super::Cylinder;
use crate::sequential::Apart;

impl Cylinder {
    /// Makes the sequential detector allow for the time between the samples of C1 and C2.
    pub fn allow(&mut self, apart: &Apart) {
        if let Some(sequential) = &mut self.sequential {
            sequential.allow(apart);
        }
    }

    /// Tells the sequential detector whether a noise on its cylinder may come from the sampling.
    pub const fn hear(&mut self, may_be_timing: bool) {
        if let Some(sequential) = &mut self.sequential {
            sequential.hear(may_be_timing);
        }
    }
}
