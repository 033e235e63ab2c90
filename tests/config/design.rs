//! What a configuration makes of the monitor.

use tertius::config::settings::{ChambersTable, CylinderProcess, Settings, SupplyTable};
use tertius::config::{self, design};
use tertius::dbc::{Database, text};
use tertius::sequential::wild::Outliers;

/// A table that says which share of wild samples it was made with goes by it, others by that of before.
#[test]
fn a_detector_allows_for_as_many_wild_samples_as_its_table() {
    let path = tertius_testing::top().join("tests/recordings/e-type-sequential.toml");
    let mut loaded = config::load(&path).expect("it is sound");
    let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("it is sound");
    let tables = loaded.settings.cylinder.iter_mut().filter_map(|it| it.sequential.as_mut());
    tables.take(1).for_each(|table| table.outlier_share = 0.003);
    let design = design::judging(&loaded.settings, &database).expect("they fit");
    let outliers = |place: usize| design.cylinders[place].sequential.as_ref().map(|it| it.outliers);
    assert_eq!(outliers(0), Some(Outliers { share: 0.003 }));
    assert_eq!(outliers(1), Some(Outliers::UNSAID));
}

/// What is wrong with `config/e-type-top.toml` after `change`; empty where a deck's attitude is compared.
fn flaws_of_deck(change: impl Fn(&mut Settings)) -> Vec<String> {
    let path = tertius_testing::top().join("config/e-type-top.toml");
    let mut loaded = config::load(&path).expect("it is sound");
    let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("it is sound");
    change(&mut loaded.settings);
    match design::judging(&loaded.settings, &database) {
        Ok(design) => {
            assert!(design.tilt.is_some());
            vec![]
        }
        Err(flaws) => flaws.iter().map(|it| format!("{}: {}", it.key, it.message)).collect(),
    }
}

#[test]
fn a_sensor_on_the_deck_takes_all_four_angles_in_rad_and_the_geometry_of_six_cylinders() {
    let none: [&str; 0] = [];
    assert_eq!(flaws_of_deck(|_| {}), none);
    assert_eq!(
        flaws_of_deck(|it| it.signals.vessel_pitch = None),
        ["signals.vessel_pitch: the attitude sensor on the deck is of no use without this angle"]
    );
    assert_eq!(
        flaws_of_deck(|it| it.hexapod = None),
        [
            "signals.top_roll: the attitude sensor on the deck is of no use without the platform's geometry"
        ]
    );
    assert_eq!(
        flaws_of_deck(|it| it.machine.cylinders = 5),
        ["machine.cylinders: the machine has 5 cylinders, and a hexapod has 6"]
    );
    let other = |name: &str| {
        let name = Some(name.to_owned());
        flaws_of_deck(|it| it.signals.top_pitch.clone_from(&name))
    };
    assert_eq!(
        other("Top_Attitude.Roll"),
        ["signals.top_pitch: Top_Attitude.Roll is used already for something else"]
    );
    assert_eq!(
        other("Mru_Translation.Heave"),
        ["signals.top_pitch: Mru_Translation.Heave is in \"m\", expected \"rad\""]
    );
    assert_eq!(other("Top_Attitude.Yaw").len(), 1);
}

/// What the design finds wrong with the table of the supply that `change` has changed.
fn flaws_of_supply(change: impl Fn(&mut Settings)) -> Vec<String> {
    let path = tertius_testing::top().join("config/e-type-simulated.toml");
    let mut loaded = config::load(&path).expect("it is sound");
    let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("it is sound");
    loaded.settings.process.supply = Some(SupplyTable {
        sample_time: 0.02,
        reference: 230.0,
        taught: [220.0, 238.0],
        pump: vec![16.0, 1.6],
        taken: [-7.5, -3.5],
        deviation: 0.15,
        mean_dependence: [1.0; 20],
    });
    change(&mut loaded.settings);
    match design::judging(&loaded.settings, &database) {
        Ok(design) => {
            // Without spools and chambers, too, each cylinder tells of its supply.
            assert!(design.supply.is_some());
            assert!(
                design.cylinders.iter().all(|it| it.process.as_ref().is_some_and(|it| it.supply))
            );
            vec![]
        }
        Err(flaws) => flaws.iter().map(|it| format!("{}: {}", it.key, it.message)).collect(),
    }
}

#[test]
fn a_supply_that_was_learnt_is_watched_and_one_of_another_machine_is_refused() {
    let table = |settings: &mut Settings, change: fn(&mut SupplyTable)| {
        settings.process.supply.iter_mut().for_each(change);
    };
    assert_eq!(flaws_of_supply(|_| {}), Vec::<String>::new());
    let other_time = flaws_of_supply(|it| table(it, |it| it.sample_time = 0.01));
    assert!(other_time[0].starts_with("process.supply.sample_time: "), "{other_time:?}");
    let falling = flaws_of_supply(|it| table(it, |it| it.taught = [238.0, 220.0]));
    assert!(falling[0].starts_with("process.supply.taught: "), "{falling:?}");
    let chambers = flaws_of_supply(|it| {
        let table = ChambersTable {
            coefficients: [0.0, 1.0, 0.0, 0.0],
            supplies: Some([238.0, 220.0]),
            deviation: 0.5,
            growth: 0.0,
            mean_dependence: [1.0; 20],
            square_dependence: [1.0; 20],
        };
        let process = CylinderProcess {
            sample_time: 0.02,
            spool: None,
            chambers: Some(table),
            flow: None,
            friction: None,
        };
        it.cylinder[2].process = Some(process);
    });
    assert_eq!(
        chambers,
        ["cylinder.process.chambers: cylinder 3: `supplies` do not rise: [238, 220]"]
    );
    let unnamed = flaws_of_supply(|it| it.signals.supply = None);
    assert!(unnamed[0].contains("signals.supply"), "{unnamed:?}");
}
