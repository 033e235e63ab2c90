//! The gateway's own messages: one table, from which identifiers, queues and the share of the bus follow.

use crate::frame::{Frame, Id, Kind};
use crate::time::{Span, Timestamp};

/// Declares [`OwnMessage`]. A row is a message, its name in the DBC, the COB-ID of its TPDO in CANopen's
/// predefined connection set, to which the node number is added, its queue, and when it is sent.
macro_rules! own_messages {
    ($(
        $(#[doc = $doc:literal])*
        $message:ident = $name:literal, $base:literal, $queue:expr, $sending:expr;
    )*) => {
        /// A message of the gateway's own.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum OwnMessage {
            $($(#[doc = $doc])* $message,)*
        }

        impl OwnMessage {
            /// All messages, in the order of their identifiers.
            pub const ALL: [Self; [$($base),*].len()] = [$(Self::$message),*];

            /// Name in the DBC.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$message => $name,)* }
            }

            /// Identifier without the node number.
            pub const fn base(self) -> u32 {
                match self { $(Self::$message => $base,)* }
            }

            /// Queue in which its frames wait to be sent.
            pub const fn queue(self) -> Queue {
                match self { $(Self::$message => $queue,)* }
            }

            /// When it is sent.
            pub const fn sending(self) -> Sending {
                match self { $(Self::$message => $sending,)* }
            }
        }
    };
}

own_messages! {
    /// The state of the monitor.
    Status = "Fd_Status", 0x180, Queue::Status, Sending::Every(Span::from_nanos(100_000_000));
    /// A warning that is raised, changed, cleared or repeated.
    Warning = "Fd_Warning", 0x280, Queue::Events, Sending::Events;
    /// The estimated length of a cylinder.
    Estimate = "Fd_Estimate", 0x380, Queue::Cyclic, Sending::Cycles;
}

/// Queue in which frames wait to be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Queue {
    /// The one place of the newest status, which no other frame delays for long.
    Status,
    /// Each frame counts; the oldest gives way where there are too many.
    Events,
    /// Sent after all others; older frames give way to newer ones.
    Cyclic,
}

/// When a message is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sending {
    /// With this period.
    Every(Span),
    /// When something happens.
    Events,
    /// For each cylinder in each cycle, if it is wanted.
    Cycles,
}

impl Sending {
    /// How often a message with a period is sent, 1/s.
    pub fn frequency(self) -> Option<f64> {
        match self {
            Self::Every(period) => Some(period.as_seconds().recip()),
            Self::Events | Self::Cycles => None,
        }
    }
}

/// A CANopen service by which the gateway sends beside its TPDOs. The numbers are the COB-IDs of
/// the predefined connection set, to which the node number is added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Service {
    /// EMCY, the emergency message.
    Emergency = 0x080,
    /// The answers of the SDO server.
    Answer = 0x580,
    /// Boot-up and heartbeat.
    Heartbeat = 0x700,
}

impl Service {
    pub const ALL: [Self; 3] = [Self::Emergency, Self::Answer, Self::Heartbeat];
}

/// What a frame of the gateway is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OwnContent {
    /// One of its messages, which are TPDOs.
    Message(OwnMessage),
    /// A frame of a CANopen service.
    Service(Service),
}

/// A frame that the gateway may send. Only [`Encoder`](super::Encoder) and
/// [`ServiceEncoder`](super::ServiceEncoder) make one, so that no other identifier can leave the gateway,
/// whatever arrives.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OwnFrame {
    frame: Frame,
    content: OwnContent,
}

impl OwnFrame {
    pub(super) fn new(content: OwnContent, at: Timestamp, id: Id, data: &[u8]) -> Self {
        Self { frame: Frame::new(at, id, Kind::Data, data), content }
    }

    pub const fn as_frame(&self) -> &Frame {
        &self.frame
    }

    pub const fn content(&self) -> OwnContent {
        self.content
    }

    /// The message; `None` for a frame of a CANopen service.
    pub const fn message(&self) -> Option<OwnMessage> {
        match self.content {
            OwnContent::Message(message) => Some(message),
            OwnContent::Service(_) => None,
        }
    }

    /// The CANopen service that the frame belongs to; `None` for a message.
    pub const fn service(&self) -> Option<Service> {
        match self.content {
            OwnContent::Message(_) => None,
            OwnContent::Service(service) => Some(service),
        }
    }
}

/// Length of a frame of the gateway on the bus, bits, with the most stuff bits it can have and the
/// interframe space.
pub const FRAME_BITS: f64 = 135.0;

/// Valid node numbers of CANopen, 1 to 127.
pub(super) const NODES: core::ops::RangeInclusive<u8> = 1..=127;

/// The identifiers that the gateway with CANopen node number `node` sends, in the order of
/// [`OwnMessage::ALL`]; `None` unless `node` is 1 to 127.
pub fn identifiers(node: u8) -> Option<[Id; OwnMessage::ALL.len()]> {
    const LOWEST: Id = match Id::standard(0) {
        Some(id) => id,
        None => panic!("0 is an 11-bit identifier"),
    };
    if !NODES.contains(&node) {
        return None;
    }
    let mut ids = [LOWEST; OwnMessage::ALL.len()];
    for (id, message) in ids.iter_mut().zip(OwnMessage::ALL) {
        *id = Id::standard(message.base() + u32::from(node))?;
    }
    Some(ids)
}
