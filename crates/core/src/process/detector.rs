//! The process detector of one cylinder.

use super::chambers::ChambersDesign;
use super::evidence::{EvidenceWindows, Weighing};
use super::parameters::ProcessParameters;
use super::spool::{Spool, SpoolDesign};
use super::trace::{SpoolForm, Trace};
use crate::sequential::statistic::Peak;
use crate::state::{choice, state, whole};
use crate::time::{self, Span, Timestamp};

/// What is wrong with a cylinder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Malfunction {
    /// Its hydraulics; nobody knows what yet.
    Unclassified,
    /// The spool sticks. Sizes are in the unit of the spool's signal.
    Sticking,
    /// The spool stands beside its command.
    Offset,
    /// The command comes late; the size is in cycles.
    Late,
    /// The valve gets, or follows, another command.
    OtherCommand,
    /// The pressures do not add up. The size is in bar.
    Chambers,
}

choice! { Malfunction { Unclassified, Sticking, Offset, Late, OtherCommand, Chambers } }

/// An alarm that stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProcessAlarm {
    pub malfunction: Malfunction,
    /// Its size, in the unit of the malfunction, where it is known.
    pub size: Option<f64>,
    /// The most evidence so far, nats.
    pub nats: f64,
    /// Begin of the window in which it was found.
    pub onset: Timestamp,
    /// Cycles since it was raised.
    age: u32,
    /// Cycles without evidence.
    quiet: u32,
}

whole! { ProcessAlarm { malfunction, size, nats, onset, age, quiet } }

/// What a process detector is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct ProcessDesign {
    pub spool: Option<SpoolDesign>,
    pub chambers: Option<ChambersDesign>,
    /// h, nats.
    pub level: f64,
    /// s.
    pub sample_time: f64,
    /// Cycles without evidence that end an alarm.
    pub clear: u32,
    pub parameters: &'static ProcessParameters,
}

/// Inputs of a cycle; `None` where nothing came.
#[derive(Clone, Copy, Debug)]
pub struct ProcessInput {
    /// u(k) as sent, m/s.
    pub command: Option<f64>,
    /// Position of the spool, in the unit of its signal.
    pub spool: Option<f64>,
    /// P_bot and P_rod, bar.
    pub chambers: [Option<f64>; 2],
    /// P_S, bar.
    pub supply: Option<f64>,
    /// Whether the platform is in a monitored state.
    pub monitored: bool,
    /// Whether a transducer is under suspicion: what the controller then commands proves nothing.
    pub held: bool,
    pub at: Timestamp,
}

/// The process detector of one cylinder.
#[derive(Clone, Debug)]
pub struct Process {
    design: ProcessDesign,
    weighings: [Option<Weighing>; RELATIONS],
    counts: Counts,
    spool: Option<Spool>,
    of_spool: EvidenceWindows,
    of_chambers: EvidenceWindows,
    trace: Trace,
    /// Cycles of the present stay in a monitored state.
    open: u32,
    /// Whether the newest cycle was judged.
    judged: [bool; RELATIONS],
    alarms: [Option<ProcessAlarm>; RELATIONS],
}

state! {
    Process { of_spool, of_chambers, trace, open, alarms }
    parts { spool }
    but { design, weighings, counts, judged }
}

/// Times of [`ProcessParameters`] in cycles.
#[derive(Clone, Copy, Debug)]
struct Counts {
    opening: u32,
    looks: [u32; 2],
    company: u32,
}

const SPOOL: usize = 0;
const CHAMBERS: usize = 1;

/// Number of relations: spool and chambers.
pub const RELATIONS: usize = 2;

impl Process {
    pub fn new(design: ProcessDesign) -> Self {
        let (by, sample_time) = (design.parameters, design.sample_time);
        let cycles = |seconds| time::cycles(seconds, sample_time);
        let weighing = |band, dependence| Weighing::new(band, dependence, sample_time);
        let of_spool = design.spool.as_ref();
        let of_chambers = design.chambers.as_ref();
        Self {
            weighings: [
                of_spool.map(|it| weighing(by.spool_band * it.largest, it.dependence)),
                of_chambers.map(|it| weighing(by.chambers_band, it.dependence)),
            ],
            counts: Counts {
                opening: cycles(by.opening),
                looks: by.looks.map(|seconds| time::samples(seconds, sample_time)),
                company: cycles(by.company),
            },
            spool: design.spool.clone().map(|it| Spool::new(it, sample_time)),
            of_spool: EvidenceWindows::default(),
            of_chambers: EvidenceWindows::default(),
            trace: Trace::default(),
            open: 0,
            judged: [false; RELATIONS],
            alarms: [None; RELATIONS],
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

    fn forget(&mut self) {
        self.of_spool.clear();
        self.of_chambers.clear();
        self.trace.clear();
    }

    /// The alarm that counts: pressures that do not add up explain a spool that is off, and not the other way round.
    #[inline]
    pub fn alarm(&self) -> Option<&ProcessAlarm> {
        let chambers = self.alarms[CHAMBERS].as_ref();
        chambers.filter(|alarm| alarm.age >= self.counts.company).or(self.alarms[SPOOL].as_ref())
    }

    /// Whether the chambers' pressures do not add up.
    #[inline]
    pub const fn has_odd_chambers(&self) -> bool {
        self.alarms[CHAMBERS].is_some()
    }

    /// Whether it compares the chambers' pressures.
    pub const fn knows_chambers(&self) -> bool {
        self.design.chambers.is_some()
    }

    /// Whether each relation judged the newest cycle; `None` for one that it does not know.
    pub fn judged(&self) -> [Option<bool>; RELATIONS] {
        core::array::from_fn(|which| self.weighings[which].as_ref().map(|_| self.judged[which]))
    }

    /// Takes a cycle.
    pub fn step(&mut self, input: &ProcessInput) {
        self.judged = [false; RELATIONS];
        self.open = if input.monitored { self.open.saturating_add(1) } else { 0 };
        // The prediction runs on in any state, so that it is right when it is asked for.
        let stand = self.spool.as_mut().and_then(|it| it.step(input.command, input.spool));
        if self.open < self.counts.opening || input.held {
            self.forget();
            return;
        }
        match stand {
            Some(stand) => {
                self.trace.push(&stand);
                if stand.is_settled {
                    self.of_spool.push(stand.residual(), stand.deviation);
                    self.weigh(SPOOL, input.at);
                }
            }
            None => self.trace.clear(),
        }
        let chambers = input.chambers[0].zip(input.chambers[1]).zip(input.supply);
        let residual = self.design.chambers.as_ref().zip(chambers).and_then(|(design, read)| {
            let ((bottom, rod), supply) = read;
            let residual = design.residual([bottom, rod], supply, input.spool)?;
            Some((residual, design.deviation))
        });
        if let Some((residual, deviation)) = residual {
            self.of_chambers.push(residual, deviation);
            self.weigh(CHAMBERS, input.at);
        }
    }

    /// Raises, follows or ends the alarm of a relation.
    fn weigh(&mut self, which: usize, at: Timestamp) {
        let Some(weighing) = &self.weighings[which] else { return };
        self.judged[which] = true;
        let evidence = [&self.of_spool, &self.of_chambers][which];
        let [mean, spread] = evidence.peaks(weighing);
        let peak = if spread.nats > mean.nats { spread } else { mean };
        if self.alarms[which].is_none() && peak.nats < self.design.level {
            return;
        }
        self.follow(which, peak, at);
    }

    #[cold]
    fn follow(&mut self, which: usize, peak: Peak, at: Timestamp) {
        let ended = match &mut self.alarms[which] {
            None => {
                self.alarms[which] = Some(self.raised(which, peak, at));
                false
            }
            Some(alarm) => {
                alarm.age = alarm.age.saturating_add(1);
                alarm.nats = alarm.nats.max(peak.nats);
                let over = peak.nats < self.design.parameters.over * self.design.level;
                alarm.quiet = if over { alarm.quiet + 1 } else { 0 };
                alarm.quiet > self.design.clear
            }
        };
        if ended {
            self.alarms[which] = None;
        } else {
            self.look(which, peak.width);
        }
    }

    fn raised(&self, which: usize, peak: Peak, at: Timestamp) -> ProcessAlarm {
        let back = self.design.sample_time * peak.width.saturating_sub(1) as f64;
        ProcessAlarm {
            malfunction: [Malfunction::Unclassified, Malfunction::Chambers][which],
            size: None,
            nats: peak.nats,
            onset: at.after(Span::from_seconds(-back)),
            age: 0,
            quiet: 0,
        }
    }

    /// Looks at the kind and size of an alarm while it is young, or while nobody knows its kind.
    fn look(&mut self, which: usize, width: usize) {
        let Some(alarm) = &mut self.alarms[which] else { return };
        let [from, until] = self.counts.looks;
        if which == CHAMBERS {
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
}

fn named(form: SpoolForm) -> (Malfunction, Option<f64>) {
    match form {
        SpoolForm::Offset(by) => (Malfunction::Offset, Some(by)),
        SpoolForm::Late(cycles) => (Malfunction::Late, Some(cycles as f64)),
        SpoolForm::Sticking(band) => (Malfunction::Sticking, Some(band)),
        SpoolForm::Gain(_) | SpoolForm::Elsewhere(_) => (Malfunction::OtherCommand, None),
    }
}
