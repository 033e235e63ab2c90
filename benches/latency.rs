//! From the frame that completes a cycle to the warning that it causes, through everything of the live gateway but the
//! socket: frames come at their times, and what is sent is only noted. `scripts/bench-window` and
//! `scripts/bench-peers` run it, alone and with others around.
//!
//!     cargo bench --bench latency -- CONFIG WARNINGS
//!
//! Writes one latency a line, µs, from the time at which the frame was due; sampling begins after 2 s.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use tertius::alarm::OwnFrame;
use tertius::appliance::flight::FlightPlan;
use tertius::appliance::history::Kept;
use tertius::appliance::http::DeskPlan;
use tertius::appliance::outputs::OutputPlan;
use tertius::appliance::realtime;
use tertius::appliance::store::StorePlan;
use tertius::appliance::surroundings::{Appliance, Keeping, SitePlan};
use tertius::appliance::telemetry::MachineFacts;
use tertius::bus::{Port, PortCounts, PortError, Received, Sent, Stamps};
use tertius::config::{self, Loaded, design};
use tertius::dbc::Database;
use tertius::frame::{Buses, Frame, Id, Kind};
use tertius::live::supervisor::{self, Opener};
use tertius::monitor::{Monitor, MonitorDesign};
use tertius::time::Timestamp;
use tertius_testing::machine::{Cycle, gateway_of};

const CYCLE: Duration = Duration::from_millis(20);
/// The last frame of a cycle comes so long after the others.
const APART: Duration = Duration::from_millis(3);
const SETTLE: i64 = 100;
/// Every so many cycles, one has a warning.
const EVERY: i64 = 10;

/// Frames at their times, and how long the gateway takes for those that matter.
struct Paced {
    start: Instant,
    cycle: i64,
    /// The valve of cylinder 6, which completes the cycle, and when it is due.
    last: Option<(Frame, Instant)>,
    asked: Option<Instant>,
    latencies: Vec<f64>,
    wanted: usize,
    stop: Arc<AtomicBool>,
    counts: PortCounts,
}

fn now() -> Timestamp {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).expect("it is after 1970");
    Timestamp::from_nanos(i64::try_from(since.as_nanos()).expect("it is before 2262"))
}

/// With the time at which it is handed over, as the kernel stamps it.
fn stamped(frame: &Frame) -> Frame {
    Frame::new(now(), frame.id, Kind::Data, frame.data())
}

fn wait(until: Instant) {
    std::thread::sleep(until.saturating_duration_since(Instant::now()));
}

impl Paced {
    fn is_bad(&self) -> bool {
        self.cycle >= SETTLE && self.cycle % EVERY == 0
    }

    /// All frames of a cycle but the last, which is kept.
    fn begin(&mut self, take: &mut dyn FnMut(&Frame)) -> usize {
        let mut frames = Cycle::new(self.cycle).frames();
        if self.is_bad() {
            let id = Id::standard(0x186).expect("eleven bits");
            let broken = Frame::new(now(), id, Kind::Data, &[0, 0, 0, 0, 0, self.cycle as u8]);
            let of_c1 = frames.iter_mut().find(|frame| frame.id == id);
            *of_c1.expect("cylinder 6 has it") = broken;
        }
        let last = frames.pop().expect("there are some");
        let due = self.start + CYCLE * u32::try_from(self.cycle).expect("it is short") + APART;
        self.last = Some((last, due));
        frames.iter().for_each(|frame| take(&stamped(frame)));
        frames.len()
    }
}

impl Port for Paced {
    fn receive(
        &mut self,
        patience: Duration,
        take: &mut dyn FnMut(&Frame),
    ) -> Result<Received, PortError> {
        let due = match &self.last {
            Some((_, due)) => *due,
            None => self.start + CYCLE * u32::try_from(self.cycle).expect("it is short"),
        };
        let given_up = Instant::now() + patience;
        wait(due.min(given_up));
        if due > given_up {
            return Ok(Received { frames: 0, drained_at: Some(now()), lost: Buses::NONE });
        }
        let frames = match self.last.take() {
            None => self.begin(take),
            Some((last, due)) => {
                self.asked = self.is_bad().then_some(due);
                self.cycle += 1;
                take(&stamped(&last));
                1
            }
        };
        self.counts.received += frames as u64;
        Ok(Received { frames, drained_at: Some(now()), lost: Buses::NONE })
    }

    fn send(&mut self, frame: &OwnFrame) -> Result<Sent, PortError> {
        let frame = frame.as_frame();
        let is_raised = frame.id.value() == 0x2D1 && frame.data()[4] >> 6 & 1 == 1;
        if let Some(asked) = self.asked.take_if(|_| is_raised) {
            self.latencies.push(asked.elapsed().as_nanos() as f64 / 1e3);
            if self.latencies.len() == self.wanted {
                self.stop.store(true, Ordering::Relaxed);
            }
        }
        Ok(Sent::Taken)
    }

    fn counts(&self) -> PortCounts {
        self.counts
    }

    fn stamps(&self) -> Stamps {
        Stamps::Embedded
    }

    fn description(&self) -> String {
        "paced".to_owned()
    }
}

impl Drop for Paced {
    fn drop(&mut self) {
        self.latencies.iter().for_each(|latency| println!("{latency:.1}"));
    }
}

struct Once(Option<Paced>);

impl Opener for Once {
    fn open(&mut self) -> Result<Box<dyn Port>, String> {
        self.0.take().map(|port| Box::new(port) as Box<dyn Port>).ok_or("it is over".to_owned())
    }
}

fn design(loaded: &Loaded) -> MonitorDesign {
    let text = tertius::dbc::text::from_bytes(&loaded.dbc_text);
    let database = Database::parse(&text).expect("it ships");
    design::judging(&loaded.settings, &database).expect("they fit")
}

fn keeping(path: &Path, loaded: &Loaded, design: &MonitorDesign) -> Keeping {
    let settings = &loaded.settings;
    let machine = settings.machine.name.clone();
    Keeping {
        history: Kept {
            machine: machine.clone(),
            cylinders: settings.machine.cylinders,
            limits: settings.drift_limits(),
            file: None,
        },
        store: loaded.store_path.clone().map(|path| StorePlan {
            path,
            size: 64_000_000,
            days: 100,
            machine,
            names: settings.names(),
            configuration: String::new(),
            sample_time: settings.machine.sample_time,
        }),
        flight: FlightPlan::new(path, loaded, design),
    }
}

fn main() {
    let words: Vec<String> = std::env::args().filter(|word| !word.starts_with("--")).collect();
    let [_, path, wanted] = &words[..] else {
        // As `cargo test` calls every bench.
        return println!("latency CONFIG WARNINGS");
    };
    let path = Path::new(path);
    let loaded = config::load(path).unwrap_or_else(|error| panic!("{error}"));
    let design = design(&loaded);
    let keeping = keeping(path, &loaded, &design);
    let limits_m = design.cylinders.iter().map(|cylinder| cylinder.limits()).collect();
    let mut gateway = gateway_of(Monitor::new(design), loaded.settings.gateway.bus_share);
    let reload = || Err("there is no other one".to_owned());
    let mut appliance = Appliance::new(Box::new(reload)).expect("signals can be caught");
    appliance.describe(MachineFacts { limits_m, ..MachineFacts::default() });
    let settings = &loaded.settings;
    let site = SitePlan {
        listen: settings.http.address(),
        desk: DeskPlan {
            token: settings.http.token.as_ref().and_then(|digest| digest.parse().ok()),
            recordings: keeping.flight.as_ref().map(|flight| flight.folder.clone()),
            ..DeskPlan::default()
        },
        tls: None,
        outputs: OutputPlan::new(path, &loaded),
    };
    appliance.starting(&path.display().to_string(), site, None);
    appliance.restore(&mut gateway, keeping);
    realtime::apply(loaded.settings.realtime);
    let port = Paced {
        start: Instant::now(),
        cycle: 0,
        last: None,
        asked: None,
        latencies: Vec::new(),
        wanted: wanted.parse().expect("a number of warnings"),
        stop: appliance.stopper(),
        counts: PortCounts::default(),
    };
    let gateway = supervisor::run(gateway, Box::new(Once(Some(port))), &mut appliance);
    appliance.stopped(&gateway);
}
