//! The words of a line.

/// The first word of `text` and what follows it; both empty where there is none.
pub fn token(text: &[u8]) -> (&[u8], &[u8]) {
    let start = text.iter().position(|byte| !is_blank(byte)).unwrap_or(text.len());
    let text = &text[start..];
    text.split_at(text.iter().position(is_blank).unwrap_or(text.len()))
}

/// Whether a byte stands between words.
pub fn is_blank(byte: &u8) -> bool {
    matches!(byte, b' ' | b'\t')
}
