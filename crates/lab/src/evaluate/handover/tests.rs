use super::reader::tests::database;
use super::*;
use tertius_config::design;
use tertius_machine::simulator::Tables;

/// What the machines of these numbers say of the cases of these labels, in the order in which they are tried.
fn outcomes(numbers: &[usize], labels: &[&str]) -> Vec<Vec<HandoverOutcome>> {
    let text = include_str!("../../../../../config/e-type-simulated.toml");
    let (settings, _) = tertius_config::parse("e-type.toml", text).expect("it is sound");
    let database = database();
    let design = design::judging(&settings, &database).expect("they fit");
    let stand = Stand::new(&Tables::default(), &settings, &database, &design);
    let study = HandoverStudy {
        grades: vec![Grade::Fine],
        seas: vec![[2.5, 8.0]],
        trials: 2,
        cases: CASES.into_iter().filter(|case| labels.contains(&case.label)).collect(),
        lessons: Lessons { calibration: 1.0 / 6.0, level: 1.0 / 6.0 },
        seed: 5,
    };
    assert_eq!(study.cases.len(), labels.len());
    let taught = study.teach(&stand, 0).expect("it can be learnt");
    let jobs = study.jobs();
    assert_eq!(jobs.len(), 2, "a machine for each trial");
    let run = |number: &usize| {
        let (_, outcomes) = study
            .run(&stand, std::slice::from_ref(&taught), jobs[*number])
            .expect("it can be simulated");
        outcomes
    };
    numbers.iter().map(run).collect()
}

/// Section 5-2 and Table 2-1 for the machine that stays; and C1 is never left where it is sound.
#[test]
fn a_machine_that_hears_who_is_wrong_is_not_black_and_a_sound_one_never_changes_over() {
    let [first, other, again] = &outcomes(&[0, 1, 0], &["none", "step 60 mm", "frozen"])[..] else {
        panic!("three were asked for")
    };
    assert_eq!(first, again, "the same seed gives the same machine");
    assert_ne!(first, other);
    for outcome in first.iter().chain(other) {
        let HandoverOutcome { case, which, spoilt, ways } = *outcome;
        let [stays, others @ ..] = ways;
        assert!(!spoilt && ways.iter().all(|way| way.wrong.is_none()), "{outcome:?}");
        if case == 0 {
            let nothing = Way { tip: stays.tip, ..Way::default() };
            assert_eq!(ways, [nothing; 3], "a sound machine is one under all policies");
            assert!(stays.tip < 0.1, "{stays:?}");
            continue;
        }
        let (black, blamed) = stays.black.zip(stays.blamed).expect("it is black, and was blamed");
        assert!(blamed < black && black < 5.0, "{outcome:?}");
        assert!(stays.tip > 0.2, "the deck goes down with the people: {stays:?}");
        for way in others {
            assert_eq!((way.black, way.blamed), (None, stays.blamed), "{outcome:?}");
            assert!(way.tip < 0.15 && way.rod < 0.08, "{outcome:?}");
            if which == 1 {
                assert_eq!(way.rod, 0.0, "C1 was never left: {outcome:?}");
            }
        }
    }
}
