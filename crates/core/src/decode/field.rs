//! Position of a signal's bits in a payload, and access to them.

use crate::frame::MAX_DATA;

const MAX_BITS: u64 = 8 * MAX_DATA as u64;
/// Last byte at which a load of eight bytes may begin.
const LAST_LOAD: usize = MAX_DATA - 8;
/// Last byte at which a load of sixteen bytes may begin.
const LAST_WIDE_LOAD: usize = MAX_DATA - 16;

/// Up to 64 bits of a payload: the eight bytes to load, and how to extract the bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitField {
    /// Mask with as many ones as the field has bits.
    mask: u64,
    /// Sign bit at the field's own width; 0 for unsigned fields, so that `(x ^ sign) - sign`
    /// extends either kind without a branch.
    sign: u64,
    /// Shift that brings the field's lowest bit to bit 0 of the loaded word.
    shift: u8,
    /// Byte at which the load begins.
    at: u8,
    /// Length that the payload must have, bytes.
    needs: u8,
    motorola: bool,
    /// Whether the field touches nine bytes, so that no load of eight holds it.
    wide: bool,
    /// First bit: 8 · byte + significance for Intel fields, 8 · byte + place from the top for
    /// Motorola fields.
    first: u16,
    length: u8,
}

/// A field within eight bytes that have already been loaded.
#[derive(Clone, Copy, Debug)]
pub(super) struct WordField {
    /// Mask as in [`BitField`].
    mask: u64,
    sign: u64,
    shift: u8,
    motorola: bool,
}

impl WordField {
    /// The signed number as [`BitField::integer`] gives it, where `word` has the first of the eight
    /// bytes lowest.
    #[inline(always)]
    pub fn integer(&self, word: u64) -> i64 {
        let word = if self.motorola { word.swap_bytes() } else { word };
        // `&` changes nothing: it lets the compiler drop its own check.
        let bits = (word >> (self.shift & 63)) & self.mask;
        (bits ^ self.sign).wrapping_sub(self.sign) as i64
    }
}

/// Why a field is impossible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoField {
    /// The length is 0 or above 64 bits.
    Length,
    /// The field ends beyond the longest payload.
    Beyond,
}

impl BitField {
    /// The field of `length` bits at `start`, counted as a DBC file does: Intel fields by their
    /// lowest bit, Motorola fields by their highest, both 8 · byte + significance.
    pub fn new(start: u64, length: u64, motorola: bool, signed: bool) -> Result<Self, NoField> {
        if !(1..=64).contains(&length) {
            return Err(NoField::Length);
        }
        if start >= MAX_BITS {
            return Err(NoField::Beyond);
        }
        let first = if motorola { start ^ 7 } else { start };
        if first + length > MAX_BITS {
            return Err(NoField::Beyond);
        }
        let (first, length) = (first as usize, length as usize);
        let at = (first / 8).min(LAST_LOAD);
        let before = first - 8 * at;
        let wide = before + length > 64;
        let shift = match (wide, motorola) {
            (true, _) => 0,
            (false, false) => before,
            (false, true) => 64 - before - length,
        };
        Ok(Self {
            mask: u64::MAX >> (64 - length),
            sign: if signed { 1 << (length - 1) } else { 0 },
            shift: shift as u8,
            at: at as u8,
            needs: (first + length).div_ceil(8) as u8,
            motorola,
            wide,
            first: first as u16,
            length: length as u8,
        })
    }

    /// Length that a payload must have to hold the field, bytes.
    #[inline]
    pub fn needs(&self) -> usize {
        usize::from(self.needs)
    }

    /// Width in bits.
    pub fn length(&self) -> u32 {
        u32::from(self.length)
    }

    pub fn is_signed(&self) -> bool {
        self.sign != 0
    }

    /// The field's bits, right-aligned, zeros above.
    #[inline]
    pub fn bits(&self, payload: &[u8; MAX_DATA]) -> u64 {
        if self.wide { self.wide_bits(payload) } else { self.narrow_bits(payload) }
    }

    /// The bits of a field that is not wide.
    #[inline(always)]
    fn narrow_bits(&self, payload: &[u8; MAX_DATA]) -> u64 {
        let at = usize::from(self.at);
        let bytes: [u8; 8] = payload[at..at + 8].try_into().expect("the slice is eight bytes");
        let word =
            if self.motorola { u64::from_be_bytes(bytes) } else { u64::from_le_bytes(bytes) };
        // `&` changes nothing: it lets the compiler drop its own check.
        (word >> (self.shift & 63)) & self.mask
    }

    /// The field's place in the eight bytes that begin with byte `at`; `None` if they do not hold
    /// all of it.
    pub(super) fn within(&self, at: usize) -> Option<WordField> {
        let (first, length) = (usize::from(self.first), usize::from(self.length));
        let before = first.checked_sub(8 * at)?;
        let behind = 64_usize.checked_sub(before + length)?;
        let (mask, sign, motorola) = (self.mask, self.sign, self.motorola);
        Some(WordField {
            mask,
            sign,
            shift: if motorola { behind } else { before } as u8,
            motorola,
        })
    }

    #[cold]
    fn wide_bits(&self, payload: &[u8; MAX_DATA]) -> u64 {
        (self.load_wide(payload) >> self.wide_shift()) as u64 & self.mask
    }

    /// The bits as a number of the field's width and sign; for an unsigned field of 64 bits, the
    /// bits are reinterpreted.
    #[inline]
    pub fn integer(&self, payload: &[u8; MAX_DATA]) -> i64 {
        (self.bits(payload) ^ self.sign).wrapping_sub(self.sign) as i64
    }

    /// Writes the lowest bits of `bits` and nothing else.
    pub fn set_bits(&self, bits: u64, payload: &mut [u8; MAX_DATA]) {
        let shift = self.wide_shift();
        let word = self.load_wide(payload) & !(u128::from(self.mask) << shift)
            | (u128::from(bits & self.mask) << shift);
        let bytes = if self.motorola { word.to_be_bytes() } else { word.to_le_bytes() };
        let at = self.wide_at();
        payload[at..at + 16].copy_from_slice(&bytes);
    }

    /// Bits of the payload that the field occupies; bit 8 · byte + significance.
    pub fn occupied(&self) -> [u64; 8] {
        let mut bits = [0; 8];
        for place in self.first..self.first + u16::from(self.length) {
            let bit = if self.motorola { place ^ 7 } else { place };
            bits[usize::from(bit / 64)] |= 1 << (bit % 64);
        }
        bits
    }

    fn wide_at(&self) -> usize {
        (usize::from(self.first) / 8).min(LAST_WIDE_LOAD)
    }

    fn wide_shift(&self) -> usize {
        let before = usize::from(self.first) - 8 * self.wide_at();
        if self.motorola { 128 - before - usize::from(self.length) } else { before }
    }

    /// Loads sixteen bytes, which hold any field.
    fn load_wide(&self, payload: &[u8; MAX_DATA]) -> u128 {
        let at = self.wide_at();
        let bytes: [u8; 16] = payload[at..at + 16].try_into().expect("the slice is 16 bytes");
        if self.motorola { u128::from_be_bytes(bytes) } else { u128::from_le_bytes(bytes) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reads bit by bit, as the format's description defines it.
    fn slowly(start: usize, length: usize, motorola: bool, payload: &[u8; MAX_DATA]) -> u64 {
        let bit = |place: usize| u64::from(payload[place / 8] >> (place % 8) & 1);
        let mut value = 0;
        let mut place = start;
        for i in 0..length {
            if motorola {
                value = value << 1 | bit(place);
                place = if place.is_multiple_of(8) { place + 15 } else { place - 1 };
            } else {
                value |= bit(start + i) << i;
            }
        }
        value
    }

    #[test]
    fn every_place_and_length_reads_as_bit_by_bit_and_writes_back() {
        let mut payload = [0; MAX_DATA];
        for (i, byte) in payload.iter_mut().enumerate() {
            *byte = (i as u8).wrapping_mul(97) ^ 0x5A;
        }
        let mut fields = 0;
        for motorola in [false, true] {
            for start in 0..512_usize {
                for length in 1..=64_usize {
                    let Ok(field) = BitField::new(start as u64, length as u64, motorola, false)
                    else {
                        continue;
                    };
                    fields += 1;
                    let bits = field.bits(&payload);
                    assert_eq!(bits, slowly(start, length, motorola, &payload), "{field:?}");
                    let mut other = payload;
                    field.set_bits(!bits, &mut other);
                    assert_eq!(field.bits(&other), !bits & field.mask);
                    field.set_bits(bits, &mut other);
                    assert_eq!(other, payload, "a neighbour was changed by {field:?}");
                }
            }
        }
        assert_eq!(fields, 2 * (512 * 64 - 63 * 64 / 2));
    }

    #[test]
    fn what_does_not_fit_is_no_field() {
        assert_eq!(BitField::new(0, 0, false, false), Err(NoField::Length));
        assert_eq!(BitField::new(0, 65, true, false), Err(NoField::Length));
        assert_eq!(BitField::new(511, 2, false, false), Err(NoField::Beyond));
        assert_eq!(BitField::new(504, 2, true, false), Err(NoField::Beyond));
        assert_eq!(BitField::new(u64::MAX, 64, true, false), Err(NoField::Beyond));
    }
}
