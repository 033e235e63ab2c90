//! A machine whose transducers fluctuate as in Figure 5-9: each is now and then four counts off for 0.2 s, and sound.

use crate::sequential_support::{Setup, one_each, setup};
use std::sync::LazyLock;
use tertius::simulator::{EPOCH, Options, Tables};
use tertius::verdict::{Fault as Kind, Suspect};

const PLANT: &str = include_str!("../../config/e-type-plant.toml");

/// The machine, calibrated once on 20 minutes.
pub static FLUCTUATING: LazyLock<Setup> = LazyLock::new(|| {
    let tables = Tables::parse(PLANT).expect("it is sound");
    setup().with(tables).calibrated()
});

#[test]
fn excursions_are_learnt_as_often_as_large_and_as_long_as_they_are() {
    for cylinder in &FLUCTUATING.settings.cylinder {
        let sequential = cylinder.sequential.as_ref().expect("it is calibrated");
        let excursions = sequential.excursions.as_ref().expect("it fluctuates");
        // 5 of 10,000 readings of either transducer begin one: 0.05 a second, 60 in 20 minutes.
        assert!((0.03..0.07).contains(&excursions.rate), "{}", excursions.rate);
        assert!((4e-4..5e-4).contains(&excursions.size), "{}", excursions.size);
        assert!((10..=22).contains(&excursions.longest), "{}", excursions.longest);
    }
    assert!(setup().settings.cylinder.iter().all(|it| {
        it.sequential.as_ref().is_some_and(|sequential| sequential.excursions.is_none())
    }));
}

#[test]
fn a_healthy_machine_that_fluctuates_is_left_alone() {
    for (seed, sea) in [(21, [1.5, 7.0]), (22, [2.5, 8.0])] {
        let options = Options { seed, sea: Some(sea), ..Options::default() };
        let heard = FLUCTUATING.play(900.0, &options);
        assert!(heard.warnings.is_empty(), "{sea:?}: {}", heard.told());
    }
}

/// Half a millimetre is hardly more than an excursion and has to outlast two in a row; 1.25 mm is more than two at once.
#[test]
fn steps_are_found_beside_excursions_and_named_at_their_onset() {
    for (size, within, least) in [("0.0005", 1.1, 5), ("-0.00075", 0.6, 5), ("0.00125", 0.15, 5)] {
        let (faults, truth) = one_each(&format!("step,size={size}"));
        let heard = FLUCTUATING.run(45.0, false, &faults);
        let mut named = 0;
        for (cylinder, suspect, at) in truth {
            let (delay, last) = heard.of(cylinder, at).expect("it is found");
            assert!((0.0..within).contains(&delay), "{size} {cylinder}: {delay}");
            assert_eq!(last.finding.fault, Kind::Abrupt, "{size} {cylinder}");
            named += usize::from(last.finding.suspect == suspect);
            let is_right = [suspect, Suspect::Undecided].contains(&last.finding.suspect);
            assert!(is_right, "{size} {cylinder}: {}", heard.told());
        }
        assert!(named >= least, "{size}: {named} of 6 are named\n{}", heard.told());
    }
}

#[test]
fn what_an_observer_and_the_difference_show_is_found_in_its_first_cycle() {
    let mut setup = FLUCTUATING.clone();
    // As fluctuations teach it.
    (setup.settings.fde.low, setup.settings.fde.high) = (3e-3, 4e-3);
    let found = |joint: Option<f64>| {
        let mut setup = setup.clone();
        setup.settings.fde.joint = joint;
        let (faults, truth) = one_each("step,size=0.0015");
        let heard = setup.run(45.0, false, &faults);
        let at_once = |(cylinder, suspect, at): &(u8, Suspect, f64)| {
            heard.others.iter().any(|warning| {
                let delay = warning.timestamp.since(EPOCH).as_seconds() - at;
                warning.cylinder == *cylinder
                    && warning.finding.suspect == *suspect
                    && (0.0..0.06).contains(&delay)
            })
        };
        truth.iter().filter(|it| at_once(it)).count()
    };
    assert_eq!(found(None), 0);
    assert!(found(Some(1e-3)) >= 5);
}

/// The recording that teaches is read the same each time, so that the limits are, too.
#[test]
fn the_same_recording_teaches_the_same_limits() {
    let again = FLUCTUATING.clone().calibrated();
    assert_eq!(again.settings.cylinder, FLUCTUATING.settings.cylinder);
}
