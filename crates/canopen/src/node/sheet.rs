//! The node's electronic data sheet (CiA 306): an EDS of the device, or a DCF of the configured
//! node. Both are written from the dictionary that the node serves, so that they cannot differ
//! from it.

use super::NodeDesign;
use super::dictionary::{Access, Live, NodeEntry, NodeObject, Shape, Source};
use super::objects::dictionary;
use super::value::NodeType;
use std::fmt::Write;
use tertius_core::alarm::OwnMessage;

/// Date of the layout of the dictionary. The date of writing would make two sheets of one
/// configuration differ.
const DATE: &str = "11-22-2026";
const TIME: &str = "12:00AM";

/// Bit rates of CiA 301, kbit/s.
const BIT_RATES: [u32; 8] = [10, 20, 50, 125, 250, 500, 800, 1000];

/// Objects that every device must have.
const MANDATORY: [u16; 3] = [0x1000, 0x1001, 0x1018];

/// First index of the manufacturer's objects, and the first beyond them.
const MANUFACTURER: [u16; 2] = [0x2000, 0x6000];

/// Kind of a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SheetKind {
    /// EDS: the device, with any node number.
    Device,
    /// DCF: the node as it is configured.
    Configured,
}

/// The sheet of the node of `design`, in a file that will be called `file_name`. The same design
/// gives the same text.
pub fn write(design: &NodeDesign, kind: SheetKind, file_name: &str) -> String {
    let mut sheet = Sheet { design, kind, text: String::new() };
    sheet.file_info(file_name);
    sheet.device_info();
    if kind == SheetKind::Configured {
        sheet.commissioning();
    }
    sheet.dummy_usage();
    let dictionary = dictionary(design);
    let manufacturer = |index: u16| (MANUFACTURER[0]..MANUFACTURER[1]).contains(&index);
    let indices = || dictionary.objects().iter().map(|object| object.index);
    sheet.list("MandatoryObjects", indices().filter(|index| MANDATORY.contains(index)));
    let optional = |index: &u16| !MANDATORY.contains(index) && !manufacturer(*index);
    sheet.list("OptionalObjects", indices().filter(optional));
    sheet.list("ManufacturerObjects", indices().filter(|index| manufacturer(*index)));
    dictionary.objects().iter().for_each(|object| sheet.object(object));
    sheet.text
}

struct Sheet<'a> {
    design: &'a NodeDesign,
    kind: SheetKind,
    text: String,
}

impl Sheet<'_> {
    /// Begins a section. Lines end as on Windows, where most of the tools are.
    fn section(&mut self, name: &str) {
        let gap = if self.text.is_empty() { "" } else { "\r\n" };
        self.text += &format!("{gap}[{name}]\r\n");
    }

    fn key(&mut self, key: &str, value: impl std::fmt::Display) {
        // Writing to a text cannot fail.
        _ = write!(self.text, "{key}={value}\r\n");
    }

    fn file_info(&mut self, file_name: &str) {
        let [major, minor] = self.design.revision();
        self.section("FileInfo");
        self.key("FileName", ascii(file_name));
        self.key("FileVersion", major);
        self.key("FileRevision", minor);
        self.key("EDSVersion", "4.0");
        let what = match self.kind {
            SheetKind::Device => "data sheet",
            SheetKind::Configured => "configuration",
        };
        let machine = ascii(&self.design.machine);
        self.key("Description", format!("Tertius {} on {machine}: {what}", self.design.version));
        for event in ["Creation", "Modification"] {
            self.key(&format!("{event}Time"), TIME);
            self.key(&format!("{event}Date"), DATE);
        }
        self.key("CreatedBy", "tertius eds");
        self.key("ModifiedBy", "tertius eds");
    }

    fn device_info(&mut self) {
        let [major, minor] = self.design.revision();
        self.section("DeviceInfo");
        self.key("VendorName", "The Tertius authors");
        self.key("VendorNumber", "0x00000000");
        self.key("ProductName", "Tertius");
        self.key("ProductNumber", "0x00000001");
        self.key("RevisionNumber", hex32(u32::from(major) << 16 | u32::from(minor)));
        self.key("OrderCode", "tertius");
        for rate in BIT_RATES {
            self.key(&format!("BaudRate_{rate}"), 1);
        }
        self.key("SimpleBootUpMaster", 0);
        self.key("SimpleBootUpSlave", 1);
        self.key("Granularity", 0);
        self.key("DynamicChannelsSupported", 0);
        self.key("GroupMessaging", 0);
        self.key("NrOfRXPDO", 0);
        self.key("NrOfTXPDO", OwnMessage::ALL.len());
        self.key("LSS_Supported", 0);
    }

    fn commissioning(&mut self) {
        // The section is spelt so in CiA 306.
        self.section("DeviceComissioning");
        self.key("NodeID", format!("0x{:02X}", self.design.node));
        self.key("NodeName", format!("Tertius on {}", ascii(&self.design.machine)));
        self.key("Baudrate", self.design.bitrate / 1000);
        self.key("NetNumber", 1);
        self.key("NetworkName", ascii(&self.design.machine));
        self.key("CANopenManager", 0);
    }

    /// No type is used to fill gaps in a PDO.
    fn dummy_usage(&mut self) {
        self.section("DummyUsage");
        (1..=7).for_each(|kind| self.key(&format!("Dummy{kind:04X}"), 0));
    }

    fn list(&mut self, name: &str, indices: impl Iterator<Item = u16> + Clone) {
        self.section(name);
        self.key("SupportedObjects", indices.clone().count());
        for (n, index) in (1..).zip(indices) {
            self.key(&n.to_string(), format!("0x{index:04X}"));
        }
    }

    fn object(&mut self, object: &NodeObject) {
        self.section(&format!("{:04X}", object.index));
        self.key("ParameterName", &object.name);
        self.key("ObjectType", format!("0x{:X}", object.shape as u8));
        if object.shape == Shape::Variable {
            object.entries.iter().for_each(|entry| self.entry(entry));
            return;
        }
        self.key("SubNumber", object.entries.len());
        for entry in &object.entries {
            self.section(&format!("{:04X}sub{:X}", object.index, entry.sub));
            self.key("ParameterName", &entry.name);
            self.key("ObjectType", format!("0x{:X}", Shape::Variable as u8));
            self.entry(entry);
        }
    }

    fn entry(&mut self, entry: &NodeEntry) {
        self.key("DataType", format!("0x{:04X}", entry.kind as u16));
        let access = match entry.access {
            Access::Constant => "const",
            Access::Read => "ro",
            Access::ReadWrite => "rw",
        };
        self.key("AccessType", access);
        self.key("DefaultValue", self.default_of(entry));
        self.key("PDOMapping", u8::from(entry.mapped));
        if entry.source != Source::Live(Live::Heartbeat) {
            return;
        }
        self.key("LowLimit", 0);
        self.key("HighLimit", u16::MAX);
        if self.kind == SheetKind::Configured {
            self.key("ParameterValue", self.default_of(entry));
        }
    }

    fn default_of(&self, entry: &NodeEntry) -> String {
        match (&entry.source, entry.kind) {
            (Source::Number(number), NodeType::Unsigned32) => hex32(*number),
            (Source::Number(number), _) => number.to_string(),
            (Source::OfNode(base), _) => match self.kind {
                SheetKind::Device => format!("$NODEID+{}", hex32(*base)),
                SheetKind::Configured => hex32(base + u32::from(self.design.node)),
            },
            (Source::Real(real), _) => real.to_string(),
            (Source::Text(text), _) => text.to_string(),
            (Source::Live(Live::Heartbeat), _) => self.design.heartbeat.to_string(),
            (Source::Live(Live::ErrorCount), _) => "0".to_owned(),
            (Source::Live(_), _) => String::new(),
        }
    }
}

fn hex32(number: u32) -> String {
    format!("0x{number:08X}")
}

/// A text for the sheet, whose encoding no reader agrees on beyond ASCII.
fn ascii(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_graphic() || c == ' ' { c } else { '?' }).collect()
}
