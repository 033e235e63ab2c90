//! What all cylinders together know, and each allows for.

use super::Cylinder;
use crate::sequential::Apart;

impl Cylinder {
    /// Its sequential detector allows for C1 and C2 being sampled so far apart.
    pub fn allow(&mut self, apart: &Apart) {
        if let Some(sequential) = &mut self.sequential {
            sequential.allow(apart);
        }
    }

    /// Its sequential detector hears whether a noise of its own may be of the sampling.
    pub const fn hear(&mut self, may_be_timing: bool) {
        if let Some(sequential) = &mut self.sequential {
            sequential.hear(may_be_timing);
        }
    }
}
