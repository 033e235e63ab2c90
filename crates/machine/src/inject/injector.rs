//! Frames in, frames with faults out.

use super::placed::Placed;
use super::shape::{Code, Reading, Shape, Unrounded, Window};
use super::tally::Tally;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tertius_core::decode::{Decoded, Inserted, SignalPlan};
use tertius_core::frame::{BusNumber, Frame, Id, Kind};
use tertius_core::time::{Span, Timestamp};

/// Puts faults into frames, one frame at a time. It allocates only when it is made.
#[derive(Clone, Debug)]
pub struct Injector {
    /// Messages with faults, sorted by identifier.
    lines: Vec<Line>,
    tallies: Vec<Tally>,
    first: Option<Timestamp>,
    /// The frame that replaces one with a fault.
    changed: Frame,
}

/// Faults of one message, in the order in which they act.
#[derive(Clone, Debug)]
struct Line {
    place: (BusNumber, Id),
    stages: Vec<Stage>,
}

#[derive(Clone, Debug)]
enum Stage {
    /// Faults of one signal, applied to its value together and rounded once.
    Signal {
        plan: SignalPlan,
        faults: Vec<Active>,
    },
    /// Repetition of the whole payload.
    Stale(Active, Option<Frame>),
    Loss(Active, f64),
}

/// Identifier of [`Injector::changed`] before the first frame with a fault.
const NO_ID: Id = Id::standard(0).expect("0 has at most 11 bits");

/// One fault at work.
#[derive(Clone, Debug)]
struct Active {
    /// Index of the fault's tally.
    index: usize,
    shape: Shape,
    window: Window,
    rng: ChaCha8Rng,
    /// Reading that a freeze holds.
    held: Option<Reading>,
}

impl Injector {
    /// An injector of `faults`, which act in this order where they meet. Each draws from its own
    /// stream of `seed`, so that another fault does not change the earlier ones.
    pub fn new(faults: &[Placed], seed: u64) -> Self {
        let mut lines: Vec<Line> = Vec::new();
        for (index, placed) in faults.iter().enumerate() {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(index as u64);
            let (shape, window) = (placed.shape, placed.window);
            let active = Active { index, shape, window, rng, held: None };
            let place = (placed.bus, placed.id);
            let at = lines.partition_point(|line| line.place < place);
            if lines.get(at).is_none_or(|line| line.place != place) {
                lines.insert(at, Line { place, stages: Vec::new() });
            }
            lines[at].add(active, &placed.plan);
        }
        Self {
            lines,
            tallies: vec![Tally::default(); faults.len()],
            first: None,
            changed: Frame::new(Timestamp::default(), NO_ID, Kind::Data, &[]),
        }
    }

    /// Takes the next frame and returns the frame to pass on instead; `None` if it is lost. The
    /// first frame of all, whatever it is, starts the time of the faults.
    pub fn take<'a>(&'a mut self, frame: &'a Frame) -> Option<&'a Frame> {
        self.take_measured(frame, |_| None)
    }

    /// Takes the next frame as [`Self::take`] does, where the transducers' lengths before their
    /// rounding to the counts of `frame` are known. A fault of a transducer adds to those lengths,
    /// so that a quarter of a count changes every fourth reading by one count instead of none.
    pub fn take_measured<'a>(
        &'a mut self,
        frame: &'a Frame,
        unrounded: impl Fn(&SignalPlan) -> Option<Unrounded>,
    ) -> Option<&'a Frame> {
        let first = *self.first.get_or_insert(frame.timestamp);
        if !matches!(frame.kind, Kind::Data | Kind::Fd { .. }) {
            return Some(frame);
        }
        let key = (frame.bus, frame.id);
        let Ok(place) = self.lines.binary_search_by_key(&key, |line| line.place) else {
            return Some(frame);
        };
        self.changed.clone_from(frame);
        let elapsed = frame.timestamp.since(first);
        for stage in &mut self.lines[place].stages {
            if !stage.apply(elapsed, &mut self.changed, &mut self.tallies, &unrounded) {
                return None;
            }
        }
        Some(&self.changed)
    }

    /// Tallies of all faults so far, in the order in which the faults were given.
    pub fn tallies(&self) -> &[Tally] {
        &self.tallies
    }
}

impl Line {
    fn add(&mut self, active: Active, plan: &SignalPlan) {
        match active.shape {
            Shape::Stale => self.stages.push(Stage::Stale(active, None)),
            Shape::Loss { probability } => self.stages.push(Stage::Loss(active, probability)),
            _ => self.add_to_signal(active, plan),
        }
    }

    /// Adds a fault of a signal. Faults of one signal share a stage, unless a fault of the whole
    /// message stands between them. The order among signals does not matter, since they have
    /// different bits.
    fn add_to_signal(&mut self, active: Active, plan: &SignalPlan) {
        for stage in self.stages.iter_mut().rev() {
            match stage {
                Stage::Signal { plan: known, faults } if known == plan => {
                    return faults.push(active);
                }
                Stage::Signal { .. } => {}
                Stage::Stale(..) | Stage::Loss(..) => break,
            }
        }
        self.stages.push(Stage::Signal { plan: plan.clone(), faults: vec![active] });
    }
}

impl Stage {
    /// Applies the stage to `frame`; returns `false` if it is lost.
    fn apply(
        &mut self,
        elapsed: Span,
        frame: &mut Frame,
        tallies: &mut [Tally],
        unrounded: impl Fn(&SignalPlan) -> Option<Unrounded>,
    ) -> bool {
        match self {
            Self::Signal { plan, faults } => {
                change(plan, faults, elapsed, frame, tallies, || unrounded(plan));
            }
            Self::Stale(active, held) => {
                let held = held.get_or_insert_with(|| frame.clone());
                if active.window.age(elapsed).is_none() {
                    held.clone_from(frame);
                    return true;
                }
                let tally = &mut tallies[active.index];
                tally.frames += 1;
                tally.altered += u64::from(held.data() != frame.data());
                *frame.buffer_mut() = *held.buffer();
                frame.set_length(held.length());
                frame.kind = held.kind;
            }
            Self::Loss(active, probability) => {
                if active.window.age(elapsed).is_some() {
                    let tally = &mut tallies[active.index];
                    let lost = active.rng.random_bool(*probability);
                    tally.frames += 1;
                    tally.altered += u64::from(lost);
                    return !lost;
                }
            }
        }
        true
    }
}

/// Applies the faults of one signal to `frame`.
fn change(
    plan: &SignalPlan,
    faults: &mut [Active],
    elapsed: Span,
    frame: &mut Frame,
    tallies: &mut [Tally],
    unrounded: impl Fn() -> Option<Unrounded>,
) {
    let Decoded::Value(value) = plan.decode(frame) else {
        let active = faults.iter().filter(|fault| fault.window.age(elapsed).is_some());
        active.for_each(|fault| tallies[fault.index].absent += 1);
        return;
    };
    let unrounded = unrounded();
    let physical = unrounded.map_or(value.physical, |it| it.length);
    let grid = unrounded.map(|it| it.grid);
    let mut reading = Reading { physical, raw: Some(value.raw), grid };
    let mut touched = false;
    for fault in faults.iter_mut() {
        touched |= fault.apply(plan, elapsed, &mut reading, &mut tallies[fault.index]);
    }
    // Not told from the values: a float's NaN is unequal to itself, and written back it may have
    // other bits.
    if !touched {
        return;
    }
    let inserted = match reading.raw {
        Some(raw) => plan.insert(raw, frame.buffer_mut()),
        None => plan.insert_physical(reading.rounded(), frame.buffer_mut()),
    };
    if inserted != Inserted::Whole {
        let active = faults.iter().filter(|fault| fault.window.age(elapsed).is_some());
        active.for_each(|fault| tallies[fault.index].clamped += 1);
    }
}

impl Active {
    /// Applies the fault to `reading`; returns whether there was anything to do.
    fn apply(
        &mut self,
        plan: &SignalPlan,
        elapsed: Span,
        reading: &mut Reading,
        tally: &mut Tally,
    ) -> bool {
        let age = self.window.age(elapsed);
        if self.shape == Shape::Freeze && (age.is_none() || self.held.is_none()) {
            self.held = Some(*reading);
        }
        let Some(age) = age else { return false };
        tally.frames += 1;
        let before = *reading;
        match self.shape {
            Shape::Constant(Code::Raw(code)) => {
                let raw = tertius_core::decode::Raw::Signed(code);
                *reading = Reading { physical: plan.physical(raw), raw: Some(raw), grid: None };
            }
            Shape::Constant(Code::Physical(physical)) => {
                *reading = Reading { physical, raw: None, grid: None };
            }
            shape => match shape.addition(reading.physical, age, &mut self.rng) {
                // Nothing added leaves every bit as it is.
                Some(0.0) => return false,
                Some(addition) => {
                    let physical = reading.physical + addition;
                    *reading = Reading { physical, raw: None, ..*reading };
                }
                None => *reading = self.held.unwrap_or(*reading),
            },
        }
        tally.altered += u64::from(*reading != before);
        true
    }
}
