//! A simulated machine that the sequential detectors were calibrated to, and what they say of it.

use std::convert::Infallible;
use std::path::Path;
use std::sync::OnceLock;
use tertius::alarm::{Detector, State as Said, Warning};
use tertius::calibrate::watch::Watch;
use tertius::calibrate::{CalibrationCourse, Recording};
use tertius::config::design;
use tertius::config::settings::Settings;
use tertius::controller::State;
use tertius::dbc::{Database, text};
use tertius::frame::Frame;
use tertius::inject::{Fault, place};
use tertius::monitor::{Monitor, MonitorDesign, Notice, Sink};
use tertius::sequential::Dwell;
pub use tertius::simulator::EPOCH;
use tertius::simulator::{Options, Simulator, Tables};
use tertius::survey::{Survey, Surveyor, Timeline, Window};
use tertius::verdict::Suspect;

pub const SAMPLE_TIME: f64 = 0.02;

const PLANT: &str = include_str!("../../config/e-type-plant.toml");

/// Transducers that are read to one count, without the fluctuations of Figure 5-9, on a plant with
/// `changes` of text, each found once, and `more` behind it.
pub fn fine(changes: &[(&str, &str)], more: &str) -> Tables {
    let plain = [("fluctuation_probability = 5.0e-4", "fluctuation_probability = 0.0")];
    let text = plain.iter().chain(changes).fold(PLANT.to_owned(), |text, (from, to)| {
        assert_eq!(text.matches(from).count(), 1, "the plant's table has not {from:?} once");
        text.replace(from, to)
    });
    Tables::parse(&(text + more)).expect("it is sound")
}

/// s of fault-free machine that the detectors are calibrated on, half to fit and half to try.
const LENGTH: f64 = 1200.0;

#[derive(Clone)]
pub struct Setup {
    pub tables: Tables,
    pub settings: Settings,
    pub database: Database,
}

/// The machine, calibrated once.
pub fn setup() -> &'static Setup {
    static SETUP: OnceLock<Setup> = OnceLock::new();
    SETUP.get_or_init(|| {
        let top = Path::new(env!("CARGO_MANIFEST_DIR"));
        let loaded =
            tertius::config::load(&top.join("config/e-type-simulated.toml")).expect("it is sound");
        let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("it is sound");
        let mut setup = Setup { tables: fine(&[], ""), settings: loaded.settings, database };
        setup.settings.sequential.stop_states = Some(vec!["safe".to_owned()]);
        setup.calibrate();
        setup
    })
}

impl Recording for Setup {
    type Error = Infallible;

    /// The same machine and sea each time.
    fn read(&self, window: Window, surveyor: impl Surveyor) -> Result<(), Infallible> {
        let design = design::surveying(&self.settings, &self.database).expect("they fit");
        let mut monitor = Monitor::new(design);
        let mut survey = Survey::new(EPOCH, window, surveyor);
        let mut simulator = self.simulator(&Options { seed: 77, ..Options::default() });
        for _ in 0..(window.to / SAMPLE_TIME) as u64 {
            simulator.step(&mut |frame| monitor.take(frame, &mut survey));
        }
        Ok(())
    }
}

impl Setup {
    /// With the same detectors, another plant.
    pub fn with(&self, tables: Tables) -> Self {
        Self { tables, ..self.clone() }
    }

    /// Without what was taught of spool, pressures and flow.
    pub fn without_process(&self) -> Self {
        let mut other = self.clone();
        other.settings.cylinder.iter_mut().for_each(|cylinder| cylinder.process = None);
        other
    }

    /// With a sensor on the deck of `config/e-type-top.toml`, and the same detectors.
    pub fn with_top(&self) -> Self {
        let top = Path::new(env!("CARGO_MANIFEST_DIR"));
        let loaded =
            tertius::config::load(&top.join("config/e-type-top.toml")).expect("it is sound");
        let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("it is sound");
        let settings = Settings { cylinder: self.settings.cylinder.clone(), ..loaded.settings };
        Self { settings, database, ..self.clone() }
    }

    /// With another level of evidence, nats.
    pub fn at_level(&self, nats: f64) -> Self {
        let mut other = self.clone();
        other.settings.sequential.level = Some(nats);
        other
    }

    /// The level that `tune` would write, nats.
    pub fn tuned(&self) -> f64 {
        let monitor = self.monitor();
        let designs: Vec<_> = monitor.sequential().map(|(_, it)| it.design().clone()).collect();
        let mut watch = Watch::new(designs.iter().map(Some), SAMPLE_TIME);
        _ = self.read(Window { from: 0.0, to: LENGTH }, &mut watch);
        watch.level(1.0).expect("it is long enough").nats
    }

    pub fn simulator(&self, options: &Options) -> Simulator {
        let simulator = Simulator::new(&self.tables, &self.settings, &self.database, options);
        let mut simulator = simulator.expect("the default machine can be simulated");
        simulator.request(State::Engaged);
        simulator
    }

    /// The same with detectors that are calibrated to its own plant.
    pub fn calibrated(mut self) -> Self {
        self.calibrate();
        self
    }

    fn calibrate(&mut self) {
        let [fitted, tried] = Window { from: 0.0, to: LENGTH }.split(0.5);
        let settings = &self.settings;
        let course = CalibrationCourse {
            settings,
            timeline: &Timeline::default(),
            fitted,
            tried,
            per_year: 1.0,
        };
        let calibrated = course.run(self).expect("it is simulated").cylinders.into_iter();
        let tables = calibrated.map(|cylinder| cylinder.table().expect("it is healthy"));
        self.settings.cylinder = tables.collect();
    }

    /// What the detectors say of a machine with these faults, for so many seconds.
    pub fn run(&self, seconds: f64, in_loop: bool, faults: &[String]) -> Heard {
        self.play(seconds, &Options { in_loop, ..self.options(4, faults) })
    }

    /// What they say of the machine of `options`, for so many seconds.
    pub fn play(&self, seconds: f64, options: &Options) -> Heard {
        let (mut simulator, mut bench) = (self.simulator(options), Bench::new(self));
        bench.run(&mut simulator, seconds);
        bench.heard
    }

    /// The machine of that seed with these faults.
    pub fn options(&self, seed: u64, faults: &[String]) -> Options {
        let placed = faults.iter().map(|fault| {
            let fault = Fault::parse(fault).expect("a fault");
            place(&fault, &self.settings, &self.database).expect("it has a place")
        });
        Options { seed, faults: placed.collect(), ..Options::default() }
    }

    pub fn design(&self) -> MonitorDesign {
        design::judging(&self.settings, &self.database).expect("they fit")
    }

    pub fn monitor(&self) -> Monitor {
        Monitor::new(self.design())
    }
}

/// A monitor beside a simulator.
pub struct Bench {
    pub monitor: Monitor,
    pub heard: Heard,
}

impl Bench {
    pub fn new(setup: &Setup) -> Self {
        Self { monitor: setup.monitor(), heard: Heard::default() }
    }

    pub fn run(&mut self, simulator: &mut Simulator, seconds: f64) {
        (0..(seconds / SAMPLE_TIME) as u64).for_each(|_| self.step(simulator));
    }

    /// One cycle.
    pub fn step(&mut self, simulator: &mut Simulator) {
        simulator.step(&mut |frame| self.monitor.take(frame, &mut self.heard));
    }

    /// Lets `passing` decide which frames of which cycle, from 0, reach the monitor, and when.
    pub fn run_through(
        &mut self,
        simulator: &mut Simulator,
        seconds: f64,
        mut passing: impl FnMut(u64, &Frame, &mut dyn FnMut(&Frame)),
    ) {
        for cycle in 0..(seconds / SAMPLE_TIME) as u64 {
            simulator.step(&mut |frame| {
                passing(cycle, frame, &mut |frame| self.monitor.take(frame, &mut self.heard));
            });
        }
    }
}

/// The warnings of the sequential detectors.
#[derive(Default)]
pub struct Heard {
    pub warnings: Vec<Warning>,
    /// Of the other detectors.
    pub others: Vec<Warning>,
    pub dwells: Vec<(u8, Dwell)>,
    pub notices: Vec<Notice>,
}

impl Sink for Heard {
    fn warning(&mut self, warning: &Warning) {
        let sequential = warning.detector == Detector::Sequential;
        let heard = if sequential { &mut self.warnings } else { &mut self.others };
        heard.push(*warning);
    }

    fn notice(&mut self, notice: &Notice) {
        self.notices.push(*notice);
    }

    fn dwell(&mut self, cylinder: u8, dwell: &Dwell) {
        self.dwells.push((cylinder, *dwell));
    }
}

impl Heard {
    /// For a person.
    pub fn told(&self) -> String {
        let line = |w: &Warning| {
            let (at, finding) = (w.timestamp.since(EPOCH).as_seconds(), &w.finding);
            let (fault, suspect) = (finding.fault.name(), finding.suspect.name());
            format!("{at:.2} s {}: {} {fault} {suspect}\n", w.cylinder, w.state.name())
        };
        self.warnings.iter().take(20).map(line).collect()
    }

    /// Of a cylinder: s from `at` to the first raise, and the last word on it before it was cleared.
    pub fn of(&self, cylinder: u8, at: f64) -> Option<(f64, Warning)> {
        let own = || self.warnings.iter().filter(|warning| warning.cylinder == cylinder);
        let first = own().find(|warning| warning.state == Said::Raised)?;
        let last = own().take_while(|warning| warning.state != Said::Cleared).last()?;
        Some((first.timestamp.since(EPOCH).as_seconds() - at, *last))
    }
}

/// One fault on each cylinder, C1 of the odd ones, 5 s apart.
pub fn one_each(fault: &str) -> (Vec<String>, Vec<(u8, Suspect, f64)>) {
    (1..=6_u8)
        .map(|cylinder| {
            let (sensor, suspect) =
                if cylinder % 2 == 1 { ("c1", Suspect::C1) } else { ("c2", Suspect::C2) };
            let at = 10.0 + 5.0 * f64::from(cylinder);
            let text = format!("{fault},cylinder={cylinder},sensor={sensor},at={at}");
            (text, (cylinder, suspect, at))
        })
        .unzip()
}
