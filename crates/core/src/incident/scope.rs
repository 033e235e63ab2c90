//! What an incident is of: one cylinder, or the machine.

use crate::alarm::status::MAX_CYLINDERS;
use crate::state::{StateError, StateReader, StateWriter, Stateful, Whole, shape_of_name, whole};

/// A set of cylinders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cylinders {
    /// A bit for each cylinder, the lowest for cylinder 1.
    bits: u8,
}

whole! { Cylinders { bits } }

// There is a bit for each.
const _: () = assert!(MAX_CYLINDERS <= u8::BITS as usize);

impl Cylinders {
    pub const NONE: Self = Self { bits: 0 };

    /// The set with these bits, the lowest for cylinder 1.
    pub const fn from_bits(bits: u8) -> Self {
        Self { bits }
    }

    pub const fn bits(self) -> u8 {
        self.bits
    }

    /// Adds the cylinder of `index`, counted from 0.
    pub const fn insert(&mut self, index: usize) {
        self.bits |= 1 << index;
    }

    /// Whether the cylinder with this number, counted from 1, is one of them.
    pub const fn has(self, number: usize) -> bool {
        number > 0 && number <= MAX_CYLINDERS && self.bits >> (number - 1) & 1 != 0
    }

    pub const fn count(self) -> usize {
        self.bits.count_ones() as usize
    }

    /// Their numbers, counted from 1, in order.
    pub fn numbers(self) -> impl Iterator<Item = u8> {
        (1..=MAX_CYLINDERS as u8).filter(move |number| self.has((*number).into()))
    }
}

/// What an incident is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// The cylinder with this number, counted from 1.
    Cylinder(u8),
    /// The machine: what these cylinders have in common.
    Machine(Cylinders),
}

impl Scope {
    /// Number of the cylinder, counted from 1; `None` for the machine.
    pub const fn cylinder(self) -> Option<u8> {
        match self {
            Self::Cylinder(number) => Some(number),
            Self::Machine(_) => None,
        }
    }

    /// The cylinders that it concerns.
    pub fn cylinders(self) -> Cylinders {
        match self {
            Self::Cylinder(number) => {
                let mut one = Cylinders::NONE;
                if (1..=MAX_CYLINDERS).contains(&usize::from(number)) {
                    one.insert(usize::from(number) - 1);
                }
                one
            }
            Self::Machine(cylinders) => cylinders,
        }
    }

    /// Whether it concerns the cylinder with this number, counted from 1.
    pub fn has(self, number: usize) -> bool {
        self.cylinders().has(number)
    }
}

impl Stateful for Scope {
    const SHAPE: u64 = shape_of_name("Scope");

    fn save(&self, into: &mut StateWriter) {
        into.put(match *self {
            Self::Cylinder(number) => [0, number],
            Self::Machine(cylinders) => [1, cylinders.bits],
        });
    }

    fn resume(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        *self = Self::read(from)?;
        Ok(())
    }
}

impl Whole for Scope {
    fn read(from: &mut StateReader<'_>) -> Result<Self, StateError> {
        match from.take()? {
            [0, number] => Ok(Self::Cylinder(number)),
            [1, bits] => Ok(Self::Machine(Cylinders { bits })),
            _ => Err(StateError::Unsound { what: "Scope" }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scope_has_its_cylinders_and_no_others() {
        let mut some = Cylinders::NONE;
        [0, 2, 5].into_iter().for_each(|index| some.insert(index));
        assert_eq!(some.numbers().collect::<Vec<_>>(), [1, 3, 6]);
        assert_eq!((some.count(), Cylinders::from_bits(some.bits())), (3, some));
        let of_machine = Scope::Machine(some);
        assert_eq!((of_machine.cylinder(), Scope::Cylinder(3).cylinder()), (None, Some(3)));
        for number in 0..300 {
            assert_eq!(of_machine.has(number), [1, 3, 6].contains(&number), "{number}");
            assert_eq!(Scope::Cylinder(3).has(number), number == 3, "{number}");
        }
        assert_eq!(Scope::Cylinder(0).cylinders(), Cylinders::NONE);
    }
}
