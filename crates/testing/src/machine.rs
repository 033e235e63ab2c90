//! The default machine at rest in the middle of its stroke, as frames made by hand.

use tertius::alarm::{OwnFrame, Warning};
use tertius::config::design::{self, Flaw};
use tertius::config::{self, Settings};
use tertius::dbc::{Database, text};
use tertius::frame::{Frame, Id, Kind};
use tertius::incident::Incident;
use tertius::live::gateway::Gateway;
use tertius::live::outbox::{Outbox, OutboxLimits};
use tertius::monitor::{Estimates, Monitor, MonitorDesign, Notice, Record, Sink};
use tertius::time::{Span, Timestamp};

/// A millisecond in nanoseconds.
pub const MS: i64 = 1_000_000;

/// The opening of cycle 0.
pub const START: i64 = 1_700_000_000_000 * MS;

/// The count of a length of zero.
const MIDDLE: u16 = 13_824;

/// Everything that the monitor gave.
#[derive(Debug, Default)]
pub struct Collected {
    pub records: Vec<Record>,
    pub warnings: Vec<Warning>,
    pub incidents: Vec<Incident>,
    pub frames: Vec<Frame>,
    pub notices: Vec<Notice>,
}

impl Sink for Collected {
    fn record(&mut self, record: &Record) {
        self.records.push(*record);
    }

    fn warning(&mut self, warning: &Warning) {
        self.warnings.push(*warning);
    }

    fn incident(&mut self, incident: &Incident) {
        self.incidents.push(*incident);
    }

    fn transmit(&mut self, frame: &OwnFrame) {
        self.frames.push(frame.as_frame().clone());
    }

    fn notice(&mut self, notice: &Notice) {
        self.notices.push(*notice);
    }
}

impl Collected {
    /// The record of `cylinder` in the cycle that opened nearest to cycle number `k`.
    pub fn record(&self, k: i64, cylinder: u8) -> &Record {
        let opening = START + k * 20 * MS;
        let of_cycle = |record: &&Record| {
            record.cylinder == cylinder && (record.timestamp.as_nanos() - opening).abs() < 10 * MS
        };
        self.records.iter().find(of_cycle).expect("every cycle has a record")
    }

    /// The newest Fd_Status.
    pub fn status(&self) -> StatusFrame {
        let frame = self.frames.iter().rev().find(|frame| frame.id.value() == 0x1D1);
        let frame = frame.expect("Fd_Status is sent every 100 ms");
        StatusFrame(u64::from_le_bytes(frame.data().try_into().expect("it has eight bytes")))
    }
}

/// The payload of Fd_Status.
pub struct StatusFrame(u64);

impl StatusFrame {
    /// C1 and C2 of cylinder 1, C1 and C2 of cylinder 2, …
    pub fn transducers(&self) -> [u64; 12] {
        std::array::from_fn(|i| self.0 >> (24 + 2 * i) & 0b11)
    }

    pub fn mode(&self) -> u64 {
        self.0 >> 51 & 0b111
    }
}

/// The frames of one cycle, engaged and at rest.
#[derive(Clone, Copy, Debug)]
pub struct Cycle {
    pub k: i64,
    /// Added to the count of C1 of cylinder 2.
    pub offset: u16,
    /// Counts of all control speeds, 0.1 mm/s.
    pub command: i16,
}

impl Cycle {
    pub const fn new(k: i64) -> Self {
        Self { k, offset: 0, command: 0 }
    }

    /// Sync, C1 and C2 of each cylinder, the platform's state, the valves; 0.1 ms apart.
    pub fn frames(self) -> Vec<Frame> {
        let mut messages = vec![(0x080, vec![self.k as u8])];
        for n in 1..=6 {
            let offset = if n == 2 { self.offset } else { 0 };
            messages.push((0x180 + n, self.transducer(offset)));
            messages.push((0x190 + n, self.transducer(0)));
        }
        messages.push((0x1C1, vec![3, 0, 0, self.k as u8]));
        for n in 1..=6 {
            let [low, high] = self.command.to_le_bytes();
            messages.push((0x1A0 + n, vec![low, high, 0, 0, 0, 0, 0, 0]));
        }
        let opening = START + self.k * 20 * MS;
        let frame = |(index, (id, data)): (usize, (u32, Vec<u8>))| {
            let at = Timestamp::from_nanos(opening + index as i64 * MS / 10);
            let id = Id::standard(id).expect("all identifiers here have 11 bits");
            Frame::new(at, id, Kind::Data, &data)
        };
        messages.into_iter().enumerate().map(frame).collect()
    }

    fn transducer(self, offset: u16) -> Vec<u8> {
        let [low, high] = (MIDDLE + offset).to_le_bytes();
        vec![low, high, 0, 0, 0, self.k as u8]
    }
}

/// The design of a configuration that ships.
pub fn design_of(config: &str) -> MonitorDesign {
    let loaded = config::load(&crate::top().join(config)).expect("it is a configuration");
    let mut database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("it is a DBC");
    config::devices::connect(&loaded.settings, &loaded.sheets, &mut database).expect("EDS files");
    design::judging(&loaded.settings, &database).expect("it can be monitored")
}

/// A monitor of the default machine that reads the pressures, too.
pub fn surveying() -> Monitor {
    let design = from_files("no such line", design::surveying);
    design.map_or_else(|flaws| panic!("{flaws}"), Monitor::new)
}

/// A monitor of the default machine.
pub fn monitor() -> Monitor {
    Monitor::new(design_of_default())
}

/// A gateway of `monitor` that may take `share` of a bus with 500 kbit/s.
pub fn gateway_of(monitor: Monitor, share: f64) -> Gateway {
    let limits = OutboxLimits {
        waiting: OutboxLimits::WAITING,
        estimates: 6,
        age: Span::from_seconds(0.2),
        bitrate: 500_000.0,
        share,
        burst: OutboxLimits::BURST,
    };
    Gateway::new(monitor, Outbox::new(limits), Span::from_seconds(0.01))
}

/// What that is made from.
pub fn design_of_default() -> MonitorDesign {
    design("no such line").unwrap_or_else(|flaws| panic!("{flaws}"))
}

/// The same, which sends its estimates.
pub fn estimating() -> Monitor {
    let design = from_files("no such line", |settings, database| {
        let design = design::judging(settings, database)?;
        Ok(MonitorDesign { estimates: Estimates::Sent, ..design })
    });
    design.map_or_else(|flaws| panic!("{flaws}"), Monitor::new)
}

/// The same with cylinders that rest at a command of 50 mm/s.
pub fn resting_at_50() -> Monitor {
    let offset = |settings: &Settings, database: &Database| {
        let mut settings = settings.clone();
        settings.model.command_offset = 0.05;
        design::judging(&settings, database)
    };
    from_files("no such line", offset).map_or_else(|flaws| panic!("{flaws}"), Monitor::new)
}

/// The same without Sync.
pub fn without_sync() -> Monitor {
    design("sync = ").map_or_else(|flaws| panic!("{flaws}"), Monitor::new)
}

/// The same with cycles of a microsecond, of which no configuration is read.
pub fn hasty() -> Monitor {
    let design = from_files("no such line", |settings, database| {
        let mut design = design::judging(settings, database)?;
        design.timing.sample_time = Span::from_nanos(1000);
        design.timing.deadline = Span::from_nanos(800);
        Ok(design)
    });
    design.map_or_else(|flaws| panic!("{flaws}"), Monitor::new)
}

/// The same without the keys whose lines begin so.
pub fn without(left_out: &[&str]) -> Monitor {
    Monitor::new(design_without(left_out))
}

/// What that is made from.
pub fn design_without(left_out: &[&str]) -> MonitorDesign {
    from_files_without(left_out, design::judging).unwrap_or_else(|flaws| panic!("{flaws}"))
}

/// Plays `frames` through the default machine's monitor.
pub fn play(frames: impl IntoIterator<Item = Frame>) -> (Monitor, Collected) {
    let mut monitor = monitor();
    let mut seen = Collected::default();
    for frame in frames {
        monitor.take(&frame, &mut seen);
    }
    monitor.finish(&mut seen);
    (monitor, seen)
}

/// The default configuration without the lines that begin with `left_out`.
fn design(left_out: &str) -> Result<MonitorDesign, String> {
    from_files(left_out, design::judging)
}

fn from_files(
    left_out: &str,
    make: fn(&Settings, &Database) -> Result<MonitorDesign, Vec<Flaw>>,
) -> Result<MonitorDesign, String> {
    from_files_without(&[left_out], make)
}

fn from_files_without(
    left_out: &[&str],
    make: fn(&Settings, &Database) -> Result<MonitorDesign, Vec<Flaw>>,
) -> Result<MonitorDesign, String> {
    let root = crate::top();
    let read = |path: &str| std::fs::read(root.join(path)).map_err(|error| error.to_string());
    let text = String::from_utf8(read("config/e-type.toml")?).map_err(|error| error.to_string())?;
    let kept = |line: &&str| !left_out.iter().any(|key| line.starts_with(key));
    let kept: Vec<&str> = text.lines().filter(kept).collect();
    let (settings, _) =
        config::parse("e-type.toml", &kept.join("\n")).map_err(|error| error.to_string())?;
    let dbc = read("dbc/e-type.dbc")?;
    let database = Database::parse(&text::from_bytes(&dbc)).map_err(|error| error.to_string())?;
    make(&settings, &database).map_err(|flaws| format!("{flaws:?}"))
}
