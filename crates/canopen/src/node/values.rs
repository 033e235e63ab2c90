//! Values of the objects that change, and their service over SDO.

use super::dictionary::{Access, Dictionary, Live, NodeEntry, Source};
use super::errors::Errors;
use super::stack::{Abort, Served, Width};
use super::value::{NodeType, NodeValue};
use tertius_core::alarm::status::{MAX_CYLINDERS, Status};
use tertius_core::alarm::{OwnFrame, OwnMessage};
use tertius_core::monitor::{Counts, Record};
use tertius_core::time::Span;

/// What the node shows of the monitor.
#[derive(Clone, Copy, Debug)]
pub struct NodeView<'a> {
    pub counts: &'a Counts,
    /// Newest status; `None` before the first.
    pub status: Option<&'a Status>,
}

/// Values that the node itself keeps.
#[derive(Clone, Debug)]
pub(super) struct Values {
    node: u8,
    /// Heartbeat time, ms; 0 for none.
    heartbeat: u16,
    /// Shortest heartbeat time that can be set, ms.
    shortest: u16,
    pub(super) errors: Errors,
    /// Contents of the newest frame of each message, in the order of [`OwnMessage::ALL`].
    pdos: [[u8; 8]; OwnMessage::ALL.len()],
    /// Newest residuals of each cylinder, m.
    residuals: [[Option<f64>; 3]; MAX_CYLINDERS],
}

impl Values {
    pub(super) fn new(node: u8, heartbeat: u16, shortest: u16) -> Self {
        Self {
            node,
            heartbeat,
            shortest,
            errors: Errors::default(),
            pdos: [[0; 8]; OwnMessage::ALL.len()],
            residuals: [[None; 3]; MAX_CYLINDERS],
        }
    }

    /// Time between heartbeats; `None` if there are none.
    pub(super) fn heartbeat(&self) -> Option<Span> {
        (self.heartbeat > 0).then(|| milliseconds(self.heartbeat))
    }

    pub(super) fn set_heartbeat(&mut self, milliseconds: u16) {
        self.heartbeat = milliseconds;
    }

    pub(super) fn record(&mut self, record: &Record) {
        let index = usize::from(record.cylinder).wrapping_sub(1);
        if let Some(residuals) = self.residuals.get_mut(index) {
            *residuals = record.residuals;
        }
    }

    pub(super) fn pdo(&mut self, frame: &OwnFrame) {
        if let (Some(message), Ok(data)) = (frame.message(), frame.as_frame().data().try_into()) {
            self.pdos[message as usize] = data;
        }
    }

    /// Puts the value of an entry into `value`.
    fn put(
        &self,
        entry: &NodeEntry,
        monitor: &NodeView<'_>,
        value: &mut NodeValue,
    ) -> Result<(), Abort> {
        match &entry.source {
            Source::Number(number) => set(value, entry.kind, (*number).into()),
            Source::OfNode(base) => set(value, entry.kind, (base + u32::from(self.node)).into()),
            Source::Real(real) => value.set(&real.to_le_bytes()),
            Source::Text(text) => value.set(text.as_bytes()),
            Source::Live(live) => return self.put_live(*live, entry.kind, monitor, value),
        }
        Ok(())
    }

    fn put_live(
        &self,
        live: Live,
        kind: NodeType,
        monitor: &NodeView<'_>,
        value: &mut NodeValue,
    ) -> Result<(), Abort> {
        let status = monitor.status.copied().unwrap_or_default();
        let number = match live {
            Live::ErrorRegister => self.errors.register().into(),
            Live::ErrorCount => self.errors.history().len() as u64,
            Live::Error(n) => {
                let error = self.errors.history().get(usize::from(n));
                u64::from(*error.ok_or(Abort::NoData)?)
            }
            Live::Heartbeat => self.heartbeat.into(),
            Live::Pdo { message, from, length } => {
                let from = usize::from(from);
                value.set(&self.pdos[message as usize][from..from + usize::from(length)]);
                return Ok(());
            }
            Live::Level => status.level as u64,
            Live::Mode => status.mode as u64,
            Live::ActiveWarnings => u64::from(status.active_warnings).min(u8::MAX.into()),
            Live::Count(n) => count(monitor.counts, n),
            Live::Health { cylinder, transducer } => {
                let pair = status.transducers[usize::from(cylinder) - 1];
                pair[usize::from(transducer)] as u64
            }
            Live::Residual { cylinder, number } => {
                let residual = self.residuals[usize::from(cylinder) - 1][usize::from(number)];
                value.set(&residual.map_or(f32::NAN, |it| it as f32).to_le_bytes());
                return Ok(());
            }
        };
        set(value, kind, number);
        Ok(())
    }
}

/// Sets a number in as many bytes as its type has.
fn set(value: &mut NodeValue, kind: NodeType, number: u64) {
    value.set(&number.to_le_bytes()[..usize::from(kind.bits() / 8)]);
}

/// The counts in the order of the object's sub-indices.
fn count(counts: &Counts, n: u8) -> u64 {
    let Counts { used, ignored, errors, cycles, incomplete, missing, late, repeated, .. } = *counts;
    let Counts { held, bad_signals, backwards, time_jumps, interruptions, .. } = *counts;
    let [first, second] = [
        [used, ignored, errors, cycles, incomplete, missing, late],
        [repeated, held, bad_signals, backwards, time_jumps, interruptions, 0],
    ];
    first.into_iter().chain(second).nth(n.into()).unwrap_or(0)
}

/// The dictionary with its values, as an SDO client sees it.
pub(super) struct Serving<'a> {
    pub(super) dictionary: &'a Dictionary,
    pub(super) values: &'a mut Values,
    pub(super) monitor: NodeView<'a>,
}

impl Served for Serving<'_> {
    fn read(&self, index: u16, sub: u8, value: &mut NodeValue) -> Result<(), Abort> {
        let entry = self.dictionary.find(index, sub)?;
        self.values.put(entry, &self.monitor, value)
    }

    fn width(&self, index: u16, sub: u8) -> Result<Width, Abort> {
        let entry = self.dictionary.find(index, sub)?;
        match (entry.access, entry.kind) {
            (Access::ReadWrite, NodeType::Unsigned8) => Ok(Width::Byte),
            (Access::ReadWrite, NodeType::Unsigned16) => Ok(Width::Word),
            _ => Err(Abort::WriteOfReadOnly),
        }
    }

    fn write(&mut self, index: u16, sub: u8, value: u16) -> Result<(), Abort> {
        match (&self.dictionary.find(index, sub)?.source, value) {
            (Source::Live(Live::ErrorCount), 0) => self.values.errors.clear_history(),
            (Source::Live(Live::ErrorCount), _) => return Err(Abort::InvalidValue),
            (Source::Live(Live::Heartbeat), time) if time > 0 && time < self.values.shortest => {
                return Err(Abort::ValueTooLow);
            }
            (Source::Live(Live::Heartbeat), time) => self.values.set_heartbeat(time),
            _ => return Err(Abort::WriteOfReadOnly),
        }
        Ok(())
    }
}

/// A span of `milliseconds`.
fn milliseconds(milliseconds: u16) -> Span {
    Span::from_nanos(i64::from(milliseconds) * 1_000_000)
}
