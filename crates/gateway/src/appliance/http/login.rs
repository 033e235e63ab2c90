//! The login of those who read from another computer.

use super::connections::Connection;
use super::guard::is_from_here;
use super::page;
use super::shared::Shared;
use super::token::WrongToken;
use super::trial::Trial;
use axum::Extension;
use axum::body::Bytes;
use axum::extract::{Query, State};
use axum::http::header::{CONTENT_SECURITY_POLICY, LOCATION, REFERRER_POLICY, SET_COOKIE};
use axum::http::{HeaderMap, HeaderValue, StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use std::sync::Arc;

/// Most bytes of a login.
pub(super) const LONGEST_LOGIN: usize = 1024;

/// As the whole page's, but a form may be sent to this server.
const POLICY: &str = "default-src 'none'; style-src 'self'; img-src 'self'; base-uri 'none'; form-action 'self'; \
                      frame-ancestors 'none'";

const FORM: &str = include_str!("page/login.html");

/// What the form sends.
#[derive(Debug, Deserialize)]
struct Form {
    token: String,
}

/// `GET /login`: the form.
pub(super) async fn form() -> Response {
    with_form(StatusCode::OK, "")
}

/// `POST /login`: opens a session for who has the token.
pub(super) async fn enter(
    State(shared): State<Shared>,
    Extension(connection): Extension<Arc<Connection>>,
    headers: HeaderMap,
    body: Bytes,
) -> Response {
    if !is_from_here(&headers) {
        return (StatusCode::FORBIDDEN, "this did not come from the gateway's own page\n")
            .into_response();
    }
    let Some(token) = shared.desk.plan().token else {
        return (StatusCode::FORBIDDEN, page::NO_TOKEN).into_response();
    };
    // What a form sends is what stands behind the question mark of an address.
    let query =
        std::str::from_utf8(&body).ok().and_then(|body| format!("/?{body}").parse::<Uri>().ok());
    let given = query.and_then(|uri| Query::<Form>::try_from_uri(&uri).ok());
    let judge = || match given {
        Some(Query(form)) => token.judge(form.token.trim()),
        None => Err(WrongToken::Other),
    };
    match shared.try_token(&connection, judge) {
        Trial::Right => {}
        Trial::Wrong(wrong) => {
            let told = format!("This is not the token{}.", wrong.advice());
            return with_form(StatusCode::UNAUTHORIZED, &told);
        }
        Trial::TooSoon(refusal) => return refusal,
    }
    match shared.sessions.open(token, shared.clock.uptime()) {
        Ok(cookie) => to("/", &cookie),
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, format!("no random numbers: {error}\n"))
            .into_response(),
    }
}

/// `POST /logout`: ends the session.
pub(super) async fn leave(State(shared): State<Shared>, headers: HeaderMap) -> Response {
    if !is_from_here(&headers) {
        return (StatusCode::FORBIDDEN, "this did not come from the gateway's own page\n")
            .into_response();
    }
    to("/login", &shared.sessions.close(&headers))
}

fn to(place: &'static str, cookie: &str) -> Response {
    let mut response = (StatusCode::SEE_OTHER, [(LOCATION, place)]).into_response();
    if let Ok(cookie) = HeaderValue::from_str(cookie) {
        response.headers_mut().insert(SET_COOKIE, cookie);
    }
    response
}

fn with_form(code: StatusCode, trouble: &str) -> Response {
    let mut response = page::html(FORM.replace("TROUBLE", trouble));
    *response.status_mut() = code;
    let headers = response.headers_mut();
    headers.insert(CONTENT_SECURITY_POLICY, HeaderValue::from_static(POLICY));
    // Without a referrer the browser would not say where the form came from either.
    headers.insert(REFERRER_POLICY, HeaderValue::from_static("same-origin"));
    response
}
