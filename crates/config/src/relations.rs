//! Relations that must hold between the values of different keys.

mod buses;
mod devices;
mod names;
mod requirement;

use super::document::Document;
use super::problem::Problems;
use super::settings::{Canopen, CylinderProcess, CylinderSequential, Settings};
use super::text::other_count;
use requirement::Relations;
use tertius_core::alarm::own::FRAME_BITS;

/// Adds a problem for each relation that does not hold. Relations with a table that already has a
/// problem are not checked yet, since its values may not be what the user means.
pub(super) fn check(settings: &Settings, document: &Document, problems: &mut Problems) {
    let mut relations = Relations::new(document, problems);
    relations.machine(settings);
    relations.plausibility(settings);
    relations.thresholds(settings);
    relations.share(settings);
    relations.heartbeat(settings);
    relations.tls(settings);
    relations.login(settings);
    relations.buses(settings);
    relations.signals(settings);
    relations.cylinders(settings);
    relations.names(settings);
    relations.devices(settings);
}

impl Relations<'_> {
    fn tls(&mut self, settings: &Settings) {
        let http = &settings.http;
        self.require(
            http.certificate.is_some() == http.key.is_some(),
            &["http.certificate", "http.key"],
            "`http.certificate` and `http.key` belong together, but one of them is missing"
                .to_owned(),
            "give both for a page over https, or none of them",
        );
    }

    fn login(&mut self, settings: &Settings) {
        let mqtt = &settings.mqtt;
        self.require(
            mqtt.user.is_some() == mqtt.password.is_some(),
            &["mqtt.user", "mqtt.password"],
            "`mqtt.user` and `mqtt.password` belong together, but one of them is missing"
                .to_owned(),
            "give both for a broker that asks for them, or none of them",
        );
    }

    fn machine(&mut self, settings: &Settings) {
        let [low, high] = settings.machine.stroke;
        self.require(
            low < high,
            &["machine.stroke"],
            format!("`machine.stroke` runs from {low:?} to {high:?}, but must run upwards"),
            "the retracted end comes first, for example stroke = [-1.5, 1.5]",
        );
        let ts = settings.machine.sample_time;
        let deadline = settings.cycle_deadline();
        self.require(
            deadline >= 0.5 * ts && deadline < ts,
            &["machine.cycle_deadline"],
            format!(
                "`machine.cycle_deadline` is {deadline:?}, but must be at least half of the \
                 sample time {ts:?} and below it"
            ),
            "it separates late readings of a cycle from those of the next; without the key it is \
             0.8 of the sample time",
        );
    }

    fn plausibility(&mut self, settings: &Settings) {
        let ts = settings.machine.sample_time;
        let plausibility = &settings.plausibility;
        for (key, value) in [
            ("plausibility.stale", plausibility.stale),
            ("plausibility.frozen", plausibility.frozen),
        ] {
            let default = self.default_note(key);
            self.require(
                value >= ts,
                &[key, "machine.sample_time"],
                format!(
                    "`{key}` is {value:?}{default}, but must be at least the sample time {ts:?}"
                ),
                "nothing new can come within one sample; take some samples",
            );
        }
        if let Some([low, high]) = plausibility.valid_raw {
            self.require(
                low < high,
                &["plausibility.valid_raw"],
                format!("`plausibility.valid_raw` runs from {low} to {high}, but must run upwards"),
                "the lowest raw count comes first, for example valid_raw = [1, 27648]",
            );
        }
    }

    fn thresholds(&mut self, settings: &Settings) {
        let fde = &settings.fde;
        let defaults = (self.default_note("fde.low"), self.default_note("fde.high"));
        self.require(
            fde.low <= fde.high,
            &["fde.low", "fde.high"],
            format!(
                "`fde.low` is {:?}{}, but must not be above `fde.high`, {:?}{}",
                fde.low, defaults.0, fde.high, defaults.1
            ),
            "a warning rises above `high` and clears below `low`",
        );
        let comparator = &settings.comparator;
        let (low, bound, critical) =
            (settings.comparator_low(), comparator.bound, comparator.critical);
        let default = self.default_note("comparator.bound");
        self.require(
            low <= bound,
            &["comparator.low", "comparator.bound"],
            format!(
                "`comparator.low` is {low:?}, but must not be above `comparator.bound`, \
                 {bound:?}{default}"
            ),
            "a warning rises above `bound` and clears below `low`",
        );
        let critical_default = self.default_note("comparator.critical");
        self.require(
            bound < critical,
            &["comparator.bound", "comparator.critical"],
            format!(
                "`comparator.bound` is {bound:?}{default}, but must be below \
                 `comparator.critical`, {critical:?}{critical_default}"
            ),
            "the monitor is there to warn before the machine itself trips at `critical`",
        );
        let maintenance = settings.drift_limits().maintenance;
        self.require(
            maintenance < critical,
            &["sequential.maintenance", "comparator.critical"],
            format!(
                "`sequential.maintenance` is {maintenance:?}, but must be below \
                 `comparator.critical`, {critical:?}{critical_default}"
            ),
            "a transducer is due before the machine itself trips; without the key it is a tenth of \
             that",
        );
    }

    /// Checks the gateway's share of the bus. Fd_Status is its proof of life, and an irregular
    /// Fd_Estimate is worse than none, since whoever relies on it waits for the next.
    fn share(&mut self, settings: &Settings) {
        let Settings { bus, gateway, estimate, .. } = settings;
        let share_of = |frames: f64| frames * FRAME_BITS / f64::from(bus.bitrate);
        let told = |share: f64| (share * 1e3).ceil() / 1e3;
        let default = self.default_note("gateway.bus_share");
        let share = gateway.bus_share;
        let beats = settings.canopen_node().is_some_and(|it| it.heartbeats() > 0.0);
        let statuses = share_of(settings.reports());
        let and_heartbeats = if beats { ", and heartbeats beside it" } else { "" };
        self.require(
            share >= statuses,
            &["gateway.bus_share", "bus.bitrate"],
            format!(
                "`gateway.bus_share` is {share:?}{default}, but at {} bit/s it must be at least {:?}: \
                 Fd_Status is sent every 100 ms{and_heartbeats}",
                bus.bitrate,
                told(statuses)
            ),
            "raise it, with room for warnings, for example to twice that; is bus.bitrate right?",
        );
        let frames = settings.periodic_frames();
        let least = told(share_of(frames));
        self.require(
            !estimate.send || share >= least || share < statuses,
            &["gateway.bus_share", "estimate.send"],
            format!(
                "`gateway.bus_share` is {share:?}{default}, but with `estimate.send` it must be at \
                 least {least:?}: {frames:.0} frames a second"
            ),
            "raise it, with room for warnings, for example by a half; or send no estimates",
        );
    }

    fn heartbeat(&mut self, settings: &Settings) {
        let Some(canopen) = settings.canopen_node() else {
            for key in ["canopen.heartbeat", "canopen.autostart"] {
                let message =
                    format!("`{key}` is of no effect, since the gateway is no CANopen node");
                let help = "make it one by `canopen.node = true`, or leave the key out";
                self.require(!self.document.has(key), &[key], message, help);
            }
            return;
        };
        let (heartbeat, shortest) = (canopen.heartbeat, Canopen::SHORTEST_HEARTBEAT);
        self.require(
            heartbeat == 0.0 || heartbeat >= shortest,
            &["canopen.heartbeat"],
            format!(
                "`canopen.heartbeat` is {heartbeat:?}, but must be at least {shortest:?}, or 0"
            ),
            "a second is usual; 0 sends no heartbeat",
        );
    }

    fn signals(&mut self, settings: &Settings) {
        let signals = &settings.signals.cylinder;
        let several = settings.machine.cylinders > 1;
        for (name, signal) in signals.named() {
            let key = format!("signals.cylinder.{name}");
            // Readings that share a frame may share these; a frame of their own they have is told later.
            let shared = name.ends_with("_counter") || name.ends_with("_status");
            self.require(
                !several || shared || signal.contains('{'),
                &[&key],
                format!(
                    "`{key}` is \"{signal}\" for all {} cylinders: {{n}} is missing in it",
                    settings.machine.cylinders
                ),
                "{n} stands for the cylinder's number, for example Cyl{n}_C1.Position",
            );
            let cylinders = settings.machine.cylinders;
            let other = other_count(signal, cylinders.into());
            self.require(
                other.is_none(),
                &[&key],
                format!(
                    "`{key}` lists {} names, but the machine has {cylinders} cylinders",
                    other.unwrap_or_default()
                ),
                "a list in braces has one name for each cylinder, in their order",
            );
        }
        for (name, _) in signals.named().filter(|(name, _)| name.starts_with("c2_")) {
            let key = format!("signals.cylinder.{name}");
            self.require(
                signals.c2.is_some(),
                &[&key],
                format!("`{key}` is there, but `signals.cylinder.c2` is not"),
                "name the position by C2, too, or leave the key out if there is no second transducer",
            );
        }
        for (first, second, key) in [
            (Some(&signals.c1), &signals.c2, "signals.cylinder.c2"),
            (signals.c1_velocity.as_ref(), &signals.c2_velocity, "signals.cylinder.c2_velocity"),
        ] {
            self.require(
                second.is_none() || first != second.as_ref(),
                &[key],
                format!("`{key}` is the same signal as that of C1"),
                "a reading that is compared with itself never shows a fault; leave the key out if \
                 there is no second transducer",
            );
        }
    }

    fn cylinders(&mut self, settings: &Settings) {
        let count = settings.machine.cylinders;
        let mut seen = [false; u8::MAX as usize + 1];
        for (index, cylinder) in settings.cylinder.iter().enumerate() {
            let key = format!("cylinder[{index}].n");
            let n = cylinder.n;
            self.require(
                n <= count,
                &[&key, "machine.cylinders"],
                format!("`{key}` is {n}, but the machine has {count} cylinders"),
                "they are numbered from 1; see machine.cylinders",
            );
            self.second(index, settings);
            let twice = std::mem::replace(&mut seen[usize::from(n)], true);
            self.require(
                !twice,
                &[&key],
                format!("`{key}` is {n}, which has a [[cylinder]] table above already"),
                "write all overrides of that cylinder into one table",
            );
            if let Some(fitted) = &cylinder.sequential {
                self.fitted(&format!("cylinder[{index}].sequential"), fitted);
            }
            if let Some(process) = &cylinder.process {
                self.process(&format!("cylinder[{index}].process"), process);
            }
            if let Some(flow) = cylinder.nonlinear.as_ref().and_then(|it| it.flow.as_ref()) {
                let table = format!("cylinder[{index}].nonlinear.flow");
                self.pieces(&table, &flow.samples, &flow.curve, "identify --nonlinear");
            }
        }
    }

    /// A cylinder without C2 has nothing that belongs to C2, and one with C2 has its signal.
    fn second(&mut self, index: usize, settings: &Settings) {
        let key = |name: &str| format!("cylinder[{index}].{name}");
        let own = &settings.cylinder[index];
        if own.c2 {
            self.require(
                settings.signals.cylinder.c2.is_some() || !self.document.has(&key("c2")),
                &[&key("c2")],
                format!("`{}` is true, but [signals.cylinder] names no `c2`", key("c2")),
                "name its position as signals.cylinder.c2, or leave the key out",
            );
            return;
        }
        for name in ["c2_name", "c2_gain", "c2_offset", "sequential"] {
            self.require(
                !self.document.has(&key(name)),
                &[&key(name)],
                format!(
                    "`{}` is there, but cylinder {} has no C2 (`c2 = false`)",
                    key(name),
                    own.n
                ),
                "leave it out, or `c2 = false`",
            );
        }
    }

    fn process(&mut self, table: &str, process: &CylinderProcess) {
        let spool = process.spool.as_ref().map(|it| ("spool", &it.samples, &it.curve));
        let flow = process.flow.as_ref().map(|it| ("flow", &it.samples, &it.curve));
        for (name, samples, curve) in spool.into_iter().chain(flow) {
            self.pieces(&format!("{table}.{name}"), samples, curve, "calibrate");
        }
    }

    /// A curve has one count of samples for each of its pieces.
    fn pieces(&mut self, table: &str, samples: &[u64], curve: &[f64], command: &str) {
        let key = format!("{table}.samples");
        let (count, pieces) = (samples.len(), curve.len() - 1);
        self.require(
            count == pieces,
            &[&key],
            format!("`{key}` has {count} values, but `curve` has {pieces} pieces"),
            &format!("take the table as `tertius {command}` writes it"),
        );
    }

    fn fitted(&mut self, table: &str, fitted: &CylinderSequential) {
        const HELP: &str = "take the table as `tertius calibrate` writes it";
        let cells = fitted.nodes.len().saturating_sub(1);
        let key = format!("{table}.samples");
        let count = fitted.samples.len();
        self.require(
            count == cells,
            &[&key],
            format!("`{key}` has {count} values, but there are {cells} cells between the nodes"),
            HELP,
        );
        let (key, count) = (format!("{table}.node_deviations"), fitted.node_deviations.len());
        self.require(
            count == 0 || count == fitted.nodes.len(),
            &[&key],
            format!("`{key}` has {count} values, but there are {} nodes", fitted.nodes.len()),
            HELP,
        );
        let key = format!("{table}.rate");
        self.require(
            fitted.rate.first() == Some(&0.0) && fitted.rate.is_sorted(),
            &[&key],
            format!("`{key}` must begin with 0 and never fall"),
            HELP,
        );
    }
}
