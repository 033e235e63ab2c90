//! The process detector of one cylinder.

mod standing;

use super::alarm::{Malfunction, ProcessAlarm};
use super::chambers::ChambersDesign;
use super::evidence::{EvidenceWindows, Weighing};
use super::flow::{self, FlowDesign, FlowWatch};
use super::friction::{FrictionDesign, FrictionWatch};
use super::input::{OilReading, ProcessInput};
use super::losses::Losses;
use super::parameters::ProcessParameters;
use super::relation::{RELATIONS, Relation};
use super::spool::{Spool, SpoolDesign};
use super::trace::{SpoolForm, Trace};
use crate::alarm::Urgency;
use crate::sequential::statistic::Peak;
use crate::state::state;
use crate::time::{self, Span, Timestamp};

/// What a process detector is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct ProcessDesign {
    pub spool: Option<SpoolDesign>,
    pub chambers: Option<ChambersDesign>,
    pub flow: Option<FlowDesign>,
    pub friction: Option<FrictionDesign>,
    /// Whether there are two transducers, by which the flow is judged; beside a single one the oil gives the rod's speed
    /// alone.
    pub is_pair: bool,
    /// Whether the machine's supply is watched, see [`Process::take_supply`].
    pub supply: bool,
    /// h, nats.
    pub level: f64,
    /// s.
    pub sample_time: f64,
    /// Cycles without evidence that end an alarm.
    pub clear: u32,
    pub parameters: &'static ProcessParameters,
}

impl ProcessDesign {
    /// h of each relation, nats.
    pub fn levels(&self) -> [f64; RELATIONS] {
        let of_blocks = flow::level(self.level, self.sample_time);
        [self.level, self.level, of_blocks, of_blocks, of_blocks]
    }
}

/// The process detector of one cylinder.
#[derive(Clone, Debug)]
pub struct Process {
    design: ProcessDesign,
    /// h of each relation, nats.
    levels: [f64; RELATIONS],
    /// Of spool and chambers.
    weighings: [Option<Weighing>; 2],
    counts: Counts,
    /// α of (3-5).
    area_ratio: f64,
    spool: Option<Spool>,
    of_spool: EvidenceWindows,
    of_chambers: EvidenceWindows,
    flow: Option<FlowWatch>,
    friction: Option<FrictionWatch>,
    trace: Trace,
    /// Cycles of the present stay in a monitored state.
    open: u32,
    losses: Losses,
    /// A bit for each relation by which the newest cycle was judged.
    judged: u8,
    alarms: [Option<ProcessAlarm>; RELATIONS],
    /// Whether there is any.
    is_raised: bool,
    /// What the newest cycle told of the supply, and whether the supply was judged in the one before.
    oil: OilReading,
    is_supply_judged: bool,
}

state! {
    Process { of_spool, of_chambers, trace, open, losses, judged, alarms, is_raised, oil, is_supply_judged }
    parts { spool, flow, friction }
    but { design, levels, weighings, counts, area_ratio }
    sound |it| it.is_raised == it.alarms.iter().any(Option::is_some)
}

/// Times of [`ProcessParameters`] in cycles.
#[derive(Clone, Copy, Debug)]
struct Counts {
    opening: u32,
    looks: [u32; 2],
    company: u32,
    lost: u32,
    gone: u32,
}

impl Process {
    pub fn new(design: ProcessDesign) -> Self {
        let (by, sample_time) = (design.parameters, design.sample_time);
        let cycles = |seconds| time::cycles(seconds, sample_time);
        let weighing = |band, dependence| Weighing::new(band, dependence, sample_time);
        let of_spool = design.spool.as_ref();
        let of_chambers = design.chambers.as_ref();
        let (flow, friction) = (design.flow.clone(), design.friction.clone());
        let of_flow = flow.as_ref().map(|it| it.area_ratio);
        let area_ratio = of_flow.or(friction.as_ref().map(|it| it.area_ratio)).unwrap_or(0.0);
        Self {
            area_ratio,
            levels: design.levels(),
            weighings: [
                of_spool.map(|it| weighing(by.spool_band * it.largest, it.dependence)),
                of_chambers.map(|it| weighing(by.chambers_band, it.dependence)),
            ],
            counts: Counts {
                opening: cycles(by.opening),
                looks: by.looks.map(|seconds| time::samples(seconds, sample_time)),
                company: cycles(by.company),
                lost: cycles(by.lost_for),
                gone: cycles(by.gone),
            },
            spool: design.spool.clone().map(|it| Spool::new(it, sample_time)),
            of_spool: EvidenceWindows::default(),
            of_chambers: EvidenceWindows::default(),
            flow: flow.and_then(|it| FlowWatch::new(it, by, sample_time)),
            friction: friction.and_then(|it| FrictionWatch::new(it, by, sample_time)),
            trace: Trace::default(),
            open: 0,
            losses: Losses::default(),
            judged: 0,
            alarms: [None; RELATIONS],
            is_raised: false,
            oil: OilReading::default(),
            is_supply_judged: false,
            design,
        }
    }

    /// Forgets the evidence, after a time in which nobody knows what happened; alarms stand.
    pub fn interrupt(&mut self) {
        self.forget();
        if let Some(spool) = &mut self.spool {
            spool.reset();
        }
        self.open = 0;
    }

    /// How fast the oil has moved the rod since the cycle before, m/s; `None` where that is not known.
    pub fn speed(&self) -> Option<f64> {
        self.flow.as_ref().and_then(FlowWatch::speed)
    }

    /// Takes a cycle. Where it is asked, returns the evidence of whose reading has moved, nats, as far as the oil tells:
    /// positive for C1, negative for C2.
    // Of its caller, so that the inputs need not go through memory.
    #[inline(always)]
    pub fn step(&mut self, input: &ProcessInput) -> Option<f64> {
        self.judged = u8::from(self.is_supply_judged) * Relation::Supply.bit();
        let is_held =
            self.losses.take(input.is_lost, self.counts.lost, self.counts.gone) || input.held;
        self.oil = input.oil(is_held);
        self.open = if input.monitored { self.open.saturating_add(1) } else { 0 };
        // The prediction runs on in any state, so that it is right when it is asked for.
        let stand = self.spool.as_mut().and_then(|it| it.step(input.command, input.spool));
        if self.open < self.counts.opening {
            self.forget();
            return None;
        }
        if is_held {
            return self.step_held(input);
        }
        match stand {
            Some(stand) => {
                self.trace.push(&stand);
                if stand.is_settled {
                    self.of_spool.push(stand.residual(), stand.variance);
                    self.judged |= Relation::Spool.bit();
                    if self.is_asked(Relation::Spool, &self.of_spool) {
                        self.weigh(Relation::Spool, input.at);
                    }
                }
            }
            None => self.trace.clear(),
        }
        let chambers = input.chambers[0].zip(input.chambers[1]).zip(input.supply);
        let residual = self.design.chambers.as_ref().zip(chambers).and_then(|(design, read)| {
            let ((bottom, rod), supply) = read;
            let residual = design.residual([bottom, rod], supply, input.spool)?;
            Some((residual, design.variance(input.spool)))
        });
        if let Some((residual, variance)) = residual {
            self.of_chambers.push(residual, variance);
            self.judged |= Relation::Chambers.bit();
            if self.is_asked(Relation::Chambers, &self.of_chambers) {
                self.weigh(Relation::Chambers, input.at);
            }
        }
        let load = input.load(self.area_ratio);
        self.step_flow(input, load);
        self.step_friction(input, load);
        None
    }

    /// Takes a cycle in which a transducer is under suspicion, or many readings are lost. Of a cylinder that has a fault of
    /// its own the oil tells nothing.
    #[cold]
    fn step_held(&mut self, input: &ProcessInput) -> Option<f64> {
        self.forget_cycles();
        self.forget_friction();
        let sample = input.passage(input.load(self.area_ratio));
        let is_well = |it: Relation| self.alarms[it as usize].is_none();
        let is_asked = input.asked && Relation::OF_CYLINDER.into_iter().all(is_well);
        self.flow.as_mut()?.step_held(sample, is_asked, input.is_gain)
    }

    /// Takes a cycle of oil and rod; pressures that do not add up prove nothing of either.
    #[inline(always)]
    fn step_flow(&mut self, input: &ProcessInput, load: Option<f64>) {
        if self.alarms[Relation::Chambers as usize].is_some() {
            self.forget_flow();
            return;
        }
        let Some(flow) = &mut self.flow else { return };
        let sample = input.passage(load);
        let is_complete = flow.step(sample);
        self.judged |= u8::from(flow.is_judging()) * Relation::Flow.bit();
        if !is_complete {
            return;
        }
        let cycles = flow.block();
        let level = self.levels[Relation::Flow as usize];
        let peak = match self.alarms[Relation::Flow as usize] {
            None => flow.peak_in_turn(level),
            Some(_) => flow.peak(self.design.parameters.over * level),
        };
        if self.alarms[Relation::Flow as usize].is_some() || peak.width > 0 {
            self.follow(Relation::Flow, peak, cycles, input.at);
        }
    }

    /// Takes a cycle of forces; pressures that do not add up prove nothing of them.
    #[inline(always)]
    fn step_friction(&mut self, input: &ProcessInput, load: Option<f64>) {
        let Some(friction) = &mut self.friction else { return };
        let is_odd = self.alarms[Relation::Chambers as usize].is_some();
        let sample = input.forces(load, self.design.is_pair).filter(|_| !is_odd);
        let is_complete = friction.step(sample);
        self.judged |= u8::from(friction.is_judging()) * Relation::Friction.bit();
        if !is_complete {
            return;
        }
        let (cycles, is_raised) =
            (friction.block(), self.alarms[Relation::Friction as usize].is_some());
        let peak = if is_raised { friction.peak() } else { friction.peak_in_turn() };
        if is_raised || peak.nats >= self.levels[Relation::Friction as usize] {
            self.follow(Relation::Friction, peak, cycles, input.at);
        }
    }

    /// Whether there is anything to weigh of a relation: an alarm, which is followed by all there is, or evidence.
    #[inline]
    fn is_asked(&self, which: Relation, evidence: &EvidenceWindows) -> bool {
        let weighing = self.weighings[which as usize].as_ref();
        self.alarms[which as usize].is_some()
            || weighing.is_some_and(|weighing| evidence.has_evidence_in_turn(weighing))
    }

    /// Raises, follows or ends the alarm of a relation.
    #[cold]
    fn weigh(&mut self, which: Relation, at: Timestamp) {
        let Some(weighing) = &self.weighings[which as usize] else { return };
        let evidence = [&self.of_spool, &self.of_chambers][which as usize];
        // An alarm is followed by all there is.
        let [mean, spread] = match self.alarms[which as usize] {
            None => evidence.peaks_in_turn(weighing),
            Some(_) => evidence.peaks(weighing),
        };
        let peak = if spread.nats > mean.nats { spread } else { mean };
        if self.alarms[which as usize].is_none() && peak.nats < self.levels[which as usize] {
            return;
        }
        self.follow(which, peak, 1, at);
    }

    /// Raises, follows or ends an alarm by evidence that is of so many `cycles` a sample.
    #[cold]
    fn follow(&mut self, which: Relation, peak: Peak, cycles: u32, at: Timestamp) {
        let ended = match &mut self.alarms[which as usize] {
            None => {
                self.alarms[which as usize] = Some(self.raised(which, peak, cycles, at));
                false
            }
            Some(alarm) => {
                let least = self.design.parameters.over * self.levels[which as usize];
                alarm.follow(peak.nats, least, cycles, self.design.clear)
            }
        };
        if ended {
            self.alarms[which as usize] = None;
            self.forget_ended(which);
        } else {
            self.look(which, peak.width);
        }
        self.is_raised = self.alarms.iter().any(Option::is_some);
    }

    fn raised(&self, which: Relation, peak: Peak, cycles: u32, at: Timestamp) -> ProcessAlarm {
        let sample = self.design.sample_time * f64::from(cycles);
        let back = sample * peak.width.saturating_sub(1) as f64;
        ProcessAlarm {
            malfunction: match which {
                Relation::Chambers => Malfunction::Chambers,
                Relation::Friction => Malfunction::Friction,
                _ => Malfunction::Unclassified,
            },
            size: None,
            nats: peak.nats,
            urgency: Urgency::None,
            onset: at.after(Span::from_seconds(-back)),
            age: 0,
            quiet: 0,
        }
    }

    /// Looks at the kind and size of an alarm while it is young, or while nobody knows its kind.
    fn look(&mut self, which: Relation, width: usize) {
        match which {
            Relation::Flow => return self.look_at_flow(),
            Relation::Friction => return self.look_at_friction(),
            _ => {}
        }
        let Some(alarm) = &mut self.alarms[which as usize] else { return };
        let [from, until] = self.counts.looks;
        if which == Relation::Chambers {
            if alarm.age <= until {
                // Of the time before the alarm a part was well.
                let own = alarm.age as usize + 1;
                alarm.size = self.of_chambers.mean(width.clamp(1, own)).or(alarm.size);
            }
            return;
        }
        let known = alarm.malfunction != Malfunction::Unclassified;
        if alarm.age < from || known && (alarm.age > until || !alarm.age.is_multiple_of(from)) {
            return;
        }
        let (Some(spool), cycles) = (&self.spool, alarm.age as usize + 1) else { return };
        let form = self.trace.form(cycles, spool.design(), self.design.parameters);
        if let Some(form) = form {
            (alarm.malfunction, alarm.size) = named(form);
        }
    }

    fn look_at_friction(&mut self) {
        let (Some(alarm), Some(friction)) =
            (&mut self.alarms[Relation::Friction as usize], &self.friction)
        else {
            return;
        };
        alarm.size = friction.size(alarm.age).or(alarm.size);
    }

    fn look_at_flow(&mut self) {
        let (Some(alarm), Some(flow)) = (&mut self.alarms[Relation::Flow as usize], &self.flow)
        else {
            return;
        };
        let is_known = alarm.malfunction != Malfunction::Unclassified;
        if let Some((malfunction, size)) = flow.malfunction(alarm.age, is_known) {
            (alarm.malfunction, alarm.size) = (malfunction, size);
        }
    }

    fn forget(&mut self) {
        self.forget_cycles();
        self.forget_flow();
        self.forget_friction();
    }

    fn forget_cycles(&mut self) {
        self.of_spool.clear();
        self.of_chambers.clear();
        self.trace.clear();
    }

    fn forget_flow(&mut self) {
        if let Some(flow) = &mut self.flow {
            flow.forget();
        }
    }

    fn forget_friction(&mut self) {
        if let Some(friction) = &mut self.friction {
            friction.forget();
        }
    }

    /// Forgets what long windows still have of a fault that is over: it would raise its alarm again.
    fn forget_ended(&mut self, which: Relation) {
        match (which, &mut self.flow, &mut self.friction) {
            (Relation::Flow, Some(flow), _) => flow.forget_evidence(),
            (Relation::Friction, _, Some(friction)) => friction.forget_evidence(),
            _ => {}
        }
    }
}

fn named(form: SpoolForm) -> (Malfunction, Option<f64>) {
    match form {
        SpoolForm::Offset(by) => (Malfunction::Offset, Some(by)),
        SpoolForm::Late(cycles) => (Malfunction::Late, Some(cycles as f64)),
        SpoolForm::Sticking(band) => (Malfunction::Sticking, Some(band)),
        SpoolForm::Gain(_) | SpoolForm::Elsewhere(_) => (Malfunction::OtherCommand, None),
    }
}

#[cfg(test)]
mod tests;
