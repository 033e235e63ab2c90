//! The token that acts need, of which the configuration knows only the digest.

use axum::http::HeaderMap;
use axum::http::header::AUTHORIZATION;
use sha2::{Digest, Sha256};
use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

/// SHA-256 of a token. Tokens are random, so that no slower function is needed.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct TokenDigest([u8; 32]);

/// Why a token is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WrongToken {
    /// It could be guessed, so that it is refused whatever the configuration has.
    Short,
    /// It has another digest, or there is none.
    Other,
}

impl TokenDigest {
    /// Random bytes of a token, which is written in hexadecimal: 128 bits.
    pub const TOKEN_BYTES: usize = 16;

    /// The digest of `token`.
    pub fn of(token: &str) -> Self {
        Self(Sha256::digest(token.as_bytes()).into())
    }

    /// Whether it is that of `token`, which has 128 bits.
    pub(super) fn judge(&self, token: &str) -> Result<(), WrongToken> {
        // Asked first and of the token alone: the answer is the same whatever the right one is.
        if token.chars().count() < 2 * Self::TOKEN_BYTES {
            return Err(WrongToken::Short);
        }
        // All bytes are compared, wherever the first difference is.
        match Self::of(token).0.iter().zip(&self.0).fold(0, |sum, (a, b)| sum | (a ^ b)) {
            0 => Ok(()),
            _ => Err(WrongToken::Other),
        }
    }

    /// Whether the request has the token, as `Authorization: Bearer TOKEN`.
    pub(super) fn judge_header(&self, headers: &HeaderMap) -> Result<(), WrongToken> {
        let value = headers.get(AUTHORIZATION).and_then(|value| value.to_str().ok());
        let token = value.and_then(|value| value.strip_prefix("Bearer "));
        token.map_or(Err(WrongToken::Other), |token| self.judge(token.trim()))
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

impl WrongToken {
    /// What is added to the refusal and to the log.
    pub(super) const fn advice(self) -> &'static str {
        match self {
            Self::Short => {
                "; a token shorter than 128 bits is never accepted: make one with `tertius token`"
            }
            Self::Other => "",
        }
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
        // As `printf %s 0123456789abcdef0123456789abcdef | sha256sum` has it.
        let text = "3eb1bd439947eb762998e566ccc2e099c791118b2f40579cc4f7da2b5061b7f9";
        let digest: TokenDigest = text.parse().expect("64 digits");
        let token = "0123456789abcdef0123456789abcdef";
        assert_eq!((digest, digest.to_string().as_str()), (TokenDigest::of(token), text));
        let judge = |value: &str| {
            let mut headers = HeaderMap::new();
            headers.insert(AUTHORIZATION, HeaderValue::from_str(value).expect("it is plain"));
            digest.judge_header(&headers)
        };
        assert_eq!(judge(&format!("Bearer {token}")), Ok(()));
        let short = |value: String| (value, WrongToken::Short);
        let other = |value: String| (value, WrongToken::Other);
        for (value, wrong) in [
            short("Bearer ".to_owned()),
            short("Bearer test".to_owned()),
            short(format!("Bearer {}", &token[1..])),
            other(format!("Bearer {token}0")),
            other(format!("Bearer 1{}", &token[1..])),
            other(token.to_owned()),
            other(format!("Basic {token}")),
            other(format!("bearer {token}")),
            other(String::new()),
        ] {
            assert_eq!(judge(&value), Err(wrong), "{value}");
        }
        assert_eq!(digest.judge_header(&HeaderMap::new()), Err(WrongToken::Other));
        for wrong in ["", "9f", "zz", &text[1..], &format!("{text}00")] {
            assert_eq!(wrong.parse::<TokenDigest>(), Err(()));
        }
    }

    #[test]
    fn a_token_that_can_be_guessed_is_refused_even_if_it_is_the_configured_one() {
        let whole = "é".repeat(2 * TokenDigest::TOKEN_BYTES);
        assert_eq!(TokenDigest::of(&whole).judge(&whole), Ok(()));
        for token in ["", "test", &"é".repeat(2 * TokenDigest::TOKEN_BYTES - 1)] {
            assert_eq!(TokenDigest::of(token).judge(token), Err(WrongToken::Short), "{token}");
        }
    }
}
