//! PDO communication and mapping parameters (CiA 301: 0x1400 and 0x1600, 0x1800 and 0x1A00).

use std::fmt;

use tertius_core::decode::{BitField, NumberForm, SignalPlan};
use tertius_core::frame::Id;

use super::scale::Scale;
use crate::eds::{Address, DataType, ObjectDictionary};

/// The most PDOs of one direction.
const MOST: u16 = 512;
/// The most objects in one PDO.
const MOST_OBJECTS: i128 = 64;
/// The most bits in one PDO, those of a CAN frame.
const MOST_BITS: u16 = 64;
/// Objects below this index are data types: they fill gaps.
const FIRST_OBJECT: u16 = 0x1000;
/// Bits of a COB-ID: the PDO is off; its identifier has 29 bits.
const OFF: i128 = 1 << 31;
const EXTENDED: i128 = 1 << 29;

/// Direction of a PDO, seen from the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// A TPDO, which the device sends.
    Sent,
    /// An RPDO, which the device receives.
    Received,
}

impl Direction {
    /// Indices of the first communication and mapping parameters, and the COB-ID of PDO 1 in the predefined
    /// connection set.
    fn bases(self) -> (u16, u16, u16) {
        match self {
            Self::Sent => (0x1800, 0x1A00, 0x180),
            Self::Received => (0x1400, 0x1600, 0x200),
        }
    }
}

/// An object in a PDO.
#[derive(Clone, Debug, PartialEq)]
pub struct MappedObject {
    pub index: u16,
    pub sub_index: u8,
    pub data_type: DataType,
    /// Its lowest bit: 8 · byte + bit.
    pub start: u16,
    pub bits: u8,
}

impl MappedObject {
    /// The object as a signal of its PDO's frames; `None` if it is not a number.
    pub fn plan(&self, scale: &Scale) -> Option<SignalPlan> {
        let (signed, form) = match self.data_type {
            DataType::Integer(_) => (true, NumberForm::Integer),
            DataType::Unsigned(64) => (false, NumberForm::Unsigned64),
            DataType::Unsigned(_) | DataType::Boolean => (false, NumberForm::Integer),
            DataType::Real32 => (false, NumberForm::Float32),
            DataType::Real64 => (false, NumberForm::Float64),
            _ => return None,
        };
        let field = BitField::new(self.start.into(), self.bits.into(), false, signed).ok()?;
        Some(SignalPlan::new(field, form, scale.factor, 0.0, Box::default()))
    }
}

/// A PDO as it is configured.
#[derive(Clone, Debug, PartialEq)]
pub struct Pdo {
    pub direction: Direction,
    /// Number from 1 to 512.
    pub number: u16,
    pub id: Id,
    /// Length of its frames, bytes.
    pub length: usize,
    /// When it is sent: up to 240 at every so many SYNCs, 254 and 255 by events; `None` where the file does
    /// not say.
    pub transmission_type: Option<u8>,
    /// Longest time between frames of an event-driven PDO, ms; 0 or `None` for none.
    pub event_timer_ms: Option<u16>,
    pub objects: Vec<MappedObject>,
}

/// Why a PDO cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PdoFlaw {
    pub direction: Direction,
    /// Number from 1 to 512.
    pub number: u16,
    pub reason: String,
}

impl fmt::Display for PdoFlaw {
    /// `TPDO1: reason`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", pdo_name(self.direction, self.number), self.reason)
    }
}

impl Pdo {
    /// `TPDO1`, `RPDO4`
    pub fn name(&self) -> String {
        pdo_name(self.direction, self.number)
    }
}

fn pdo_name(direction: Direction, number: u16) -> String {
    match direction {
        Direction::Sent => format!("TPDO{number}"),
        Direction::Received => format!("RPDO{number}"),
    }
}

/// All PDOs of a device.
#[derive(Clone, Debug, Default)]
pub struct Pdos {
    /// Those that can be used, what the device sends first, by ascending number.
    pub sound: Vec<Pdo>,
    /// Those that are off or have an error.
    pub refused: Vec<PdoFlaw>,
}

impl Pdos {
    /// The PDOs that `dictionary` configures on the node of that node-ID, 1 to 127.
    pub fn of(dictionary: &ObjectDictionary, node_id: u8) -> Self {
        let mut pdos = Self::default();
        for direction in [Direction::Sent, Direction::Received] {
            for number in 1..=MOST {
                let reader = Reader { dictionary, node_id, direction, number };
                let (communication, mapping) = reader.indices();
                if dictionary.object(communication).is_none()
                    && dictionary.object(mapping).is_none()
                {
                    continue;
                }
                match reader.pdo() {
                    Ok(pdo) => pdos.sound.push(pdo),
                    Err(reason) => pdos.refused.push(PdoFlaw { direction, number, reason }),
                }
            }
        }
        pdos
    }
}

struct Reader<'a> {
    dictionary: &'a ObjectDictionary,
    node_id: u8,
    direction: Direction,
    number: u16,
}

impl Reader<'_> {
    fn indices(&self) -> (u16, u16) {
        let (communication, mapping, _) = self.direction.bases();
        (communication + self.number - 1, mapping + self.number - 1)
    }

    /// The number that an object is configured to; `None` where it is missing or has none.
    fn number_at(&self, index: u16, sub_index: u8) -> Option<i128> {
        self.dictionary.number(index, sub_index, self.node_id)
    }

    fn pdo(&self) -> Result<Pdo, String> {
        let (communication, _) = self.indices();
        let id = self.id(communication)?;
        let (objects, bits) = self.objects()?;
        let small = |sub_index| self.number_at(communication, sub_index);
        Ok(Pdo {
            direction: self.direction,
            number: self.number,
            id,
            length: usize::from(bits.div_ceil(8)),
            transmission_type: small(2).and_then(|number| u8::try_from(number).ok()),
            event_timer_ms: small(5).and_then(|number| u16::try_from(number).ok()),
            objects,
        })
    }

    fn id(&self, communication: u16) -> Result<Id, String> {
        let address = Address { index: communication, sub_index: Some(1) };
        let (_, _, first) = self.direction.bases();
        // Of the first four the standard says where they are.
        let predefined = (self.number <= 4)
            .then(|| i128::from(first + (self.number - 1) * 0x100) + i128::from(self.node_id));
        let cob_id = self
            .number_at(communication, 1)
            .or(predefined)
            .ok_or_else(|| format!("its COB-ID, {address}, has no value in the file"))?;
        if cob_id & OFF != 0 {
            return Err(format!("it is off: bit 31 of its COB-ID, {address}, is set"));
        }
        let number = cob_id & i128::from(Id::EXTENDED_MAX);
        let id = u32::try_from(number).ok().and_then(|number| {
            if cob_id & EXTENDED != 0 { Id::extended(number) } else { Id::standard(number) }
        });
        id.ok_or_else(|| format!("its COB-ID, {address}, is 0x{cob_id:X}, which is no identifier"))
    }

    /// The mapped objects, and the number of bits with gaps.
    fn objects(&self) -> Result<(Vec<MappedObject>, u16), String> {
        let (_, mapping) = self.indices();
        let told = self.number_at(mapping, 0);
        let count = told.ok_or_else(|| {
            format!("how many objects are mapped, 0x{mapping:04X}:00, has no value in the file")
        })?;
        let subs = match u8::try_from(count) {
            Ok(subs) if (1..=MOST_OBJECTS).contains(&count) => subs,
            _ => return Err(format!("0x{mapping:04X}:00 says that {count} objects are mapped")),
        };
        let (mut objects, mut start) = (Vec::new(), 0);
        for sub_index in 1..=subs {
            let place = format!("0x{mapping:04X}:{sub_index:02X}");
            let entry = self.number_at(mapping, sub_index).and_then(|it| u32::try_from(it).ok());
            let entry = entry.ok_or_else(|| format!("{place} has no value in the file"))?;
            let [bits, sub_index, low, high] = entry.to_le_bytes();
            let index = u16::from_le_bytes([low, high]);
            let end = start + u16::from(bits);
            if bits == 0 || end > MOST_BITS {
                return Err(format!("{place}, 0x{entry:08X}, ends at bit {end}, expected 1 to 64"));
            }
            if index >= FIRST_OBJECT {
                let data_type = self.data_type(index, sub_index, bits, &place)?;
                objects.push(MappedObject { index, sub_index, data_type, start, bits });
            }
            start = end;
        }
        Ok((objects, start))
    }

    /// The type of a mapped object, which has to have that many bits.
    fn data_type(
        &self,
        index: u16,
        sub_index: u8,
        bits: u8,
        place: &str,
    ) -> Result<DataType, String> {
        let variable = self.dictionary.variable(index, sub_index);
        let data_type = variable.map_err(|error| format!("{place}: {error}"))?.data_type;
        match data_type.bits() {
            Some(own) if own != bits => Err(format!(
                "{place} maps {bits} bits of 0x{index:04X}:{sub_index:02X}, which is {data_type}"
            )),
            _ => Ok(data_type),
        }
    }
}
