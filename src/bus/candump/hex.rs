//! Digits, one by one and eight at a time in a machine word.

const ONES: u64 = u64::MAX / 0xFF;
const HIGH: u64 = ONES * 0x80;

/// The value of one hexadecimal digit of either case.
pub fn digit(byte: u8) -> Option<u8> {
    char::from(byte).to_digit(16).map(|value| value as u8)
}

/// The value of up to eight hexadecimal digits; the byte that is none as error.
pub fn number(text: &[u8]) -> Result<u32, u8> {
    debug_assert!(text.len() <= 8);
    let add = |value: u32, &byte| digit(byte).map(|d| value << 4 | u32::from(d)).ok_or(byte);
    text.iter().try_fold(0, add)
}

/// How many of eight characters (the first in the lowest byte) are hexadecimal digits before the
/// first that is none.
#[inline(always)]
pub fn leading_digits(word: u64) -> u32 {
    // Adding 0x80 − c sets a byte's high bit exactly when its low seven bits are at least c.
    let at_least = |word: u64, c: u8| word + ONES * u64::from(0x80 - c);
    let low = word & !HIGH;
    let lower = low | (ONES * 0x20);
    let decimal = at_least(low, b'0') & !at_least(low, b'9' + 1);
    let letter = at_least(lower, b'a') & !at_least(lower, b'f' + 1);
    let no_digit = !(decimal | letter) | word;
    (no_digit & HIGH).trailing_zeros() / 8
}

/// Eight hexadecimal digits (the first in the lowest byte) as four bytes, the first lowest. A pair
/// with a character that is no digit, and every pair after it, comes out as anything.
#[inline(always)]
pub fn bytes(word: u64) -> u32 {
    // 'A' and 'a' have 1 in their low four bits: nine short of their value.
    let nibbles = (word & (ONES * 0x0F)).wrapping_add(((word >> 6) & ONES) * 9);
    let pairs = ((nibbles << 4) | (nibbles >> 8)) & 0x00FF_00FF_00FF_00FF;
    let quads = (pairs | (pairs >> 8)) & 0x0000_FFFF_0000_FFFF;
    (quads | (quads >> 16)) as u32
}

/// Six decimal digits and then `") "`, the first in the lowest byte; `None` for all else.
#[inline(always)]
pub fn six_decimals(word: u64) -> Option<u32> {
    let digits = word ^ u64::from_le_bytes(*b"000000) ");
    let beyond_nine = digits.wrapping_add(0x0000_7676_7676_7676) | digits;
    if digits >> 48 != 0 || beyond_nine & HIGH != 0 {
        return None;
    }
    let eight = digits << 16;
    let pairs = eight * 10 + (eight >> 8);
    let mask = 0x0000_00FF_0000_00FF;
    let first = (pairs & mask).wrapping_mul(100 + (1_000_000 << 32));
    let second = ((pairs >> 16) & mask).wrapping_mul(1 + (10_000 << 32));
    Some((first.wrapping_add(second) >> 32) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_at_every_place_is_a_digit_or_not_as_the_standard_library_says() {
        for place in 0..8 {
            for byte in 0..=u8::MAX {
                let mut text = *b"09afAF7b";
                text[place] = byte;
                let expected = if byte.is_ascii_hexdigit() { 8 } else { place as u32 };
                assert_eq!(leading_digits(u64::from_le_bytes(text)), expected, "{text:?}");
            }
        }
        assert_eq!(leading_digits(u64::from_le_bytes([0xFF; 8])), 0);
    }

    #[test]
    fn pairs_become_bytes_whatever_follows() {
        for value in [0u32, 0x0123_4567, 0x89AB_CDEF, u32::MAX, 0xFEDC_BA98] {
            for text in [format!("{value:08X}"), format!("{value:08x}")] {
                let word = u64::from_le_bytes(text.as_bytes().try_into().unwrap());
                assert_eq!(bytes(word), value.swap_bytes());
            }
        }
        for byte in 0..=u8::MAX {
            let text = [b'F', b'e', b'9', b'A', byte, byte, byte, byte];
            assert_eq!(bytes(u64::from_le_bytes(text)) & 0xFFFF, 0x9AFE);
        }
    }

    #[test]
    fn six_decimals_are_read_and_nothing_else() {
        let read = |text: &[u8; 8]| six_decimals(u64::from_le_bytes(*text));
        for value in (0..1_000_000).step_by(997).chain([999_999]) {
            let text = format!("{value:06}) ");
            assert_eq!(read(text.as_bytes().try_into().unwrap()), Some(value));
        }
        for place in 0..8 {
            for byte in 0..=u8::MAX {
                let mut text = *b"123456) ";
                let allowed = text[place] == byte || (place < 6 && byte.is_ascii_digit());
                text[place] = byte;
                assert_eq!(read(&text).is_some(), allowed, "{text:?}");
            }
        }
    }
}
