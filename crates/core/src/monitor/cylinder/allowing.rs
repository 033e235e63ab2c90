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
}
