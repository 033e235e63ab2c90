//! The buses of a machine, where it has more than one.

use crate::state::{StateError, StateReader, StateWriter, Stateful, Whole, shape_of_name, whole};
use core::fmt;

/// A bus of the machine. Nearly all machines have one, [`Self::First`]; it is also the one on which the gateway sends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum BusNumber {
    #[default]
    First,
    Second,
    Third,
    Fourth,
}

impl BusNumber {
    /// All buses that a machine may have.
    pub const ALL: [Self; 4] = [Self::First, Self::Second, Self::Third, Self::Fourth];

    /// Names in the configuration and in reports, by number.
    pub const NAMES: [&str; Self::ALL.len()] = ["first", "second", "third", "fourth"];

    /// Number of the bus among [`Self::ALL`], from 0.
    #[inline]
    pub const fn index(self) -> usize {
        self as usize
    }
}

impl fmt::Display for BusNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(Self::NAMES[self.index()])
    }
}

/// A set of buses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Buses {
    /// Whether each of [`BusNumber::ALL`] is one of the set. Bytes, since one is written for every frame.
    are: [bool; BusNumber::ALL.len()],
}

whole! { Buses { are } }

impl Buses {
    pub const NONE: Self = Self { are: [false; BusNumber::ALL.len()] };

    #[inline(always)]
    pub const fn insert(&mut self, bus: BusNumber) {
        self.are[bus.index()] = true;
    }

    pub const fn remove(&mut self, bus: BusNumber) {
        self.are[bus.index()] = false;
    }

    #[inline(always)]
    pub const fn has(self, bus: BusNumber) -> bool {
        self.are[bus.index()]
    }

    #[inline(always)]
    pub fn is_empty(self) -> bool {
        self == Self::NONE
    }

    /// The buses of the set, in their order.
    pub fn iter(self) -> impl Iterator<Item = BusNumber> {
        BusNumber::ALL.into_iter().filter(move |bus| self.has(*bus))
    }
}

impl FromIterator<BusNumber> for Buses {
    fn from_iter<I: IntoIterator<Item = BusNumber>>(buses: I) -> Self {
        let mut set = Self::NONE;
        buses.into_iter().for_each(|bus| set.insert(bus));
        set
    }
}

impl Stateful for BusNumber {
    const SHAPE: u64 = shape_of_name("BusNumber");

    fn save(&self, into: &mut StateWriter) {
        (*self as u8).save(into);
    }

    fn resume(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        *self = Self::read(from)?;
        Ok(())
    }
}

impl Whole for BusNumber {
    fn read(from: &mut StateReader<'_>) -> Result<Self, StateError> {
        let bus = Self::ALL.get(usize::from(u8::read(from)?));
        bus.copied().ok_or(StateError::Unsound { what: "number of a bus" })
    }
}
