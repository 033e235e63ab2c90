//! What a host application knows of the machine, and what it has to be told.

use super::payload::Metric;
use crate::appliance::telemetry::points::{Point, PointKind, Points};
use std::time::{Duration, Instant};

/// Numbers that change all the time by themselves.
const RESTLESS: [&str; 3] = ["uptime", "since_frame", "cycles"];

/// Metrics of the node, or of one device.
pub(super) struct Message {
    pub device: Option<String>,
    pub metrics: Vec<Metric>,
}

/// What was told last of all values.
pub(super) struct Published {
    points: Points,
    /// When the numbers were told.
    numbers: Instant,
}

impl Published {
    /// The births of the node and of its devices, one for each cylinder, at `at`, ms since 1970.
    pub fn birth(points: Points, at: u64) -> (Self, Vec<Message>) {
        let message = |(device, own): (Option<String>, &Vec<Point>)| {
            let metric = |it: &Point| Metric::of(it, name(it, device.as_deref()), at).described(it);
            Message { metrics: own.iter().map(metric).collect(), device }
        };
        let messages = owners(&points).map(message).collect();
        (Self { points, numbers: Instant::now() }, messages)
    }

    /// What is to be told in the state `points`: states at once, numbers every `period`, and at once where they become known or
    /// unknown. `None` if the machine has other devices than those that were born.
    pub fn changes(&mut self, points: &Points, period: Duration, at: u64) -> Option<Vec<Message>> {
        if points.cylinders.len() != self.points.cylinders.len() {
            return None;
        }
        let is_time = self.numbers.elapsed() >= period;
        if is_time {
            self.numbers = Instant::now();
        }
        let told = std::iter::once(&mut self.points.machine).chain(&mut self.points.cylinders);
        let mut messages = Vec::new();
        for ((device, now), told) in owners(points).zip(told) {
            let mut metrics = Vec::new();
            for (now, told) in now.iter().zip(told) {
                let is_number =
                    now.kind == PointKind::Real || RESTLESS.contains(&now.name.as_str());
                let becomes = now.value.is_some() != told.value.is_some();
                if now.value != told.value && (is_time || becomes || !is_number) {
                    metrics.push(Metric::of(now, name(now, device.as_deref()), at));
                    told.value = now.value;
                }
            }
            if !metrics.is_empty() {
                messages.push(Message { device, metrics });
            }
        }
        Some(messages)
    }
}

/// The node and the devices with their values.
fn owners(points: &Points) -> impl Iterator<Item = (Option<String>, &Vec<Point>)> {
    let devices = (1..).zip(&points.cylinders);
    let devices = devices.map(|(number, own)| (Some(format!("cylinder_{number}")), own));
    std::iter::once((None, &points.machine)).chain(devices)
}

/// Name of a metric of `device`: that of the point without the device.
fn name<'a>(point: &'a Point, device: Option<&str>) -> &'a str {
    let own = device.and_then(|device| point.name.strip_prefix(device)?.strip_prefix('_'));
    own.unwrap_or(&point.name)
}
