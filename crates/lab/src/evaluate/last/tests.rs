//! Both studies on few machines, and that their result does not depend on the order of their jobs.

use super::*;
use crate::evaluate::extent::Lessons;
use crate::evaluate::study::TaughtStudy;
use crate::evaluate::workers::Serial;
use tertius_dbc::{Database, text};
use tertius_machine::inject::Shape;
use tertius_machine::simulator::Tables;

/// A study of few faults on one machine of each group.
fn study(asked: StudyName, faults: &[Option<Wanted>]) -> LastStudy {
    let extent = Extent {
        trials: 3,
        hours: 0.1,
        seas: vec![[2.5, 8.0]],
        studies: vec![asked.name],
        lessons: Lessons { calibration: 0.1, level: 0.1 },
        weights: Vec::new(),
        cylinders: 6,
        taught: None,
        lag: 0.06,
    };
    let study = LastStudy::planned(7, &extent).expect("it was asked for");
    LastStudy { faults: faults.to_vec(), ..study }
}

/// The result on the machine of the configuration.
fn result(study: &LastStudy, workers: Serial) -> LastResult {
    let config = include_str!("../../../../../config/e-type-simulated.toml");
    let (settings, _) =
        tertius_config::parse("e-type-simulated.toml", config).expect("it is sound");
    let dbc = text::from_bytes(include_bytes!("../../../../../dbc/e-type.dbc"));
    let database = Database::parse(&dbc).expect("it is sound");
    let monitor = design::judging(&settings, &database).expect("they fit");
    let stand = Stand::new(&Tables::default(), &settings, &database, &monitor);
    let course = TaughtStudy::new(study, &stand, &workers).expect("C2 is not needed");
    course.figures(&workers).expect("it can be simulated")
}

const LOST: Option<Wanted> = Some(Wanted::Shape(Shape::Loss { probability: 1.0 }));

/// Whatever has become of the other transducer, the last one is named when it is lost, too; where nothing happens to
/// it, it is not named.
#[test]
fn a_last_transducer_that_is_lost_is_named_and_a_sound_one_is_not() {
    let mut study = study(LAST, &[LOST, None]);
    study.groups.truncate(1);
    assert_eq!(study.jobs().len(), 1 + 3, "a machine, and a stretch with each outage");
    let forwards = result(&study, Serial::default());
    assert_eq!(forwards, result(&study, Serial { reversed: true }), "in any order");
    let of: Vec<_> = forwards.faults.iter().map(|it| (it.outage, &*it.label)).collect();
    let outages = ["lost", "frozen", "10 mm off"];
    assert_eq!(of, outages.map(|it| [(it, "loss of 100 %"), (it, "none")]).as_flattened());
    for pair in forwards.faults.chunks(2) {
        let [lost, none] = pair else { panic!("an odd row") };
        assert_eq!((lost.faults, lost.spoilt, lost.named.right), (3, 0, 3), "{lost:?}");
        assert!(lost.delay.median.is_some_and(|it| (0.09..0.2).contains(&it)), "{lost:?}");
        assert_eq!((none.faults, none.named.right), (3, 0), "{none:?}");
    }
    assert_eq!(forwards.hours.len(), 3);
    for hours in &forwards.hours {
        // A minute before the outages is not theirs.
        assert!((0.44..0.45).contains(&hours.hours), "nine minutes of three cylinders: {hours:?}");
        assert_eq!(hours.named.events, 0, "{hours:?}");
    }
}

/// A cylinder without C2 has faults of C1 alone, beside the loop and in it, and an estimate that follows a slow drift.
#[test]
fn a_cylinder_without_a_second_transducer_is_tried_by_the_same_faults() {
    let drift = Some(Wanted::Shape(Shape::Drift { rate: 1e-3 }));
    let mut study = study(SINGLE, &[drift, LOST, None]);
    study.groups.truncate(2);
    let all = result(&study, Serial::default());
    let loops: Vec<_> = all.faults.iter().map(|it| (it.outage, it.in_loop)).collect();
    assert_eq!(loops, [[("absent", false); 3], [("absent", true); 3]].as_flattened());
    for rows in all.faults.chunks(3) {
        let [drift, lost, none] = rows else { panic!("three faults a group") };
        assert!(drift.wrong[0] > 0.0, "no other reading tells of it: {drift:?}");
        assert_eq!((lost.faults, lost.named.right), (3, 3), "{lost:?}");
        assert_eq!((none.named.right, none.outlasted.count), (0, 0), "{none:?}");
    }
    let [hours] = &all.hours[..] else { panic!("the loop has no hours of its own") };
    assert!((0.44..0.45).contains(&hours.hours), "{hours:?}");
}
