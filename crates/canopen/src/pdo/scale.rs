//! What the numbers of objects stand for: encoders (CiA 406) and fluid power (CiA 408).

use crate::eds::ObjectDictionary;

/// Factor and unit of an object: a number times the factor is in the unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    pub factor: f64,
    /// `m`, `m/s`, `bar`, or [`FULL_SCALE`], [`BITS`] or [`COUNT`].
    pub unit: &'static str,
}

/// Unit of a share of a reference value.
pub const FULL_SCALE: &str = "of full scale";
/// Unit of words of bits.
pub const BITS: &str = "bits";
/// Unit of what the device's profile does not say what it stands for.
pub const COUNT: &str = "counts";

/// Why an object has no scale.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ScaleError {
    #[error(
        "its scale, object 0x{index:04X}:{sub_index:02X}, has no value above 0 in the file; put the \
         device's own value into a DCF (ParameterValue)"
    )]
    NoStep { index: u16, sub_index: u8 },
    #[error(
        "its unit, object 0x{index:04X}:02, is 0x{code:02X}; known are 0x00 (none), 0x01 (m), 0x22 (Pa) \
         and 0x4E (bar), CiA 303-2"
    )]
    Unit { index: u16, code: i128 },
    #[error("its prefix, object 0x{index:04X}:03, is {exponent}; expected -18 to 18, CiA 303-2")]
    Prefix { index: u16, exponent: i128 },
}

/// Profiles, by the lower half of the device type 0x1000.
const ENCODER: i128 = 406;
const FLUID_POWER: i128 = 408;

/// Linear encoder measuring step settings: :01 in 0.001 µm, :02 in 0.01 mm/s.
const STEPS: u16 = 0x6005;
/// Measuring step, in 0.001 µm.
const STEP: u16 = 0x6501;

const WORD: Scale = Scale { factor: 1.0, unit: BITS };
const UNKNOWN: Scale = Scale { factor: 1.0, unit: COUNT };

/// The scale of an object of the device on the node of that node-ID.
///
/// # Errors
/// An object that the scale follows from has no usable value in the file.
pub fn scale(dictionary: &ObjectDictionary, node_id: u8, index: u16) -> Result<Scale, ScaleError> {
    let numbers = Numbers { dictionary, node_id };
    match numbers.at(0x1000, 0).map(|device_type| device_type & 0xFFFF) {
        Some(ENCODER) => numbers.of_encoder(index),
        Some(FLUID_POWER) => numbers.of_fluid_power(index),
        _ => Ok(UNKNOWN),
    }
}

struct Numbers<'a> {
    dictionary: &'a ObjectDictionary,
    node_id: u8,
}

impl Numbers<'_> {
    fn at(&self, index: u16, sub_index: u8) -> Option<i128> {
        self.dictionary.number(index, sub_index, self.node_id)
    }

    fn of_encoder(&self, index: u16) -> Result<Scale, ScaleError> {
        match index {
            // Position of a single sensor, and of several.
            0x6004 | 0x6020 => {
                let step = self.step(1).or_else(|none| {
                    let own = self.at(STEP, 0).filter(|step| *step > 0);
                    own.map(|step| step as f64).ok_or(none)
                })?;
                // Divided, so that it is rounded once.
                Ok(Scale { factor: step / 1e9, unit: "m" })
            }
            0x6030 => Ok(Scale { factor: self.step(2)? / 1e5, unit: "m/s" }),
            // Work area state, operating status, alarms, warnings.
            0x6400 | 0x6500 | 0x6503 | 0x6505 => Ok(WORD),
            _ => Ok(UNKNOWN),
        }
    }

    fn step(&self, sub_index: u8) -> Result<f64, ScaleError> {
        let step = self.at(STEPS, sub_index).filter(|step| *step > 0);
        step.map(|step| step as f64).ok_or(ScaleError::NoStep { index: STEPS, sub_index })
    }

    fn of_fluid_power(&self, index: u16) -> Result<Scale, ScaleError> {
        match index {
            // Control word, status word.
            0x6040 | 0x6041 => Ok(WORD),
            // Set point and actual value of the spool, by its reference; a set point may leave its unit to
            // the actual value.
            0x6300 | 0x6301 | 0x6310 => self.of_value(index, 0x6301, Some(0x6311)),
            // Set point and actual value of the pressure.
            0x6380 | 0x6381 => self.of_value(index, 0x6381, None),
            _ => Ok(UNKNOWN),
        }
    }

    /// The scale of a record of value, unit and prefix, or else that of `other`; without a unit a number is a share
    /// of that at `reference`.
    fn of_value(
        &self,
        index: u16,
        other: u16,
        reference: Option<u16>,
    ) -> Result<Scale, ScaleError> {
        let own = self.at(index, 2).is_some();
        let index = if own { index } else { other };
        let exponent = self.at(index, 3).unwrap_or(0);
        let power = power_of_ten(exponent).ok_or(ScaleError::Prefix { index, exponent })?;
        match (self.at(index, 2).unwrap_or(0), reference) {
            (0x00, Some(reference)) if exponent == 0 => {
                // 0x4000 is 100 % where the device does not say otherwise.
                let full = self.at(reference, 1).unwrap_or(0x4000);
                if full <= 0 {
                    return Err(ScaleError::NoStep { index: reference, sub_index: 1 });
                }
                Ok(Scale { factor: 1.0 / full as f64, unit: FULL_SCALE })
            }
            (0x00, Some(_)) => Ok(Scale { factor: power, unit: FULL_SCALE }),
            (0x00, None) => Ok(UNKNOWN),
            (0x01, _) => Ok(Scale { factor: power, unit: "m" }),
            (0x22, _) => Ok(Scale { factor: power / 1e5, unit: "bar" }),
            (0x4E, _) => Ok(Scale { factor: power, unit: "bar" }),
            (code, _) => Err(ScaleError::Unit { index, code }),
        }
    }
}

/// 10 to the power of a prefix, rounded once.
fn power_of_ten(exponent: i128) -> Option<f64> {
    (-18..=18).contains(&exponent).then(|| format!("1e{exponent}").parse().ok()).flatten()
}
