//! What the event store has, as JSON: alarms, incidents and events, stops.

use super::connections::Connection;
use super::sending::{body, no_place, no_thread};
use super::shared::{Shared, json};
use crate::appliance::store::{
    AlarmEntry, AlarmOverview, EventKind, ExportFormat, Filter, StoreReader, StoreState, Trouble,
    export,
};
use crate::appliance::telemetry::Telemetry;
use axum::Extension;
use axum::extract::{Path, Query, State};
use axum::http::StatusCode;
use axum::http::header::{CACHE_CONTROL, CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use tertius_core::alarm::Level;
use tertius_core::alarm::status::Mode;
use tertius_core::time::Timestamp;
use tertius_core::verdict::Suspect;

/// The alarm list, and whether it is of now.
#[derive(Debug, Serialize)]
struct Alarms {
    store: StoreState,
    /// Whether acts are allowed to those who have the token.
    acts: bool,
    #[serde(flatten)]
    overview: Option<AlarmOverview>,
}

pub(super) async fn alarms(State(shared): State<Shared>) -> Response {
    let now = shared.clock.system();
    let gated = shared.telemetry.is_in(Mode::Gated);
    let (store, acts) = (shared.store_state(), shared.desk.plan().token.is_some());
    if store.path.is_none() {
        return json(&Alarms { store, acts, overview: None });
    }
    let (telemetry, uptime) = (shared.telemetry.clone(), shared.clock.uptime());
    read(&shared, move |reader| {
        let mut overview = reader.overview(now, gated)?;
        overview.alarms.iter_mut().for_each(|alarm| follow(alarm, &telemetry, uptime));
        Ok(json(&Alarms { store, acts, overview: Some(overview) }))
    })
    .await
}

/// Adds what an alarm's worst quantity is now, while its incident is open.
fn follow(alarm: &mut AlarmEntry, telemetry: &Telemetry, uptime: Duration) {
    let quantity = alarm.quantity.as_deref().filter(|_| alarm.ending.is_none());
    alarm.now_m = alarm
        .cylinder
        .zip(quantity)
        .and_then(|(number, it)| telemetry.newest(number.into(), it, uptime));
}

/// What is searched for, as it stands in an address.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Wanted {
    text: String,
    cylinder: Option<u8>,
    suspect: Option<String>,
    level: Option<String>,
    kind: Option<String>,
    /// Times, s since 1970.
    from: Option<f64>,
    to: Option<f64>,
    before: Option<i64>,
    limit: usize,
}

impl Wanted {
    /// The filter.
    ///
    /// # Errors
    /// What there is no such name for.
    fn filter(self) -> Result<Filter, String> {
        let wrong = |what: &str, name: &str| format!("there is no {what} {name:?}\n");
        let suspect = self.suspect.map(|name| {
            let known = Suspect::ALL.into_iter().find(|suspect| suspect.name() == name);
            known.ok_or_else(|| wrong("suspect", &name))
        });
        let level = self.level.map(|name| {
            let known = Level::ALL.into_iter().find(|level| level.name() == name);
            known.ok_or_else(|| wrong("level", &name))
        });
        let kind = self.kind.map(|name| {
            let known = EventKind::ALL.into_iter().find(|kind| kind.name() == name);
            known.ok_or_else(|| wrong("kind of event", &name))
        });
        let time = |seconds: Option<f64>| {
            let seconds = seconds.filter(|seconds| seconds.is_finite());
            seconds.map(|seconds| Timestamp::from_nanos((seconds * 1e9) as i64))
        };
        Ok(Filter {
            text: self.text,
            cylinder: self.cylinder,
            suspect: suspect.transpose()?,
            level: level.transpose()?,
            kind: kind.transpose()?,
            from: time(self.from),
            to: time(self.to),
            before: self.before,
            limit: self.limit,
        })
    }
}

pub(super) async fn events(State(shared): State<Shared>, Query(wanted): Query<Wanted>) -> Response {
    let now = shared.clock.system();
    match wanted.filter() {
        Ok(filter) => read(&shared, move |reader| Ok(json(&reader.search(&filter, now)?))).await,
        Err(told) => (StatusCode::BAD_REQUEST, told).into_response(),
    }
}

pub(super) async fn incident(State(shared): State<Shared>, Path(id): Path<i64>) -> Response {
    let now = shared.clock.system();
    let (telemetry, uptime) = (shared.telemetry.clone(), shared.clock.uptime());
    read(&shared, move |reader| match reader.incident(id, now)? {
        Some(mut incident) => {
            follow(&mut incident.alarm, &telemetry, uptime);
            Ok(json(&incident))
        }
        None => Ok((StatusCode::NOT_FOUND, "there is no such incident\n").into_response()),
    })
    .await
}

pub(super) async fn stops(State(shared): State<Shared>, Path(cylinder): Path<u8>) -> Response {
    read(&shared, move |reader| Ok(json(&reader.stops(cylinder)?))).await
}

/// The events as a file: `events.csv` or `events.jsonl`.
pub(super) async fn file(
    State(shared): State<Shared>,
    Extension(connection): Extension<Arc<Connection>>,
    Path(name): Path<String>,
    Query(wanted): Query<Wanted>,
) -> Response {
    let (format, kind) = match name.as_str() {
        "events.csv" => (ExportFormat::Csv, "text/csv; charset=utf-8"),
        "events.jsonl" => (ExportFormat::Jsonl, "application/jsonl; charset=utf-8"),
        _ => return (StatusCode::NOT_FOUND, "there is no such file\n").into_response(),
    };
    let filter = match wanted.filter() {
        Ok(filter) => filter,
        Err(told) => return (StatusCode::BAD_REQUEST, told).into_response(),
    };
    let store = match opened(&shared) {
        Ok(path) => path,
        Err(told) => return (StatusCode::NOT_FOUND, told).into_response(),
    };
    let place = match shared.places.exports.place(&connection) {
        Ok(place) => place,
        Err(refusal) => return no_place(refusal),
    };
    let (now, facts) = (shared.clock.system(), shared.telemetry.facts());
    let headers = [
        (CONTENT_TYPE, kind.to_owned()),
        (CACHE_CONTROL, "no-store".to_owned()),
        (CONTENT_DISPOSITION, format!("attachment; filename=\"{name}\"")),
    ];
    let make = move |mut out: &mut dyn Write| {
        let reader = StoreReader::open(&store).map_err(io::Error::other)?;
        // Rows that are damaged are told by the page, too.
        export(&reader, &filter, format, &facts.names, now, &mut out)
            .map(drop)
            .map_err(io::Error::other)
    };
    match body(&connection, place, make) {
        Ok(body) => (headers, body).into_response(),
        Err(error) => no_thread(&error),
    }
}

/// The path of the event store.
///
/// # Errors
/// Why there is none.
fn opened(shared: &Shared) -> Result<PathBuf, String> {
    let StoreState { path, trouble } = shared.store_state();
    path.ok_or_else(|| {
        let told = trouble.unwrap_or_else(|| {
            "nothing is kept: `file = \"FILE\"` in [store] of the configuration makes the gateway keep its \
             events"
                .to_owned()
        });
        told + "\n"
    })
}

/// The answer of `ask`, which may wait for the disk, on a thread for that.
async fn read(
    shared: &Shared,
    ask: impl FnOnce(&StoreReader) -> Result<Response, Trouble> + Send + 'static,
) -> Response {
    let path = match opened(shared) {
        Ok(path) => path,
        Err(told) => return (StatusCode::NOT_FOUND, told).into_response(),
    };
    let answer = tokio::task::spawn_blocking(move || {
        let reader = StoreReader::open(&path)?;
        ask(&reader)
    });
    match answer.await {
        Ok(Ok(response)) => response,
        Ok(Err(trouble)) => {
            (StatusCode::SERVICE_UNAVAILABLE, format!("the event store: {trouble}\n"))
                .into_response()
        }
        Err(_) => {
            (StatusCode::INTERNAL_SERVER_ERROR, "the event store was not read\n").into_response()
        }
    }
}
