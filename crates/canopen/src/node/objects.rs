//! The objects of the gateway.

use super::design::NodeDesign;
use super::dictionary::{Dictionary, Live, NodeEntry, NodeObject, Shape};
use super::errors::HISTORY;
use super::value::NodeType::{
    Integer16, Real32, Unsigned8, Unsigned16, Unsigned24, Unsigned32, Unsigned64,
};
use tertius_core::alarm::OwnMessage;
use tertius_core::alarm::own::Sending;

/// Name of the device, 0x1008.
const DEVICE: &str = "Tertius: the third vote for redundant position transducers";

/// COB-ID bit by which a PDO cannot be asked for by a remote frame.
const NO_REMOTE: u32 = 1 << 30;

/// COB-ID bit of a PDO that does not exist.
const ABSENT: u32 = 1 << 31;

/// Transmission type of PDOs that the device sends when it sees fit.
const BY_EVENT: u32 = 254;

/// Index of the object with the parts of the first PDO; those of the others follow.
const PDO_PARTS: u16 = 0x2010;

/// Names of the counts of a monitor, in the order of its fields.
const COUNTS: [&str; 13] = [
    "Frames used",
    "Frames ignored",
    "Error frames",
    "Cycles",
    "Incomplete cycles",
    "Missing cycles",
    "Late frames",
    "Repeated frames",
    "Held frames",
    "Bad signals",
    "Frames out of order",
    "Time jumps",
    "Interruptions",
];

/// A part of a PDO: its name, its type and its first byte.
type Part = (&'static str, super::value::NodeType, u8);

/// The parts of a message. The layout is that of [`Encoder`](tertius_core::alarm::Encoder), byte by byte.
const fn parts(message: OwnMessage) -> &'static [Part] {
    match message {
        OwnMessage::Status => &[
            ("Crc", Unsigned16, 0),
            ("Counter", Unsigned8, 2),
            ("Transducer states", Unsigned24, 3),
            ("Level, mode and active warnings", Unsigned16, 6),
        ],
        OwnMessage::Warning => &[
            ("Crc", Unsigned16, 0),
            ("Counter", Unsigned8, 2),
            ("Cylinder, detector, fault, suspect, level and raised", Unsigned16, 3),
            ("Residual", Integer16, 5),
            ("Threshold", Unsigned8, 7),
        ],
        OwnMessage::Estimate => &[
            ("Crc", Unsigned16, 0),
            ("Counter", Unsigned8, 2),
            ("Cylinder and valid", Unsigned8, 3),
            ("Position", Unsigned16, 4),
            ("Sigma", Unsigned16, 6),
        ],
    }
}

/// The dictionary of the gateway that `design` describes.
pub(super) fn dictionary(design: &NodeDesign) -> Dictionary {
    let mut objects = device(design);
    objects.extend(OwnMessage::ALL.map(|message| communication(message, design)));
    objects.extend(OwnMessage::ALL.map(mapping));
    objects.extend(machine(design));
    objects.extend(OwnMessage::ALL.map(contents));
    objects.extend((1_u8..).zip(&design.cylinders).map(|(n, _)| cylinder(n)));
    for (n, thresholds) in (1_u16..).zip(&design.cylinders) {
        objects.push(NodeObject::record(
            0x2200 + n,
            format!("Thresholds of cylinder {n}"),
            [
                NodeEntry::real("R1 and R2 clear below, m", thresholds.observer[0]),
                NodeEntry::real("R1 and R2 raise above, m", thresholds.observer[1]),
                NodeEntry::real("R3 clears below, m", thresholds.difference[0]),
                NodeEntry::real("R3 raises above, m", thresholds.difference[1]),
                NodeEntry::real("Critical difference, m", thresholds.critical),
            ],
        ));
    }
    Dictionary::new(objects)
}

/// What every device has, CiA 301.
fn device(design: &NodeDesign) -> Vec<NodeObject> {
    let [major, minor] = design.revision();
    let variable = NodeObject::variable;
    let history = (0..HISTORY as u8).map(|n| {
        NodeEntry::live(format!("Standard error field {}", n + 1), Unsigned32, Live::Error(n))
    });
    let mut errors = NodeObject::record(0x1003, "Pre-defined error field", history);
    errors.shape = Shape::Array;
    errors.entries[0] = NodeEntry::live("Number of errors", Unsigned8, Live::ErrorCount).writable();
    vec![
        // No device profile.
        variable(0x1000, NodeEntry::number("Device type", Unsigned32, 0)),
        variable(0x1001, NodeEntry::live("Error register", Unsigned8, Live::ErrorRegister)),
        errors,
        variable(0x1008, NodeEntry::text("Manufacturer device name", DEVICE)),
        variable(0x1009, NodeEntry::text("Manufacturer hardware version", "software only")),
        variable(0x100A, NodeEntry::text("Manufacturer software version", &design.version)),
        variable(0x1014, NodeEntry::of_node("COB-ID EMCY", 0x080)),
        variable(
            0x1017,
            NodeEntry::live("Producer heartbeat time", Unsigned16, Live::Heartbeat).writable(),
        ),
        NodeObject::record(
            0x1018,
            "Identity object",
            [
                // CiA gives vendors their numbers; this is none.
                NodeEntry::number("Vendor-ID", Unsigned32, 0),
                NodeEntry::number("Product code", Unsigned32, 1),
                NodeEntry::number(
                    "Revision number",
                    Unsigned32,
                    u32::from(major) << 16 | u32::from(minor),
                ),
                NodeEntry::number("Serial number", Unsigned32, 0),
            ],
        ),
        NodeObject::record(
            0x1200,
            "SDO server parameter",
            [
                NodeEntry::of_node("COB-ID client to server", 0x600),
                NodeEntry::of_node("COB-ID server to client", 0x580),
            ],
        ),
    ]
}

fn communication(message: OwnMessage, design: &NodeDesign) -> NodeObject {
    let event_time = match message.sending() {
        Sending::Every(period) => (period.as_nanos() / 1_000_000) as u32,
        Sending::Events | Sending::Cycles => 0,
    };
    let is_absent = message.sending() == Sending::Cycles && !design.sends_estimates;
    let cob_id = message.base() | NO_REMOTE | if is_absent { ABSENT } else { 0 };
    NodeObject::record(
        0x1800 + message as u16,
        format!("TPDO {} communication parameter", message as u8 + 1),
        [
            NodeEntry::of_node("COB-ID used by TPDO", cob_id),
            NodeEntry::number("Transmission type", Unsigned8, BY_EVENT),
            NodeEntry::number("Inhibit time", Unsigned16, 0),
            NodeEntry::number("Event timer", Unsigned16, event_time).at(5),
        ],
    )
}

fn mapping(message: OwnMessage) -> NodeObject {
    let index = u32::from(PDO_PARTS + message as u16);
    let entries = (1_u32..).zip(parts(message)).map(|(sub, (_, kind, _))| {
        let mapped = index << 16 | sub << 8 | u32::from(kind.bits());
        NodeEntry::number(format!("Application object {sub}"), Unsigned32, mapped)
    });
    let name = format!("TPDO {} mapping parameter", message as u8 + 1);
    NodeObject::record(0x1A00 + message as u16, name, entries)
}

/// The parts of a message as objects: those of the newest one that was made.
fn contents(message: OwnMessage) -> NodeObject {
    let entries = parts(message).iter().map(|&(name, kind, from)| {
        let live = Live::Pdo { message, from, length: kind.bits() / 8 };
        NodeEntry::live(name, kind, live).mapped()
    });
    NodeObject::record(PDO_PARTS + message as u16, message.name(), entries)
}

fn machine(design: &NodeDesign) -> [NodeObject; 4] {
    let cylinders = design.cylinders.len() as u32;
    let microseconds = (design.sample_time * 1e6).round() as u32;
    let counts = (0..).zip(COUNTS);
    [
        NodeObject::record(
            0x2000,
            "Machine",
            [
                NodeEntry::text("Name", &design.machine),
                NodeEntry::number("Cylinders", Unsigned8, cylinders),
                NodeEntry::number("Sample time, us", Unsigned32, microseconds),
            ],
        ),
        NodeObject::record(
            0x2001,
            "Monitor",
            [
                NodeEntry::live("Alarm level", Unsigned8, Live::Level),
                NodeEntry::live("Mode", Unsigned8, Live::Mode),
                NodeEntry::live("Active warnings", Unsigned8, Live::ActiveWarnings),
            ],
        ),
        NodeObject::record(
            0x2002,
            "Counts",
            counts.map(|(n, name)| NodeEntry::live(name, Unsigned64, Live::Count(n))),
        ),
        NodeObject::record(
            0x2003,
            "Calibration",
            [
                NodeEntry::number(
                    "Identity of the configuration",
                    Unsigned32,
                    design.configuration,
                ),
                NodeEntry::number(
                    "CRC-32 of the DBC and the EDS files",
                    Unsigned32,
                    design.database,
                ),
                NodeEntry::number("Calibrated cylinders", Unsigned8, design.calibrated.into()),
                NodeEntry::number("Identity of the calibration", Unsigned32, design.calibration),
            ],
        ),
    ]
}

fn cylinder(n: u8) -> NodeObject {
    let health = |name: &'static str, transducer| {
        NodeEntry::live(name, Unsigned8, Live::Health { cylinder: n, transducer })
    };
    let residual = |name: &'static str, number| {
        NodeEntry::live(name, Real32, Live::Residual { cylinder: n, number })
    };
    NodeObject::record(
        0x2100 + u16::from(n),
        format!("Cylinder {n}"),
        [
            health("State of C1", 0),
            health("State of C2", 1),
            residual("R1, m", 0),
            residual("R2, m", 1),
            residual("R3, m", 2),
        ],
    )
}
