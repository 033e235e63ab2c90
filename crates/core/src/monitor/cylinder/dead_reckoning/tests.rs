//! Dead reckoning of a rod in a swell.

use super::*;

static PARAMETERS: VerdictParameters = VerdictParameters::DEFAULT;

impl DeadReckoning {
    /// Takes a cycle, which is calm unless a transducer is `alone`.
    fn tick(
        &mut self,
        readings: [Option<f64>; 2],
        velocity: Option<f64>,
        alone: Option<usize>,
    ) -> Option<CourseError> {
        let is_tick = self.begin();
        let error = is_tick.then(|| self.judge(readings, alone, alone.is_none())).flatten();
        self.end(velocity);
        error
    }
}

/// A rod in a swell of 10 s, of which dead reckoning does not know a part of the speed.
struct Swell {
    reckoning: DeadReckoning,
    length: f64,
    cycle: u32,
    unknown: f64,
}

impl Swell {
    fn new(unknown: f64) -> Self {
        let reckoning = DeadReckoning::new(&PARAMETERS, 0.02, 0.01);
        Self { reckoning, length: 0.0, cycle: 0, unknown }
    }

    /// Goes on for some seconds with an error of the reading; returns when that was found, s, and the finding.
    fn go(
        &mut self,
        seconds: f64,
        alone: Option<usize>,
        error: impl Fn(f64) -> f64,
    ) -> Option<(f64, CourseError)> {
        let mut found = None;
        for k in 0..(seconds / 0.02) as u32 {
            let angle = f64::from(self.cycle) * 0.02 * core::f64::consts::TAU / 10.0;
            let (velocity, after) = (0.2 * angle.cos(), 0.02 * f64::from(k));
            let readings = [Some(self.length + error(after)); 2];
            let error = self.reckoning.tick(readings, Some(velocity), alone);
            found = found.or(error.map(|it| (after, it)));
            self.length += 0.02 * (velocity * (1.0 + self.unknown));
            self.cycle += 1;
        }
        found
    }
}

#[test]
fn a_drift_of_the_last_transducer_departs_from_it() {
    for (rate, latest) in [(0.05, 1.1), (-0.02, 2.1), (0.004, 6.1)] {
        let mut swell = Swell::new(0.01);
        assert_eq!(swell.go(600.0, None, |_| 0.0), None);
        let (after, departure) = swell.go(60.0, Some(1), |t| rate * t).expect("it is found");
        assert!(after < latest, "{rate}: {after}");
        let (error, so_far) = (departure.error, rate * after);
        assert!((error - so_far).abs() < 0.5 * so_far.abs(), "{rate}: {error} of {so_far}");
    }
}

#[test]
fn what_is_usual_is_none_however_much_faster_the_rod_goes() {
    let mut swell = Swell::new(0.02);
    assert_eq!(swell.go(600.0, None, |_| 0.0), None);
    assert_eq!(swell.go(600.0, Some(0), |_| 0.0), None);
    let (mut length, mut found) = (swell.length, None);
    for k in 0..30_000_u32 {
        let velocity = 1.2 * (f64::from(k) * 0.02 * core::f64::consts::TAU / 10.0).cos();
        found = found.or(swell.reckoning.tick([Some(length), None], Some(velocity), Some(0)));
        length += 0.02 * velocity * 1.02;
    }
    assert_eq!(found, None);
}

#[test]
fn a_wild_reading_at_a_tick_is_none() {
    let mut swell = Swell::new(0.01);
    assert_eq!(swell.go(600.0, None, |_| 0.0), None);
    // The reading of each 24th cycle ends a tick.
    let wild = |t: f64| f64::from(u8::from((t - 10.48).abs() < 1e-6)) * 0.3;
    assert_eq!(swell.go(120.0, Some(0), wild), None);
    let lasting = |t: f64| f64::from(u8::from((10.48..11.0).contains(&t))) * 0.3;
    assert!(swell.go(120.0, Some(0), lasting).is_some(), "the same for two ticks");
}

/// Without lessons nothing is judged, and a rod that moves while its way is not known makes no error.
#[test]
fn without_lessons_or_a_way_nothing_is_found() {
    let mut swell = Swell::new(0.01);
    assert_eq!(swell.go(600.0, Some(0), |t| 0.05 * t), None);
    let mut swell = Swell::new(0.01);
    assert_eq!(swell.go(600.0, None, |_| 0.0), None);
    swell.reckoning.pause();
    swell.length += 0.7;
    assert_eq!(swell.go(60.0, Some(0), |_| 0.0), None);
}

/// The model follows its command, and is not used until it has lost what it began with.
#[test]
fn the_model_alone_follows_its_command() {
    use crate::observe::model::Model;
    let theta = [-0.0101, -0.1231, -1.6891e-5, -10.7104, -0.0023];
    let model = Model::new(0.02, theta, [0.0926, 6.5427]);
    let design = ObserverDesign::new(&model, [1e-8, 1e-3, 100.0], [1e-8; 2], false, 50, 5);
    let design = design.expect("there is a gain");
    let mut free = FreeModel::new(1500);
    let speeds: Vec<_> =
        (0..3000).map(|k| free.step(&design, 0.0, (k % 2 == 0).then_some(0.3))).collect();
    assert_eq!(speeds.iter().position(Option::is_some), Some(1499));
    let last = speeds[2999].expect("it has settled");
    assert!((last - 0.3 * model.velocity_gain().expect("it settles")).abs() < 0.01, "{last}");
}
