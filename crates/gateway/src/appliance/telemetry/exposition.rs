//! The telemetry in the text format of OpenMetrics, for Prometheus.

mod names;
mod plain;

pub use plain::{PLAIN_CONTENT_TYPE, plain};

use super::cell::{Histogram, State, Total};
use super::clock::Clock;
use super::overview::known;
use super::stops::Reading;
use super::{Cylinder, Telemetry};
use prometheus_client::collector::Collector;
use prometheus_client::encoding::{DescriptorEncoder, MetricEncoder, NoLabelSet, text};
use prometheus_client::metrics::MetricType;
use prometheus_client::registry::{Registry, Unit};
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tertius_core::alarm::Detector;
use tertius_core::alarm::register;
use tertius_core::alarm::status::{Health, Mode};
use tertius_core::error_frame::ControllerState;
use tertius_core::sample::Transducer;
use tertius_core::time::{Span, Timestamp};

/// Content type of the text, for HTTP.
pub const CONTENT_TYPE: &str = "application/openmetrics-text; version=1.0.0; charset=utf-8";

const CYLINDERS: [&str; 6] = ["1", "2", "3", "4", "5", "6"];
const RESIDUALS: [&str; 3] = ["r1", "r2", "r3"];

/// Names of the forecasts, in the order of the telemetry.
const LEFT: [(&str, &str); 3] = [
    (
        "stop_months_until_maintenance",
        "Months from the newest dwell until the reading will have drifted by \
         sequential.maintenance. Absent where it does not drift.",
    ),
    ("stop_earliest_months_until_maintenance", "The smallest value that the dwells allow."),
    ("stop_latest_months_until_maintenance", "The largest value that the dwells allow."),
];

/// The text of `telemetry` as it is now by `clock`.
///
/// # Errors
/// None in practice: writing to a text does not fail.
pub fn exposition(telemetry: &Arc<Telemetry>, clock: &dyn Clock) -> Result<String, fmt::Error> {
    let mut registry = Registry::with_prefix("tertius");
    registry.register_collector(Box::new(View {
        telemetry: Arc::clone(telemetry),
        uptime: clock.uptime(),
        system: clock.system(),
    }));
    let mut out = String::with_capacity(64 * 1024);
    text::encode(&mut out, &registry)?;
    Ok(out)
}

/// The telemetry at one time.
#[derive(Debug)]
struct View {
    telemetry: Arc<Telemetry>,
    uptime: Duration,
    system: Timestamp,
}

impl Collector for View {
    fn encode(&self, mut encoder: DescriptorEncoder<'_>) -> fmt::Result {
        let out = &mut Out(&mut encoder);
        self.totals(out)?;
        self.bus(out)?;
        self.names(out)?;
        self.cylinders(out)?;
        self.verdicts(out)?;
        self.stops(out)?;
        self.process(out)
    }
}

impl View {
    fn totals(&self, out: &mut Out<'_, '_>) -> fmt::Result {
        let peers = &self.telemetry.peers;
        for (name, help, total) in
            self.telemetry.totals.described().into_iter().chain(peers.totals())
        {
            out.family(name, help, None, MetricType::Counter)?
                .encode_counter::<NoLabelSet, u64, f64>(&total.get(), None)?;
        }
        for (name, help, value) in peers.gauges() {
            out.gauge(name, help, value)?;
        }
        let totals = &self.telemetry.totals;
        let help = "Times that the configuration was read again, by result.";
        let mut reloads = out.family("configuration_reloads", help, None, MetricType::Counter)?;
        count(&mut reloads, &[("result", "accepted")], &totals.reloads_accepted)?;
        count(&mut reloads, &[("result", "refused")], &totals.reloads_refused)
    }

    fn bus(&self, out: &mut Out<'_, '_>) -> fmt::Result {
        let link = &self.telemetry.link;
        let open = Some(f64::from(u8::from(self.telemetry.is_open())));
        out.gauge(
            "bus_up",
            "1 while the interface is open and is being received from, else 0.",
            open,
        )?;
        let help = "1 while the interface is brought up; a controller that is bus-off still is.";
        out.gauge("link_up", help, link.up.get())?;
        let help = "State of the CAN controller: 1 for the present state, 0 for the others. Absent \
            without a controller.";
        let mut family = out.family("controller_state", help, None, MetricType::Gauge)?;
        if link.state.get().is_some() {
            one_of(&mut family, &[], &ControllerState::NAMES, link.state.get())?;
        }
        let help = "The controller's transmit error counter; error-passive from 128 on.";
        out.gauge("controller_transmit_errors", help, link.transmit_errors.get())?;
        let help = "The controller's receive error counter; error-passive from 128 on.";
        out.gauge("controller_receive_errors", help, link.receive_errors.get())
    }

    /// Cylinders of the machine, by their number.
    fn numbered(&self) -> impl Iterator<Item = (&'static str, &Cylinder)> {
        CYLINDERS.into_iter().zip(self.telemetry.cylinders())
    }

    fn cylinders(&self, out: &mut Out<'_, '_>) -> fmt::Result {
        let help = "Size of a residual in the newest cycle. Absent where there is none.";
        let mut family = out.family("residual", help, Some(Unit::Meters), MetricType::Gauge)?;
        let evidence = self.telemetry.has_evidence(self.uptime);
        for (number, cylinder) in self.numbered().filter(|_| evidence) {
            for (name, residual) in RESIDUALS.iter().zip(&cylinder.residuals) {
                let labels = [("cylinder", number), ("residual", name)];
                if let Some(size) = residual.get() {
                    family.encode_family(&labels)?.encode_gauge(&size)?;
                }
            }
        }
        let help = "Limit of a residual, and of the measured difference of C1 and C2 (c1_c2).";
        let unit = Some(Unit::Meters);
        let mut family = out.family("residual_limit", help, unit, MetricType::Gauge)?;
        let facts = self.telemetry.facts();
        for ((number, _), limits) in self.numbered().zip(&facts.limits_m) {
            let named = RESIDUALS.iter().chain(["c1_c2"].iter()).zip(limits);
            for (name, limit) in named.filter(|(_, limit)| limit.is_finite()) {
                let labels = [("cylinder", number), ("residual", name)];
                family.encode_family(&labels)?.encode_gauge(limit)?;
            }
        }
        let help =
            "Standard deviation of the estimated length. Absent where there is no valid one.";
        let unit = Some(Unit::Meters);
        let mut family = out.family("estimate_sigma", help, unit, MetricType::Gauge)?;
        for (number, cylinder) in self.numbered().filter(|_| evidence) {
            if let Some(sigma) = cylinder.sigma.get() {
                family.encode_family(&[("cylinder", number)])?.encode_gauge(&sigma)?;
            }
        }
        let help = "Sizes of a residual, cycle by cycle.";
        let unit = Some(Unit::Meters);
        let mut family = out.family("residual_size", help, unit, MetricType::Histogram)?;
        for (number, cylinder) in self.numbered() {
            for (name, sizes) in RESIDUALS.iter().zip(&cylinder.sizes) {
                histogram(&mut family, &[("cylinder", number), ("residual", name)], sizes)?;
            }
        }
        Ok(())
    }

    fn verdicts(&self, out: &mut Out<'_, '_>) -> fmt::Result {
        let help = "Warnings raised.";
        let mut family = out.family("warnings_raised", help, None, MetricType::Counter)?;
        let warn = |detector: &&Detector| register::DETECTORS.contains(*detector);
        for (number, cylinder) in self.numbered() {
            for detector in Detector::ALL.iter().filter(warn) {
                let labels = [("cylinder", number), ("detector", detector.name())];
                count(&mut family, &labels, &cylinder.raised[*detector as usize - 1])?;
            }
        }
        let help =
            "Incidents that were opened: the warnings of a cylinder that have one cause are one.";
        let mut family = out.family("incidents_opened", help, None, MetricType::Counter)?;
        for (number, cylinder) in self.numbered() {
            count(&mut family, &[("cylinder", number)], &cylinder.incidents.opened)?;
        }
        count(&mut family, &[("cylinder", "machine")], &self.telemetry.shared.opened)?;
        let help = "Incidents that are not closed.";
        let mut family = out.family("incidents_open", help, None, MetricType::Gauge)?;
        for (number, cylinder) in self.numbered() {
            let open = cylinder.incidents.slots().count() as f64;
            family.encode_family(&[("cylinder", number)])?.encode_gauge(&open)?;
        }
        let open = self.telemetry.shared.slots().count() as f64;
        family.encode_family(&[("cylinder", "machine")])?.encode_gauge(&open)?;
        let standing = f64::from(self.telemetry.standing.load(Ordering::Relaxed));
        out.gauge("warnings_standing", "Standing warnings.", Some(standing))?;
        let help = "The highest level of the standing warnings: 0 none, 1 yellow, 2 orange, \
                    3 red, 4 black.";
        let level = f64::from(self.telemetry.level.load(Ordering::Relaxed));
        out.gauge("alarm_level", help, Some(level))?;
        let help = "Mode of the monitor: 1 for the present mode, 0 for the others; all 0 while the \
            bus is not served.";
        let mut family = out.family("mode", help, None, MetricType::Gauge)?;
        let mode = self.telemetry.mode.get().filter(|_| self.telemetry.lives(self.uptime));
        one_of(&mut family, &[], &Mode::NAMES, mode)?;
        self.transducers(out)?;
        let help = "From the time stamp of the frame (or the deadline) that caused a warning to \
                    the hand-over of the warning's frame to the interface.";
        let unit = Some(Unit::Seconds);
        let mut family = out.family("warning_latency", help, unit, MetricType::Histogram)?;
        histogram(&mut family, &[], &self.telemetry.latency)
    }

    fn transducers(&self, out: &mut Out<'_, '_>) -> fmt::Result {
        let help = "State of a transducer: 1 for the present state, 0 for the others.";
        let mut family = out.family("transducer_state", help, None, MetricType::Gauge)?;
        let evidence = self.telemetry.has_evidence(self.uptime);
        for (number, cylinder) in self.numbered() {
            for (name, state) in Transducer::NAMES.iter().zip(&cylinder.transducers) {
                let labels = [("cylinder", number), ("transducer", name)];
                let state = known(State::get(state), evidence) as u8;
                one_of(&mut family, &labels, &Health::NAMES, Some(state))?;
            }
        }
        Ok(())
    }

    /// Writes the readings on the stops. Without enough dwells there are none.
    fn stops(&self, out: &mut Out<'_, '_>) -> fmt::Result {
        let help = "Number of readings of the rod on its stop that are kept.";
        let mut family = out.family("stop_dwells", help, None, MetricType::Gauge)?;
        for (number, cylinder) in self.numbered() {
            if let Some(dwells) = cylinder.stop.dwells.get() {
                family.encode_family(&[("cylinder", number)])?.encode_gauge(&dwells)?;
            }
        }
        let help = "Move of the newest reading on the stop from the first ones.";
        let moved = |reading: &Reading| reading.moved.get();
        self.readings(out, ("stop_moved", help, Some(Unit::Meters)), moved)?;
        let help = "Drift of the reading on the stop in a month, metres.";
        let drift = |reading: &Reading| reading.drift.get();
        self.readings(out, ("stop_drift_meters_per_month", help, None), drift)?;
        let help = "Standard error of the drift in a month, metres.";
        let error = |reading: &Reading| reading.error.get();
        self.readings(out, ("stop_drift_error_meters_per_month", help, None), error)?;
        for (i, (name, help)) in LEFT.into_iter().enumerate() {
            self.readings(out, (name, help, None), |reading| reading.left[i].get())?;
        }
        Ok(())
    }

    /// Writes a gauge for each transducer on its stop: name, help and unit.
    fn readings(
        &self,
        out: &mut Out<'_, '_>,
        (name, help, unit): (&'static str, &str, Option<Unit>),
        value: impl Fn(&Reading) -> Option<f64>,
    ) -> fmt::Result {
        let mut family = out.family(name, help, unit, MetricType::Gauge)?;
        for (number, cylinder) in self.numbered() {
            for (transducer, reading) in Transducer::NAMES.iter().zip(&cylinder.stop.readings) {
                if let Some(value) = value(reading) {
                    let labels = [("cylinder", number), ("transducer", transducer)];
                    family.encode_family(&labels)?.encode_gauge(&value)?;
                }
            }
        }
        Ok(())
    }

    fn process(&self, out: &mut Out<'_, '_>) -> fmt::Result {
        let telemetry = &self.telemetry;
        let help = "Size of the event store, bytes. Absent without one.";
        out.gauge("store_size_bytes", help, telemetry.store_size.get())?;
        let help = "What runs.";
        out.family("build", help, None, MetricType::Info)?
            .encode_info(&[("version", env!("CARGO_PKG_VERSION"))])?;
        let facts = self.telemetry.facts();
        let calibration = facts.calibration.as_deref().unwrap_or("");
        let help = "By which configuration and calibration it judges.";
        out.family("configuration", help, None, MetricType::Info)?.encode_info(&[
            ("configuration", facts.identity.as_str()),
            ("calibration", calibration),
            ("calibration_recorded", facts.calibration_recorded.as_deref().unwrap_or("")),
        ])?;
        let help = "When the gateway started, since 1970.";
        out.time("start_time", help, Some(telemetry.started))?;
        let help = "When the data path last turned, since 1970. Absent before the first turn.";
        out.time("last_turn_timestamp", help, self.ago(telemetry.since_turn(self.uptime)))?;
        let help = "When the last frame of the machine was received, since 1970. Absent before the \
            first one since the bus was opened.";
        out.time("last_frame_timestamp", help, self.ago(telemetry.since_frame(self.uptime)))
    }

    /// The system's time at that time before now.
    fn ago(&self, time: Option<Duration>) -> Option<Timestamp> {
        let nanos = i64::try_from(time?.as_nanos()).ok()?;
        Some(self.system.after(Span::from_nanos(-nanos)))
    }
}

/// Output of metric families.
struct Out<'a, 'b>(&'a mut DescriptorEncoder<'b>);

impl Out<'_, '_> {
    fn family<'s>(
        &'s mut self,
        name: &'s str,
        help: &str,
        unit: Option<Unit>,
        kind: MetricType,
    ) -> Result<MetricEncoder<'s>, fmt::Error> {
        let unit = match unit {
            Some(Unit::Meters) => Some(&Unit::Meters),
            Some(Unit::Seconds) => Some(&Unit::Seconds),
            _ => None,
        };
        self.0.encode_descriptor(name, help, unit, kind)
    }

    /// Writes a number that may be absent.
    fn gauge(&mut self, name: &str, help: &str, value: Option<f64>) -> fmt::Result {
        let mut family = self.family(name, help, None, MetricType::Gauge)?;
        value.map_or(Ok(()), |value| family.encode_gauge(&value))
    }

    fn time(&mut self, name: &str, help: &str, value: Option<Timestamp>) -> fmt::Result {
        let mut family = self.family(name, help, Some(Unit::Seconds), MetricType::Gauge)?;
        value.map_or(Ok(()), |value| family.encode_gauge(&value.as_seconds()))
    }
}

type Labels<'a> = [(&'a str, &'a str)];

fn count(family: &mut MetricEncoder<'_>, labels: &Labels<'_>, total: &Total) -> fmt::Result {
    family.encode_family(&labels)?.encode_counter::<NoLabelSet, u64, f64>(&total.get(), None)
}

/// Writes a sample for each of `names`: 1 for the one of `number`, 0 for the others.
fn one_of(
    family: &mut MetricEncoder<'_>,
    labels: &Labels<'_>,
    names: &[&'static str],
    number: Option<u8>,
) -> fmt::Result {
    let label = if names == Mode::NAMES { "mode" } else { "state" };
    for (i, name) in names.iter().enumerate() {
        let labels = [labels, &[(label, *name)]].concat();
        let is = number.is_some_and(|number| usize::from(number) == i);
        family.encode_family(&labels)?.encode_gauge(&i64::from(is))?;
    }
    Ok(())
}

fn histogram(
    family: &mut MetricEncoder<'_>,
    labels: &Labels<'_>,
    histogram: &Histogram,
) -> fmt::Result {
    let buckets = histogram.buckets();
    let observed = buckets.iter().map(|(_, count)| count).sum();
    let mut family = family.encode_family(&labels)?;
    family.encode_histogram::<NoLabelSet>(histogram.sum(), observed, &buckets, None)
}
