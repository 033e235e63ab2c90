//! What a notice says, field by field, for lines of JSON and tables.

use super::device::EmergencyFields;
use super::jsonl::digits;
use serde::{Serialize, Serializer};
use tertius_core::frame::BusNumber;
use tertius_core::monitor::Notice;
use tertius_core::sample::device::DeviceNews;
use tertius_core::sample::dispute::Doubt;
use tertius_core::time::{Span, Timestamp};

/// Fields of a notice; most notices have few of them.
#[derive(Debug, Default, Serialize)]
pub(super) struct NoticeFields {
    #[serde(skip)]
    pub(super) at: Timestamp,
    pub(super) notice: &'static str,
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "in_digits")]
    pub(super) seconds: Option<Span>,
    /// One of several buses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) bus: Option<&'static str>,
    /// Identifier of the message whose frames cannot be relied on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) message: Option<String>,
    /// Cylinder number, counted from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) cylinder: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) detector: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) reason: Option<&'static str>,
    /// Mean time by which C2 is sampled sooner than C1, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) skew: Option<f64>,
    /// Standard deviation of its random part, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) jitter: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) device: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) node: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) state: Option<&'static str>,
    /// Bits of a status that have no meaning in the configuration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) status: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none", flatten)]
    pub(super) emergency: Option<EmergencyFields>,
}

impl From<&Notice> for NoticeFields {
    fn from(notice: &Notice) -> Self {
        let of = |at, notice| Self { at, notice, ..Self::default() };
        match *notice {
            Notice::Gap { at, length } => Self { seconds: Some(length), ..of(at, "gap") },
            Notice::TimeJump { at, by } => Self { seconds: Some(by), ..of(at, "time_jump") },
            Notice::Interruption { at, bus } => {
                Self { bus: bus.map(name_of), ..of(at, "interruption") }
            }
            Notice::Silence { at, bus, silent } => {
                let what = if silent { "silence" } else { "heard_again" };
                Self { bus: Some(name_of(bus)), ..of(at, what) }
            }
            Notice::Doubt { at, id, bus, doubt, is_over } => {
                let what = match (doubt, is_over) {
                    (Doubt::Contradiction, false) => "contradiction",
                    (Doubt::Contradiction, true) => "contradiction_over",
                    (Doubt::TooShort, false) => "too_short",
                    (Doubt::TooShort, true) => "too_short_over",
                    (Doubt::Uncounted, false) => "uncounted",
                    (Doubt::Uncounted, true) => "uncounted_over",
                    (Doubt::Flood, false) => "sync_floods",
                    (Doubt::Flood, true) => "sync_floods_over",
                    (Doubt::Absent, false) => "sync_absent",
                    (Doubt::Absent, true) => "sync_absent_over",
                    (Doubt::Imitation, false) => "imitation",
                    (Doubt::Imitation, true) => "imitation_over",
                };
                Self { bus: Some(name_of(bus)), message: Some(format!("0x{id}")), ..of(at, what) }
            }
            Notice::Restart { at, cylinder, detector, reason } => Self {
                cylinder: Some(cylinder),
                detector: Some(detector.name()),
                reason: Some(reason.name()),
                ..of(at, "restart")
            },
            Notice::Timing { at, apart: Some(apart) } => {
                Self { skew: Some(apart.mean), jitter: Some(apart.spread), ..of(at, "timing") }
            }
            Notice::Timing { at, apart: None } => of(at, "timing_restored"),
            Notice::UnnamedStatus { at, cylinder, transducer, bits } => Self {
                cylinder: Some(cylinder),
                device: Some(transducer.name()),
                status: Some(format!("0x{bits:X}")),
                ..of(at, "unnamed_status")
            },
            Notice::Device { at, cylinder, role, node, news } => {
                let (name, state, emergency) = match news {
                    DeviceNews::State(state) => ("device_state", Some(state.name()), None),
                    DeviceNews::Network(emergency) => {
                        ("device_network", None, Some(EmergencyFields::from(emergency)))
                    }
                };
                Self {
                    cylinder: Some(cylinder),
                    device: Some(role.name()),
                    node: Some(node),
                    state,
                    emergency,
                    ..of(at, name)
                }
            }
        }
    }
}

/// Name of a bus in the configuration.
const fn name_of(bus: BusNumber) -> &'static str {
    BusNumber::NAMES[bus.index()]
}

#[expect(clippy::ref_option, reason = "as serde calls it")]
fn in_digits<S: Serializer>(span: &Option<Span>, to: S) -> Result<S::Ok, S::Error> {
    span.map(digits).serialize(to)
}
