//! The protocols of CiA 301 as `canopen-rs` has them: NMT, SDO, EMCY. That crate is named in this
//! file only, so that it can be replaced.
//!
//! Its `Node` is not used: it keeps the whole dictionary as copies of values, clears the history of
//! errors with the last error, and cannot clear one error of several. Its SDO server is used on a
//! dictionary with only the object that is asked for. What that server lacks is added here: values
//! of more than 32 bytes, the abort code of an absent sub-index, and limits of values.

use super::value::NodeValue;
use canopen_rs::nmt::{self, NmtStateMachine};
use canopen_rs::sdo::{self, SdoServer};
use canopen_rs::{
    AccessType, Address, ByteString, EmergencyMessage, Entry, ErrorRegister, MAX_STRING_LEN,
    NodeId, ObjectDictionary, Value,
};
use std::fmt;

/// NMT state of a node that has booted. The numbers are those of a heartbeat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeState {
    Stopped = 4,
    Operational = 5,
    PreOperational = 127,
}

impl NodeState {
    /// Name in the log.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stopped => "stopped",
            Self::Operational => "operational",
            Self::PreOperational => "pre-operational",
        }
    }
}

/// Command of an NMT master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NmtCommand {
    Start,
    Stop,
    EnterPreOperational,
    ResetNode,
    ResetCommunication,
}

impl NmtCommand {
    /// Name in the log.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::Stop => "stop",
            Self::EnterPreOperational => "enter pre-operational",
            Self::ResetNode => "reset node",
            Self::ResetCommunication => "reset communication",
        }
    }
}

/// The state machine of a node.
pub(super) struct Nmt {
    node: NodeId,
    machine: NmtStateMachine,
}

impl Nmt {
    /// A node that has not booted; `None` unless `node` is 1 to 127.
    pub(super) fn new(node: u8) -> Option<Self> {
        Some(Self { node: NodeId::new(node).ok()?, machine: NmtStateMachine::new() })
    }

    /// `None` before the node has booted.
    pub(super) fn state(&self) -> Option<NodeState> {
        match self.machine.state() {
            nmt::NmtState::Initialising => None,
            nmt::NmtState::Stopped => Some(NodeState::Stopped),
            nmt::NmtState::Operational => Some(NodeState::Operational),
            nmt::NmtState::PreOperational => Some(NodeState::PreOperational),
        }
    }

    /// Completes the initialisation: the node is pre-operational, or operational if it starts by
    /// itself.
    pub(super) fn boot(&mut self, autostart: bool) {
        self.machine.boot();
        if autostart {
            self.machine.apply(nmt::NmtCommand::StartRemoteNode);
        }
    }

    /// Follows a command to this node or to all; returns it, and whether it was for all. After a
    /// reset the node has not booted.
    pub(super) fn follow(&mut self, data: [u8; 2]) -> Option<(NmtCommand, bool)> {
        let (command, target) = nmt::decode_command(&data).ok()?;
        let everyone = target == NodeId::BROADCAST;
        if !everyone && target != self.node {
            return None;
        }
        self.machine.apply(command);
        let command = match command {
            nmt::NmtCommand::StartRemoteNode => NmtCommand::Start,
            nmt::NmtCommand::StopRemoteNode => NmtCommand::Stop,
            nmt::NmtCommand::EnterPreOperational => NmtCommand::EnterPreOperational,
            nmt::NmtCommand::ResetNode => NmtCommand::ResetNode,
            nmt::NmtCommand::ResetCommunication => NmtCommand::ResetCommunication,
        };
        Some((command, everyone))
    }
}

impl fmt::Debug for Nmt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Nmt({:?})", self.state())
    }
}

/// The payload of an emergency message.
pub(super) fn emergency(code: u16, register: u8, info: [u8; 5]) -> [u8; 8] {
    EmergencyMessage::new(code, ErrorRegister(register), info).encode()
}

/// Why the SDO server refuses a transfer. The numbers are those of CiA 301.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Abort {
    Toggle = 0x0503_0000,
    WriteOfReadOnly = 0x0601_0002,
    NoObject = 0x0602_0000,
    NoSubIndex = 0x0609_0011,
    InvalidValue = 0x0609_0030,
    ValueTooLow = 0x0609_0032,
    NoData = 0x0800_0024,
}

/// Type of an object that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Width {
    Byte,
    Word,
}

/// The objects behind an SDO server.
pub(super) trait Served {
    /// Puts the value of an object into `value`.
    fn read(&self, index: u16, sub: u8, value: &mut NodeValue) -> Result<(), Abort>;

    /// The type of an object that can be written.
    fn width(&self, index: u16, sub: u8) -> Result<Width, Abort>;

    fn write(&mut self, index: u16, sub: u8, value: u16) -> Result<(), Abort>;
}

/// Command specifiers of requests, the upper three bits of their first byte.
const SEGMENT_DOWN: u8 = 0;
const DOWNLOAD: u8 = 1;
const UPLOAD: u8 = 2;
const SEGMENT_UP: u8 = 3;

/// An SDO server with one channel.
pub(super) struct Sdo {
    node: NodeId,
    server: SdoServer,
    /// Object that is being written in segments.
    written: Option<Address>,
    /// Value that is being read and is too long for `server`.
    long: Option<Long>,
}

struct Long {
    address: Address,
    value: NodeValue,
    at: usize,
    toggle: bool,
}

impl Sdo {
    /// `None` unless `node` is 1 to 127.
    pub(super) fn new(node: u8) -> Option<Self> {
        let node = NodeId::new(node).ok()?;
        Some(Self { node, server: SdoServer::new(node), written: None, long: None })
    }

    /// Forgets the transfer under way, if any.
    pub(super) fn reset(&mut self) {
        self.server = SdoServer::new(self.node);
        self.written = None;
        self.long = None;
    }

    /// The answer to a request; `None` where there is none.
    pub(super) fn answer(
        &mut self,
        request: &[u8; 8],
        served: &mut impl Served,
    ) -> Option<[u8; 8]> {
        let address = Address::new(u16::from_le_bytes([request[1], request[2]]), request[3]);
        let answer = match request[0] >> 5 {
            UPLOAD => self.read(address, request, served),
            DOWNLOAD => self.write(address, request, served),
            SEGMENT_DOWN => self.write_on(request, served),
            SEGMENT_UP => match self.long.take() {
                Some(long) => self.read_on(long, request),
                None => Ok(self.server.handle(&mut ObjectDictionary::<1>::new(), request)),
            },
            _ => {
                // The client's abort, or what this server does not have.
                self.written = None;
                self.long = None;
                Ok(self.server.handle(&mut ObjectDictionary::<1>::new(), request))
            }
        };
        answer.unwrap_or_else(|(address, abort)| Some(refusal(address, abort)))
    }

    fn read(&mut self, address: Address, request: &[u8; 8], served: &impl Served) -> Answer {
        self.reset();
        let mut value = NodeValue::default();
        served
            .read(address.index, address.subindex, &mut value)
            .map_err(|abort| (address, abort))?;
        if value.bytes().len() > MAX_STRING_LEN {
            let length = value.bytes().len() as u32;
            self.long = Some(Long { address, value, at: 0, toggle: false });
            return Ok(Some(sdo::encode_upload_initiate_segmented_response(address, length)));
        }
        // On the wire a value is its bytes, whatever its type.
        let bytes = ByteString::from_bytes(value.bytes()).unwrap_or_default();
        let entry = Entry { value: Value::OctetString(bytes), access: AccessType::Ro };
        Ok(self.server.handle(&mut only(address, entry), request))
    }

    fn read_on(&mut self, mut long: Long, request: &[u8; 8]) -> Answer {
        if sdo::decode_upload_segment_request(request) != Ok(long.toggle) {
            return Err((long.address, Abort::Toggle));
        }
        let rest = &long.value.bytes()[long.at..];
        let segment = &rest[..rest.len().min(sdo::SEGMENT_DATA_MAX)];
        let last = segment.len() == rest.len();
        let answer = sdo::encode_data_segment(segment, long.toggle, last).ok();
        if !last {
            long.at += segment.len();
            long.toggle = !long.toggle;
            self.long = Some(long);
        }
        Ok(answer)
    }

    fn write(&mut self, address: Address, request: &[u8; 8], served: &mut impl Served) -> Answer {
        self.reset();
        self.written = Some(address);
        self.write_on(request, served)
    }

    /// Lets the server take a part of what is written, and hands on the whole.
    fn write_on(&mut self, request: &[u8; 8], served: &mut impl Served) -> Answer {
        let Some(address) = self.written else {
            return Ok(self.server.handle(&mut ObjectDictionary::<1>::new(), request));
        };
        let refuse = |abort| (address, abort);
        let width = served.width(address.index, address.subindex).map_err(refuse)?;
        let value = match width {
            Width::Byte => Value::Unsigned8(0),
            Width::Word => Value::Unsigned16(0),
        };
        let mut object = only(address, Entry::rw(value));
        let answer = self.server.handle(&mut object, request);
        if self.server.take_write().is_some() {
            self.written = None;
            let value = match object.read(address) {
                Ok(Value::Unsigned8(value)) => value.into(),
                Ok(Value::Unsigned16(value)) => value,
                _ => return Err(refuse(Abort::InvalidValue)),
            };
            served.write(address.index, address.subindex, value).map_err(refuse)?;
        }
        Ok(answer)
    }
}

impl fmt::Debug for Sdo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let busy = self.long.is_some() || self.server.is_busy();
        write!(f, "Sdo {{ busy: {busy} }}")
    }
}

/// The answer to a request, if any; or what is refused, and why.
type Answer = Result<Option<[u8; 8]>, (Address, Abort)>;

/// A dictionary with one object.
fn only(address: Address, entry: Entry) -> ObjectDictionary<1> {
    let mut objects = ObjectDictionary::new();
    // There is room for one.
    _ = objects.insert(address, entry);
    objects
}

fn refusal(address: Address, abort: Abort) -> [u8; 8] {
    // The crate has no name for most of these codes.
    let mut answer = sdo::encode_abort(address, sdo::SdoAbortCode::General);
    answer[4..].copy_from_slice(&(abort as u32).to_le_bytes());
    answer
}
