//! A healthy machine, and one with faults, on a bus that delays, shuffles and loses frames: what comes
//! late or not at all costs evidence, but makes no fault and blames nobody wrongly.

use crate::sequential_support::{self, Bench, Heard, Setup, setup};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tertius::alarm::{State as Said, Warning};
use tertius::frame::Frame;
use tertius::monitor::Counts;
use tertius::time::{Span, Timestamp};
use tertius::verdict::Suspect;

/// Frames on their way, by when they come.
#[derive(Default)]
struct Delayed(Vec<(Timestamp, Frame)>);

impl Delayed {
    fn push(&mut self, at: Timestamp, frame: Frame) {
        let place = self.0.partition_point(|(known, _)| *known <= at);
        self.0.insert(place, (at, frame));
    }

    /// Passes what has come by `now`.
    fn pass(&mut self, now: Timestamp, pass: &mut dyn FnMut(&Frame)) {
        let come = self.0.partition_point(|(at, _)| *at <= now);
        self.0.drain(..come).for_each(|(_, frame)| pass(&frame));
    }
}

const SYNC: u32 = 0x080;

/// A machine of which a `part` of the frames, but for Sync, comes 19 to 26 ms late.
fn with_late_frames(setup: &Setup, seconds: f64, part: f64, faults: &[String]) -> (Heard, Counts) {
    let (mut simulator, mut bench) =
        (setup.simulator(&setup.options(21, faults)), Bench::new(setup));
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    let mut delayed = Delayed::default();
    bench.run_through(&mut simulator, seconds, |_, frame, pass| {
        delayed.pass(frame.timestamp, pass);
        if frame.id.value() != SYNC && rng.random_bool(part) {
            let mut late = frame.clone();
            late.timestamp =
                frame.timestamp.after(Span::from_seconds(rng.random_range(0.019..0.026)));
            delayed.push(late.timestamp, late);
        } else {
            pass(frame);
        }
    });
    (bench.heard, *bench.monitor.counts())
}

/// A machine whose frames come in another order, by up to 5 ms, and of which one in fifty is lost.
fn shuffled(setup: &Setup, seed: u64, seconds: f64, faults: &[String]) -> (Heard, Counts) {
    let (mut simulator, mut bench) =
        (setup.simulator(&setup.options(seed, faults)), Bench::new(setup));
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut delayed = Delayed::default();
    bench.run_through(&mut simulator, seconds, |_, frame, pass| {
        let place = frame.timestamp.after(Span::from_seconds(rng.random_range(0.0..0.010)));
        delayed.pass(frame.timestamp, pass);
        if !rng.random_bool(0.02) {
            delayed.push(place, frame.clone());
        }
    });
    (bench.heard, *bench.monitor.counts())
}

fn position_only(setup: &Setup) -> Setup {
    let mut setup = setup.clone();
    let signals = &mut setup.settings.signals.cylinder;
    (signals.c1_velocity, signals.c2_velocity) = (None, None);
    setup
}

fn told(warnings: &[Warning]) -> String {
    let line = |w: &Warning| {
        let (at, found) = (w.timestamp.since(tertius::simulator::EPOCH).as_seconds(), &w.finding);
        let (fault, suspect) = (found.fault.name(), found.suspect.name());
        format!(
            "{at:.2} s {} {}: {} {fault} {suspect}\n",
            w.detector.name(),
            w.cylinder,
            w.state.name()
        )
    };
    warnings.iter().take(30).map(line).collect()
}

#[track_caller]
fn nothing(heard: &Heard, what: &str) {
    let (others, count) = (told(&heard.others), heard.others.len());
    assert!(heard.warnings.is_empty() && count == 0, "{what}: {count}\n{}{others}", heard.told());
}

/// The counter tells them from those that are punctual. As many as of an hour with one in a thousand.
#[test]
fn frames_late_by_a_cycle_are_no_fault() {
    let (heard, counts) = with_late_frames(setup(), 600.0, 0.006, &[]);
    println!("{counts:?}");
    assert!(counts.late > 2000, "{counts:?}");
    nothing(&heard, "late");
}

#[test]
fn shuffled_and_lost_frames_are_no_fault() {
    for (what, setup) in [("", setup().clone()), ("position only", position_only(setup()))] {
        let (heard, counts) = shuffled(&setup, 22, 300.0, &[]);
        println!("{what}: {counts:?}");
        assert!(counts.backwards > 10_000, "{counts:?}");
        nothing(&heard, what);
    }
}

/// Of each kind one on each cylinder, on C1 or C2: who is blamed is the one, or nobody.
#[test]
fn faults_on_such_a_bus_are_blamed_right_or_on_nobody() {
    for (what, setup) in [("", setup().clone()), ("position only", position_only(setup()))] {
        let once = ["step,size=0.004", "step,size=-0.02", "drift,rate=0.02"].map(|it| (23, it));
        // Noise of 2 and of 5 σ.
        let noise = |seed| ["noise,size=0.00087", "noise,size=0.00217"].map(|it| (seed, it));
        for (seed, fault) in once.into_iter().chain((23..27).flat_map(noise)) {
            let (faults, truth) = sequential_support::one_each(fault);
            let (heard, _) = shuffled(&setup, seed, 60.0, &faults);
            let (mut right, mut undecided) = (0, 0);
            for warning in heard.warnings.iter().chain(&heard.others) {
                let (_, suspect, at) = truth[usize::from(warning.cylinder) - 1];
                let since = warning.timestamp.since(tertius::simulator::EPOCH).as_seconds() - at;
                let found = warning.finding.suspect;
                let allowed = since > 0.0 && (found == suspect || found == Suspect::Undecided);
                assert!(allowed, "{what} {fault}: {}", told(&[*warning]));
                if warning.state == Said::Raised {
                    right += usize::from(found == suspect);
                    undecided += usize::from(found == Suspect::Undecided);
                }
            }
            println!("{what} {fault}, {seed}: {right} blamed right, {undecided} undecided");
            assert!(right + undecided >= 6, "{what} {fault}: not seen");
        }
    }
}
