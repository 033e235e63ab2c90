//! Whether a recording is too short to calibrate a cylinder, which is then not said to be unhealthy.

use super::taught::Taught;
use tertius_learn::calibrate::{ENOUGH, too_short};

impl Taught {
    /// Longest judged time, s, of the cylinders that are refused, if all of them are because the recording is too short.
    fn too_short(&self) -> Option<f64> {
        let refused = self.refused_cylinders();
        let cylinders = self.calibration.iter().flat_map(|it| &it.cylinders);
        let short = cylinders.filter(|it| refused.contains(&it.number));
        let judged: Option<Vec<f64>> = short.map(|it| it.contradiction?.too_short()).collect();
        judged?.into_iter().reduce(f64::max)
    }

    /// Whether any of the `cylinders` is left that thresholds can be tuned to.
    ///
    /// # Errors
    /// All of them are refused, with the reason where they have one in common.
    pub(super) fn any_left(&self, cylinders: u8) -> Result<(), String> {
        if self.refused_cylinders().len() < usize::from(cylinders) {
            return Ok(());
        }
        Err(self.told_too_short().unwrap_or_else(|| "every cylinder is refused".to_owned()))
    }

    /// Whether cylinders are refused because the recording is too short, and it has not half of the time that it needs. Of
    /// three minutes one half contradicts the other in two to five cylinders of six, and not in the others by chance.
    pub(super) fn is_far_too_short(&self) -> bool {
        self.too_short().is_some_and(|seconds| seconds < 0.5 * ENOUGH)
    }

    /// That the recording is too short, with how long it has to be, if that is why cylinders are refused.
    pub(super) fn told_too_short(&self) -> Option<String> {
        self.too_short().map(too_short)
    }
}
