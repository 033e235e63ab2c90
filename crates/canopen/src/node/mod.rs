//! The gateway as a CANopen node (CiA 301): boot-up and heartbeat, emergency messages, an SDO server
//! with an object dictionary, and NMT.
//!
//! Frames and time stamps come in and frames go out; there is no clock, and nothing is allocated per
//! frame. The node only watches the monitor. Nothing that arrives here reaches it: the only objects
//! that can be written are the heartbeat time and the history of errors, and NMT decides which
//! frames are sent, never what is judged.

mod design;
mod dictionary;
mod errors;
mod objects;
pub mod sheet;
mod stack;
mod value;
mod values;

pub use design::{CylinderThresholds, NodeDesign};
use dictionary::Dictionary;
use errors::Emergency;
use stack::{Nmt, Sdo, emergency};
pub use stack::{NmtCommand, NodeState};
use tertius_core::alarm::{OwnFrame, ServiceEncoder, Warning};
use tertius_core::frame::{Frame, Id, Kind};
use tertius_core::monitor::Record;
use tertius_core::time::Timestamp;
pub use values::NodeView;
use values::{Serving, Values};

/// COB-ID of NMT commands.
const NMT: u32 = 0x000;

/// COB-ID of SDO requests, without the node.
const REQUEST: u32 = 0x600;

/// State in a boot-up message.
const BOOT_UP: u8 = 0;

/// CRC-32 (ISO-HDLC, as of zip and Ethernet) of a file.
pub fn checksum(bytes: &[u8]) -> u32 {
    crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(bytes)
}

/// An NMT command that the node has followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NmtEvent {
    pub at: Timestamp,
    pub command: NmtCommand,
    /// Whether the command was for all nodes, and not for this one alone. NMT does not tell who
    /// sent it.
    pub everyone: bool,
    /// State after the command, and after booting where it was a reset.
    pub state: NodeState,
}

/// A CANopen node.
#[derive(Debug)]
pub struct Node {
    node: u8,
    autostart: bool,
    heartbeat: u16,
    encoder: ServiceEncoder,
    dictionary: Dictionary,
    nmt: Nmt,
    sdo: Sdo,
    values: Values,
    /// Time of the next heartbeat; `None` where its period begins with the next call.
    next: Option<Timestamp>,
}

impl Node {
    /// A node that has not booted; `None` unless its number is 1 to 127.
    pub fn new(design: &NodeDesign) -> Option<Self> {
        let NodeDesign { node, heartbeat, autostart, .. } = *design;
        Some(Self {
            node,
            autostart,
            heartbeat,
            encoder: ServiceEncoder::new(node)?,
            dictionary: objects::dictionary(design),
            nmt: Nmt::new(node)?,
            sdo: Sdo::new(node)?,
            values: Values::new(node, heartbeat, design.shortest_heartbeat),
            next: None,
        })
    }

    /// The identifiers that the node of this number receives: NMT and SDO requests.
    pub fn inputs(node: u8) -> impl Iterator<Item = Id> {
        [NMT, REQUEST + u32::from(node)].into_iter().filter_map(Id::standard)
    }

    /// NMT state; `None` before the node has booted.
    pub fn state(&self) -> Option<NodeState> {
        self.nmt.state()
    }

    /// Takes any frame from the bus and passes the frames that answer it to `send`. The first frame
    /// makes the node boot: alone on a bus it would only disturb, since nobody acknowledges.
    pub fn take(
        &mut self,
        frame: &Frame,
        monitor: NodeView<'_>,
        send: &mut impl FnMut(OwnFrame),
    ) -> Option<NmtEvent> {
        if frame.kind == Kind::Error {
            return None;
        }
        if self.state().is_none() {
            self.boot(frame.timestamp, send);
        }
        if frame.kind != Kind::Data || frame.id.is_extended() {
            return None;
        }
        match frame.id.value() {
            NMT => self.obey(frame, send),
            id if id == REQUEST + u32::from(self.node) => {
                self.serve(frame, monitor, send);
                None
            }
            _ => None,
        }
    }

    /// Tells that time has passed: sends the heartbeat that is due. A clock that was set does not
    /// silence it.
    pub fn advance(&mut self, now: Timestamp, send: &mut impl FnMut(OwnFrame)) {
        let (Some(state), Some(period)) = (self.state(), self.values.heartbeat()) else {
            self.next = None;
            return;
        };
        let next = *self.next.get_or_insert_with(|| now.after(period));
        if next.since(now) > period {
            self.next = Some(now.after(period));
        } else if now >= next {
            send(self.encoder.heartbeat(now, state as u8));
            let on_time = next.after(period);
            self.next = Some(if on_time > now { on_time } else { now.after(period) });
        }
    }

    /// Takes a cycle of one cylinder.
    pub fn record(&mut self, record: &Record) {
        self.values.record(record);
    }

    /// Takes a warning, and passes an emergency message to `send` if it was raised or cleared.
    pub fn warning(&mut self, warning: &Warning, send: &mut impl FnMut(OwnFrame)) {
        let Some(Emergency { code, register, info }) = self.values.errors.take(warning) else {
            return;
        };
        if matches!(self.state(), Some(NodeState::PreOperational | NodeState::Operational)) {
            send(self.encoder.emergency(warning.timestamp, emergency(code, register, info)));
        }
    }

    /// Takes a PDO that the monitor has made, and returns whether it may be sent: PDOs are sent only
    /// while the node is operational.
    pub fn transmit(&mut self, frame: &OwnFrame) -> bool {
        self.values.pdo(frame);
        self.sends_pdos()
    }

    /// Whether PDOs are sent.
    pub fn sends_pdos(&self) -> bool {
        self.state() == Some(NodeState::Operational)
    }

    fn boot(&mut self, at: Timestamp, send: &mut impl FnMut(OwnFrame)) {
        self.nmt.boot(self.autostart);
        self.sdo.reset();
        self.values.set_heartbeat(self.heartbeat);
        self.next = None;
        send(self.encoder.heartbeat(at, BOOT_UP));
    }

    fn obey(&mut self, frame: &Frame, send: &mut impl FnMut(OwnFrame)) -> Option<NmtEvent> {
        let (command, everyone) = self.nmt.follow(frame.data().try_into().ok()?)?;
        if self.state().is_none() {
            self.boot(frame.timestamp, send);
        } else if self.state() == Some(NodeState::Stopped) {
            self.sdo.reset();
        }
        Some(NmtEvent { at: frame.timestamp, command, everyone, state: self.state()? })
    }

    fn serve(&mut self, frame: &Frame, monitor: NodeView<'_>, send: &mut impl FnMut(OwnFrame)) {
        if self.state() == Some(NodeState::Stopped) {
            return;
        }
        // A request has eight bytes; anything else is none.
        let Ok(request) = frame.data().try_into() else { return };
        let before = self.values.heartbeat();
        let Self { dictionary, values, sdo, .. } = self;
        let answer = sdo.answer(request, &mut Serving { dictionary, values, monitor });
        if self.values.heartbeat() != before {
            self.next = self.values.heartbeat().map(|period| frame.timestamp.after(period));
        }
        if let Some(answer) = answer {
            send(self.encoder.answer(frame.timestamp, answer));
        }
    }
}

#[cfg(test)]
mod tests;
