//! One commissioning, from the machine to its record.

use crate::held_out::Watched;
use crate::line::Line;
use crate::machine;
use crate::plan::{Spoilt, Task};
use crate::recording::Memory;
use std::fs;
use std::path::Path;
use tertius::calibrate::Cuts;
use tertius::commission::{self, Commissioned, Fitness};
use tertius::config::design;
use tertius::config::{self, Settings};
use tertius::dbc::{Database, text};
use tertius::inject::{Fault, Placed, Shape, Wanted, Window, place};
use tertius::monitor::MonitorDesign;
use tertius::simulator::Tables;
use tertius::survey::{self, Origin};
use tertius::time::Span;

/// Inputs that all commissionings share.
pub struct World {
    /// Configurations of fine and of coarse transducers, without and with the statement that there
    /// are no spikes.
    configurations: [[Configuration; 2]; 2],
    database: Database,
    harsh: Tables,
}

struct Configuration {
    name: &'static str,
    text: String,
    settings: Settings,
}

const NAMES: [&str; 2] = ["config/e-type.toml", "config/e-type-coarse.toml"];

/// Text that precedes the statement, and the text with it.
const TABLE: &str = "false_alarms_per_year = 1.0";
/// Text with the statement.
const FREE: &str = "outlier_share = 0.001\nfalse_alarms_per_year = 1.0";

impl World {
    /// Reads the files of the repository `top`.
    pub fn load(top: &Path) -> Result<Self, String> {
        let read = |name: &str| {
            fs::read(top.join(name)).map_err(|error| format!("{name} cannot be read: {error}"))
        };
        let utf8 = |bytes| String::from_utf8(bytes).map_err(|error| error.to_string());
        let configuration = |name: &'static str, stated_free: bool| {
            let text = utf8(read(name)?)?;
            let text = if stated_free { text.replace(TABLE, FREE) } else { text };
            let (settings, _) = config::parse(name, &text).map_err(|error| error.to_string())?;
            Ok::<_, String>(Configuration { name, text, settings })
        };
        let [fine, coarse] = NAMES;
        let of = |name| Ok::<_, String>([configuration(name, false)?, configuration(name, true)?]);
        let configurations = [of(fine)?, of(coarse)?];
        let dbc = text::from_bytes(&read("dbc/e-type.dbc")?).into_owned();
        let database = Database::parse(&dbc).map_err(|error| error.to_string())?;
        let harsh = utf8(read("config/e-type-harsh-plant.toml")?)?;
        let harsh = Tables::parse(&harsh).map_err(|error| error.to_string())?;
        Ok(Self { configurations, database, harsh })
    }

    fn configuration(&self, task: &Task) -> &Configuration {
        &self.configurations[usize::from(task.is_coarse())][usize::from(task.stated_free)]
    }
}

/// CPU time of this thread, s; zero where the system does not provide it.
fn cpu() -> f64 {
    let text = fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanos = text.split_whitespace().next().and_then(|word| word.parse::<f64>().ok());
    nanos.unwrap_or(0.0) / 1e9
}

/// The fault in the recording: its cylinder, its beginning and end, s, and its shape.
fn spoilt(task: &Task) -> Option<(u8, [f64; 2], Shape)> {
    let cylinder = (task.number % 6) as u8 + 1;
    // In the first file.
    let at = 0.3 * task.length;
    let (until, shape) = match task.spoilt? {
        Spoilt::Step => (at + 10.0, Shape::Step { size: 5e-4 }),
        Spoilt::Noise => (at + 20.0, Shape::Noise { size: 8.68e-4 }),
        Spoilt::Jump => (at + 1.0, Shape::Step { size: 0.02 }),
        Spoilt::Stays => (task.length / 2.0, Shape::Step { size: 5e-4 }),
    };
    Some((cylinder, [at, until], shape))
}

fn placed(task: &Task, world: &World) -> Vec<Placed> {
    let fault = spoilt(task).map(|(cylinder, [from, until], shape)| {
        let [from, until] = [from, until].map(Span::from_seconds);
        let (sensor, wanted) = ("c1", Wanted::Shape(shape));
        let fault = Fault { cylinder, sensor, wanted, window: Window { from, until: Some(until) } };
        place(&fault, &world.configuration(task).settings, &world.database)
            .expect("the machine has C1")
    });
    fault.into_iter().collect()
}

/// Records, commissions, and watches for `hours` and through `faults` faults of each kind.
pub fn commission(world: &World, task: &Task, hours: f64, faults: usize) -> Line {
    let World { database, harsh, .. } = world;
    let Configuration { name, text, settings } = world.configuration(task);
    let begun = cpu();
    let tables = machine::draw(harsh, task);
    let befallen = machine::befallen(&tables, task);
    let memory = Memory::record(task, &befallen, settings, database, &placed(task, world));
    let memory = memory.expect("a machine of the draw can be simulated");
    let recorded = cpu();
    let timeline = memory.timeline();
    let origin = Origin {
        inputs: format!("census {}", task.number),
        window: survey::Window { from: 0.0, to: timeline.length() + 1e-9 },
        timeline,
        remarks: Vec::new(),
    };
    let room = commission::Task {
        name,
        text,
        database,
        origin: &origin,
        cuts: &Cuts::default(),
        per_year: 1.0,
        version: env!("CARGO_PKG_VERSION"),
    };
    let Ok(result) = room.run(&memory, |_| ());
    drop(memory);
    let commissioned = cpu();
    let mut line = line(task, &result);
    if result.verdict.fitness != Fitness::Unfit {
        match monitor(name, &result.taught.text, database) {
            Ok((settings, design)) if result.verdict.fitness == Fitness::Fit => {
                let (settings, design) = (&settings, &design);
                // The bus goes on as it was.
                let watched = Watched { tables: &befallen, settings, database, design };
                line.faults = watched.faults(task, faults);
                line.false_alarms = watched.false_alarms(task, hours);
                line.hours = hours;
            }
            Ok(_) => {}
            Err(flaw) => line.flaw = Some(flaw),
        }
    }
    line.cpu_s = [recorded - begun, commissioned - recorded, cpu() - commissioned];
    line
}

/// The monitor as `check` would judge it.
fn monitor(
    name: &str,
    text: &str,
    database: &Database,
) -> Result<(Settings, MonitorDesign), String> {
    let (settings, _) = config::parse(name, text).map_err(|error| error.to_string())?;
    let design = design::judging(&settings, database);
    let design = design.map_err(|flaws| {
        flaws.iter().map(|flaw| format!("{}: {}", flaw.key, flaw.message)).collect::<String>()
    })?;
    Ok((settings, design))
}

fn line(task: &Task, result: &Commissioned) -> Line {
    let taught = &result.taught;
    let cylinders = || taught.calibration.iter().flat_map(|it| &it.cylinders);
    let fitness = match &result.verdict.fitness {
        Fitness::Fit => "fit",
        Fitness::Partly { .. } => "partly",
        Fitness::Unfit => "unfit",
    };
    let spoilt = spoilt(task);
    let cut = spoilt.is_some_and(|(cylinder, [from, until], _)| {
        let own = cylinders().filter(|it| it.number == cylinder).flat_map(|it| &it.left_out);
        own.into_iter().any(|[begin, end]| *begin <= from + 1.0 && until - 1.0 <= *end)
    });
    Line {
        number: task.number,
        seed: task.seed,
        machine: task.machine,
        transducers: task.transducers(),
        length_s: task.length,
        pair: task.pair,
        calm_first: task.calm_first,
        mishap: task.mishap,
        stated_free: task.stated_free,
        spoilt: task.spoilt,
        faulty: spoilt.map(|(cylinder, ..)| cylinder),
        fitness: fitness.to_owned(),
        refused: taught.refused_cylinders(),
        sentence: result.verdict.sentence.clone(),
        reasons: result.verdict.reasons.clone(),
        cut,
        levels_nats: cylinders().filter_map(|it| it.level).collect(),
        bound_mm: taught.calibration.as_ref().and_then(|it| it.bound).map(|it| it.level * 1e3),
        high_mm: taught.tuning.as_ref().map(|it| it.thresholds.high * 1e3),
        seen: result.coverage.iter().map(|it| it.seen).collect(),
        flaw: None,
        faults: Vec::new(),
        hours: 0.0,
        false_alarms: Vec::new(),
        cpu_s: [0.0; 3],
    }
}
