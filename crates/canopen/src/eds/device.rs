//! What an EDS says of the device as a whole, and a DCF of its place on the bus.

use super::finding::{Concern, Findings};
use super::group::{FIRST_OBJECT, Groups};
use super::ini::{Entry, Section};
use super::number;
use super::parse_error::excerpt;
use super::{MAX_NAME, data_type::DataType};

/// `[DeviceInfo]`: who made the device and what it can do.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DeviceInformation {
    pub vendor_name: String,
    /// The maker's number at CiA, as in object 0x1018:01.
    pub vendor_number: Option<u32>,
    pub product_name: String,
    pub product_number: Option<u32>,
    pub revision_number: Option<u32>,
    pub order_code: String,
    /// Bit rates that the device supports, kbit/s, ascending.
    pub bit_rates_kbit_s: Vec<u32>,
    /// Number of PDOs that the device can receive.
    pub rx_pdos: Option<u16>,
    /// Number of PDOs that the device can send.
    pub tx_pdos: Option<u16>,
}

/// `[DeviceComissioning]` of a DCF, whose name is misspelt in the standard: the device's place on the
/// bus.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Commissioning {
    /// From 1 to 127.
    pub node_id: Option<u8>,
    pub node_name: String,
    /// kbit/s.
    pub bit_rate_kbit_s: Option<u32>,
}

const BIT_RATES_KBIT_S: [u32; 8] = [10, 20, 50, 125, 250, 500, 800, 1000];

/// Reads `[DeviceInfo]`.
pub(super) fn information(groups: &Groups, findings: &mut Findings) -> DeviceInformation {
    let Some(section) = groups.other("DeviceInfo") else {
        let what = "there is no [DeviceInfo]".to_owned();
        findings.warn(Concern::Section, 1, what, "an EDS says there who made the device");
        return DeviceInformation::default();
    };
    let mut supports = |rate: &u32| {
        number(section, &format!("BaudRate_{rate}"), findings).is_some_and(|flag: u32| flag != 0)
    };
    let bit_rates_kbit_s = BIT_RATES_KBIT_S.into_iter().filter(|rate| supports(rate)).collect();
    if number(section, "CompactPDO", findings).is_some_and(|mask: u32| mask != 0) {
        let what = "CompactPDO leaves out objects of PDOs".to_owned();
        let remedy = "objects without a section are not known here: ask the maker for a full EDS";
        findings.warn(Concern::Section, section.line, what, remedy);
    }
    DeviceInformation {
        vendor_name: text(section, "VendorName"),
        vendor_number: number(section, "VendorNumber", findings),
        product_name: text(section, "ProductName"),
        product_number: number(section, "ProductNumber", findings),
        revision_number: number(section, "RevisionNumber", findings),
        order_code: text(section, "OrderCode"),
        bit_rates_kbit_s,
        rx_pdos: number(section, "NrOfRXPDO", findings),
        tx_pdos: number(section, "NrOfTXPDO", findings),
    }
}

/// Reads `[DeviceComissioning]`, rightly spelt or not; `None` for an EDS, which has none.
pub(super) fn commissioning(groups: &Groups, findings: &mut Findings) -> Option<Commissioning> {
    let names = ["DeviceComissioning", "DeviceCommissioning"];
    let section = names.iter().find_map(|name| groups.other(name))?;
    let node_id: Option<u8> = number(section, "NodeID", findings);
    let valid = node_id.filter(|id| (1..=127).contains(id));
    if let (Some(id), None, Some(entry)) = (node_id, valid, section.entry("NodeID")) {
        let what = format!("NodeID is {id}");
        findings.warn(Concern::Number, entry.line, what, "a node-ID is from 1 to 127");
    }
    Some(Commissioning {
        node_id: valid,
        node_name: text(section, "NodeName"),
        bit_rate_kbit_s: number(section, "Baudrate", findings),
    })
}

/// Reads `[DummyUsage]`: the types that may fill gaps in the device's PDOs, by their numbers.
pub(super) fn dummies(groups: &Groups, findings: &mut Findings) -> Vec<DataType> {
    let Some(section) = groups.other("DummyUsage") else { return Vec::new() };
    let mut is_used = |type_number: &u16| {
        number(section, &format!("Dummy{type_number:04}"), findings)
            .is_some_and(|flag: u8| flag == 1)
    };
    (1..8).filter(|number| is_used(number)).map(DataType::from_number).collect()
}

/// Warns of objects that `[MandatoryObjects]` and its like list and that have no section.
pub(super) fn check_lists(groups: &Groups, findings: &mut Findings) {
    for name in ["MandatoryObjects", "OptionalObjects", "ManufacturerObjects"] {
        let Some(section) = groups.other(name) else { continue };
        let of_objects = |entry: &&Entry| !entry.key.eq_ignore_ascii_case("SupportedObjects");
        for entry in section.entries.iter().filter(of_objects) {
            let index = number::within(entry.value).filter(|index| *index >= FIRST_OBJECT);
            let is_there = |index| groups.objects.contains_key(&index);
            if index.is_some_and(is_there) {
                continue;
            }
            let what = format!("[{name}] lists {:?}", excerpt(entry.value));
            let remedy = "expected the index of an object that has a section";
            findings.warn(Concern::Count, entry.line, what, remedy);
        }
    }
}

fn text(section: &Section, key: &str) -> String {
    let mut text = section.entry(key).map_or("", |entry| entry.value);
    if let Some((end, _)) = text.char_indices().nth(MAX_NAME) {
        text = &text[..end];
    }
    text.to_owned()
}

fn number<T: TryFrom<i128>>(section: &Section, key: &str, findings: &mut Findings) -> Option<T> {
    let entry = section.filled(key)?;
    let number = number::within(entry.value);
    if number.is_none() {
        let what = format!("{} is {:?}", entry.key, excerpt(entry.value));
        findings.warn(Concern::Number, entry.line, what, "expected a number that fits");
    }
    number
}
