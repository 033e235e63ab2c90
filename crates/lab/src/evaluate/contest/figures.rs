//! Figures of a row of the contest.

use super::hours::Hours;
use super::ladder::{LEVELS, Rival};
use super::lorden;
use super::row::{ContestRow, Course};
use super::trial::Entry;
use crate::evaluate::fault::{fault_kind, fault_name, fault_size};
use crate::evaluate::figures::{Delay, DetectorFigures, SuspectFigures};
use crate::evaluate::proportion::Proportion;
use serde::Serialize;
use tertius_learn::extremes::per_second;
use tertius_machine::inject::Wanted;

/// Result for one grade of transducers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GradeResult {
    pub grade: &'static str,
    /// Level h of the sequential detector, nats.
    pub level: f64,
    /// What the level was made from: the largest evidence, nats, and the time of cylinders, h;
    /// `None` where the level is configured.
    pub level_from: Option<[f64; 2]>,
    pub hours: Hours,
    pub rows: Vec<RowFigures>,
}

/// A row of the contest with its figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RowFigures {
    pub label: String,
    pub fault: &'static str,
    pub size: Option<f64>,
    /// The fault was tried until the machine's next stop.
    pub at_stop: bool,
    pub faults: u64,
    /// Faults that began while a sequential alarm stood; they are excluded from all other figures.
    pub spoilt: u64,
    /// Faults found by each rival: at the thesis's thresholds, and at the level h.
    pub found: [DetectorFigures; Rival::ALL.len()],
    /// Suspect that the sequential detector blames in the end; wrong if it was ever wrong.
    pub suspect: SuspectFigures,
    /// How often the sequential detector names the fault correctly in the end, where the fault has
    /// a name.
    pub kind: Option<Proportion>,
    /// Lorden's bound for one false alarm a year, s; `None` where there is no bound, or no
    /// fault-free hours to compute it from.
    pub bound: Option<f64>,
    /// Cycles to the median detection divided by those of the bound, which are at least one.
    pub ratio: Option<f64>,
    /// Curves of delay against false alarms, by rival.
    pub curves: [Vec<Point>; Rival::ALL.len()],
}

/// One level of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Level, m or nats.
    pub level: f64,
    pub false_alarms_per_year: f64,
    pub found: f64,
    /// Median delay, s, including the cycle in which the fault is found; `None` where fewer than
    /// half are found.
    pub median: Option<f64>,
    /// 95th percentile of the delay, s; `None` where fewer are found.
    pub p95: Option<f64>,
}

impl RowFigures {
    /// The figures of `entries` of `row`.
    pub fn of(
        row: &ContestRow,
        entries: &[Entry],
        hours: &Hours,
        (cylinders, sample_time): (u8, f64),
    ) -> Self {
        let fair: Vec<&Entry> = entries.iter().filter(|entry| !entry.spoilt).collect();
        let at_stop = row.course == Course::Stop;
        let found = Rival::ALL.map(|rival| {
            DetectorFigures::of(fair.iter().map(|entry| entry.delays[rival as usize]).collect())
        });
        let sequential = |entry: &&&Entry| entry.delays[Rival::Sequential as usize].is_some();
        let seen: Vec<&Entry> = fair.iter().filter(sequential).copied().collect();
        let kind = fault_kind(row.wanted)
            .map(|kind| Proportion::counting(&seen, |it| it.kind == Some(kind)));
        let bound = bound(row, hours, cylinders, sample_time).filter(|_| !at_stop);
        let median = found[Rival::Sequential as usize].delay.median;
        let cycles = |delay: f64| (delay / sample_time).ceil().max(1.0);
        let ratio = bound.zip(median).map(|(bound, median)| cycles(median) / bound.max(1.0));
        let curve = |rival: Rival| -> Vec<Point> {
            (0..LEVELS).map(|index| point(&fair, rival, index, hours, sample_time)).collect()
        };
        let curves = if at_stop || row.wanted.is_none() || hours.hours == 0.0 {
            Default::default()
        } else {
            Rival::ALL.map(curve)
        };
        Self {
            label: row.label(),
            fault: fault_name(row.wanted),
            size: fault_size(row.wanted),
            at_stop,
            faults: fair.len() as u64,
            spoilt: (entries.len() - fair.len()) as u64,
            found,
            suspect: SuspectFigures::of(seen.iter().map(|entry| entry.blame)),
            kind,
            bound: bound.map(|samples| samples * sample_time),
            ratio,
            curves,
        }
    }
}

/// Lorden's bound, samples.
fn bound(row: &ContestRow, hours: &Hours, cylinders: u8, sample_time: f64) -> Option<f64> {
    let Some(Wanted::Shape(shape)) = row.wanted else { return None };
    if hours.deviation <= 0.0 {
        return None;
    }
    // Samples of all cylinders in a year.
    let evidence = (f64::from(cylinders) / sample_time / per_second(1.0)).ln();
    lorden::bound(&shape, hours.deviation, evidence, sample_time)
}

fn point(entries: &[&Entry], rival: Rival, index: usize, hours: &Hours, sample_time: f64) -> Point {
    let cycles = |entry: &&Entry| entry.ladder.first(rival, index);
    let delays: Vec<Option<f64>> =
        entries.iter().map(|it| cycles(it).map(|n| f64::from(n) * sample_time)).collect();
    let found = delays.iter().flatten().count() as f64 / delays.len().max(1) as f64;
    let delay = Delay::of(delays);
    Point {
        level: rival.level(index),
        false_alarms_per_year: hours.false_alarms[rival as usize][index],
        found,
        median: delay.median,
        p95: delay.p95,
    }
}
