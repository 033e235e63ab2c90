//! State that can be saved and taken up again.
//!
//! A type that changes with the frames says below its definition which of its fields are state. The others follow
//! from the design, and stay as the constructor has made them:
//!
//! ```text
//! state! {
//!     Trigger { raised, below, was_below }
//!     but { thresholds }
//! }
//! ```
//!
//! Every field is named once: with one too few the crate does not compile. State is therefore taken up in place, by
//! a value made from the same design ([`Stateful::resume`]), so that no table of a calibration is saved. A value that
//! has no design is declared by `whole!` or, without data, by `choice!`, and is read as a whole ([`Whole`]).
//!
//! Numbers are written little-endian and in full, so that what is read is what was saved, bit by bit. The names and
//! types of all fields give [`Stateful::SHAPE`] at compile time, by which a program knows whether a state has the
//! fields that it expects: no version has to be counted up by hand.
//!
//! Whatever the bytes are, reading gives an error or a value with which nothing panics: `sound` has the conditions
//! for that. Counts are refused from [`MOST_COUNTED`] on, so that adding to them does not overflow.

mod error;
mod macros;
mod stream;
#[cfg(test)]
mod tests;
mod values;

pub use error::StateError;
pub(crate) use macros::{choice, state, whole};
pub use stream::{StateReader, StateWriter};
pub use values::MOST_COUNTED;

/// A value with state, which is saved, and taken up by another value of the same design.
pub trait Stateful {
    /// Fingerprint of the names, types and order of all that is saved.
    const SHAPE: u64;

    /// Appends the state.
    fn save(&self, into: &mut StateWriter);

    /// Takes up what was saved. After an error the value is to be discarded, since a part was taken up.
    ///
    /// # Errors
    /// The bytes end, or have what no value of this design has.
    fn resume(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError>;
}

/// A value that is state only, so that it can be made from what was saved.
pub trait Whole: Stateful + Sized {
    /// Reads a value.
    ///
    /// # Errors
    /// See [`Stateful::resume`].
    fn read(from: &mut StateReader<'_>) -> Result<Self, StateError>;
}

/// Values with state that are there, or are as many, as the design says.
pub trait Parts {
    /// As [`Stateful::SHAPE`].
    const SHAPE: u64;

    /// Appends the number of parts, and the state of each.
    fn save_parts(&self, into: &mut StateWriter);

    /// Takes up the state of each part.
    ///
    /// # Errors
    /// See [`Stateful::resume`]; also another number of parts.
    fn resume_parts(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError>;
}

/// Patterns of bits, of which each is possible, other than of a count.
pub trait Bits: Sized {
    /// As [`Stateful::SHAPE`].
    const SHAPE: u64;

    /// Appends the pattern.
    fn save_bits(&self, into: &mut StateWriter);

    /// Reads a pattern.
    ///
    /// # Errors
    /// The bytes end.
    fn read_bits(from: &mut StateReader<'_>) -> Result<Self, StateError>;
}

/// Fingerprint of a name.
pub const fn shape_of_name(name: &str) -> u64 {
    // FNV-1a.
    let (bytes, mut hash, mut at) = (name.as_bytes(), 0xCBF2_9CE4_8422_2325_u64, 0);
    while at < bytes.len() {
        hash = (hash ^ bytes[at] as u64).wrapping_mul(0x0100_0000_01B3);
        at += 1;
    }
    hash
}

/// Fingerprint of two shapes, one after the other.
pub const fn shape_of_both(one: u64, other: u64) -> u64 {
    (one.rotate_left(5) ^ other).wrapping_mul(0x9E37_79B9_7F4A_7C15)
}

/// Shape of the field that `_of` names.
pub const fn shape_of_field<S, T: Stateful>(_of: fn(&S) -> &T) -> u64 {
    T::SHAPE
}

/// Shape of the parts that `_of` names.
pub const fn shape_of_parts<S, T: Parts>(_of: fn(&S) -> &T) -> u64 {
    T::SHAPE
}

/// Shape of the pattern that `_of` names.
pub const fn shape_of_bits<S, T: Bits>(_of: fn(&S) -> &T) -> u64 {
    T::SHAPE
}
