//! Error frames: a CAN controller's reports on the bus, as laid out in linux/can/error.h.

use crate::frame::{Frame, Kind};

/// State of a CAN controller, by its error counters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControllerState {
    ErrorActive,
    /// An error counter is at 96 or more.
    Warning,
    /// An error counter is at 128 or more: the controller may no longer mark others' frames as
    /// wrong. A sender whose frames nobody acknowledges stays here.
    Passive,
    /// The controller takes no part in the bus.
    BusOff,
    /// The interface is down.
    Stopped,
    Sleeping,
}

impl ControllerState {
    /// All states, in order.
    pub const ALL: [Self; 6] = [
        Self::ErrorActive,
        Self::Warning,
        Self::Passive,
        Self::BusOff,
        Self::Stopped,
        Self::Sleeping,
    ];

    /// Names as in `ip -details link`, in lower case, in order.
    pub const NAMES: [&'static str; 6] =
        ["error-active", "error-warning", "error-passive", "bus-off", "stopped", "sleeping"];

    pub const fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
}

// The classes, bits of the identifier.
const LOST_ARBITRATION: u32 = 0x002;
const CONTROLLER: u32 = 0x004;
const PROTOCOL: u32 = 0x008;
const TRANSCEIVER: u32 = 0x010;
const NO_ACKNOWLEDGE: u32 = 0x020;
const BUS_OFF: u32 = 0x040;
const RESTARTED: u32 = 0x100;
const COUNTERS: u32 = 0x200;

// The controller's, bits of byte 1.
const RECEIVE_OVERFLOW: u8 = 0x01;
const TRANSMIT_OVERFLOW: u8 = 0x02;
const WARNING: u8 = 0x04 | 0x08;
const PASSIVE: u8 = 0x10 | 0x20;
const ACTIVE: u8 = 0x40;

/// Content of one error frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ErrorFrame {
    /// New state of the controller, if it changed.
    pub state: Option<ControllerState>,
    /// The controller came back after bus-off.
    pub restarted: bool,
    /// Whether nobody acknowledged a frame.
    pub unacknowledged: bool,
    /// Whether the controller had no room for frames, which are lost and counted by no socket.
    pub receive_overflow: bool,
    pub transmit_overflow: bool,
    pub lost_arbitration: bool,
    /// Whether a frame on the bus was wrong.
    pub protocol: bool,
    /// Whether the line itself is faulty: a wire is broken or shorted.
    pub transceiver: bool,
    /// Transmit and receive error counters of the controller.
    pub counters: Option<[u8; 2]>,
}

impl ErrorFrame {
    /// Reads an error frame; `None` if `frame` is of another kind.
    pub fn read(frame: &Frame) -> Option<Self> {
        if frame.kind != Kind::Error {
            return None;
        }
        let class = frame.id.value();
        let has = |bit| class & bit != 0;
        let byte = |index: usize| frame.data().get(index).copied().unwrap_or(0);
        let controller = if has(CONTROLLER) { byte(1) } else { 0 };
        let state = match controller {
            _ if has(BUS_OFF) => Some(ControllerState::BusOff),
            _ if has(RESTARTED) => Some(ControllerState::ErrorActive),
            bits if bits & PASSIVE != 0 => Some(ControllerState::Passive),
            bits if bits & WARNING != 0 => Some(ControllerState::Warning),
            bits if bits & ACTIVE != 0 => Some(ControllerState::ErrorActive),
            _ => None,
        };
        Some(Self {
            state,
            restarted: has(RESTARTED),
            unacknowledged: has(NO_ACKNOWLEDGE),
            receive_overflow: controller & RECEIVE_OVERFLOW != 0,
            transmit_overflow: controller & TRANSMIT_OVERFLOW != 0,
            lost_arbitration: has(LOST_ARBITRATION),
            protocol: has(PROTOCOL),
            transceiver: has(TRANSCEIVER),
            counters: has(COUNTERS).then(|| [byte(6), byte(7)]),
        })
    }

    /// Whether the controller went bus-off, so that nothing was received from here on.
    pub fn is_bus_off(&self) -> bool {
        self.state == Some(ControllerState::BusOff)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Id;
    use crate::time::Timestamp;

    fn read(class: u32, data: [u8; 8]) -> ErrorFrame {
        let id = Id::extended(class).expect("classes fit an extended identifier");
        let frame = Frame::new(Timestamp::default(), id, Kind::Error, &data);
        ErrorFrame::read(&frame).expect("it is an error frame")
    }

    #[test]
    fn a_controllers_state_is_what_its_driver_says() {
        let state = |class, bits| read(class, [0, bits, 0, 0, 0, 0, 0, 0]).state;
        assert_eq!(state(0x040, 0), Some(ControllerState::BusOff));
        assert_eq!(state(0x100, 0), Some(ControllerState::ErrorActive));
        assert_eq!(state(0x004, 0x04), Some(ControllerState::Warning));
        assert_eq!(state(0x004, 0x20), Some(ControllerState::Passive));
        assert_eq!(state(0x004, 0x10 | 0x08), Some(ControllerState::Passive));
        assert_eq!(state(0x004, 0x40), Some(ControllerState::ErrorActive));
        assert_eq!(state(0x004, 0x01), None, "an overflow is no state");
        assert_eq!(state(0x008, 0x10), None, "byte 1 is of another class");
    }

    /// As iproute2 prints them.
    #[test]
    fn states_have_the_names_that_ip_gives_them() {
        let names = ControllerState::ALL.map(ControllerState::name);
        let expected =
            ["error-active", "error-warning", "error-passive", "bus-off", "stopped", "sleeping"];
        assert_eq!(names, expected);
    }

    #[test]
    fn each_bit_says_one_thing() {
        for (class, bits, expected) in [
            (0x001, 0, ErrorFrame::default()),
            (0x002, 0, ErrorFrame { lost_arbitration: true, ..ErrorFrame::default() }),
            (0x004, 0x01, ErrorFrame { receive_overflow: true, ..ErrorFrame::default() }),
            (0x004, 0x02, ErrorFrame { transmit_overflow: true, ..ErrorFrame::default() }),
            (0x008, 0x03, ErrorFrame { protocol: true, ..ErrorFrame::default() }),
            (0x010, 0, ErrorFrame { transceiver: true, ..ErrorFrame::default() }),
            (0x020, 0, ErrorFrame { unacknowledged: true, ..ErrorFrame::default() }),
        ] {
            assert_eq!(read(class, [0, bits, 0, 0, 0, 0, 0, 0]), expected, "{class:#x}");
        }
        assert!(read(0x100, [0; 8]).restarted);
        assert!(read(0x040, [0; 8]).is_bus_off() && !read(0x100, [0; 8]).is_bus_off());
    }

    #[test]
    fn counters_are_there_only_where_the_driver_gives_them() {
        let data = [0, 0, 0, 0, 0, 0, 136, 7];
        assert_eq!(read(0x200, data).counters, Some([136, 7]));
        assert_eq!(read(0x020, data).counters, None);
        assert!(read(0x020, data).unacknowledged);
    }

    #[test]
    fn data_frames_are_none() {
        let id = Id::extended(0x40).expect("it is in range");
        assert_eq!(ErrorFrame::read(&Frame::new(Timestamp::default(), id, Kind::Data, &[])), None);
    }
}
