//! Who has logged in: random identifiers in memory, bounded in number and time.

use super::token::TokenDigest;
use axum::http::HeaderMap;
use axum::http::header::COOKIE;
use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, Read};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Name of the cookie. Browsers keep one that begins so only if it came encrypted, and give it to this host alone.
const NAME: &str = "__Host-tertius";

/// Most sessions at once; the oldest one gives way.
const MOST: usize = 64;

/// Time after which somebody has to log in again.
const LONGEST: Duration = Duration::from_secs(12 * 3600);

/// The sessions of a server.
#[derive(Debug, Default)]
pub(super) struct Sessions(Mutex<VecDeque<Session>>);

#[derive(Debug)]
struct Session {
    /// Digest of its identifier, which only the browser knows.
    id: TokenDigest,
    /// The token that opened it; with another one in force it is over.
    token: TokenDigest,
    /// Uptime at which it ends.
    end: Duration,
}

impl Sessions {
    /// Opens a session by `token` at the uptime `now`, and returns the cookie that tells of it.
    ///
    /// # Errors
    /// The system has no random numbers.
    pub fn open(&self, token: TokenDigest, now: Duration) -> io::Result<String> {
        let mut bytes = [0; 32];
        File::open("/dev/urandom")?.read_exact(&mut bytes)?;
        let id: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        let mut sessions = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        sessions.retain(|session| session.end > now);
        if sessions.len() == MOST {
            sessions.pop_front();
        }
        sessions.push_back(Session { id: TokenDigest::of(&id), token, end: now + LONGEST });
        Ok(cookie(&id, LONGEST))
    }

    /// Whether the request belongs to a session that `token` has opened and that is not over at the uptime `now`.
    pub fn admit(&self, headers: &HeaderMap, token: &TokenDigest, now: Duration) -> bool {
        let sessions = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is = |id: &TokenDigest| {
            sessions.iter().any(|it| it.id == *id && it.token == *token && it.end > now)
        };
        ids(headers).any(|id| is(&id))
    }

    /// Ends the session of the request, and returns the cookie that makes the browser forget it.
    pub fn close(&self, headers: &HeaderMap) -> String {
        let mut sessions = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        for id in ids(headers) {
            sessions.retain(|session| session.id != id);
        }
        cookie("", Duration::ZERO)
    }
}

fn cookie(id: &str, age: Duration) -> String {
    let age = age.as_secs();
    format!("{NAME}={id}; Path=/; Max-Age={age}; Secure; HttpOnly; SameSite=Strict")
}

/// Digests of the identifiers that a request bears.
fn ids(headers: &HeaderMap) -> impl Iterator<Item = TokenDigest> {
    let lines = headers.get_all(COOKIE).into_iter().filter_map(|line| line.to_str().ok());
    let pairs =
        lines.flat_map(|line| line.split(';')).filter_map(|pair| pair.trim().split_once('='));
    pairs.filter(|(name, _)| *name == NAME).map(|(_, id)| TokenDigest::of(id))
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderValue;

    fn with(cookie: &str) -> HeaderMap {
        let pair = cookie.split(';').next().expect("the pair comes first");
        let mut headers = HeaderMap::new();
        let value = HeaderValue::from_str(&format!("other=1; {pair}")).expect("it is plain");
        headers.insert(COOKIE, value);
        headers
    }

    #[test]
    fn sessions_end_by_time_by_number_by_leaving_and_with_their_token() {
        let (sessions, token, other) =
            (Sessions::default(), TokenDigest::of("a"), TokenDigest::of("b"));
        let open = |now| sessions.open(token, now).expect("there is chance");
        let now = Duration::from_secs(5);
        let first = open(now);
        for words in ["__Host-tertius=", "; Path=/;", "; Secure", "; HttpOnly", "; SameSite=Strict"]
        {
            assert!(first.contains(words), "{first}");
        }
        assert!(sessions.admit(&with(&first), &token, now));
        assert!(!sessions.admit(&with(&first), &other, now), "the token was replaced");
        assert!(!sessions.admit(&with("__Host-tertius=0"), &token, now));
        assert!(!sessions.admit(&HeaderMap::new(), &token, now));
        assert!(!sessions.admit(&with(&first), &token, now + LONGEST), "it was too long");

        let second = open(now);
        assert_ne!(first, second);
        assert!(sessions.close(&with(&second)).contains("Max-Age=0"));
        assert!(!sessions.admit(&with(&second), &token, now));
        assert!(sessions.admit(&with(&first), &token, now), "others stay");
        (0..MOST).for_each(|_| drop(open(now)));
        assert!(!sessions.admit(&with(&first), &token, now), "the oldest gave way");
        assert_eq!(sessions.0.lock().expect("nobody panicked").len(), MOST);
    }
}
