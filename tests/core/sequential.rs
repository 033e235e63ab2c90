//! The sequential detectors on a simulated machine that they were calibrated to: what they find, how
//! soon, whom they blame, and what they let pass.

use crate::sequential_support::{Bench, fine, one_each, setup};
use tertius::alarm::Detector;
use tertius::controller::State;
use tertius::sequential::{Blame, Judgement, stops};
use tertius::simulator::{EPOCH, Options};
use tertius::verdict::{Fault as Kind, Suspect};

#[test]
fn a_healthy_machine_is_left_alone() {
    let heard = setup().run(900.0, false, &[]);
    assert!(heard.warnings.is_empty(), "{}", heard.told());
}

#[test]
fn half_a_millimetre_is_found_and_the_right_transducer_blamed() {
    for size in ["0.0005", "-0.0005"] {
        let (faults, truth) = one_each(&format!("step,size={size}"));
        let heard = setup().run(45.0, false, &faults);
        for (cylinder, suspect, at) in truth {
            let (delay, last) = heard.of(cylinder, at).expect("it is found");
            assert!((0.0..0.2).contains(&delay), "{cylinder}: {delay}");
            assert_eq!(last.finding.suspect, suspect, "{cylinder}: {:?}", last.finding);
            assert_eq!(last.finding.fault, Kind::Abrupt, "{cylinder}");
            let size = last.finding.residual.expect("it has a size").abs();
            assert!((size - 5e-4).abs() < 1.5e-4, "{cylinder}: {size}");
            let evidence = last.finding.evidence.expect("it has evidence");
            let onset = evidence.onset.since(EPOCH).as_seconds();
            assert!((onset - at).abs() < 0.1, "{cylinder}: {onset} for {at}");
            assert!(evidence.location.is_some_and(|nats| nats.abs() > 5.0), "{evidence:?}");
        }
    }
}

/// Ten millimetres are in the variance, too, and sooner than in the mean.
#[test]
fn a_large_step_is_no_noise() {
    for size in ["0.003", "-0.025"] {
        let (faults, truth) = one_each(&format!("step,size={size}"));
        let heard = setup().run(45.0, false, &faults);
        for (cylinder, suspect, at) in truth {
            let (delay, last) = heard.of(cylinder, at).expect("it is found");
            assert!((0.0..0.2).contains(&delay), "{cylinder}: {delay}");
            let told = (last.finding.suspect, last.finding.fault);
            assert_eq!(told, (suspect, Kind::Abrupt), "{size} {cylinder}\n{}", heard.told());
        }
    }
}

#[test]
fn noise_is_told_from_a_step_and_its_transducer_blamed() {
    let (faults, truth) = one_each("noise,size=0.000868");
    let heard = setup().run(45.0, false, &faults);
    for (cylinder, suspect, at) in truth {
        let (delay, last) = heard.of(cylinder, at).expect("it is found");
        // No sample is more than 3.9 nats, because it might be wild; the slowest of these takes 0.69 s.
        assert!((0.0..0.8).contains(&delay), "{cylinder}: {delay}");
        let told = (last.finding.suspect, last.finding.fault);
        assert_eq!(told, (suspect, Kind::Noise), "{cylinder}\n{}", heard.told());
    }
}

/// In the closed loop the controller follows C1, and C2 is the one that looks wrong.
#[test]
fn a_slow_drift_is_found_and_without_the_flow_nobody_is_blamed_for_it() {
    let setup = setup().without_process();
    for in_loop in [false, true] {
        for rate in [1e-3, 1e-4] {
            let (faults, truth) = one_each(&format!("drift,rate={rate}"));
            let heard = setup.run(50.0, in_loop, &faults);
            for (cylinder, _, at) in truth {
                let (delay, last) = heard.of(cylinder, at).expect("it is found");
                assert!((0.0..4.0).contains(&delay), "{cylinder}: {delay}");
                assert_eq!(last.finding.suspect, Suspect::Undecided, "{cylinder} {in_loop} {rate}");
                if rate > 2e-4 {
                    assert_eq!(last.finding.fault, Kind::Incipient, "{cylinder} {in_loop}");
                }
            }
        }
    }
}

/// The oil moves the rod, whatever the readings make the controller command.
#[test]
fn the_flow_names_who_drifts_in_the_loop() {
    let (faults, truth) = one_each("drift,rate=0.001");
    let heard = setup().run(50.0, true, &faults);
    let mut named = 0;
    for (cylinder, suspect, at) in truth {
        let (_, last) = heard.of(cylinder, at).expect("it is found");
        let said = last.finding.suspect;
        assert!(said == suspect || said == Suspect::Undecided, "{cylinder}\n{}", heard.told());
        named += u32::from(said == suspect);
    }
    // The first two begin before the flow of their cylinders is known well enough.
    assert!(named >= 4, "{}", heard.told());
}

/// That the readings agree is said where they do: a fault of a reading is in C1 − C2 as soon as in its
/// observer's innovation.
#[test]
fn a_transducers_fault_is_not_taken_for_the_process() {
    let mut told = 0;
    for in_loop in [false, true] {
        for fault in [
            "step,size=0.00125",
            "step,size=-0.003",
            "step,size=0.02",
            "noise,size=0.000868",
            "noise,size=0.002",
            "incipient,size=0.07",
            "drift,rate=0.02",
            "spike,size=0.005,probability=0.02",
        ] {
            let (faults, truth) = one_each(fault);
            let heard = setup().run(45.0, in_loop, &faults);
            for (cylinder, suspect, at) in truth {
                let own = heard.others.iter().filter(|warning| warning.cylinder == cylinder);
                let since = own.filter(|w| w.timestamp.since(EPOCH).as_seconds() < at + 5.0);
                let observers =
                    since.filter(|w| matches!(w.detector, Detector::Fde1 | Detector::Fde2));
                for warning in observers {
                    told += u32::from(warning.finding.suspect == suspect);
                    let what = (fault, in_loop, cylinder, warning);
                    assert_ne!(warning.finding.suspect, Suspect::Process, "{what:?}");
                }
            }
        }
    }
    assert!(told > 100, "{told}");
}

/// Spikes of single samples and lost frames are no faults of a transducer's length.
#[test]
fn single_wild_samples_and_lost_frames_are_let_pass() {
    let faults = [
        "spike,size=0.01,probability=0.005,cylinder=2,sensor=c1,at=20",
        "loss,probability=0.02,cylinder=4,sensor=c2,at=20",
    ];
    let heard = setup().run(120.0, false, &faults.map(str::to_owned));
    assert!(heard.warnings.is_empty(), "{}", heard.told());
}

/// The machine goes down to its stops again and again; C1 of cylinder 3 drifts meanwhile.
#[test]
fn the_stop_tells_which_transducer_has_drifted() {
    let setup = setup();
    let faults = ["drift,rate=0.00001,cylinder=3,sensor=c1,at=400".to_owned()];
    let options = Options { start: State::Safe, ..setup.options(9, &faults) };
    let (mut simulator, mut bench) = (setup.simulator(&options), Bench::new(setup));
    for round in 0..10 {
        for state in [State::Engaged, State::Safe] {
            simulator.request(state);
            bench.run(&mut simulator, 60.0);
        }
        let heard = &bench.heard;
        assert!(round < 3 || heard.dwells.len() >= 6 * 3, "{round}: {}", heard.dwells.len());
    }
    let Bench { monitor, heard } = bench;
    let (_, last) = heard.of(3, 400.0).expect("the drift is found");
    assert_eq!(last.finding.suspect, Suspect::C1, "{}", heard.told());
    assert!(heard.warnings.iter().all(|warning| warning.cylinder == 3), "{}", heard.told());
    let judged = stops::judge(monitor.dwells().map(|(_, dwells)| dwells));
    let blame = |judged: &Option<Judgement>| judged.map_or(Blame::Neither, |it| it.blame);
    let blames: Vec<Blame> = judged.iter().map(blame).collect();
    let mut expected = [Blame::Neither; 6];
    expected[2] = Blame::C1;
    assert_eq!(blames, expected);
    let (_, dwells) = monitor.dwells().find(|(n, _)| *n == 3).expect("it has one");
    let trend = dwells.trend(0).expect("there is a history");
    assert!(trend.per_month > 10.0 * trend.error, "{trend:?}");
}

/// Where they move in steps of four counts, what chance seems to add to the time between both samples is
/// large now and then: still whose a fault is, is told.
#[test]
fn steps_and_noise_on_coarse_transducers_have_their_suspects() {
    let coarse = fine(&[("counts = 27648.0", "counts = 6912.0")], "");
    let setup = setup().with(coarse).calibrated();
    for fault in ["step,size=0.00125", "noise,size=0.0013"] {
        let (faults, truth) = one_each(fault);
        let heard = setup.run(50.0, false, &faults);
        let last = |(cylinder, suspect, at): &(u8, Suspect, f64)| {
            (heard.of(*cylinder, *at).expect("it is found").1.finding.suspect, *suspect)
        };
        let said: Vec<_> = truth.iter().map(last).collect();
        let right = said.iter().filter(|(found, truth)| found == truth).count();
        let wrong = said.iter().filter(|it| it.0 != it.1 && it.0 != Suspect::Undecided).count();
        assert!(right >= 5 && wrong == 0, "{fault}: {said:?}");
    }
    // Small noise of two at once, which may be the sampling's as far as each alone can tell.
    let (mut right, mut wrong) = (0, 0);
    for seed in 0..6 {
        let noisy = [(1 + seed as u8 % 3, Suspect::C1), (4 + seed as u8 % 3, Suspect::C2)];
        let faults = noisy.map(|(cylinder, suspect)| {
            let sensor = suspect.name();
            format!("noise,size=0.000434,cylinder={cylinder},sensor={sensor},at=40")
        });
        let heard = setup.play(50.0, &setup.options(seed, &faults));
        for (cylinder, suspect) in noisy {
            let last = heard.of(cylinder, 40.0).map(|(_, last)| last.finding.suspect);
            right += u32::from(last == Some(suspect));
            wrong += u32::from(![None, Some(Suspect::Undecided), Some(suspect)].contains(&last));
        }
    }
    assert!(right >= 10 && wrong == 0, "{right} of 12 right, {wrong} wrong");
}
