//! The simulated machine's configuration with what a calibration on twenty healthy minutes makes of it.

use tertius::calibrate::{Fitting, Gathering, Profiling, Scattering};
use tertius::config::settings::{Cylinder, CylinderSequential, Settings};
use tertius::controller::State;
use tertius::decode::Database;
use tertius::monitor::{Monitor, MonitorDesign};
use tertius::simulator::{EPOCH, Options, Simulator, Tables};
use tertius::survey::{Survey, Surveyor, Window};

const SAMPLE_TIME: f64 = 0.02;

const PLANT: &str = include_str!("../../config/e-type-plant.toml");

/// s of fault-free machine that the detectors are calibrated on, half to fit and half to try.
const LENGTH: f64 = 1200.0;

/// Transducers that are read to one count, without the fluctuations of Figure 5-9.
pub fn fine() -> Tables {
    let plain = "fluctuation_probability = 5.0e-4";
    assert!(PLANT.contains(plain), "the plant's table has changed");
    Tables::parse(&PLANT.replace(plain, "fluctuation_probability = 0.0")).expect("it is sound")
}

/// Fits the corrections of C2, and everything that `[cylinder.sequential]` holds, to a machine of
/// `tables`.
pub fn calibrate(tables: &Tables, settings: &mut Settings, database: &Database) {
    let [fitted, tried] = Window { from: 0.0, to: LENGTH }.split(0.5);
    let mut gathering = Gathering::new(3.0, vec![None; 6]);
    survey(tables, settings, database, fitted, &mut gathering);
    let lines = (0..6).map(|i| Some(gathering.judge(i).expect("it is healthy")));
    let mut fitting = Fitting::new(lines);
    survey(tables, settings, database, fitted, &mut fitting);
    let fits: Vec<_> = (0..6).map(|i| fitting.result(i).unwrap().expect("a line")).collect();
    let mut profiling = Profiling::new(settings.machine.stroke, SAMPLE_TIME, fits.iter().map(Some));
    survey(tables, settings, database, fitted, &mut profiling);
    let profiles: Vec<_> = (0..6).map(|i| profiling.result(i).expect("a profile")).collect();
    let mut scattering = Scattering::new(SAMPLE_TIME, fits.iter().zip(&profiles).map(Some));
    survey(tables, settings, database, tried, &mut scattering);
    settings.cylinder = (0..6)
        .map(|i| {
            let (profile, scatter) = (&profiles[i], scattering.result(i).expect("a scatter"));
            Cylinder {
                n: i as u8 + 1,
                c2_gain: fits[i].line.gain,
                c2_offset: fits[i].line.offset,
                theta: None,
                gamma: None,
                command_offset: None,
                sequential: Some(CylinderSequential {
                    first: profile.reference.first,
                    spacing: profile.reference.spacing,
                    nodes: profile.reference.nodes.clone(),
                    samples: profile.samples.clone(),
                    velocity: profile.reference.velocity,
                    deviation: scatter.deviation,
                    rate_spacing: scatter.rate.spacing,
                    rate: scatter.rate.values,
                    drive: profile.drive.map(|drive| drive.0),
                    prediction: scatter.prediction.expect("there is a drive"),
                }),
            }
        })
        .collect();
}

/// The same machine and sea each time.
fn survey(
    tables: &Tables,
    settings: &Settings,
    database: &Database,
    window: Window,
    surveyor: impl Surveyor,
) {
    let design = MonitorDesign::surveying(settings, database).expect("they fit");
    let mut monitor = Monitor::new(design);
    let mut survey = Survey::new(EPOCH, window, surveyor);
    let options = Options { seed: 77, ..Options::default() };
    let mut simulator =
        Simulator::new(tables, settings, database, &options).expect("it can be simulated");
    simulator.request(State::Engaged);
    for _ in 0..(window.to / SAMPLE_TIME) as u64 {
        simulator.step(&mut |frame| monitor.take(frame, &mut survey));
    }
}
