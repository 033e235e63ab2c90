//! The estimated length, carried on by the command alone.

use crate::state::whole;
use nalgebra::{Matrix3, Vector3};

/// An estimated state, and its prediction since.
#[derive(Clone, Copy, Debug)]
pub struct Carrier {
    pub x: Vector3<f64>,
    /// Variance of the length when it was last read, m².
    pub variance: f64,
    /// Cycles since the last reading.
    pub coasted: u32,
    /// Whether the velocity has settled, too.
    pub able: bool,
}

whole! { Carrier { x, variance, coasted, able } }

impl Carrier {
    /// Predicts the next cycle; `None` if a number is no longer finite.
    pub fn predicted(self, a: &Matrix3<f64>, part: &Vector3<f64>) -> Option<Self> {
        let x = a * self.x + part;
        let coasted = self.coasted.saturating_add(1);
        x.iter().all(|value| value.is_finite()).then_some(Self { x, coasted, ..self })
    }
}

/// Earlier carriers. The older one does not include what a transducer read within the second or two
/// before it was blamed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reserve {
    younger: Option<Carrier>,
    older: Option<Carrier>,
}

whole! { Reserve { younger, older } }

impl Reserve {
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Takes a state estimated while no transducer was blamed.
    pub fn offer(&mut self, carrier: Carrier, apart: u32) {
        if self.younger.is_none_or(|younger| younger.coasted >= apart) {
            (self.older, self.younger) = (self.younger, Some(carrier));
        }
    }

    pub fn predict(&mut self, a: &Matrix3<f64>, part: &Vector3<f64>) {
        let ahead = |carrier: Option<Carrier>| carrier.and_then(|it| it.predicted(a, part));
        (self.younger, self.older) = (ahead(self.younger), ahead(self.older));
    }

    /// The older of the two carriers.
    pub const fn get(&self) -> Option<Carrier> {
        self.older
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const APART: u32 = 50;

    #[test]
    fn the_reserve_is_of_one_to_two_seconds_ago_and_goes_on() {
        let mut reserve = Reserve::default();
        let part = Vector3::new(1.0, 0.0, 0.0);
        for k in 0..1000 {
            let x = Vector3::new(f64::from(k), 0.0, 0.0);
            reserve.offer(Carrier { x, variance: 1.0, coasted: 0, able: true }, APART);
            match reserve.get() {
                None => assert!(k < APART),
                Some(kept) => {
                    assert!((APART..2 * APART + 1).contains(&kept.coasted), "{}", kept.coasted);
                    assert_eq!(kept.x[0], f64::from(k));
                }
            }
            reserve.predict(&Matrix3::identity(), &part);
        }
        (0..300).for_each(|_| reserve.predict(&Matrix3::identity(), &part));
        assert!(reserve.get().is_some_and(|kept| kept.coasted > 300 && kept.x[0] == 1300.0));
    }
}
