//! What people do with alarms. No act changes a frame on the bus or mutes a detector.

use super::connections::Connection;
use super::guard::is_from_here;
use super::shared::Shared;
use super::trial::Trial;
use crate::alarm_list::ActKind;
use crate::appliance::store::{ActError, AlarmAct};
use axum::Extension;
use axum::body::Bytes;
use axum::extract::{Path, State};
use axum::http::header::{CONTENT_TYPE, WWW_AUTHENTICATE};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tertius_core::time::Span;

/// Most bytes of an act.
pub(super) const LONGEST_ACT: usize = 8192;

/// Time within which the store has to answer.
const PATIENCE: Duration = Duration::from_secs(4);

/// An act, as the page sends it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ActForm {
    who: String,
    #[serde(default)]
    note: String,
    /// How long a shelving lasts.
    #[serde(default)]
    minutes: u32,
}

/// `POST /api/alarms/INCIDENT/acknowledge`, `shelve` or `unshelve`.
pub(super) async fn act(
    State(shared): State<Shared>,
    Path((incident, name)): Path<(i64, String)>,
    Extension(connection): Extension<Arc<Connection>>,
    headers: HeaderMap,
    body: Bytes,
) -> Response {
    if let Some(refusal) = refusal(&shared, &connection, &headers) {
        return refusal;
    }
    let told: ActForm = match serde_json::from_slice(&body) {
        Ok(told) => told,
        Err(error) => return (StatusCode::BAD_REQUEST, format!("{error}\n")).into_response(),
    };
    let now = shared.clock.system();
    let kind = match name.as_str() {
        "acknowledge" => ActKind::Acknowledge,
        "shelve" => {
            let length = Span::from_nanos(i64::from(told.minutes) * 60_000_000_000);
            ActKind::Shelve(now.after(length))
        }
        "unshelve" => ActKind::Unshelve,
        _ => return (StatusCode::NOT_FOUND, "there is no such act\n").into_response(),
    };
    let Some(store) = &shared.desk.store else {
        return answer(&ActError::Unavailable("it is off".to_owned()));
    };
    let act = AlarmAct::new(incident, kind, now, [&told.who, &told.note]);
    match act.and_then(|act| store.act(act)) {
        Ok(answered) => match tokio::time::timeout(PATIENCE, answered).await {
            Ok(Ok(Ok(()))) => StatusCode::NO_CONTENT.into_response(),
            Ok(Ok(Err(error))) => answer(&error),
            Ok(Err(_)) | Err(_) => answer(&ActError::Busy),
        },
        Err(error) => answer(&error),
    }
}

/// `POST /api/record`: a recording of the last frames, as SIGUSR1 asks for it.
pub(super) async fn record(
    State(shared): State<Shared>,
    Extension(connection): Extension<Arc<Connection>>,
    headers: HeaderMap,
) -> Response {
    if let Some(refusal) = refusal(&shared, &connection, &headers) {
        return refusal;
    }
    if shared.desk.plan().recordings.is_none() {
        let told =
            "nothing is recorded: `folder` in [recorder] of the configuration says where to\n";
        return (StatusCode::NOT_FOUND, told).into_response();
    }
    shared.desk.demand.store(true, Ordering::Relaxed);
    StatusCode::ACCEPTED.into_response()
}

fn answer(error: &ActError) -> Response {
    let code = match error {
        ActError::Name | ActError::Reason | ActError::Note => StatusCode::BAD_REQUEST,
        ActError::Unknown => StatusCode::NOT_FOUND,
        ActError::Refused(_) => StatusCode::CONFLICT,
        ActError::Busy | ActError::Unavailable(_) => StatusCode::SERVICE_UNAVAILABLE,
    };
    (code, format!("{error}\n")).into_response()
}

/// Why a request is not admitted: only those of this page are, by people who have the token. A page from elsewhere has
/// neither: it can send no header of its own, and no JSON, without asking first, and nothing here answers that question.
fn refusal(shared: &Shared, connection: &Connection, headers: &HeaderMap) -> Option<Response> {
    let refused = |code: StatusCode, told: &'static str| Some((code, told).into_response());
    if !is_from_here(headers) {
        return refused(StatusCode::FORBIDDEN, "this did not come from the gateway's own page\n");
    }
    let json = headers.get(CONTENT_TYPE).is_some_and(|kind| kind.as_bytes() == b"application/json");
    if !json {
        return refused(StatusCode::UNSUPPORTED_MEDIA_TYPE, "an act is application/json\n");
    }
    let Some(token) = &shared.desk.plan().token else {
        let told = "acts are off: `tertius token` makes a token, whose digest belongs into [http] of the \
                    configuration\n";
        return refused(StatusCode::FORBIDDEN, told);
    };
    match shared.try_header(connection, headers, token) {
        Some(Trial::Right) => None,
        Some(Trial::TooSoon(refusal)) => Some(refusal),
        trial @ (Some(Trial::Wrong(_)) | None) => {
            let header = [(WWW_AUTHENTICATE, HeaderValue::from_static("Bearer"))];
            let advice = if let Some(Trial::Wrong(wrong)) = trial { wrong.advice() } else { "" };
            let told = format!("the token is missing or wrong{advice}\n");
            Some((StatusCode::UNAUTHORIZED, header, told).into_response())
        }
    }
}
