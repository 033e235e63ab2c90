//! What every request has to pass, and what every answer says to the browser.

use super::connections::Connection;
use super::page::NO_TOKEN;
use super::shared::Shared;
use super::trial::Trial;
use axum::extract::{Request, State};
use axum::http::header::{
    CONTENT_LENGTH, CONTENT_SECURITY_POLICY, HOST, HeaderName, LOCATION, ORIGIN, REFERRER_POLICY,
    STRICT_TRANSPORT_SECURITY, TRANSFER_ENCODING, X_CONTENT_TYPE_OPTIONS, X_FRAME_OPTIONS,
};
use axum::http::uri::Authority;
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::net::IpAddr;
use std::sync::Arc;

/// Nothing but what comes from the gateway itself, no frames, no inline script or style.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; \
                      img-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Headers of every answer to people.
const HEADERS: [(HeaderName, &str); 6] = [
    (CONTENT_SECURITY_POLICY, POLICY),
    (X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (X_FRAME_OPTIONS, "DENY"),
    (REFERRER_POLICY, "no-referrer"),
    (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
];

const FAR: &str = "the page is served on this computer only, because what is sent here is not encrypted.\n\
                   From another one:\n  ssh -L 9481:127.0.0.1:9481 BOX     and then open http://127.0.0.1:9481/\n\
                   or give the gateway a certificate (http.certificate, http.key), or let a proxy with one \
                   (nginx, Caddy) pass it on to http.listen on a loopback address.\n";

/// Refuses requests with a body, which nothing here takes.
pub(super) async fn without_body(request: Request, next: Next) -> Response {
    let headers = request.headers();
    let empty = headers.get(CONTENT_LENGTH).is_none_or(|length| length == HeaderValue::from(0));
    if empty && !headers.contains_key(TRANSFER_ENCODING) {
        return next.run(request).await;
    }
    (StatusCode::PAYLOAD_TOO_LARGE, "a request here has no body\n").into_response()
}

/// Refuses requests that may not read. On an address of this computer alone these are those to another host: a page
/// from elsewhere whose name was made to point here (DNS rebinding) would be of the same origin as ours, but its
/// requests bear its own name.
pub(super) async fn only_known_hosts(
    State(shared): State<Shared>,
    request: Request,
    next: Next,
) -> Response {
    if !shared.address.ip().is_loopback() {
        return match is_encrypted(&request) {
            true => only_known_people(&shared, request, next).await,
            false => (StatusCode::FORBIDDEN, FAR).into_response(),
        };
    }
    match misdirected(&shared, request.headers()) {
        Some(refusal) => refusal,
        None => next.run(request).await,
    }
}

/// As [`only_known_hosts`] for what machines read without a login: on another address a monitoring system may know this
/// computer by any name.
pub(super) async fn only_known_machines(
    State(shared): State<Shared>,
    request: Request,
    next: Next,
) -> Response {
    match misdirected(&shared, request.headers()) {
        Some(refusal) if shared.address.ip().is_loopback() => refusal,
        _ => next.run(request).await,
    }
}

/// The refusal of a request to another host; `None` if it is to this one.
fn misdirected(shared: &Shared, headers: &HeaderMap) -> Option<Response> {
    let host = headers.get(HOST).and_then(|host| host.to_str().ok());
    if host.is_some_and(is_own) {
        return None;
    }
    let told =
        format!("this gateway is http://{}/; it does not answer to another name\n", shared.address);
    Some((StatusCode::MISDIRECTED_REQUEST, told).into_response())
}

/// Refuses a login on a connection that others can read.
pub(super) async fn only_encrypted(request: Request, next: Next) -> Response {
    if is_encrypted(&request) {
        return next.run(request).await;
    }
    (StatusCode::FORBIDDEN, "there is a login over https only\n").into_response()
}

fn is_encrypted(request: &Request) -> bool {
    let connection = request.extensions().get::<Arc<Connection>>();
    connection.is_some_and(|connection| connection.is_encrypted())
}

/// Refuses requests of those who are not logged in and have no token. The cookie of a login is not given to a page of
/// another name, so that the name need not be known here.
async fn only_known_people(shared: &Shared, request: Request, next: Next) -> Response {
    let (headers, path) = (request.headers(), request.uri().path());
    // Files of the program, which are public.
    if path.starts_with("/assets/") {
        return next.run(request).await;
    }
    let Some(token) = shared.desk.plan().token else {
        return (StatusCode::FORBIDDEN, NO_TOKEN).into_response();
    };
    if shared.sessions.admit(headers, &token, shared.clock.uptime()) {
        return next.run(request).await;
    }
    let connection = request.extensions().get::<Arc<Connection>>();
    let trial = connection.and_then(|connection| shared.try_header(connection, headers, &token));
    let told = match trial {
        Some(Trial::Right) => return next.run(request).await,
        Some(Trial::TooSoon(refusal)) => return refusal,
        Some(Trial::Wrong(wrong)) => format!("the token is wrong{}\n", wrong.advice()),
        None => "log in at /login\n".to_owned(),
    };
    if path == "/" {
        return (StatusCode::SEE_OTHER, [(LOCATION, "/login")]).into_response();
    }
    (StatusCode::UNAUTHORIZED, told).into_response()
}

/// Whether a request comes from our own page, or from no page at all.
pub(super) fn is_from_here(headers: &HeaderMap) -> bool {
    let text = |name: HeaderName| headers.get(name).map(|value| value.to_str().unwrap_or_default());
    let site = text(HeaderName::from_static("sec-fetch-site"));
    let host = text(HOST).unwrap_or_default();
    let own = |origin: &str| {
        let rest = origin.strip_prefix("http://").or(origin.strip_prefix("https://"));
        rest.is_some_and(|rest| rest.eq_ignore_ascii_case(host))
    };
    text(ORIGIN).is_none_or(own) && site.is_none_or(|site| site == "same-origin")
}

/// Whether a Host header names a loopback address or `localhost`. The port may be that of a tunnel.
fn is_own(host: &str) -> bool {
    let Ok(authority) = host.parse::<Authority>() else { return false };
    if authority.as_str().contains('@') {
        return false;
    }
    let name = authority.host().trim_start_matches('[').trim_end_matches(']');
    name.eq_ignore_ascii_case("localhost")
        || name.parse::<IpAddr>().is_ok_and(|address| address.is_loopback())
}

/// For how long a browser comes by https only once it has, s: a month, since a box may lose its certificate.
const HSTS: &str = "max-age=2592000";

/// Adds what the browser has to know.
pub(super) async fn with_policy(request: Request, next: Next) -> Response {
    let encrypted = is_encrypted(&request);
    let mut response = next.run(request).await;
    if encrypted {
        let hsts = HeaderValue::from_static(HSTS);
        response.headers_mut().insert(STRICT_TRANSPORT_SECURITY, hsts);
    }
    for (name, value) in HEADERS {
        response.headers_mut().entry(name).or_insert(HeaderValue::from_static(value));
    }
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_loopback_names_are_its_own() {
        for host in ["127.0.0.1:9481", "localhost", "LOCALHOST:8080", "[::1]:9481", "127.0.0.2"] {
            assert!(is_own(host), "{host}");
        }
        let others = [
            "",
            "evil.example",
            "localhost.evil.example",
            "127.0.0.1.evil.example:9481",
            "me@localhost",
            "192.168.1.2:9481",
            "0.0.0.0",
            "[::]",
            "local host",
        ];
        for host in others {
            assert!(!is_own(host), "{host}");
        }
    }
}
