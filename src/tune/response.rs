//! What a fault of one reading leaves in the innovation.

use crate::observe::observer::Design;
use nalgebra::Vector3;

/// The innovation after a unit step of the position reading, cycle by cycle:
/// e(k+1) = (A − L C) e(k) − L f(k), ν(k) = C e(k) + f(k), without a fault of the velocity.
pub fn step(design: &Design, cycles: usize) -> Vec<f64> {
    respond(design, std::iter::repeat_n(1.0, cycles))
}

/// The innovation after `faults` of the position reading.
pub fn respond(design: &Design, faults: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut error: Vector3<f64> = Vector3::zeros();
    let one = |fault: f64| {
        let position = error[0] + fault;
        // A velocity that is not measured has no gain.
        let velocity = error[1];
        error = design.a * error - design.l.column(0) * position - design.l.column(1) * velocity;
        position
    };
    faults.into_iter().map(one).collect()
}

/// Cycles after which the response to a unit step stays below a tenth; `most` where it takes longer.
pub fn settled(design: &Design, most: usize) -> usize {
    let response = step(design, most);
    response.iter().rposition(|value| value.abs() >= 0.1).map_or(0, |last| last + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observe::model::Model;

    /// The same as two observers side by side, one on a faulty reading.
    #[test]
    fn a_response_is_what_two_observers_differ_by() {
        use crate::observe::observer::{Measurement, Observer};
        let theta = [-0.0101, -0.1231, -1.6891e-5, -10.7104, -0.0023];
        let model = Model::new(0.02, theta, [0.0926, 6.5427]);
        let design = Design::new(&model, [1e-8, 1e-3, 100.0], [1e-8, 1e-2], true, 0, 0)
            .expect("Table 4-1 has an observer");
        let expected = step(&design, 12);
        let mut observers = [Observer::new(design.clone()), Observer::new(design.clone())];
        for k in 0..32 {
            let t = f64::from(k) * 0.02;
            let fault = if k < 20 { 0.0 } else { 1e-3 };
            let [healthy, faulty] = [0.0, fault].map(|fault| Measurement {
                position: 0.3 * t.sin() + fault,
                velocity: Some(0.3 * t.cos()),
            });
            let of = |observer: &mut Observer, measurement| {
                observer.step(Some(measurement), Some(0.3 * t.cos())).0.expect("it runs").residual
            };
            let difference = of(&mut observers[1], faulty) - of(&mut observers[0], healthy);
            let response = if k < 20 { 0.0 } else { expected[k as usize - 20] };
            assert!((difference - 1e-3 * response).abs() < 1e-12, "{k}: {difference}");
        }
        assert_eq!(settled(&design, 50), 2);
    }
}
