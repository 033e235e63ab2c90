//! A machine with its gateway: the gateway hears the machine's frames, and the machine's controller the gateway's.

use super::cases::Policy;
use super::reader::{Blamed, Reader};
use tertius_core::alarm::{Detector, OwnFrame};
use tertius_core::frame::Frame;
use tertius_core::monitor::{Monitor, Sink};
use tertius_machine::controller::State;
use tertius_machine::hexapod::Tip;
use tertius_machine::plant::CYLINDERS;
use tertius_machine::simulator::Simulator;

/// Smallest residual with which the observers' and the comparator's word is taken, m. One crossing of their thresholds
/// may be chance, above all on coarse transducers; 1 cm is beyond what healthy transducers differ by (section 5-5).
const LARGE: f64 = 0.01;

/// Fd_Warning.Fault of a frozen reading.
const FROZEN: u8 = 6;

/// Whether the controller acts upon such a warning at once. A reading that is called frozen may stand because the rod
/// turns while the other reading wanders off: it has to go on standing ([`Installation::step`]).
fn is_believed(blamed: &Blamed) -> bool {
    let by = |detector: Detector| blamed.detector == detector as u8;
    by(Detector::Sequential)
        || (by(Detector::Plausibility) && blamed.fault != FROZEN)
        || blamed.residual.is_some_and(|residual| residual.abs() >= LARGE)
}

/// The gateway's frames of a cycle.
#[derive(Clone, Debug, Default)]
struct Sent(Vec<Frame>);

impl Sink for Sent {
    fn wants_records(&self) -> bool {
        false
    }

    fn transmit(&mut self, frame: &OwnFrame) {
        self.0.push(frame.as_frame().clone());
    }
}

/// A reading that was called frozen.
#[derive(Clone, Copy, Debug)]
struct Standing {
    blamed: Blamed,
    /// Readings of its cylinder when it was called so, m.
    lengths: [f64; 2],
}

impl Standing {
    fn still_stands(&self, lengths: &[[f64; 2]; CYLINDERS]) -> bool {
        let Blamed { leg, which, .. } = self.blamed;
        lengths[leg][which] == self.lengths[which]
    }

    /// Whether the other reading has gone on by [`LARGE`].
    fn has_parted(&self, lengths: &[[f64; 2]; CYLINDERS]) -> bool {
        let Blamed { leg, which, .. } = self.blamed;
        (lengths[leg][1 - which] - self.lengths[1 - which]).abs() >= LARGE
    }
}

/// Motion of a machine, from when it is followed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Largest difference of each cylinder's true length from that of the healthy machine, before a code black, m.
    pub rods: [f64; CYLINDERS],
    /// Largest way of the gangway's tip, m, the way into the safe state after a code black included.
    pub tip: f64,
}

/// A machine, its gateway, and what its controller makes of the gateway's frames.
#[derive(Clone, Debug)]
pub struct Installation {
    pub simulator: Simulator,
    monitor: Monitor,
    reader: Reader,
    sent: Sent,
    tip: Tip,
    policy: Policy,
    /// Transducers that were blamed.
    out: [[bool; 2]; CYLINDERS],
    /// Readings that were called frozen.
    standing: Vec<Standing>,
    pub motion: Motion,
}

impl Installation {
    /// With a gangway of `gangway` from the middle of the deck, m.
    pub fn new(simulator: Simulator, monitor: Monitor, reader: Reader, gangway: f64) -> Self {
        Self {
            simulator,
            monitor,
            reader,
            sent: Sent::default(),
            tip: Tip::new(gangway),
            policy: Policy::Stay,
            out: [[false; 2]; CYLINDERS],
            standing: Vec::new(),
            motion: Motion::default(),
        }
    }

    /// The same with another policy.
    pub fn with(&self, policy: Policy) -> Self {
        Self { policy, ..self.clone() }
    }

    /// Plays one cycle; the warnings in it that blame a transducer and are believed. What the gateway sends in a cycle
    /// is known to the controller in the next one.
    pub fn step(&mut self) -> Vec<Blamed> {
        let Self { simulator, monitor, sent, reader, .. } = self;
        if simulator.is_black() {
            simulator.step(&mut |_| {});
            return Vec::new();
        }
        simulator.step(&mut |frame| monitor.take(frame, sent));
        reader.open();
        let told = sent.0.drain(..).filter_map(|frame| reader.take(&frame));
        let (mut blamed, doubtful): (Vec<Blamed>, Vec<Blamed>) = told.partition(is_believed);
        simulator.tell(reader.lengths());
        let lengths = self.simulator.heard().lengths;
        for it in doubtful.into_iter().filter(|it| it.fault == FROZEN) {
            self.standing.push(Standing { blamed: it, lengths: lengths[it.leg] });
        }
        self.standing.retain(|it| it.still_stands(&lengths));
        let frozen = self.standing.iter().filter(|it| it.has_parted(&lengths));
        blamed.extend(frozen.map(|it| it.blamed));
        blamed
    }

    /// Lets the controller act upon `blamed`.
    pub fn act(&mut self, blamed: &[Blamed]) {
        let Some(instead) = self.policy.instead() else { return };
        for Blamed { leg, which, .. } in blamed {
            if std::mem::replace(&mut self.out[*leg][*which], true) {
                continue;
            }
            let Some(supervision) = self.simulator.supervision() else { continue };
            supervision.leave_out(*leg);
            if self.out[*leg] == [true; 2] {
                // Nothing is left to rely on.
                supervision.trip();
                self.simulator.request(State::Safe);
            } else if *which == 0 {
                self.simulator.measure(*leg, instead);
            }
        }
    }

    /// Follows the machine's motion at the present time, where the healthy machine's strokes are `healthy`, m.
    pub fn follow(&mut self, healthy: &[f64; CYLINDERS]) {
        let machine = self.simulator.machine();
        let strokes = machine.states().map(|state| state.length);
        if !self.simulator.is_black() {
            for (rod, (is, would)) in self.motion.rods.iter_mut().zip(strokes.iter().zip(healthy)) {
                *rod = rod.max((is - would).abs());
            }
        }
        let moved = self.tip.motion(machine.hexapod(), &machine.motion().pose, &strokes);
        self.motion.tip = moved.map_or(self.motion.tip, |moved| self.motion.tip.max(moved));
    }
}

#[cfg(test)]
mod tests {
    use super::super::reader::tests::database;
    use super::*;
    use tertius_config::design;
    use tertius_machine::controller::Supervision;
    use tertius_machine::simulator::{Options, Tables};

    fn installation(policy: Policy) -> Installation {
        let text = include_str!("../../../../../config/e-type-simulated.toml");
        let (settings, _) = tertius_config::parse("e-type.toml", text).expect("it is sound");
        let database = database();
        let design = design::judging(&settings, &database).expect("they fit");
        let options = Options { in_loop: true, ..Options::default() };
        let mut simulator = Simulator::new(&Tables::default(), &settings, &database, &options)
            .expect("it can be simulated");
        simulator.supervise(Supervision::new(0.05, 5));
        let reader = Reader::new(&database).expect("it has them");
        Installation::new(simulator, Monitor::new(design), reader, 20.0).with(policy)
    }

    fn blamed(which: usize, detector: Detector, residual: Option<f64>) -> Blamed {
        Blamed { leg: 4, which, detector: detector as u8, fault: 1, residual }
    }

    #[test]
    fn one_crossing_of_a_threshold_is_not_believed_and_what_is_large_is() {
        for detector in [Detector::Fde1, Detector::Fde2, Detector::Fde3] {
            assert!(!is_believed(&blamed(0, detector, Some(-0.002))));
            assert!(is_believed(&blamed(0, detector, Some(-0.06))));
        }
        for detector in [Detector::Sequential, Detector::Plausibility] {
            assert!(is_believed(&blamed(1, detector, None)));
        }
    }

    #[test]
    fn a_frozen_reading_is_believed_when_the_other_one_has_gone_on() {
        let frozen = Blamed { fault: FROZEN, ..blamed(0, Detector::Plausibility, None) };
        assert!(!is_believed(&frozen));
        let standing = Standing { blamed: frozen, lengths: [0.2, 0.203] };
        let at = |first, second| {
            let mut lengths = [[0.0; 2]; CYLINDERS];
            lengths[4] = [first, second];
            [standing.still_stands(&lengths), standing.has_parted(&lengths)]
        };
        assert_eq!(at(0.2, 0.196), [true, false]);
        assert_eq!(at(0.2, 0.192), [true, true]);
        assert!(!at(0.2001, 0.192)[0], "a count is enough");
    }

    #[test]
    fn a_machine_without_a_reading_to_rely_on_goes_black_and_one_that_stays_takes_no_notice() {
        for policy in Policy::ALL {
            let mut it = installation(policy);
            for which in [0, 0, 1] {
                assert!(!it.simulator.is_black(), "{policy:?}: one is left");
                it.act(&[blamed(which, Detector::Sequential, None)]);
                it.step();
            }
            assert_eq!(it.simulator.is_black(), policy != Policy::Stay, "{policy:?}");
        }
    }
}
