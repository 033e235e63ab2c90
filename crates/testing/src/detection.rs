//! The healthy recording, played through injector and monitor a window at a time.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tertius::alarm::{Detector, Finding, State, Warning};
use tertius::bus::{Options, Recording, Source};
use tertius::config::design;
use tertius::config::{self, Settings};
use tertius::dbc::{Database, text};
use tertius::frame::Frame;
use tertius::inject::{Fault, Injector, Tally, place};
use tertius::monitor::{Monitor, MonitorDesign, Record, Sink};
use tertius::time::{Span, Timestamp};
use tertius::verdict::Suspect;

/// Seconds before the fault: the observers settle in one of them.
pub const BEFORE: f64 = 4.0;

/// The recording with what is needed to monitor it.
pub struct Healthy {
    frames: Vec<Frame>,
    first: Timestamp,
    settings: Settings,
    database: Database,
    design: MonitorDesign,
    /// When the platform's state is engaged, s since the first frame.
    pub engaged: [f64; 2],
}

/// What came of a window.
#[derive(Default)]
pub struct Outcome {
    /// The time stamp of the first frame that a fault changed or dropped.
    pub first_faulty: Option<Timestamp>,
    pub warnings: Vec<Warning>,
    /// Of all cylinders.
    pub records: Vec<Record>,
    pub tallies: Vec<Tally>,
}

impl Sink for Outcome {
    fn warning(&mut self, warning: &Warning) {
        self.warnings.push(*warning);
    }

    fn record(&mut self, record: &Record) {
        self.records.push(*record);
    }
}

impl Healthy {
    pub fn load() -> Self {
        let top = crate::top();
        let loaded = config::load(&top.join("tests/recordings/e-type.toml")).unwrap();
        let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).unwrap();
        let design = design::judging(&loaded.settings, &database).unwrap();
        let log = top.join("tests/recordings/e-type-healthy.log.zst");
        let mut recording = Recording::open(&[log], Options::default()).unwrap();
        let mut frames = Vec::with_capacity(660_000);
        while let Some(frame) = recording.next_frame().unwrap() {
            frames.push(frame.clone());
        }
        let first = frames[0].timestamp;
        let (message, state) = database.signal("Plc_State.PlatformState").unwrap();
        let engaged = frames.iter().filter(|frame| {
            frame.id == message.id
                && state.plan.decode(frame).value().is_some_and(|value| value.physical == 3.0)
        });
        let times: Vec<f64> =
            engaged.map(|frame| frame.timestamp.since(first).as_seconds()).collect();
        let engaged = [times[0], times[times.len() - 1]];
        Self { frames, first, settings: loaded.settings, database, design, engaged }
    }

    pub fn sample_time(&self) -> Span {
        Span::from_seconds(self.settings.machine.sample_time)
    }

    /// `t` seconds after the first frame.
    pub fn at(&self, t: f64) -> Timestamp {
        self.first.after(Span::from_seconds(t))
    }

    /// Plays the frames from `from` to `to` seconds after the first frame, with `faults` whose
    /// times count from there too, through a new monitor.
    pub fn play(&self, faults: &[Fault], [from, to]: [f64; 2], seed: u64) -> Outcome {
        let begin = self.frames.partition_point(|frame| frame.timestamp < self.at(from));
        let end = self.frames.partition_point(|frame| frame.timestamp < self.at(to));
        // The injector counts from the first frame that it sees.
        let skipped = self.frames[begin].timestamp.since(self.first).as_nanos();
        let shift = |span: Span| Span::from_nanos(span.as_nanos() - skipped);
        let placed: Vec<_> = faults
            .iter()
            .map(|fault| {
                let mut placed = place(fault, &self.settings, &self.database).unwrap();
                placed.window.from = shift(placed.window.from);
                placed.window.until = placed.window.until.map(shift);
                placed
            })
            .collect();
        let mut injector = Injector::new(&placed, seed);
        let mut monitor = Monitor::new(self.design.clone());
        let mut outcome = Outcome::default();
        for frame in &self.frames[begin..end] {
            if let Some(frame) = injector.take(frame) {
                monitor.take(frame, &mut outcome);
            }
            if outcome.first_faulty.is_none() && injector.tallies().iter().any(|t| t.altered > 0) {
                outcome.first_faulty = Some(frame.timestamp);
            }
        }
        monitor.finish(&mut outcome);
        outcome.tallies = injector.tallies().to_vec();
        outcome
    }

    /// As [`Self::play`] around a fault at `t`.
    pub fn play_fault(&self, spec: &str, t: f64, after: f64, seed: u64) -> Outcome {
        let fault = Fault::parse(spec).unwrap_or_else(|error| panic!("{spec}: {error}"));
        self.play(&[fault], [t - BEFORE, t + after], seed)
    }
}

/// Where and when a fault is tried.
#[derive(Clone, Copy, Debug)]
pub struct Try {
    pub number: u64,
    pub t: f64,
    pub cylinder: u8,
    pub suspect: Suspect,
    pub sign: f64,
}

impl Try {
    pub fn sensor(&self) -> &'static str {
        self.suspect.name()
    }

    /// The observer on the transducer.
    pub fn detector(&self) -> Detector {
        if self.suspect == Suspect::C1 { Detector::Fde1 } else { Detector::Fde2 }
    }

    pub fn other(&self) -> Suspect {
        if self.suspect == Suspect::C1 { Suspect::C2 } else { Suspect::C1 }
    }
}

/// `count` tries at seeded times while engaged; cylinders, transducers and signs take turns, all 24
/// of their combinations.
pub fn tries(healthy: &Healthy, count: u64, seed: u64, after: f64) -> Vec<Try> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let [begin, end] = healthy.engaged;
    (0..count)
        .map(|number| Try {
            number,
            t: rng.random_range(begin + BEFORE..end - after),
            cylinder: (number % 6) as u8 + 1,
            suspect: if number / 6 % 2 == 0 { Suspect::C1 } else { Suspect::C2 },
            sign: if number / 12 % 2 == 0 { 1.0 } else { -1.0 },
        })
        .collect()
}

/// What was said about one try.
#[derive(Clone, Copy, Debug, Default)]
pub struct Said {
    /// From the first faulty frame to the raise by the transducer's own observer, s.
    pub delay: Option<f64>,
    /// The suspect of that raise.
    pub at_first: Option<Suspect>,
    /// The newest finding of that observer's warning.
    pub finally: Option<Finding>,
    /// FDE3 was first, or came with it.
    pub difference_delay: Option<f64>,
    /// Warnings, of any detector and state, that blame the other transducer or the process.
    pub wrongly: usize,
    /// Warnings about other cylinders, or before the fault.
    pub beside: usize,
}

impl Said {
    pub fn of(outcome: &Outcome, one: &Try) -> Self {
        let mut said = Self::default();
        let Some(first) = outcome.first_faulty else { return said };
        for warning in &outcome.warnings {
            if warning.cylinder != one.cylinder || warning.timestamp < first {
                said.beside += 1;
                continue;
            }
            let delay = warning.timestamp.since(first).as_seconds();
            let suspect = warning.finding.suspect;
            said.wrongly += usize::from(suspect == one.other() || suspect == Suspect::Process);
            if warning.detector == one.detector() && warning.state != State::Cleared {
                said.delay.get_or_insert(delay);
                said.at_first.get_or_insert(suspect);
                said.finally = Some(warning.finding);
            }
            if warning.detector == Detector::Fde3 && warning.state == State::Raised {
                said.difference_delay.get_or_insert(delay);
            }
        }
        said
    }

    /// Raised by the right observer within one cycle of the first faulty frame.
    pub fn at_once(&self, healthy: &Healthy) -> bool {
        self.delay.is_some_and(|delay| delay < healthy.sample_time().as_seconds())
    }

    /// Blames `suspect` from the raise to the end, and nothing blames another.
    pub fn blames(&self, suspect: Suspect) -> bool {
        let finally = self.finally.map(|finding| finding.suspect);
        self.at_first == Some(suspect) && finally == Some(suspect) && self.wrongly == 0
    }
}
