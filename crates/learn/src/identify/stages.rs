//! Estimators and validators of all cylinders, as surveyors.

use super::{Estimator, Validator};
use crate::survey::{Row, Surveyor};

/// One surveyor for each cylinder, by its number less one; `None` where it is not needed.
#[derive(Clone, Debug)]
pub struct Each<T>(pub Vec<Option<T>>);

impl<T> Each<T> {
    fn of(&mut self, cylinder: u8) -> Option<&mut T> {
        self.0.get_mut(usize::from(cylinder).checked_sub(1)?)?.as_mut()
    }
}

impl Surveyor for Each<Estimator> {
    fn row(&mut self, row: &Row) {
        if let Some(estimator) = self.of(row.cylinder) {
            estimator.row(row);
        }
    }

    fn gap(&mut self, cylinder: u8) {
        if let Some(estimator) = self.of(cylinder) {
            estimator.gap();
        }
    }
}

impl Surveyor for Each<Validator> {
    fn row(&mut self, row: &Row) {
        if let Some(validator) = self.of(row.cylinder) {
            validator.row(row);
        }
    }

    fn gap(&mut self, cylinder: u8) {
        if let Some(validator) = self.of(cylinder) {
            validator.gap();
        }
    }
}
