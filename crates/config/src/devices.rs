//! Devices that describe themselves: from their EDS or DCF to messages beside those of the DBC.

use std::collections::BTreeMap;

use super::design::Flaw;
use super::loader::Sheet;
use super::settings::{Device, Settings, object_name};
use tertius_canopen::eds::{ObjectDictionary, ObjectType, Severity};
use tertius_canopen::pdo::{Direction, FULL_SCALE, MappedObject, Pdo, Pdos, scale};
use tertius_core::frame::Id;
use tertius_dbc::{Database, DeviceMessages, DeviceServices, Message, Signal, text};

/// COB-ID of emergency messages (CiA 301).
const EMERGENCY_ID: u16 = 0x1014;

/// Time from one heartbeat to the next, ms (CiA 301).
const HEARTBEAT_TIME: u16 = 0x1017;

/// The set point of a valve (CiA 408).
const SET_POINT: u16 = 0x6300;

/// Adds the messages of the configured devices to those of the DBC, as [`Database::add_device`] does. Of a
/// device, only objects that are numbers are signals.
///
/// # Errors
/// An EDS that cannot be read, a device of another node-ID than its DCF says, an
/// identifier that something else on the bus has.
pub fn connect(
    settings: &Settings,
    sheets: &[Sheet],
    database: &mut Database,
) -> Result<(), Vec<Flaw>> {
    let mut flaws = Vec::new();
    let dictionaries = parse(settings, sheets, &mut flaws);
    let mut known: Vec<u8> = Vec::new();
    for (index, device) in settings.devices().iter().enumerate() {
        let Some(dictionary) = dictionaries.get(device.eds.as_str()) else { continue };
        // One node with several sensors is several devices.
        if known.contains(&device.node) {
            continue;
        }
        known.push(device.node);
        let key = |name: &str| format!("canopen.device[{index}].{name}");
        let told = dictionary.commissioning.as_ref().and_then(|it| it.node_id);
        if let Some(told) = told.filter(|told| *told != device.node) {
            flaws.push(Flaw::new(
                &key("node"),
                format!("`node` is {}, but {} is the DCF of node {told}", device.node, device.eds),
                "give each node its own DCF, or the EDS of its kind",
            ));
            continue;
        }
        if let Some(found) = other_profile(device, dictionary) {
            flaws.push(Flaw::new(
                &key("eds"),
                format!("{} is of a device of profile {found}", device.eds),
                format!("a {} is one of profile CiA {}", device.kind.word(), device.kind.profile()),
            ));
            continue;
        }
        if let Err(taken) = database.add_device(messages(settings, device, dictionary)) {
            flaws.push(Flaw::new(
                &key("node"),
                taken,
                "nodes have node-IDs and COB-IDs of their own; leave a message that a device \
                 describes out of the DBC",
            ));
        }
    }
    if flaws.is_empty() { Ok(()) } else { Err(flaws) }
}

/// Where an object is in its PDO, in words.
fn place(object: &MappedObject) -> String {
    let (byte, bit, bits) = (object.start / 8, object.start % 8, object.bits);
    match bit {
        0 => format!("byte {byte}, {bits} bits"),
        bit => format!("byte {byte} from bit {bit} on, {bits} bits"),
    }
}

/// The profile that the file has (object 0x1000), where it is another than the device's kind has.
fn other_profile(device: &Device, dictionary: &ObjectDictionary) -> Option<i128> {
    let device_type = dictionary.number(0x1000, 0, device.node)?;
    let profile = device_type & 0xFFFF;
    (profile != i128::from(device.kind.profile())).then_some(profile)
}

/// What was found in the EDS and DCF files that can be used all the same, by their paths.
pub fn findings(sheets: &[Sheet]) -> Vec<(&Sheet, Vec<String>)> {
    let findings = |sheet: &Sheet| {
        let read = ObjectDictionary::parse(&text::from_bytes(&sheet.text));
        let found = read.map(|it| it.findings().iter().map(ToString::to_string).collect());
        found.unwrap_or_default()
    };
    sheets.iter().map(|sheet| (sheet, findings(sheet))).collect()
}

fn parse<'a>(
    settings: &Settings,
    sheets: &'a [Sheet],
    flaws: &mut Vec<Flaw>,
) -> BTreeMap<&'a str, ObjectDictionary> {
    let mut dictionaries = BTreeMap::new();
    for sheet in sheets {
        match ObjectDictionary::parse(&text::from_bytes(&sheet.text)) {
            Ok(dictionary) => _ = dictionaries.insert(sheet.name.as_str(), dictionary),
            Err(error) => {
                let used = |device: &Device| device.eds == sheet.name;
                let index = settings.devices().iter().position(used).unwrap_or_default();
                flaws.push(Flaw::new(
                    &format!("canopen.device[{index}].eds"),
                    format!("{}: {error}", sheet.path.display()),
                    "give the EDS or DCF of the device, as its maker or a CANopen tool writes it",
                ));
            }
        }
    }
    dictionaries
}

fn messages(settings: &Settings, device: &Device, dictionary: &ObjectDictionary) -> DeviceMessages {
    let pdos = Pdos::of(dictionary, device.node);
    let mut notes: Vec<String> = pdos.refused.iter().map(ToString::to_string).collect();
    let mut messages: Vec<Message> = Vec::new();
    for pdo in &pdos.sound {
        if messages.iter().any(|message| message.id == pdo.id) {
            notes.push(format!("{} has the identifier of another PDO", pdo.name()));
            continue;
        }
        messages.push(message(device, dictionary, pdo, &mut notes));
    }
    let errors = dictionary.findings().iter().filter(|it| it.severity == Severity::Error);
    notes.extend(errors.map(ToString::to_string));
    let names = settings.devices().iter().filter(|it| it.node == device.node).map(Device::name);
    let services = services(device.node, dictionary, &pdos);
    DeviceMessages { names: names.collect(), messages, services, note: notes.join("; ") }
}

/// Services by which the node tells of itself. Heartbeats have one identifier. That of emergency messages is
/// in the dictionary, where its highest bit is set if there are none, and bit 29 if it has 29 bits.
fn services(node: u8, dictionary: &ObjectDictionary, pdos: &Pdos) -> DeviceServices {
    let of_set = |base: u32| Id::standard(base + u32::from(node));
    let emergency = match dictionary.number(EMERGENCY_ID, 0, node).map(u32::try_from) {
        Some(Ok(number)) if number >> 31 != 0 => None,
        Some(Ok(number)) if number >> 29 & 1 != 0 => Id::extended(number & Id::EXTENDED_MAX),
        Some(Ok(number)) => Id::standard(number),
        Some(Err(_)) | None => of_set(0x080),
    };
    let milliseconds = dictionary.number(HEARTBEAT_TIME, 0, node).unwrap_or(0);
    let period = u16::try_from(milliseconds).ok().filter(|time| *time > 0);
    let period = period.map(|time| f64::from(time) * 1e-3);
    // An EDS has the timer with which the device left its factory, and only a DCF the one that it has.
    let sent = pdos.sound.iter().find(|pdo| pdo.direction == Direction::Sent);
    let sent = sent.filter(|pdo| pdo.transmission_type.is_some_and(|number| number >= 254));
    let timer = sent.filter(|_| dictionary.commissioning.is_some());
    let timer = timer.and_then(|pdo| pdo.event_timer_ms).filter(|time| *time > 0);
    let event_timer = timer.map(|time| f64::from(time) * 1e-3);
    DeviceServices { emergency, heartbeat: of_set(0x700), period, event_timer }
}

fn message(
    device: &Device,
    dictionary: &ObjectDictionary,
    pdo: &Pdo,
    notes: &mut Vec<String>,
) -> Message {
    let mut signals: Vec<Signal> = Vec::new();
    for object in &pdo.objects {
        let name = object_name(object.index, object.sub_index);
        // An object may be mapped twice; its first place counts.
        if signals.iter().any(|signal| signal.name == name) {
            continue;
        }
        match signal(device, dictionary, object, name) {
            Ok(signal) => signals.push(signal),
            Err(note) => notes.push(note),
        }
    }
    Message {
        id: pdo.id,
        name: format!("{} of node {}", pdo.name(), device.node),
        short: None,
        length: pdo.length,
        signals,
        comment: None,
        line: 1,
    }
}

/// An object as a signal.
///
/// # Errors
/// Why it is none.
fn signal(
    device: &Device,
    dictionary: &ObjectDictionary,
    object: &MappedObject,
    name: String,
) -> Result<Signal, String> {
    let variable = dictionary.variable(object.index, object.sub_index);
    let variable = variable.map_err(|error| error.to_string())?;
    let record = dictionary.object(object.index).filter(|it| it.object_type == ObjectType::Record);
    let of_record = record.map_or(String::new(), |record| format!("{}: ", record.name));
    let mut scale = scale(dictionary, device.node, object.index)
        .map_err(|error| format!("{name} cannot be used: {error}"))?;
    if let (SET_POINT, FULL_SCALE, Some(speed)) = (object.index, scale.unit, device.full_speed) {
        scale.factor *= speed;
        scale.unit = "m/s";
    }
    let plan = object.plan(&scale);
    let plan = plan.ok_or_else(|| format!("{name} is {}, no number", object.data_type))?;
    Ok(Signal {
        name,
        short: (object.sub_index == 0).then(|| format!("0x{:04X}", object.index)),
        unit: scale.unit.to_owned(),
        range: None,
        values: Vec::new(),
        comment: Some(format!("{of_record}{}; {}", variable.name, place(object))),
        plan,
        line: variable.line,
    })
}
