//! Response of the innovation to a fault of one reading.

use nalgebra::Vector3;
use tertius_core::observe::observer::ObserverDesign;

/// The innovation after a unit step of the position reading, cycle by cycle:
/// e(k+1) = (A − L C) e(k) − L f(k), ν(k) = C e(k) + f(k), without a fault of the velocity.
pub fn step(design: &ObserverDesign, cycles: usize) -> Vec<f64> {
    respond(design, std::iter::repeat_n(1.0, cycles))
}

/// The innovation after `faults` of the position reading.
pub fn respond(design: &ObserverDesign, faults: impl IntoIterator<Item = f64>) -> Vec<f64> {
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

/// Onsets of an incipient fault between two readings, parts of a cycle.
const ONSETS: [f64; 4] = [0.0, 0.25, 0.5, 0.75];

/// The largest innovation, m, within `cycles` of the first reading after an incipient fault φ (1 −
/// (1 + b)^−t) (5-18) has begun, where `fault` is (φ, b), φ in m and t in s. It is averaged over
/// the onset within a cycle of `sample_time` seconds, since an observer that follows sees the fault
/// best when it begins with a reading.
pub fn incipient(
    design: &ObserverDesign,
    (size, b): (f64, f64),
    sample_time: f64,
    cycles: usize,
) -> f64 {
    let peak = |onset: f64| {
        let since = |k: usize| (k as f64 - onset).max(0.0) * sample_time;
        let faults = (0..=cycles).map(|k| size * (1.0 - (1.0 + b).powf(-since(k))));
        let innovations = respond(design, faults);
        innovations.iter().fold(0.0_f64, |peak, innovation| peak.max(innovation.abs()))
    };
    ONSETS.map(peak).iter().sum::<f64>() / ONSETS.len() as f64
}

/// Cycles after which the response to a unit step stays below a tenth; `most` where it takes longer.
pub fn settled(design: &ObserverDesign, most: usize) -> usize {
    let response = step(design, most);
    response.iter().rposition(|value| value.abs() >= 0.1).map_or(0, |last| last + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tertius_core::observe::model::Model;

    /// The response is the difference of two observers side by side, one of which has a faulty
    /// reading.
    #[test]
    fn a_response_is_what_two_observers_differ_by() {
        use tertius_core::observe::observer::{Measurement, Observer};
        let theta = [-0.0101, -0.1231, -1.6891e-5, -10.7104, -0.0023];
        let model = Model::new(0.02, theta, [0.0926, 6.5427]);
        let design = ObserverDesign::new(&model, [1e-8, 1e-3, 100.0], [1e-8, 1e-2], true, 0, 0)
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

    /// Against SciPy's `solve_discrete_are` and a loop of its own: with onset on a reading, a quarter, a half and
    /// three quarters of a cycle before one the observer of the thesis's weights leaves 0.964, 0.724, 0.617
    /// and 0.790 mm of Type III.
    #[test]
    fn an_incipient_fault_leaves_what_an_observer_made_elsewhere_does() {
        use tertius_core::observe::model::Model;
        let theta = [-0.0101, -0.1231, -1.6891e-5, -10.7104, -0.0023];
        let model = Model::new(0.02, theta, [0.0926, 6.5427]);
        for (q, r, expected, over) in [
            ([1e-8, 1e-3, 100.0], [1e-8, 1e-2], 0.773_883_6e-3, 2),
            ([5e-9, 2e-4, 1e4], [1e-8, 5.0], 0.773_681_3e-3, 3),
            ([1e-8, 3e-5, 2e3], [1e-8, 1.0], 0.845_820_9e-3, 4),
        ] {
            let design = ObserverDesign::new(&model, q, r, true, 0, 0).expect("it has an observer");
            let left = incipient(&design, (0.07, 1.0), 0.02, 5);
            assert!((left - expected).abs() < 1e-9, "{left} {expected}");
            assert_eq!(settled(&design, 50), over);
        }
    }
}
