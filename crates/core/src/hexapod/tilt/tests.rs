use super::*;

const GEOMETRY: Geometry = Geometry {
    base_radius: 2.9,
    base_half_angle: 0.12,
    top_radius: 2.3,
    top_half_angle: 0.14,
    neutral_height: 4.2,
    reach: [-1.5, 1.5],
};

const TS: f64 = 0.02;

/// A vessel that rolls and pitches under a deck that its cylinders hold, with a sensor of 0.01° on it.
struct Rig {
    hexapod: Hexapod,
    tilt: Tilt,
    cycle: u32,
    /// Of C1 and of C2 of each cylinder, m.
    errors: [[f64; 2]; LEGS],
    /// Whether the controller holds the deck by C1, as it reads it.
    in_loop: bool,
    /// What the deck's sensor is taken to read instead.
    instead: Option<[f64; 2]>,
    /// Whether the cylinders have no C2.
    is_single: bool,
}

impl Rig {
    fn new() -> Self {
        let design = TiltDesign {
            geometry: GEOMETRY,
            accuracy: 1.75e-4,
            sample_time: TS,
            parameters: &TiltParameters::DEFAULT,
        };
        let hexapod = Hexapod::new(&GEOMETRY);
        let (tilt, errors) = (Tilt::new(&design), [[0.0; 2]; LEGS]);
        Self { hexapod, tilt, cycle: 0, errors, in_loop: true, instead: None, is_single: false }
    }

    /// A number between −1 and 1 that differs from cycle to cycle.
    fn odd(&self, salt: u32) -> f64 {
        f64::from((self.cycle.wrapping_mul(7919) + salt * 104_729) % 2003) / 1001.5 - 1.0
    }

    fn step(&mut self) -> [Option<f64>; LEGS] {
        self.judge().parted
    }

    fn judge(&mut self) -> TiltJudgement {
        let time = f64::from(self.cycle) * TS;
        let [roll, pitch] = [0.03 * libm::sin(0.8 * time), 0.02 * libm::sin(0.7 * time + 1.0)];
        let vessel = Pose::new([0.1 * libm::sin(0.9 * time), 0.0, 0.2], [roll, pitch, 0.01]);
        let level = self.hexapod.inverse(&vessel, &self.hexapod.neutral()).expect("within reach");
        let errors = self.errors;
        // Whatever C1 is off by, the rod goes the other way.
        let strokes: [f64; LEGS] = core::array::from_fn(|leg| {
            level[leg] - if self.in_loop { errors[leg][0] } else { 0.0 }
        });
        let deck = self.hexapod.forward(&strokes, &self.hexapod.neutral()).expect("there is one");
        let sensed = inclination(&(up([roll, pitch]) * deck.pose.rotation()));
        let noisy = [0, 1].map(|axis| sensed[axis] + 2e-3 + 3e-4 * self.odd(axis as u32));
        let top = self.instead.unwrap_or(noisy);
        let angles = [
            (Inclination::VesselRoll, roll),
            (Inclination::VesselPitch, pitch),
            (Inclination::TopRoll, top[0]),
            (Inclination::TopPitch, top[1]),
        ];
        angles.into_iter().for_each(|(which, angle)| assert!(self.tilt.put(which, angle)));
        self.cycle += 1;
        let is_single = self.is_single;
        let is_healthy = is_single || errors == [[0.0; 2]; LEGS];
        self.tilt.step(&core::array::from_fn(|leg| {
            let [c1, c2] = errors[leg];
            let has_parted = !is_single && errors[leg] != [0.0; 2];
            TiltLeg {
                length: Some(strokes[leg] + c1),
                is_healthy,
                is_single,
                parted: has_parted.then_some(Some(c1 - c2)),
            }
        }))
    }

    fn work(mut self, seconds: f64) -> Self {
        (0..(seconds / TS) as u32).for_each(|_| assert_eq!(self.step(), [None; LEGS]));
        self
    }

    /// A machine whose cylinders have one transducer each, after so many seconds.
    fn single(seconds: f64) -> Self {
        Self { is_single: true, ..Self::new() }.work(seconds)
    }

    /// All that is found of single transducers while C1 of cylinders drift for some seconds, m/s: `(leg, rate)`.
    fn changes(&mut self, drifts: &[(usize, f64)], seconds: f64) -> Vec<TiltChange> {
        let mut changes = Vec::new();
        for _ in 0..(seconds / TS) as u32 {
            drifts.iter().for_each(|(leg, rate)| self.errors[*leg][0] += rate * TS);
            changes.extend(self.judge().change);
        }
        changes
    }

    /// What is said of each cylinder after some seconds of these drifts, m/s: `(cylinder, transducer, rate)`.
    fn said(mut self, drifts: &[(usize, usize, f64)], seconds: f64) -> [Option<f64>; LEGS] {
        let mut said = [None; LEGS];
        for _ in 0..(seconds / TS) as u32 {
            for (leg, which, rate) in drifts {
                self.errors[*leg][*which] += rate * TS;
            }
            let newest = self.step();
            said = if newest == [None; LEGS] { said } else { newest };
        }
        said
    }
}

#[test]
fn it_names_the_reading_that_has_moved_of_each_cylinder_in_the_loop_and_beside_it() {
    for leg in 0..LEGS {
        for rate in [5e-4, -5e-4] {
            for in_loop in [true, false] {
                let rig = || Rig { in_loop, ..Rig::new() }.work(60.0);
                let one = rig().said(&[(leg, 0, rate)], 20.0);
                let two = rig().said(&[(leg, 1, rate)], 20.0);
                let [one, two] = [one[leg].expect("it is told"), two[leg].expect("it is told")];
                assert!(one > 8.0 && two < -8.0, "{leg}, {rate}, {in_loop}: {one}, {two}");
            }
        }
    }
}

#[test]
fn nobody_else_is_named_and_each_of_two_is() {
    let said = Rig::new().work(60.0).said(&[(1, 0, 1e-3), (4, 1, 1e-3)], 20.0);
    assert!(said[1].is_some_and(|nats| nats > 8.0), "{said:?}");
    assert!(said[4].is_some_and(|nats| nats < -8.0), "{said:?}");
    assert!([0, 2, 3, 5].into_iter().all(|leg| said[leg].is_none()), "{said:?}");
}

/// What the controller holds level by C1 says nothing of C1: whoever presumes it blames C2.
#[test]
fn a_deck_that_is_presumed_to_be_level_blames_c2_whoever_has_moved() {
    for which in [0, 1] {
        let mut rig = Rig::new();
        let mut said = None;
        for k in 0..(80.0 / TS) as u32 {
            rig.instead = Some([1e-5 * f64::from(k % 7), 0.0]);
            if k as f64 * TS > 60.0 {
                rig.errors[2][which] += 1e-3 * TS;
            }
            said = rig.step()[2].or(said);
        }
        assert!(said.is_some_and(|nats| nats < -8.0), "{which}: {said:?}");
    }
}

#[test]
fn a_sensor_that_is_frozen_or_gone_is_no_witness() {
    let mut frozen = Rig::new().work(60.0);
    frozen.instead = Some([2e-3; 2]);
    assert_eq!(frozen.work(3.0).said(&[(0, 0, 1e-3)], 20.0), [None; LEGS]);
    let mut gone = Rig::new().work(60.0);
    let leg = |parted| TiltLeg { length: Some(0.0), parted, ..TiltLeg::default() };
    for _ in 0..1000 {
        let mut legs = [leg(None); LEGS];
        legs[0] = leg(Some(Some(0.02)));
        assert_eq!(gone.tilt.step(&legs), TiltJudgement::default());
    }
}

#[test]
fn a_tilt_that_no_reading_explains_is_nobodys() {
    let mut rig = Rig::new().work(60.0);
    rig.errors[3] = [3e-3, 0.0];
    let said = (0..1000).fold([None; LEGS], |_, k| {
        // A sensor that has come loose.
        rig.instead = Some([0.02 + 1e-5 * f64::from(k % 7), -0.03]);
        rig.step()
    });
    assert_eq!(said, [None; LEGS]);
}

#[test]
fn nothing_is_said_before_it_is_known_what_is_usual() {
    assert_eq!(Rig::new().work(10.0).said(&[(0, 0, 1e-3)], 20.0), [None; LEGS]);
    let mut rig = Rig::new().work(60.0);
    assert!(rig.tilt.is_judging());
    rig.tilt.forget();
    assert!(!rig.tilt.is_judging());
    assert_eq!(rig.said(&[(0, 0, 1e-3)], 20.0), [None; LEGS]);
}

#[test]
fn an_angle_that_no_machine_has_is_not_taken() {
    let mut rig = Rig::new();
    for angle in [f64::NAN, f64::INFINITY, 2.0] {
        assert!(!rig.tilt.put(Inclination::TopRoll, angle), "{angle}");
    }
}

/// The legs that are named, each once in a row.
fn named(changes: &[TiltChange]) -> Vec<usize> {
    let leg = |change: &TiltChange| match change {
        TiltChange::Moved(error) => Some(error.leg),
        TiltChange::Returned(_) => None,
    };
    let mut legs: Vec<usize> = changes.iter().filter_map(leg).collect();
    legs.dedup();
    legs
}

#[test]
fn a_single_transducer_that_drifts_is_found_by_the_direction_of_the_tilt() {
    for leg in 0..LEGS {
        for rate in [2e-3, -2e-3] {
            for in_loop in [true, false] {
                let mut rig = Rig { in_loop, ..Rig::single(90.0) };
                let changes = rig.changes(&[(leg, rate)], 10.0);
                assert_eq!(named(&changes), [leg], "{rate}, {in_loop}");
                let [TiltChange::Moved(first), .., TiltChange::Moved(last)] = changes[..] else {
                    panic!("{changes:?}");
                };
                assert!(first.apart >= 8.0 && first.size.abs() < 0.015, "{first:?}");
                // The mean comes late by its time constant.
                assert!((last.size - 8.0 * rate).abs() < 2.5e-3, "{last:?}");
            }
        }
    }
}

#[test]
fn what_has_stepped_stays_found_until_it_is_back() {
    let mut rig = Rig::single(90.0);
    rig.errors[3][0] = -0.02;
    assert_eq!(named(&rig.changes(&[], 30.0)), [3]);
    // Nothing is learnt from it, and the minutes do not make it usual.
    let changes = rig.changes(&[], 900.0);
    let is_right = |it: &TiltChange| matches!(it, TiltChange::Moved(error) if error.leg == 3 && (error.size + 0.02).abs() < 1e-3);
    assert!(changes.len() > 8000 && changes.iter().all(is_right), "{:?}", changes.last());
    rig.errors[3][0] = 0.0;
    let changes = rig.changes(&[], 30.0);
    assert_eq!(changes.last(), Some(&TiltChange::Returned(3)));
    assert_eq!(rig.changes(&[], 60.0), []);
}

/// Roll alone and pitch alone lie midway between two legs, and so does a sensor that has come loose about one axis.
#[test]
fn a_tilt_that_no_single_leg_explains_names_nobody_and_becomes_usual() {
    for off in [[8e-3, 0.0], [0.0, 8e-3]] {
        let mut rig = Rig::single(90.0);
        let mut changes = Vec::new();
        for k in 0..(1000.0 / TS) as u32 {
            let odd = 1e-4 * f64::from(k % 7);
            rig.instead = Some([2e-3 + off[0] + odd, 2e-3 + off[1] - odd]);
            changes.extend(rig.judge().change);
        }
        assert_eq!(changes, [], "{off:?}");
        assert!(rig.tilt.departure.is_none() && rig.tilt.is_judging(), "it is the new usual tilt");
    }
}

#[test]
fn a_drift_that_is_learnt_away_is_not_found_and_what_is_healthy_is_not_either() {
    assert_eq!(Rig::single(90.0).changes(&[(2, 2e-5)], 600.0), []);
    assert_eq!(Rig::single(90.0).changes(&[], 1800.0), []);
    // Before the usual tilt is known, and after it was forgotten.
    assert_eq!(Rig::single(50.0).changes(&[(2, 2e-3)], 10.0), []);
    let mut rig = Rig::single(90.0);
    rig.tilt.forget();
    assert_eq!(rig.changes(&[(2, 2e-3)], 10.0), []);
}

/// A cylinder with two transducers is never named, and a tilt that fits it names no other.
#[test]
fn only_cylinders_with_a_single_transducer_are_named() {
    let slopes = [[0.1, 0.0], [0.0, 0.1], [0.1, 0.1], [0.1, -0.1], [0.05, 0.1], [0.1, 0.05]];
    let departure = Departure::new(slopes);
    let inverse = nalgebra::Matrix2::identity() * 1e8;
    let explain = |single| {
        let off = Vector2::new(0.0, -0.02);
        departure.explain(&off, &inverse, single, 0.0, &TiltParameters::DEFAULT)
    };
    assert!(explain([true; LEGS]).is_some_and(|it| it.leg == 1 && (it.size - 0.2).abs() < 1e-9));
    assert_eq!(explain([true, false, true, true, true, true]), None);
}

/// The slopes by which a length tilts the deck, against the attitude of decks with that much longer a cylinder.
#[test]
fn a_length_tilts_the_deck_as_the_forward_kinematics_say() {
    let hexapod = Hexapod::new(&GEOMETRY);
    let (vessel, step) = ([0.03, -0.05], 1e-5);
    let base = Pose::new([0.1, -0.2, 0.1], [vessel[0], vessel[1], 0.0]);
    let strokes = hexapod
        .inverse(&base, &Pose::new([0.0, 0.1, 4.3], [0.01, 0.02, 0.03]))
        .expect("it is within reach");
    let deck = |strokes: &[f64; LEGS]| {
        hexapod.forward(strokes, &hexapod.neutral()).expect("there is one").pose
    };
    let attitude = |strokes: &[f64; LEGS]| inclination(&(up(vessel) * deck(strokes).rotation()));
    let at = deck(&strokes);
    let found = Comparison { tilt: [0.0; 2], deck: at, up: up(vessel) * at.rotation(), vessel };
    let slopes = found.slopes(&hexapod).expect("the pose is regular");
    for leg in 0..LEGS {
        let moved = |by: f64| {
            let mut moved = strokes;
            moved[leg] += by;
            attitude(&moved)
        };
        let [low, high] = [moved(-step), moved(step)];
        for axis in 0..2 {
            let expected = (high[axis] - low[axis]) / (2.0 * step);
            let slope = slopes[leg][axis];
            assert!((slope - expected).abs() < 1e-6, "{leg}, {axis}: {slope}, {expected}");
        }
    }
}
