//! The hexapod's kinematics against geometry that is built another way.

use nalgebra::{Rotation3, Unit, Vector3};
use tertius::hexapod::{
    FrameMotion, Geometry, Hexapod, KinematicsError, LEGS, Legs, Pose, PoseRate,
};
use tertius_testing::support::Seeded;

fn geometry() -> Geometry {
    Geometry {
        base_radius: 2.9,
        base_half_angle: 0.12,
        top_radius: 2.3,
        top_half_angle: 0.14,
        neutral_height: 4.2,
        reach: [-1.5, 1.5],
    }
}

fn uniform(random: &mut Seeded, size: f64) -> f64 {
    (random.next() >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 * size - size
}

/// Up to 0.8 m and 0.35 rad from `middle`.
fn near(middle: &Pose, random: &mut Seeded) -> Pose {
    let mut pose = *middle;
    for axis in 0..3 {
        pose.translation[axis] += uniform(random, 0.8);
        pose.attitude[axis] += uniform(random, 0.35);
    }
    pose
}

/// Turns a point as a hand would: about the vertical, then about where that has left the y axis,
/// then about where both have left the x axis.
fn turned(pose: &Pose, point: &Vector3<f64>) -> Vector3<f64> {
    let about =
        |axis: &Vector3<f64>, angle| Rotation3::from_axis_angle(&Unit::new_normalize(*axis), angle);
    let yaw = about(&Vector3::z(), pose.attitude[2]);
    let pitch = about(&(yaw * Vector3::y()), pose.attitude[1]);
    let roll = about(&(pitch * (yaw * Vector3::x())), pose.attitude[0]);
    roll * (pitch * (yaw * point))
}

#[test]
fn lengths_are_the_distances_between_gimbals_that_were_turned_by_hand() {
    let hexapod = Hexapod::new(&geometry());
    let mut random = Seeded(1);
    let mut within_reach = 0;
    for _ in 0..1000 {
        let base = near(&Pose::default(), &mut random);
        let deck = near(&hexapod.neutral(), &mut random);
        let distance = |leg: usize| {
            let low = turned(&base, &hexapod.base()[leg]) + base.translation;
            let high = turned(&deck, &hexapod.top()[leg]) + deck.translation;
            (high - low).norm() - hexapod.neutral_length()
        };
        let expected: [f64; LEGS] = std::array::from_fn(distance);
        match hexapod.inverse(&base, &deck) {
            Ok(strokes) => {
                within_reach += 1;
                for (stroke, expected) in strokes.iter().zip(expected) {
                    assert!((stroke - expected).abs() < 1e-13, "{stroke} {expected}");
                }
            }
            Err(KinematicsError::Unreachable { cylinder, stroke, .. }) => {
                assert!(stroke.abs() > 1.5 && (stroke - expected[cylinder - 1]).abs() < 1e-13);
            }
            Err(error) => panic!("{error}"),
        }
    }
    assert!(within_reach > 300, "{within_reach}");
}

/// Roll to starboard (positive, by the right hand, about x forward) lowers what lies to starboard;
/// pitch lowers the bow; yaw turns it to port.
#[test]
fn the_signs_of_roll_pitch_and_yaw_are_those_of_a_ship() {
    let (bow, port) = (Vector3::x(), Vector3::y());
    let turn = |attitude| Pose::new([0.0; 3], attitude).rotation();
    assert!((turn([0.1, 0.0, 0.0]) * port).z > 0.0);
    assert!((turn([0.0, 0.1, 0.0]) * bow).z < 0.0);
    assert!((turn([0.0, 0.0, 0.1]) * bow).y > 0.0);
}

#[test]
fn all_strokes_are_zero_in_the_neutral_pose_and_grow_with_heave() {
    let hexapod = Hexapod::new(&geometry());
    let strokes = hexapod.inverse(&Pose::default(), &hexapod.neutral()).expect("in reach");
    assert!(strokes.iter().all(|stroke| stroke.abs() < 1e-14), "{strokes:?}");
    let mut high = hexapod.neutral();
    high.translation.z += 0.5;
    let strokes = hexapod.inverse(&Pose::default(), &high).expect("in reach");
    let first = strokes[0];
    assert!(first > 0.4 && first < 0.5, "{first}");
    assert!(strokes.iter().all(|stroke| (stroke - first).abs() < 1e-14), "{strokes:?}");
}

#[test]
fn ten_thousand_poses_come_back_from_their_lengths() {
    let hexapod = Hexapod::new(&geometry());
    let mut random = Seeded(2);
    let (mut tried, mut worst, mut iterations) = (0, 0.0_f64, 0);
    while tried < 10_000 {
        let pose = near(&hexapod.neutral(), &mut random);
        let Ok(strokes) = hexapod.inverse(&Pose::default(), &pose) else { continue };
        tried += 1;
        let found = hexapod.forward(&strokes, &hexapod.neutral()).expect("it has a pose");
        let apart = (found.pose.translation - pose.translation).norm();
        let turned = (found.pose.attitude - pose.attitude).norm();
        worst = worst.max(apart).max(turned);
        iterations = iterations.max(found.iterations);
    }
    assert!(worst < 1e-10, "{worst:e} m or rad");
    assert!(iterations <= 8, "{iterations} iterations");
}

#[test]
fn the_jacobian_is_that_of_differences() {
    let hexapod = Hexapod::new(&geometry());
    let mut random = Seeded(3);
    let step = 1e-6;
    for _ in 0..200 {
        let pose = near(&hexapod.neutral(), &mut random);
        let legs = |pose: &Pose| Legs::new(&hexapod, &Pose::default(), pose);
        let jacobian = legs(&pose).jacobian();
        for column in 0..6 {
            let moved = |step: f64| {
                let mut pose = pose;
                if column < 3 {
                    pose.translation[column] += step;
                } else {
                    // A small turn about a fixed axis, by the rates that make it.
                    let mut axis = Vector3::zeros();
                    axis[column - 3] = step;
                    let rates = pose.axes().try_inverse().expect("far from 90°") * axis;
                    pose.attitude += rates;
                }
                legs(&pose).lengths
            };
            let (ahead, behind) = (moved(step), moved(-step));
            for leg in 0..LEGS {
                let slope = (ahead[leg] - behind[leg]) / (2.0 * step);
                let entry = jacobian[(leg, column)];
                assert!((slope - entry).abs() < 1e-8, "[{leg}][{column}]: {slope} {entry}");
            }
        }
    }
}

#[test]
fn velocities_are_the_differences_of_lengths_while_both_frames_move() {
    let hexapod = Hexapod::new(&geometry());
    let mut random = Seeded(4);
    let step = 1e-6;
    for _ in 0..200 {
        let (base, deck) =
            (near(&Pose::default(), &mut random), near(&hexapod.neutral(), &mut random));
        let mut rate = || PoseRate {
            translation: Vector3::from_fn(|_, _| uniform(&mut random, 1.0)),
            attitude: Vector3::from_fn(|_, _| uniform(&mut random, 0.5)),
        };
        let (base_rate, deck_rate) = (rate(), rate());
        let after = |pose: &Pose, rate: &PoseRate, time: f64| Pose {
            translation: pose.translation + rate.translation * time,
            attitude: pose.attitude + rate.attitude * time,
        };
        let lengths = |time| {
            let base = after(&base, &base_rate, time);
            Legs::new(&hexapod, &base, &after(&deck, &deck_rate, time)).lengths
        };
        let (ahead, behind) = (lengths(step), lengths(-step));
        let velocities = Legs::new(&hexapod, &base, &deck).velocities(
            FrameMotion { pose: &base, rate: &base_rate },
            FrameMotion { pose: &deck, rate: &deck_rate },
        );
        for leg in 0..LEGS {
            let slope = (ahead[leg] - behind[leg]) / (2.0 * step);
            assert!((slope - velocities[leg]).abs() < 1e-8, "{slope} {}", velocities[leg]);
        }
    }
}

/// A platform with its gimbals above the base's own triangle, turned by 90° about the vertical, is
/// the known singular one: it can turn on without any cylinder's moving.
#[test]
fn a_singular_pose_is_told() {
    let alike = Geometry { reach: [-10.0, 10.0], ..geometry() };
    let hexapod = Hexapod::new(&alike);
    let mut pose = hexapod.neutral();
    pose.attitude[2] = std::f64::consts::FRAC_PI_2;
    let strokes = hexapod.inverse(&Pose::default(), &pose).expect("in so wide a reach");
    assert_eq!(hexapod.forward(&strokes, &pose), Err(KinematicsError::Singular));
}

#[test]
fn lengths_that_cannot_be_are_told() {
    let hexapod = Hexapod::new(&geometry());
    let neutral = hexapod.neutral();
    let error = hexapod.forward(&[0.0, 0.0, 0.0, 1.6, 0.0, 0.0], &neutral).expect_err("too long");
    assert_eq!(
        error,
        KinematicsError::Unreachable { cylinder: 4, stroke: 1.6, reach: [-1.5, 1.5] }
    );
    let mut far = neutral;
    far.translation.z += 3.0;
    let error = hexapod.inverse(&Pose::default(), &far).expect_err("too far");
    assert!(matches!(error, KinematicsError::Unreachable { .. }), "{error}");
    let nowhere = [f64::NAN; LEGS];
    assert_eq!(hexapod.forward(&nowhere, &neutral), Err(KinematicsError::NotFinite));
    // One leg so much shorter than its neighbours that no rigid deck has room between them.
    let torn = [1.5, -1.5, 1.5, -1.5, 1.5, -1.5];
    let wide = Hexapod::new(&Geometry { top_half_angle: 1.0, top_radius: 0.5, ..geometry() });
    let error = wide.forward(&torn, &wide.neutral()).expect_err("no deck fits");
    assert!(
        matches!(error, KinematicsError::NoPose { .. } | KinematicsError::Singular),
        "{error:?}"
    );
}
