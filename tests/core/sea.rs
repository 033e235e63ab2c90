//! The sea and the vessel: that they are what their numbers say.

use nalgebra::{Complex, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use tertius::hexapod::Pose;
use tertius::sea::{Response, Sea, SeaError, Spectrum, Vessel};
use tertius::simulator::{Machine, MachineError, Options, Tables};

const SAMPLE_TIME: f64 = 0.02;

fn random(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// A cork: it heaves with the water and does nothing else.
fn cork() -> Vessel {
    let still = Response { gain: 0.0, natural_period: 1.0, damping: 1.0, phase: 0.0 };
    let heave = Response { gain: 1.0, natural_period: 0.1, ..still };
    Vessel { surge: still, sway: still, heave, roll: still, pitch: still, yaw: still }
}

fn sea(height: f64, period: f64, seed: u64) -> Sea {
    let spectrum = Spectrum::new(height, period, 3.3).expect("such a sea can be");
    Sea::new(&spectrum, &Tables::default().vessel, SAMPLE_TIME, &mut random(seed))
}

fn deviation(numbers: &[f64]) -> f64 {
    let mean = numbers.iter().sum::<f64>() / numbers.len() as f64;
    let square = numbers.iter().map(|number| (number - mean).powi(2)).sum::<f64>();
    (square / numbers.len() as f64).sqrt()
}

/// Hs is four times the standard deviation of the elevation.
#[test]
fn the_waves_have_the_significant_height_that_was_asked_for() {
    for (height, seed) in [(1.0, 1), (2.5, 2), (6.0, 3)] {
        let mut sea = sea(height, 9.0, seed);
        let elevations: Vec<f64> = (0..500_000)
            .map(|_| {
                sea.advance();
                sea.elevation()
            })
            .collect();
        let found = 4.0 * deviation(&elevations);
        assert!((found / height - 1.0).abs() < 0.02, "{found} of {height} m");
    }
}

/// Where most of the energy is, by the components; and the JONSWAP peak is 3.3 times Pierson and
/// Moskowitz's.
#[test]
fn the_spectrum_peaks_at_its_period_and_is_peaked() {
    let spectrum = Spectrum::new(2.0, 8.0, 3.3).expect("such a sea can be");
    let peak = std::f64::consts::TAU / 8.0;
    let best = (1..4000)
        .map(|step| f64::from(step) * 1e-3)
        .max_by(|a, b| spectrum.shape(*a).total_cmp(&spectrum.shape(*b)));
    assert!((best.expect("there are some") - peak).abs() < 2e-3, "{best:?} {peak}");
    let flat = Spectrum::new(2.0, 8.0, 1.0).expect("such a sea can be");
    assert!((spectrum.shape(peak) / flat.shape(peak) - 3.3).abs() < 1e-12);
    let components = spectrum.components(&mut random(5));
    let near = components.iter().filter(|one| (one.frequency / peak - 1.0).abs() < 0.2).count();
    assert!((15..30).contains(&near), "{near} of {} within a fifth", components.len());
    let energy: f64 = components.iter().map(|one| one.amplitude.powi(2) / 2.0).sum();
    assert!((energy - 4.0 / 16.0).abs() < 1e-12, "m0 is Hs²/16: {energy}");
}

#[test]
fn a_cork_rides_the_waves_and_stays_upright() {
    let spectrum = Spectrum::new(2.0, 8.0, 3.3).expect("such a sea can be");
    let mut sea = Sea::new(&spectrum, &cork(), SAMPLE_TIME, &mut random(6));
    for _ in 0..5000 {
        sea.advance();
        let pose = sea.motion().pose;
        // Its free motion of 0.1 s is far above the waves.
        assert!((pose.translation.z - sea.elevation()).abs() < 0.05, "{pose:?}");
        assert_eq!(pose.attitude, Vector3::zeros());
    }
}

/// The answer of a mass on a spring in a wave, by its own equation of motion.
#[test]
fn a_response_is_that_of_a_damped_oscillator() {
    let response = Response { gain: 0.7, natural_period: 6.0, damping: 0.3, phase: 0.0 };
    let natural = std::f64::consts::TAU / 6.0;
    for frequency in [0.2, 0.8, 1.05, 1.6, 4.0] {
        // ẍ + 2ζω₀ẋ + ω₀²x = gain ω₀² e^iωt.
        let i = Complex::new(0.0, frequency);
        let x = response.at(frequency);
        let left = i * i * x + i * x * (2.0 * 0.3 * natural) + x * natural * natural;
        assert!((left - Complex::from(0.7 * natural * natural)).norm() < 1e-12, "{left}");
    }
}

#[test]
fn rates_and_accelerations_are_the_derivatives_of_the_pose() {
    let mut sea = sea(2.5, 8.0, 7);
    // Over several of the refreshes from the time itself.
    let mut before = sea.motion();
    sea.advance();
    let mut now = sea.motion();
    for _ in 0..5000 {
        sea.advance();
        let after = sea.motion();
        let slope = (after.pose.translation - before.pose.translation) / (2.0 * SAMPLE_TIME);
        assert!((slope - now.rate.translation).norm() < 1e-3, "{slope}");
        let slope = (after.pose.attitude - before.pose.attitude) / (2.0 * SAMPLE_TIME);
        assert!((slope - now.rate.attitude).norm() < 1e-4, "{slope}");
        let slope = (after.rate.translation - before.rate.translation) / (2.0 * SAMPLE_TIME);
        assert!((slope - now.acceleration.translation).norm() < 3e-3, "{slope}");
        (before, now) = (now, after);
    }
}

#[test]
fn a_deviation_foretold_is_the_one_that_comes() {
    let mut sea = sea(2.5, 8.0, 8);
    let measure = |pose: &Pose| pose.translation.z + 2.0 * pose.attitude[1];
    let foretold = sea.deviation(measure);
    let seen: Vec<f64> = (0..500_000)
        .map(|_| {
            sea.advance();
            measure(&sea.motion().pose)
        })
        .collect();
    assert!((deviation(&seen) / foretold - 1.0).abs() < 0.03, "{} {foretold}", deviation(&seen));
}

#[test]
fn a_seed_is_a_sea_and_another_seed_another() {
    let after = |seed| {
        let mut sea = sea(2.0, 8.0, seed);
        (0..100).for_each(|_| sea.advance());
        sea.motion()
    };
    assert_eq!(after(1), after(1));
    assert_ne!(after(1), after(2));
}

#[test]
fn a_sea_that_cannot_be_is_refused() {
    assert_eq!(Spectrum::new(-1.0, 8.0, 3.3), Err(SeaError::Height(-1.0)));
    assert!(matches!(Spectrum::new(f64::NAN, 8.0, 3.3), Err(SeaError::Height(_))));
    assert_eq!(Spectrum::new(2.0, 0.5, 3.3), Err(SeaError::Period(0.5)));
}

/// The workspace is ±1 m: a sea beyond it is refused, and in one just below the strokes stay within.
#[test]
fn the_strokes_stay_within_the_workspace() {
    let machine = |height: f64| {
        let sea = Some([height, 8.0]);
        Machine::new(&Tables::default(), SAMPLE_TIME, &Options { sea, ..Options::default() })
    };
    let roughest =
        (10..80).map(|tenth| f64::from(tenth) / 10.0).take_while(|h| machine(*h).is_ok());
    let roughest = roughest.last().expect("1 m is no sea to speak of");
    assert!((2.5..5.0).contains(&roughest), "{roughest} m");
    let Err(MachineError::Rough { stroke, limit, .. }) = machine(roughest + 0.2) else {
        panic!("it is too rough");
    };
    assert!(stroke > limit && stroke < 1.2 * limit, "{stroke} m");
    let mut machine = machine(roughest).expect("just calm enough");
    let mut largest = 0.0_f64;
    for _ in 0..30_000 {
        let sample = machine.sample();
        let mut readings = tertius::controller::Readings {
            pressures: sample.load_pressures,
            pose: sample.motion.pose,
            rate: sample.motion.rate,
            ..Default::default()
        };
        readings.lengths = sample.transducers.map(|[c1, _]| c1.length);
        readings.speeds = sample.transducers.map(|[c1, _]| c1.speed);
        machine.command(&readings);
        machine.advance();
        largest = machine.states().iter().map(|state| state.length.abs()).fold(largest, f64::max);
    }
    assert!((0.6..=1.05).contains(&largest), "{largest} m");
}
