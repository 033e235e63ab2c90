//! Dead reckoning of a rod in a swell.

use super::*;
use crate::observe::observer::ObserverDesign;

static PARAMETERS: ReckoningParameters = ReckoningParameters::DEFAULT;

impl DeadReckoning {
    /// Takes a cycle.
    fn tick(
        &mut self,
        readings: [Option<f64>; 2],
        velocity: Option<f64>,
        compared: Compared,
        is_calm: bool,
    ) -> Option<CourseError> {
        let is_tick = self.begin();
        let error = is_tick.then(|| self.judge(readings, compared, is_calm)).flatten();
        self.go(velocity);
        error
    }
}

/// A rod in a swell of 10 s, of which dead reckoning does not know a part of the speed.
struct Swell {
    reckoning: DeadReckoning,
    length: f64,
    cycle: u32,
    unknown: f64,
    /// Of an only transducer, beside which nothing is found; else it is calm unless a transducer is left alone.
    is_only: bool,
    /// Whether the two readings are known to differ.
    differs: bool,
}

impl Swell {
    fn new(unknown: f64) -> Self {
        let reckoning = DeadReckoning::new(&PARAMETERS, WaySource::Drive, 0.02, 0.01);
        Self { reckoning, length: 0.0, cycle: 0, unknown, is_only: false, differs: false }
    }

    /// What each window has learnt from.
    fn lessons(&self) -> [u32; WINDOWS] {
        self.reckoning.usual.map(|it| it.count())
    }

    /// Goes on for some seconds with an error of the reading; returns when that was found, s, and the finding.
    fn go(
        &mut self,
        seconds: f64,
        alone: Option<usize>,
        error: impl Fn(f64) -> f64,
    ) -> Option<(f64, CourseError)> {
        self.go_each(seconds, alone, |after| [error(after); 2])
    }

    /// The same with an error of each reading.
    fn go_each(
        &mut self,
        seconds: f64,
        alone: Option<usize>,
        errors: impl Fn(f64) -> [f64; 2],
    ) -> Option<(f64, CourseError)> {
        let beside = if self.differs { Compared::Neither } else { Compared::Together };
        let compared = alone.map_or(beside, Compared::Alone);
        let mut found = None;
        for k in 0..(seconds / 0.02) as u32 {
            let angle = f64::from(self.cycle) * 0.02 * core::f64::consts::TAU / 10.0;
            let (velocity, after) = (0.2 * angle.cos(), 0.02 * f64::from(k));
            let readings = errors(after).map(|error| Some(self.length + error));
            let is_calm = self.is_only || compared == Compared::Together;
            let error = self.reckoning.tick(readings, Some(velocity), compared, is_calm);
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
        let readings = [Some(length), None];
        found = found.or(swell.reckoning.tick(readings, Some(velocity), Compared::Alone(0), false));
        length += 0.02 * velocity * 1.02;
    }
    assert_eq!(found, None);
}

/// As oil that warms leaks more and more; a transducer that is left alone may be so for hours.
#[test]
fn a_bias_that_wanders_is_followed_and_a_drift_is_not() {
    let wander = |t: f64| 7e-4 * t - 0.5 * 1.1e-6 * t * t;
    for (drift, is_found) in [(0.0, false), (0.002, true), (-0.005, true)] {
        let mut swell = Swell::new(0.002);
        assert_eq!(swell.go(900.0, None, wander), None, "beside the other one");
        assert_eq!(swell.go(900.0, Some(1), |t| wander(900.0 + t)), None, "alone");
        let on = |t: f64| wander(1800.0 + t) + drift * t;
        let found = swell.go(120.0, Some(1), on).map(|(after, _)| after);
        assert_eq!(found.is_some_and(|it| it < 15.0), is_found, "{drift}: {found:?}");
        assert_eq!(found.is_some(), is_found, "{drift}: {found:?}");
    }
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

#[test]
fn a_window_is_judged_once_eight_of_its_length_were_learnt() {
    for (seconds, is_judged) in [(4.0, false), (5.0, true)] {
        let mut swell = Swell::new(0.01);
        assert_eq!(swell.go(seconds, None, |_| 0.0), None);
        assert_eq!(swell.go(4.0, Some(1), |t| 0.05 * t).is_some(), is_judged, "{seconds}");
    }
}

/// By few lessons a drift is not told from what is usual, of which many make sure.
#[test]
fn few_lessons_count_less_than_many() {
    for (seconds, is_found) in [(6.0, false), (600.0, true)] {
        let mut swell = Swell::new(0.05);
        assert_eq!(swell.go(seconds, None, |_| 0.0), None);
        assert_eq!(swell.go(4.0, Some(1), |t| 0.07 * t).is_some(), is_found, "{seconds}");
    }
}

#[test]
fn however_well_it_is_known_no_error_below_the_least_is_one() {
    for (error, is_found) in [(0.009, false), (0.011, true)] {
        let mut swell = Swell::new(0.0);
        assert_eq!(swell.go(600.0, None, |_| 0.0), None);
        let found = swell.go(60.0, Some(1), |t| if t > 5.0 { error } else { 0.0 });
        assert_eq!(found.is_some(), is_found, "{error}");
    }
}

/// Windows that overlap have their errors in common, and one that reaches back to a finding may have it.
#[test]
fn lessons_neither_overlap_nor_reach_back_to_a_finding() {
    let mut swell = Swell::new(0.01);
    assert_eq!(swell.go(64.6, None, |_| 0.0), None);
    let learnt = swell.lessons();
    assert_eq!(learnt, [127, 63, 31, 15, 7, 3, 1, 0]);
    assert_eq!(swell.go(31.9, Some(0), |_| 0.0), None);
    assert_eq!(swell.lessons(), learnt, "it is not calm");
    assert_eq!(swell.go(4.5, None, |_| 0.0), None);
    let more: Vec<u32> = swell.lessons().iter().zip(learnt).map(|(now, then)| now - then).collect();
    assert_eq!(more[3..], [0; 5], "{more:?}");
}

/// Its first cycle would be a lesson that makes it usual before the second one confirms it.
#[test]
fn an_error_of_an_only_transducer_does_not_become_usual() {
    for ticks in 20..60 {
        let mut swell = Swell { is_only: true, ..Swell::new(0.02) };
        assert_eq!(swell.go(0.5 * f64::from(ticks), Some(0), |_| 0.0), None);
        let found = swell.go(30.0, Some(0), |_| 0.2);
        assert!(found.is_some_and(|(after, _)| after < 2.0), "{ticks}: {found:?}");
    }
}

/// What is wrong with one of two is seen by their difference, and its drift is no bias of dead reckoning.
#[test]
fn two_are_off_by_what_both_are_off_by() {
    for (errors, off) in [
        ([0.03, 0.03], Some(0.03)),
        ([-0.03, -0.031], Some(-0.03)),
        ([0.03, 0.0], None),
        ([0.03, -0.03], None),
    ] {
        let mut swell = Swell::new(0.001);
        assert_eq!(swell.go(600.0, None, |_| 0.0), None);
        let found = swell.go_each(60.0, None, |_| errors).map(|(_, it)| it.error);
        let is_as_large = |off: f64| found.is_some_and(|it| (it - off).abs() < 0.1 * off.abs());
        assert_eq!(found.is_some(), off.is_some(), "{errors:?}: {found:?}");
        assert!(off.is_none_or(is_as_large), "{errors:?}: {found:?}");
    }
}

#[test]
fn a_drift_of_one_of_two_is_no_bias() {
    let mut swell = Swell::new(0.001);
    assert_eq!(swell.go(600.0, None, |_| 0.0), None);
    swell.differs = true;
    assert_eq!(swell.go_each(60.0, None, |t| [0.0, 0.01 * t]), None);
    assert!(swell.reckoning.bias.value().abs() < 1e-4, "{}", swell.reckoning.bias.value());
    assert_eq!(swell.go_each(60.0, None, |t| [0.01 * t; 2]), None);
    assert!(swell.reckoning.bias.value() > 1e-3, "followed all the same");
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
