use super::*;
use crate::process::Curve;
use crate::process::friction::{FORCE_TERMS, FrictionDesign};

const SAMPLE_TIME: f64 = 0.02;

fn process() -> Process {
    let scatter =
        core::array::from_fn(|i| core::array::from_fn(|j| if i == j { 1e-10 } else { 0.0 }));
    let flow = FlowDesign {
        limit: 50.0,
        curve: Curve::new(50.0, alloc::vec![-0.5, 0.5]),
        taught: alloc::vec![true],
        between: 0.5,
        leakage: 0.0,
        compression: 0.0,
        area_ratio: 0.5,
        supplies: [200.0, 220.0],
        scatter: [scatter; 2],
    };
    Process::new(ProcessDesign {
        spool: None,
        chambers: None,
        flow: Some(flow),
        friction: None,
        is_pair: true,
        supply: false,
        level: 25.0,
        sample_time: SAMPLE_TIME,
        clear: 50,
        parameters: &ProcessParameters::DEFAULT,
    })
}

/// What is said of a rod that moves as its oil does, the readings of which drift from the second minute on by `drifts`,
/// m/s, in the form of a gain or not, the supply's pressure being so high from then on, bar. A second later somebody is
/// suspected, and the oil `asked`.
fn said_at(drifts: [f64; 2], asked: bool, is_gain: bool, pressure: f64) -> Option<f64> {
    let (mut process, mut length, mut last, mut newest) = (process(), 0.0, 0.0, None);
    for k in 0..80 * 50 {
        let time = SAMPLE_TIME * f64::from(k);
        let spool = 20.0 * libm::sin(0.05 * f64::from(k));
        let root = if time < 60.0 { 1.0 } else { libm::sqrt(pressure / 210.0) };
        length += SAMPLE_TIME * root * 0.5 * (last + spool) / 100.0;
        last = spool;
        let [c1, c2] = drifts.map(|drift| length + drift * (time - 60.0).max(0.0));
        let held = time > 61.0;
        let said = process.step(&ProcessInput {
            command: None,
            spool: Some(spool),
            chambers: [None; 2],
            load: Some(0.0),
            supply: Some(if time < 60.0 { 210.0 } else { pressure }),
            lengths: [Some(c1), Some(c2)],
            apart: Some(c1 - c2),
            monitored: true,
            is_lost: false,
            held,
            asked: held && asked,
            is_gain,
            at: Timestamp::default(),
        });
        assert!(held || said.is_none(), "nobody has asked");
        newest = said.or(newest);
        assert_eq!(process.alarm(), None);
    }
    newest
}

fn said(drifts: [f64; 2], asked: bool) -> Option<f64> {
    said_at(drifts, asked, false, 210.0)
}

/// There a curve that is off looks like a gain, but not like a drift.
#[test]
fn at_a_supply_that_was_not_taught_the_oil_tells_nothing_of_a_gain() {
    let of = |is_gain, pressure| said_at([2e-3, 0.0], true, is_gain, pressure);
    for pressure in [171.0, 210.0, 252.0] {
        assert!(of(true, pressure).is_some_and(|nats| nats > 8.0), "{pressure}");
    }
    for pressure in [169.0, 254.0] {
        assert_eq!(of(true, pressure), None, "{pressure}");
        assert!(of(false, pressure).is_some_and(|nats| nats > 8.0), "{pressure}");
    }
}

#[test]
fn the_oil_tells_whose_reading_drifts_where_it_is_asked() {
    for rate in [2e-3, -2e-3] {
        assert!(said([rate, 0.0], true).is_some_and(|nats| nats > 8.0));
        assert!(said([0.0, rate], true).is_some_and(|nats| nats < -8.0));
        assert_eq!(said([rate, 0.0], false), None);
    }
}

/// c₁ to c₄ of the rod that [`swing`] moves.
const FORCES: [f64; FORCE_TERMS] = [2.0, 5.0, 20.0, 1.5];

/// A detector that knows friction and nothing else.
fn of_friction() -> Process {
    let friction =
        FrictionDesign { coefficients: FORCES, scatter: [0.01, 0.005, 0.1], area_ratio: 0.5 };
    Process::new(ProcessDesign {
        spool: None,
        chambers: None,
        flow: None,
        friction: Some(friction),
        is_pair: true,
        supply: false,
        level: 25.0,
        sample_time: SAMPLE_TIME,
        clear: 50,
        parameters: &ProcessParameters::DEFAULT,
    })
}

/// Cycle `k` of a rod that swings by half a metre in 8 s, and takes so much `more` pressure by Coulomb's friction, bar.
fn swing(k: u32, more: f64, held: bool) -> ProcessInput {
    let (t, w) = (SAMPLE_TIME * f64::from(k), core::f64::consts::PI / 4.0);
    let rod = |t: f64| [libm::sin(w * t), w * libm::cos(w * t)].map(|it| 0.5 * it);
    // P_L counts from a cycle to the next, so that it is that of its middle.
    let ([length, _], [at, speed]) = (rod(t), rod(t - 0.5 * SAMPLE_TIME));
    let along = libm::tanh(speed / ProcessParameters::DEFAULT.friction_speed);
    let terms = [at, -w * w * at, speed, along];
    let load: f64 = terms.iter().zip(FORCES).map(|(term, of)| term * of).sum();
    ProcessInput {
        command: None,
        spool: None,
        chambers: [None; 2],
        load: Some(24.0 + load + more * along),
        supply: None,
        lengths: [Some(length); 2],
        apart: None,
        monitored: true,
        is_lost: false,
        held,
        asked: false,
        is_gain: false,
        at: Timestamp::default(),
    }
}

#[test]
fn friction_that_has_grown_is_found_with_its_size_and_ends_with_it() {
    let mut process = of_friction();
    for k in 0..60 * 50 {
        process.step(&swing(k, 0.0, false));
        assert_eq!(process.alarm(), None);
    }
    let mut raised = None;
    for k in 60 * 50..120 * 50 {
        process.step(&swing(k, 2.0, false));
        raised = raised.or(process.alarm().map(|_| k));
    }
    let delay = SAMPLE_TIME * f64::from(raised.expect("it is found")) - 60.0;
    assert!((1.0..20.0).contains(&delay), "{delay} s");
    let alarm = process.alarm().expect("it stands");
    assert_eq!(alarm.malfunction, Malfunction::Friction);
    let size = alarm.size.expect("it was looked at for long enough");
    // The rest went with what is slow.
    assert!((1.6..2.05).contains(&size), "{size} bar");
    for k in 120 * 50..400 * 50 {
        process.step(&swing(k, 0.0, false));
    }
    assert_eq!(process.alarm(), None, "it goes as before");
}

#[test]
fn friction_is_not_judged_while_a_transducer_is_suspected_nor_by_what_went_before() {
    let (mut process, settling) = (of_friction(), ProcessParameters::DEFAULT.friction_settling);
    let mut last = 0;
    for k in 0..240 * 50 {
        // What the rod does meanwhile is the controller's answer to a wrong reading.
        let held = (60 * 50..120 * 50).contains(&k);
        process.step(&swing(k, if held { 4.0 } else { 0.0 }, held));
        assert_eq!(process.alarm(), None, "{k}");
        let open = if k < 60 * 50 { k } else { k.saturating_sub(120 * 50) };
        let is_known = SAMPLE_TIME * f64::from(open) > settling;
        let is_judged = process.judged() & Relation::Friction.bit() != 0;
        assert!(is_known || !is_judged, "{k}");
        last = if is_judged { k } else { last };
    }
    assert_eq!(last + 1, 240 * 50);
}

/// A controller that follows a transducer which lies may take all the oil there is.
#[test]
fn a_rod_is_as_long_as_either_reading_says_and_of_no_length_under_suspicion() {
    let mut process = of_friction();
    let mut told = |lengths, held| {
        process.step(&ProcessInput { lengths, supply: Some(230.0), ..swing(0, 0.0, held) });
        process.oil()
    };
    let reading = |length| OilReading { pressure: Some(230.0), length };
    assert_eq!(told([Some(0.1), Some(0.2)], false), reading(Some(0.1)));
    assert_eq!(told([None, Some(0.2)], false), reading(Some(0.2)));
    assert_eq!(told([Some(0.1), Some(0.2)], true), reading(None));
    assert_eq!(told([None; 2], false), reading(None));
}

#[test]
fn pressures_spool_supply_and_oil_come_before_friction() {
    let mut process = of_friction();
    let alarm = |malfunction, age| {
        let onset = Timestamp::default();
        Some(ProcessAlarm {
            malfunction,
            size: None,
            nats: 30.0,
            urgency: Urgency::None,
            onset,
            age,
            quiet: 0,
        })
    };
    let named = |process: &Process| process.alarm().map(|alarm| alarm.malfunction);
    let old = process.counts.company;
    (process.alarms[Relation::Friction as usize], process.is_raised) =
        (alarm(Malfunction::Friction, old), true);
    assert_eq!(named(&process), Some(Malfunction::Friction));
    for (which, malfunction) in [
        (Relation::Flow, Malfunction::Leakage),
        (Relation::Supply, Malfunction::Supply),
        (Relation::Spool, Malfunction::Sticking),
        (Relation::Chambers, Malfunction::Chambers),
    ] {
        process.alarms[which as usize] = alarm(malfunction, old);
        assert_eq!(named(&process), Some(malfunction));
    }
    let [.., of_blocks] = process.levels;
    // Ten cycles are one block: as many false alarms an hour take log 10 less.
    assert!((25.0 - of_blocks - libm::log(0.2 / SAMPLE_TIME)).abs() < 1e-9, "{of_blocks}");
}

/// The longest windows hold a friction of half a minute for a minute more than its alarm lasts.
#[test]
fn nothing_is_left_of_a_friction_that_is_over() {
    let (mut process, mut raises, mut was_raised) = (of_friction(), 0, false);
    for k in 0..240 * 50 {
        let more = if (60 * 50..90 * 50).contains(&k) { 2.0 } else { 0.0 };
        process.step(&swing(k, more, false));
        let is_raised = process.alarm().is_some();
        raises += u32::from(is_raised && !was_raised);
        if was_raised && !is_raised {
            let left = process.friction.as_ref().map(|it| it.peak().nats);
            assert_eq!(left, Some(0.0), "it would raise it again");
        }
        was_raised = is_raised;
    }
    assert_eq!((raises, was_raised), (1, false));
}
