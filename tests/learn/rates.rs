//! The same faults on machines of 10, 20, 50 and 100 Hz, each with what was learnt of it at its rate:
//! times are the same where the detectors go by time, and samples where it takes samples to tell.
//! `scripts/sweep-rates` measures more of it.

use serde_json::Value;
use std::fs;
use tertius_testing::support::{Scratch, changed, replay, tertius};
use tertius_testing::top;

/// When the fault of the cylinder begins, s since the first frame: on no grid of the rates. One cylinder
/// after the other, since what is on all at once is the sampling's.
fn begin(cylinder: u8) -> f64 {
    40.0 + 30.0 * f64::from(cylinder - 1) + 0.0137 * f64::from(cylinder)
}

const LASTS: f64 = 15.0;

/// A simulated machine.
struct Machine {
    folder: Scratch,
    rate: f64,
}

/// What became of the fault of each cylinder.
struct Outcome {
    /// Median times until it was found, s: by the sequential detector and by R3.
    sequential: f64,
    difference: f64,
    /// How often the right transducer was blamed in the end, and the other one.
    blamed: [usize; 2],
}

impl Machine {
    fn learnt(rate: f64) -> Self {
        let folder = Scratch::new();
        let machine = Self { folder, rate };
        let plant = fs::read_to_string(top().join("config/e-type-plant.toml")).expect("it ships");
        let changes = [
            // Readings that stand off for a while are what the sequential detectors find.
            ("fluctuation_probability = 5.0e-4", "fluctuation_probability = 0.0"),
            // At 10 Hz the command predicts a cycle to 0.3 mm. Beside less noise no drive is fitted.
            ("noise = 4.0e-5", "noise = 5.0e-5"),
        ];
        let plant = changed(&plant, &changes);
        machine.folder.write("plant.toml", plant);
        let dbc = fs::read(top().join("dbc/e-type.dbc")).expect("it ships");
        machine.folder.write("e-type.dbc", dbc);
        let text =
            fs::read_to_string(top().join("config/e-type-simulated.toml")).expect("it ships");
        let few = (5.0 / rate).max(0.1);
        let text = changed(
            &text,
            &[
                ("../dbc/e-type.dbc", "e-type.dbc"),
                ("bitrate = 500000", "bitrate = 1000000"),
                ("sample_time = 0.02", &format!("sample_time = {:?}", 1.0 / rate)),
                ("stale = 0.1\n", &format!("stale = {few:?}\n")),
                ("frozen = 0.1\n", &format!("frozen = {few:?}\n")),
            ],
        );
        let config = machine.folder.write("config.toml", text);
        let log = machine.simulate("taught.log", 1, 1800);
        for command in ["identify", "calibrate"] {
            tertius(&[command, &log, "--config", &config, "--into", &config], b"").ok();
        }
        machine
    }

    fn simulate(&self, name: &str, seed: u32, seconds: u32) -> String {
        let [config, plant, log] =
            ["config.toml", "plant.toml", name].map(|name| self.folder.path(name));
        let [seed, seconds] = [seed, seconds].map(|number| number.to_string());
        let machine = ["simulate", "--config", &config, "--plant", &plant];
        let extent = ["--seed", &seed, "--duration", &seconds, "--output", &log];
        tertius(&[&machine[..], &extent].concat(), b"").ok();
        log
    }

    /// C1 and C2 in turn have this `fault`.
    fn outcome(&self, log: &str, fault: &str) -> Outcome {
        let [config, faulty] = ["config.toml", "faulty.log"].map(|name| self.folder.path(name));
        let faults = (1..=6_u8).map(|n| {
            let (from, which) = (begin(n), if n % 2 == 1 { "c1" } else { "c2" });
            format!("{fault},cylinder={n},sensor={which},at={from},until={}", from + LASTS)
        });
        let faults: Vec<String> = faults.collect();
        let mut call = vec!["inject", log, "--config", &config, "--output", &faulty, "--force"];
        faults.iter().for_each(|fault| call.extend(["--fault", fault]));
        tertius(&call, b"").ok();
        let warnings = replay(&[&faulty], &config, &[]).ok().warnings();
        let mut blamed = [0; 2];
        for n in 1..=6 {
            let own = during(&warnings, n, "sequential");
            let last = own.filter_map(|warning| warning["suspect"].as_str()).last();
            match last {
                Some("c1") => blamed[usize::from(n % 2 == 0)] += 1,
                Some("c2") => blamed[usize::from(n % 2 == 1)] += 1,
                _ => {}
            }
        }
        let [sequential, difference] = ["sequential", "fde3"].map(|it| median(&warnings, it));
        Outcome { sequential, difference, blamed }
    }
}

/// What a detector says of a cylinder while it has its fault.
fn during<'a>(
    warnings: &'a [Value],
    cylinder: u8,
    detector: &'a str,
) -> impl Iterator<Item = &'a Value> {
    let since = move |warning: &Value| warning["t"].as_f64().expect("a time") - begin(cylinder);
    warnings.iter().filter(move |warning| {
        warning["cylinder"] == cylinder
            && warning["detector"] == detector
            && (0.0..LASTS).contains(&since(warning))
    })
}

/// Of the times until the detector has found the faults, s; infinite where it does not find half of them.
fn median(warnings: &[Value], detector: &str) -> f64 {
    let mut times: Vec<f64> = (1..=6)
        .map(|n| {
            let first = during(warnings, n, detector).find(|warning| warning["state"] == "raised");
            first.map_or(f64::INFINITY, |it| it["t"].as_f64().expect("a time") - begin(n))
        })
        .collect();
    times.sort_by(f64::total_cmp);
    0.5 * (times[2] + times[3])
}

const STEP: &str = "step,size=2e-3";
const NOISE: &str = "noise,size=8e-4";
const DRIFT: &str = "drift,rate=3e-4";

#[test]
fn faults_are_found_as_soon_at_every_rate_as_samples_allow() {
    let of = |rate: f64| {
        let machine = Machine::learnt(rate);
        let log = machine.simulate("healthy.log", 2, 220);
        let healthy = replay(&[&log], &machine.folder.path("config.toml"), &[]).ok().warnings();
        let false_alarms = healthy.iter().filter(|it| it["detector"] == "sequential").count();
        assert_eq!(false_alarms, 0, "{rate} Hz: {healthy:?}");
        (machine.rate, [STEP, NOISE, DRIFT].map(|fault| machine.outcome(&log, fault)))
    };
    let (usual, at_50) = of(50.0);
    for (rate, found) in [10.0, 20.0, 100.0].map(of) {
        let [step, noise, drift] = &found;
        let cycle = 1.0 / rate.min(usual);
        // R3 sees a length, and a length takes a time; and it is seen for two samples more, as it may be a spike; …
        let later = 2.0 * (1.0 / rate - 1.0 / usual);
        for (known, here) in [(&at_50[0], step), (&at_50[2], drift)] {
            let [known, here] = [known, here].map(|it| it.difference);
            assert!(
                (here - later - known).abs() < 0.2 * known + cycle,
                "{rate} Hz, R3: {here} s, {known} s"
            );
        }
        // … what is weighed against noise takes samples: σ²/(r² t³) of them a second for a drift of r.
        let [known, here] = [&at_50[2], drift].map(|it| it.sequential);
        let longer = (usual / rate).cbrt();
        let bounds = longer.min(1.0) * known - cycle..longer.max(1.0) * known + cycle;
        assert!(bounds.contains(&here), "{rate} Hz, drift: {here} s, {known} s");
        for (what, known, here, most) in
            [("step", &at_50[0], step, 1.0), ("noise", &at_50[1], noise, 5.0)]
        {
            let [known, here] = [usual * known.sequential, rate * here.sequential];
            assert!((here - known).abs() <= most, "{rate} Hz, {what}: {here} samples, {known}");
        }
        for (what, outcome) in [("step", step), ("noise", noise), ("drift", drift)] {
            let [right, wrong] = outcome.blamed;
            assert_eq!(wrong, 0, "{rate} Hz, {what}");
            assert!(what == "drift" || right >= 5, "{rate} Hz, {what}: {right} of 6");
        }
    }
}
