//! The study on one machine of each grade, and that its result does not depend on the order of its jobs.

use super::*;
use crate::evaluate::study::TaughtStudy;
use crate::evaluate::workers::Serial;
use tertius_config::design::judging;
use tertius_dbc::{Database, text};
use tertius_machine::inject::Shape;
use tertius_machine::simulator::Tables;

/// The figures of `cases`, in the order of the jobs and in the reverse.
fn figures(cases: &[AccommodateCase]) -> Vec<AccommodateFigures> {
    let config = include_str!("../../../../../config/e-type-simulated.toml");
    let (settings, _) =
        tertius_config::parse("e-type-simulated.toml", config).expect("it is sound");
    let dbc = text::from_bytes(include_bytes!("../../../../../dbc/e-type.dbc"));
    let database = Database::parse(&dbc).expect("it is sound");
    let monitor = judging(&settings, &database).expect("they fit");
    let stand = Stand::new(&Tables::default(), &settings, &database, &monitor);
    let study = AccommodateStudy {
        cases: cases.to_vec(),
        seas: vec![[2.5, 8.0]],
        trials: 6,
        seed: 3,
        cylinders: 6,
    };
    assert_eq!(study.jobs().len(), 4, "two machines of each grade");
    let gathered = |workers: Serial| {
        let course = TaughtStudy::new(&study, &stand, &workers).expect("it learns nothing");
        course.figures(&workers).expect("it can be simulated").cases
    };
    let forwards = gathered(Serial::default());
    assert_eq!(forwards, gathered(Serial { reversed: true }), "in any order");
    forwards
}

/// With accommodation the estimate is valid and right as long as nothing else happens, and ends with a second step.
#[test]
fn a_step_is_subtracted_until_a_second_one_and_a_drift_never() {
    let step = Shape::Step { size: 0.01 };
    let cases = [
        AccommodateCase { first: step, second: None },
        AccommodateCase { first: Shape::Drift { rate: 1e-3 }, second: None },
        AccommodateCase { first: step, second: Some(step) },
    ];
    let all = figures(&cases);
    assert_eq!(all.len(), 2 * cases.len() * 2);
    for grade in all.chunks(6) {
        let [off, on, _, drift, _, second] = grade else { panic!("three cases, off and on") };
        assert!(grade.iter().all(|it| it.cylinders == 6), "{grade:?}");
        assert_eq!((off.accommodates, on.accommodates), (false, true));
        // A coarse one is beyond its threshold now and then, which ends it.
        let least = if on.grade == "fine" { 0.99 } else { 0.8 };
        assert!(off.valid < 0.05 && on.valid > least, "{off:?} {on:?}");
        assert!(on.errors.is_some_and(|[median, _]| median < 3e-4), "{on:?}");
        assert!(drift.valid < 0.05, "{drift:?}");
        // It begins after 20 to 21 of 60 s.
        assert!((0.32 * least..0.36).contains(&second.valid), "{second:?}");
        assert!(second.wrong_for[1] < 1.0, "{second:?}");
    }
}
