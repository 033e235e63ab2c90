//! The least delay that any detector can have (Lorden 1971).
//!
//! Where samples are independent, a detector with a mean time of A samples between false alarms
//! needs at least ln A / D samples in the mean, D being the Kullback-Leibler divergence of a faulty
//! sample from a healthy one; where it changes from sample to sample, as many as add up to ln A.
//! Healthy residuals are taken as Gaussian with their own standard deviation.

use tertius_machine::inject::Shape;

/// Least mean delay in samples, not necessarily whole; `None` where the divergence does not depend
/// on the residual alone.
///
/// `deviation` in m; `evidence` is ln A, nats; `sample_time` in s.
pub fn bound(shape: &Shape, deviation: f64, evidence: f64, sample_time: f64) -> Option<f64> {
    match shape {
        Shape::Step { size } => Some(evidence / shifted(*size, deviation)),
        Shape::Noise { size } => Some(evidence / noisy(*size, deviation)),
        Shape::Drift { rate } => Some(drifting(rate * sample_time / deviation, evidence)),
        _ => None,
    }
}

/// Divergence of a sample that is off by `size`, nats.
fn shifted(size: f64, deviation: f64) -> f64 {
    0.5 * (size / deviation).powi(2)
}

/// Samples that a drift of `slope` deviations a sample needs: Σ (slope k)²/2 reaches the evidence.
fn drifting(slope: f64, evidence: f64) -> f64 {
    let mut sum = 0.0;
    for k in 1..10_000_000_u32 {
        let more = 0.5 * (slope * f64::from(k)).powi(2);
        if sum + more >= evidence {
            return f64::from(k - 1) + (evidence - sum) / more;
        }
        sum += more;
    }
    f64::INFINITY
}

/// Divergence of a sample with noise (5-17), nats: −size, 0 or size, each in a third of the cases.
fn noisy(size: f64, deviation: f64) -> f64 {
    let s = size / deviation;
    let normal = |z: f64| (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt();
    // ∫ f ln(f/g): a sum with a hundred points a deviation.
    let (step, reach) = (0.01, s + 9.0);
    let points = (2.0 * reach / step) as u32;
    let part = |i: u32| {
        let z = step.mul_add(f64::from(i), -reach);
        let faulty = (normal(z - s) + normal(z) + normal(z + s)) / 3.0;
        // ln g is taken as it is: g itself vanishes far out.
        let healthy = -0.5 * z * z - 0.5 * std::f64::consts::TAU.ln();
        if faulty > 0.0 { faulty * (faulty.ln() - healthy) } else { 0.0 }
    };
    step * (0..=points).map(part).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEVIATION: f64 = 8.2e-5;

    fn seconds(shape: Shape) -> f64 {
        0.02 * bound(&shape, DEVIATION, 22.97, 0.02).expect("it has one")
    }

    #[test]
    fn a_step_needs_twice_the_evidence_by_its_square() {
        let expected = 0.02 * 2.0 * 22.97 * (DEVIATION / 2.5e-4).powi(2);
        assert!((seconds(Shape::Step { size: 2.5e-4 }) - expected).abs() < 1e-12);
    }

    /// Σ k² ≈ n³/3.
    #[test]
    fn a_drift_needs_the_cube_root() {
        let expected = 0.02 * (6.0 * 22.97 * (DEVIATION / 2e-7).powi(2)).cbrt();
        let found = seconds(Shape::Drift { rate: 1e-5 });
        assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
        // So fast that the first sample is more than enough.
        assert!(seconds(Shape::Drift { rate: 1.0 }) < 0.02);
    }

    /// scipy.integrate.quad of the same densities.
    #[test]
    fn noise_is_integrated() {
        for (sigmas, nats) in NOISE {
            let found = noisy(sigmas * DEVIATION, DEVIATION);
            assert!((found / nats - 1.0).abs() < 1e-6, "{sigmas}: {found} for {nats}");
        }
    }

    const NOISE: [(f64, f64); 3] =
        [(0.5, 0.006278453220079751), (2.0, 0.7141888482251981), (10.0, 32.23472219555318)];
}
