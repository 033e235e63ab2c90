//! Models and tables made for another sample time than the machine's.

use super::connector::Connector;
use super::flaw::Flaw;
use crate::settings::Cylinder;
use tertius_core::frame::BusNumber;

/// Sample times that differ by less than this, s, are equal and only written differently.
const SAME: f64 = 1e-9;

/// What the tables of sequential detectors are taken for that do not say it, s: those which were written
/// before there was a key for it are of the thesis's machine.
const FIRST_TABLES_TIME: f64 = 0.02;

/// Bits at the nominal rate in the shortest frame that CAN or CAN FD has: from the start of frame to
/// the switch of the rate, and from the CRC delimiter to the space between frames.
const SHORTEST_FRAME_BITS: f64 = 30.0;

impl Connector<'_> {
    /// Refuses θ and γ of (4-1), weights of the Riccati equation and tables for the sequential
    /// detector that were made for another sample time, since they would describe another machine. What is not in
    /// the file, the default model, is refused only where it would judge (`by_default`).
    pub(super) fn refuse_other_times(&mut self, by_default: bool) {
        let settings = self.settings;
        for n in 1..=settings.machine.cylinders {
            let own = settings.cylinder.iter().position(|cylinder| cylinder.n == n);
            let table = own.map(|index| format!("cylinder[{index}]"));
            let is_own = own.is_some_and(|index| has_model(&settings.cylinder[index]));
            let (key, model) = match (&table, is_own) {
                (Some(table), true) => (format!("{table}.sample_time"), "the model (4-1)"),
                _ if settings.model.sample_time.is_some() => {
                    ("model.sample_time".to_owned(), "the model (4-1)")
                }
                // Nothing in the file is at fault but that there is no model in it.
                _ => ("machine.sample_time".to_owned(), "the default model, Table 4-1,"),
            };
            if by_default || key != "machine.sample_time" {
                self.refuse_time(
                    &key,
                    settings.model_time_of(n),
                    &format!("{model} of cylinder {n}"),
                    "`tertius commission`, or `tertius identify`, takes this configuration as it is, and writes a \
                     model of the machine's own sample time",
                );
            }
            if let Some(fitted) = settings.process_of(n) {
                self.refuse_time(
                    &format!("{}.process.sample_time", table.as_deref().unwrap_or("cylinder")),
                    Some(fitted.sample_time),
                    &format!("the table [cylinder.process] of cylinder {n}"),
                    "`tertius calibrate` takes this configuration as it is, and writes the table again",
                );
            }
            let Some(fitted) = settings.sequential_of(n) else { continue };
            let unsaid =
                if fitted.sample_time.is_some() { "" } else { ", which has none of its own," };
            self.refuse_time(
                &format!("{}.sequential.sample_time", table.as_deref().unwrap_or("cylinder")),
                fitted.sample_time.or(Some(FIRST_TABLES_TIME)),
                &format!("the table [cylinder.sequential] of cylinder {n}{unsaid}"),
                "`tertius calibrate` takes this configuration as it is, and writes the table again",
            );
        }
        self.refuse_time(
            "process.supply.sample_time",
            settings.process.supply.as_ref().map(|fitted| fitted.sample_time),
            "the table [process.supply]",
            "`tertius calibrate` takes this configuration as it is, and writes the table again",
        );
        self.refuse_time(
            "observer.sample_time",
            settings.observer.sample_time,
            "the table [observer]",
            "leave the table out and run `tertius tune`, which writes it again",
        );
    }

    fn refuse_time(&mut self, key: &str, fitted: Option<f64>, what: &str, help: &str) {
        let ours = self.settings.machine.sample_time;
        let Some(fitted) = fitted.filter(|fitted| (fitted - ours).abs() > SAME * ours) else {
            return;
        };
        let message = format!(
            "`machine.sample_time` is {ours:?}, but {what} is for a sample time of {fitted:?} s"
        );
        self.flaws.push(Flaw::new(key, message, help));
    }

    /// Refuses a cycle that is shorter than its own frames: the sample time or the bit rate is
    /// wrong.
    pub(super) fn refuse_crowded_cycles(&mut self) {
        let (machine, bitrate) = (&self.settings.machine, self.settings.bus.bitrate);
        let frames = self
            .subscriptions
            .all()
            .iter()
            .filter(|message| message.bus == BusNumber::First && (message.sync || message.cyclic))
            .count();
        let least = frames as f64 * SHORTEST_FRAME_BITS / f64::from(bitrate);
        if machine.sample_time < least {
            let message = format!(
                "`machine.sample_time` is {:?}, but at {bitrate} bit/s the {frames} frames of a cycle \
                 take at least {least:.6} s",
                machine.sample_time
            );
            let help = "correct the sample time, or bus.bitrate";
            self.flaws.push(Flaw::new("machine.sample_time", message, help));
        }
    }
}

fn has_model(cylinder: &Cylinder) -> bool {
    cylinder.theta.is_some() || cylinder.gamma.is_some()
}
