//! Trying a token: whether its address may, and what becomes of it.

use super::attempts::Failed;
use super::connections::Connection;
use super::shared::Shared;
use super::token::{TokenDigest, WrongToken};
use axum::http::header::{AUTHORIZATION, RETRY_AFTER};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use std::time::Duration;
use tracing::warn;

/// What became of a token that somebody gave.
pub(super) enum Trial {
    Right,
    Wrong(WrongToken),
    /// It was not looked at.
    TooSoon(Response),
}

impl Shared {
    /// What `judge` says of a token that came by `connection`; it is asked only if its address may try.
    pub(super) fn try_token(
        &self,
        connection: &Connection,
        judge: impl FnOnce() -> Result<(), WrongToken>,
    ) -> Trial {
        let (from, now) = (connection.peer(), self.clock.uptime());
        if let Some(wait) = self.attempts.wait(from, now) {
            return Trial::TooSoon(too_soon(wait));
        }
        let Err(wrong) = judge() else {
            self.attempts.succeed(from);
            return Trial::Right;
        };
        let Failed { is_out, told } = self.attempts.fail(from, now, self.desk.plan().logins);
        self.telemetry.login_failed(is_out);
        if let Some(told) = told {
            warn!("http: {told}{}", wrong.advice());
        }
        Trial::Wrong(wrong)
    }

    /// As [`Self::try_token`], of the token in `Authorization`; `None` if there is none.
    pub(super) fn try_header(
        &self,
        connection: &Connection,
        headers: &HeaderMap,
        token: &TokenDigest,
    ) -> Option<Trial> {
        headers.get(AUTHORIZATION)?;
        Some(self.try_token(connection, || token.judge_header(headers)))
    }
}

fn too_soon(wait: Duration) -> Response {
    let seconds = wait.as_secs() + 1;
    let told = format!("too many wrong tokens; try again in {seconds} s\n");
    (StatusCode::TOO_MANY_REQUESTS, [(RETRY_AFTER, seconds.to_string())], told).into_response()
}
