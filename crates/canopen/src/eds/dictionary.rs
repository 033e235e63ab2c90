//! The object dictionary of a device, as its EDS or DCF describes it.

use std::collections::BTreeMap;

use super::collect::collect;
use super::data_type::DataType;
use super::device::{self, Commissioning, DeviceInformation};
use super::finding::{Address, Finding, Findings};
use super::group::Groups;
use super::ini;
use super::object::{Object, Variable};
use super::parse_error::ParseError;

/// Why an address leads to no variable.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LookupError {
    #[error("there is no object 0x{index:04X} in the EDS{}", nearest_text(.nearest))]
    Object {
        index: u16,
        /// Up to three indices that the EDS has, the nearest first.
        nearest: Vec<u16>,
    },
    #[error("object 0x{index:04X} has no sub-index {sub_index:02X}; it has {}", known_text(.known))]
    SubObject { index: u16, sub_index: u8, known: Vec<u8> },
    /// It is there, but has an error.
    #[error("object {address} cannot be used: {reason}")]
    Refused {
        address: Address,
        /// The first of its findings, with its line.
        reason: String,
    },
}

fn nearest_text(nearest: &[u16]) -> String {
    let nearest: Vec<String> = nearest.iter().map(|index| format!("0x{index:04X}")).collect();
    if nearest.is_empty() { String::new() } else { format!("; nearest: {}", nearest.join(", ")) }
}

fn known_text(known: &[u8]) -> String {
    match known {
        [] => "none".to_owned(),
        [first, .., last] if known.len() > 4 => {
            format!("{} from {first:02X} to {last:02X}", known.len())
        }
        known => known.iter().map(|sub| format!("{sub:02X}")).collect::<Vec<_>>().join(", "),
    }
}

/// The objects of a device, and what the file says of the device.
#[derive(Clone, Debug)]
pub struct ObjectDictionary {
    pub device: DeviceInformation,
    /// What a DCF says of the device's place on the bus; `None` for an EDS.
    pub commissioning: Option<Commissioning>,
    /// Types that may fill gaps in the device's PDOs.
    pub dummies: Vec<DataType>,
    objects: BTreeMap<u16, Object>,
    refused: BTreeMap<Address, Finding>,
    findings: Findings,
}

impl ObjectDictionary {
    /// Reads the text of an EDS or DCF.
    ///
    /// # Errors
    /// The text is no EDS, or has too much of something. Objects with errors refuse only
    /// themselves: see [`Self::findings`] and [`Self::refused`].
    pub fn parse(text: &str) -> Result<Self, ParseError> {
        let mut findings = Findings::default();
        let sections = ini::split(text, &mut findings)?;
        let groups = Groups::new(&sections, &mut findings);
        let collected = collect(&groups, &mut findings)?;
        if collected.objects.is_empty() && collected.refused.is_empty() {
            return Err(ParseError::NoObjects);
        }
        device::check_lists(&groups, &mut findings);
        let device = device::information(&groups, &mut findings);
        let commissioning = device::commissioning(&groups, &mut findings);
        let dummies = device::dummies(&groups, &mut findings);
        findings.sort();
        let (objects, refused) = (collected.objects, collected.refused);
        Ok(Self { device, commissioning, dummies, objects, refused, findings })
    }

    /// The objects that can be used, by ascending index.
    pub fn objects(&self) -> impl Iterator<Item = &Object> {
        self.objects.values()
    }

    /// The object of that index, unless it is missing or refused.
    pub fn object(&self, index: u16) -> Option<&Object> {
        self.objects.get(&index)
    }

    /// The variable at that place. A single variable has sub-index 0.
    ///
    /// # Errors
    /// There is none (the nearest are given), or it has an error.
    pub fn variable(&self, index: u16, sub_index: u8) -> Result<&Variable, LookupError> {
        if let Some(variable) = self.object(index).and_then(|it| it.variables.get(&sub_index)) {
            return Ok(variable);
        }
        for address in [None, Some(sub_index)].map(|sub_index| Address { index, sub_index }) {
            if let Some(finding) = self.refused.get(&address) {
                return Err(LookupError::Refused { address, reason: finding.to_string() });
            }
        }
        match self.object(index) {
            Some(object) => {
                let known = object.variables.keys().copied().collect();
                Err(LookupError::SubObject { index, sub_index, known })
            }
            None => Err(LookupError::Object { index, nearest: self.nearest(index) }),
        }
    }

    /// The whole number that a variable has on the node of that node-ID: its value in a DCF, or else its
    /// default; `None` where it is missing or is none.
    pub fn number(&self, index: u16, sub_index: u8, node_id: u8) -> Option<i128> {
        self.variable(index, sub_index).ok()?.configured()?.whole(Some(node_id))
    }

    fn nearest(&self, index: u16) -> Vec<u16> {
        const MOST: usize = 3;
        let below = self.objects.range(..index).rev().take(MOST);
        let above = self.objects.range(index..).take(MOST);
        let mut nearest: Vec<u16> = below.chain(above).map(|(known, _)| *known).collect();
        nearest.sort_by_key(|known| known.abs_diff(index));
        nearest.truncate(MOST);
        nearest
    }

    /// Findings in the order of lines: errors, which make their object unusable, and warnings. At most
    /// [`super::MAX_FINDINGS`].
    pub fn findings(&self) -> &[Finding] {
        self.findings.list()
    }

    /// Number of findings beyond [`Self::findings`].
    pub fn findings_left_out(&self) -> usize {
        self.findings.left_out()
    }

    /// Objects and sub-objects with an error, and their first error, in the order of their addresses.
    pub fn refused(&self) -> impl Iterator<Item = (Address, &Finding)> {
        self.refused.iter().map(|(address, finding)| (*address, finding))
    }
}
