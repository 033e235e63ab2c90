//! The token that acts need, of which the configuration knows only the digest.

use axum::http::HeaderMap;
use axum::http::header::AUTHORIZATION;
use sha2::{Digest, Sha256};
use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

/// SHA-256 of a token. Tokens are random, so that no slower function is needed.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct TokenDigest([u8; 32]);

impl TokenDigest {
    /// The digest of `token`.
    pub fn of(token: &str) -> Self {
        Self(Sha256::digest(token.as_bytes()).into())
    }

    /// Whether it is that of `token`.
    pub(super) fn is_of(&self, token: &str) -> bool {
        // All bytes are compared, wherever the first difference is.
        Self::of(token).0.iter().zip(&self.0).fold(0, |sum, (a, b)| sum | (a ^ b)) == 0
    }

    /// Whether the request has the token, as `Authorization: Bearer TOKEN`.
    pub(super) fn admits(&self, headers: &HeaderMap) -> bool {
        let value = headers.get(AUTHORIZATION).and_then(|value| value.to_str().ok());
        let token = value.and_then(|value| value.strip_prefix("Bearer "));
        token.is_some_and(|token| self.is_of(token.trim()))
    }
}

impl FromStr for TokenDigest {
    type Err = ();

    /// Reads 64 hexadecimal digits.
    fn from_str(text: &str) -> Result<Self, ()> {
        let digits: Vec<u32> =
            text.chars().map(|c| c.to_digit(16)).collect::<Option<_>>().ok_or(())?;
        let bytes: Vec<u8> =
            digits.chunks_exact(2).map(|pair| (pair[0] << 4 | pair[1]) as u8).collect();
        if digits.len() != 64 {
            return Err(());
        }
        bytes.try_into().map(Self).map_err(drop)
    }
}

impl Display for TokenDigest {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// Shows nothing by which tokens could be tried.
impl fmt::Debug for TokenDigest {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str("TokenDigest")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderValue;

    #[test]
    fn only_the_token_itself_is_admitted() {
        // As `printf %s test | sha256sum` has it.
        let text = "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08";
        let digest: TokenDigest = text.parse().expect("64 digits");
        assert_eq!((digest, digest.to_string().as_str()), (TokenDigest::of("test"), text));
        let admits = |value: &'static str| {
            let mut headers = HeaderMap::new();
            headers.insert(AUTHORIZATION, HeaderValue::from_static(value));
            digest.admits(&headers)
        };
        assert!(admits("Bearer test"));
        for value in
            ["", "test", "Bearer ", "Bearer tes", "Bearer test2", "Basic test", "bearer test"]
        {
            assert!(!admits(value), "{value}");
        }
        assert!(!digest.admits(&HeaderMap::new()));
        for wrong in ["", "9f", "zz", &text[1..], &format!("{text}00")] {
            assert_eq!(wrong.parse::<TokenDigest>(), Err(()));
        }
    }
}
