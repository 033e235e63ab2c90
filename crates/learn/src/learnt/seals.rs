//! The configuration that the kept pieces belong to.

use crate::tables::model::{NONLINEAR, OF_A_MODEL};
use crc::{CRC_32_ISO_HDLC, Crc};
use thiserror::Error;
use toml::{Table, Value};

const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Checksums of the values of a configuration, whatever its comments, order and layout.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seals {
    /// Checksum of what turns frames into readings: the machine, its signals and devices, the DBC and the
    /// EDS files.
    pub readings: u32,
    /// Checksum of the model (4-1) of the machine and of its cylinders.
    pub model: u32,
    /// Checksum of Q, R, δ_l and δ_h.
    pub weights: u32,
    /// Checksum of the bound of R3 and of the cylinders' calibrations, by which a recording is
    /// judged.
    pub calibration: u32,
}

/// What differs in a configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Broken {
    #[error(
        "[machine], [signals], the devices, the DBC or an EDS differ from those of the recording"
    )]
    Readings,
    #[error(
        "[model], or theta, gamma or command_offset of a cylinder, differ from those that were \
         learnt"
    )]
    Model,
    #[error(
        "the weights of [observer] or the thresholds of [fde] differ from those that were \
        learnt"
    )]
    Weights,
    #[error(
        "comparator.bound or the calibrations of [[cylinder]] differ from those that were \
        learnt"
    )]
    Calibration,
}

impl Seals {
    /// Seals of a configuration and the bytes of its DBC, followed by those of its EDS files; `None` for a
    /// text that is not TOML.
    pub fn of(config: &str, layout: &[u8]) -> Option<Self> {
        let table: Table = config.parse().ok()?;
        let mut readings = canonical(&table, &["machine", "signals"]);
        if let Some(devices) = table.get("canopen").and_then(|canopen| canopen.get("device")) {
            write(&mut readings, devices);
        }
        let mut readings = readings.into_bytes();
        readings.extend(layout);
        let cylinders = table.get("cylinder").and_then(Value::as_array);
        let cylinders = cylinders.into_iter().flatten().filter_map(Value::as_table);
        let (mut model, mut calibration) = (canonical(&table, &["model"]), String::new());
        if let Some(bound) = table.get("comparator").and_then(|it| it.get("bound")) {
            write(&mut calibration, bound);
        }
        for cylinder in cylinders {
            // The monitor does not use the non-linear model.
            for (key, value) in sorted(cylinder) {
                if key == NONLINEAR {
                    continue;
                }
                let of_model = OF_A_MODEL.contains(&key.as_str());
                let text = if of_model { &mut model } else { &mut calibration };
                // Whose it is stands in both.
                write(text, cylinder.get("n").unwrap_or(&Value::Boolean(false)));
                *text += key;
                write(text, value);
            }
        }
        Some(Self {
            readings: CRC.checksum(&readings),
            model: CRC.checksum(model.as_bytes()),
            weights: CRC.checksum(canonical(&table, &["observer", "fde"]).as_bytes()),
            calibration: CRC.checksum(calibration.as_bytes()),
        })
    }

    /// Seals as stored in a file.
    pub const fn of_parts([readings, model, weights, calibration]: [u32; 4]) -> Self {
        Self { readings, model, weights, calibration }
    }

    /// All checksums, in the order of [`Self::of_parts`].
    pub const fn all(&self) -> [u32; 4] {
        [self.readings, self.model, self.weights, self.calibration]
    }

    /// Checks that `other` has the same readings and tables; without `all`, only those of a
    /// calibration.
    ///
    /// # Errors
    /// What differs.
    pub fn agree(&self, other: &Self, all: bool) -> Result<(), Broken> {
        let pairs = [
            (self.readings == other.readings, Broken::Readings),
            (!all || self.model == other.model, Broken::Model),
            (!all || self.weights == other.weights, Broken::Weights),
            (self.calibration == other.calibration, Broken::Calibration),
        ];
        pairs.into_iter().find(|(same, _)| !same).map_or(Ok(()), |(_, broken)| Err(broken))
    }
}

/// The values of these tables in a canonical order.
fn canonical(table: &Table, keys: &[&str]) -> String {
    let mut text = String::new();
    for key in keys {
        text += key;
        if let Some(value) = table.get(*key) {
            write(&mut text, value);
        }
    }
    text
}

fn sorted(table: &Table) -> Vec<(&String, &Value)> {
    let mut entries: Vec<_> = table.iter().collect();
    entries.sort_by_key(|(key, _)| *key);
    entries
}

fn write(text: &mut String, value: &Value) {
    match value {
        Value::Table(table) => {
            text.push('{');
            for (key, value) in sorted(table) {
                *text += key;
                write(text, value);
            }
            text.push('}');
        }
        Value::Array(values) => {
            text.push('[');
            values.iter().for_each(|value| write(text, value));
            text.push(']');
        }
        value => *text += &format!("={value};"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "[machine]\nname = \"It\"\n[model]\ntheta = [1.0]\n[observer]\nq = [1.0]\n\
                        [comparator]\nbound = 1e-3\ncritical = 0.05\n[[cylinder]]\nn = 1\n\
                        gamma = [2.0]\nc2_gain = 1.0\n";

    fn seals(from: &str, to: &str) -> Seals {
        let changed = TEXT.replace(from, to);
        assert!(from.is_empty() || changed != TEXT);
        Seals::of(&changed, b"BO_ 1").expect("it is TOML")
    }

    #[test]
    fn each_part_has_its_own_seal_and_a_comment_has_none() {
        let whole = seals("", "");
        let broken = |from, to| whole.agree(&seals(from, to), true).err();
        assert_eq!(broken("[model]\n", "# better\n[model]\n"), None);
        assert_eq!(broken("critical = 0.05", "critical = 0.06"), None);
        assert_eq!(broken("\"It\"", "\"It 2\""), Some(Broken::Readings));
        assert_eq!(broken("[1.0]\n[observer]", "[1.1]\n[observer]"), Some(Broken::Model));
        assert_eq!(broken("gamma = [2.0]", "gamma = [2.1]"), Some(Broken::Model));
        assert_eq!(broken("q = [1.0]", "q = [1.1]"), Some(Broken::Weights));
        assert_eq!(broken("1e-3", "2e-3"), Some(Broken::Calibration));
        assert_eq!(broken("c2_gain = 1.0", "c2_gain = 1.1"), Some(Broken::Calibration));
        let device = "[[canopen.device]]\nnode = 1\n[[cylinder]]";
        assert_eq!(broken("[[cylinder]]", device), Some(Broken::Readings));
        let other = Seals::of(TEXT, b"BO_ 2").expect("it is TOML");
        assert_eq!(whole.agree(&other, false), Err(Broken::Readings));
        assert_eq!(whole.agree(&seals("q = [1.0]", "q = [1.1]"), false), Ok(()));
    }
}
