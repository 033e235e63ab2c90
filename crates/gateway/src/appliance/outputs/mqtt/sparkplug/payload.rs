//! The payload of Sparkplug B 3.0 (6.4), as Protocol Buffers.

use crate::appliance::telemetry::points::{Point, PointKind, PointUnit, PointValue};
use prost::{Message, Oneof};

/// Data types (6.4.16).
const INT64: u32 = 4;
const DOUBLE: u32 = 10;
const BOOLEAN: u32 = 11;
const STRING: u32 = 12;
const DATE_TIME: u32 = 13;

#[derive(Clone, PartialEq, Message)]
pub(super) struct Payload {
    /// Time of the message, ms since 1970.
    #[prost(uint64, optional, tag = "1")]
    pub timestamp: Option<u64>,
    #[prost(message, repeated, tag = "2")]
    pub metrics: Vec<Metric>,
    /// Number of the message, 0 to 255; none in a death.
    #[prost(uint64, optional, tag = "3")]
    pub seq: Option<u64>,
}

#[derive(Clone, PartialEq, Message)]
pub(super) struct Metric {
    #[prost(string, optional, tag = "1")]
    pub name: Option<String>,
    /// Time of the value, ms since 1970.
    #[prost(uint64, optional, tag = "3")]
    pub timestamp: Option<u64>,
    #[prost(uint32, optional, tag = "4")]
    pub datatype: Option<u32>,
    /// Whether it was kept and is forwarded, and so is not of now.
    #[prost(bool, optional, tag = "5")]
    pub is_historical: Option<bool>,
    /// Whether there is no value.
    #[prost(bool, optional, tag = "7")]
    pub is_null: Option<bool>,
    #[prost(message, optional, tag = "9")]
    pub properties: Option<PropertySet>,
    #[prost(oneof = "MetricValue", tags = "10, 11, 13, 14, 15")]
    pub value: Option<MetricValue>,
}

#[derive(Clone, PartialEq, Oneof)]
pub(super) enum MetricValue {
    /// Signed numbers of 32 bits and below, by their bits.
    #[prost(uint32, tag = "10")]
    Int(u32),
    /// Signed numbers of 64 bits by their bits, and points in time.
    #[prost(uint64, tag = "11")]
    Long(u64),
    #[prost(double, tag = "13")]
    Double(f64),
    #[prost(bool, tag = "14")]
    Boolean(bool),
    #[prost(string, tag = "15")]
    String(String),
}

/// Properties of a metric: keys, and as many values.
#[derive(Clone, PartialEq, Message)]
pub(super) struct PropertySet {
    #[prost(string, repeated, tag = "1")]
    pub keys: Vec<String>,
    #[prost(message, repeated, tag = "2")]
    pub values: Vec<PropertyText>,
}

/// A property that is a text.
#[derive(Clone, PartialEq, Message)]
pub(super) struct PropertyText {
    #[prost(uint32, optional, tag = "1")]
    pub datatype: Option<u32>,
    #[prost(string, optional, tag = "8")]
    pub text: Option<String>,
}

impl Metric {
    /// A metric at the time `at`, ms since 1970.
    fn new(name: &str, at: u64, datatype: u32, value: Option<MetricValue>) -> Self {
        Self {
            name: Some(name.to_owned()),
            timestamp: Some(at),
            datatype: Some(datatype),
            is_null: value.is_none().then_some(true),
            value,
            ..Self::default()
        }
    }

    pub fn whole(name: &str, at: u64, value: u64) -> Self {
        Self::new(name, at, INT64, Some(MetricValue::Long(value)))
    }

    pub fn boolean(name: &str, at: u64, value: bool) -> Self {
        Self::new(name, at, BOOLEAN, Some(MetricValue::Boolean(value)))
    }

    /// A text; `None` where there is none yet.
    pub fn text(name: &str, at: u64, value: Option<String>) -> Self {
        Self::new(name, at, STRING, value.map(MetricValue::String))
    }

    /// A value of the machine under `name`.
    pub fn of(point: &Point, name: &str, at: u64) -> Self {
        let datatype = match point.kind {
            PointKind::Whole => INT64,
            PointKind::Real => DOUBLE,
            PointKind::Time => DATE_TIME,
            PointKind::Choice(_) => STRING,
        };
        let value = match (point.value, point.kind) {
            (None, _) => None,
            (Some(PointValue::Whole(value)), _) => Some(MetricValue::Long(value as u64)),
            (Some(PointValue::Real(value)), _) => Some(MetricValue::Double(value)),
            (Some(PointValue::Time(time)), _) => {
                Some(MetricValue::Long((time.as_nanos() / 1_000_000) as u64))
            }
            (Some(PointValue::Choice(place)), PointKind::Choice(names)) => {
                names.get(usize::from(place)).map(|name| MetricValue::String((*name).to_owned()))
            }
            (Some(PointValue::Choice(_)), _) => None,
        };
        Self::new(name, at, datatype, value)
    }

    /// With its unit and its meaning, as a birth has them.
    pub fn described(self, point: &Point) -> Self {
        let mut properties = PropertySet::default();
        let unit = (point.unit != PointUnit::None).then(|| ("engUnit", point.unit.symbol()));
        for (key, text) in unit.into_iter().chain([("documentation", point.meaning.as_str())]) {
            properties.keys.push(key.to_owned());
            let text = Some(text.to_owned());
            properties.values.push(PropertyText { datatype: Some(STRING), text });
        }
        Self { properties: Some(properties), ..self }
    }

    pub fn historical(self) -> Self {
        Self { is_historical: Some(true), ..self }
    }
}
