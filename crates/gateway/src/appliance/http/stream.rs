//! Server-sent events: the overview and the newest bins of the trends, to everybody who watches.

use super::audience::Pieces;
use super::connections::Connection;
use super::sending::no_place;
use super::shared::Shared;
use crate::appliance::telemetry::feed::{PERIOD, TrendFeed, TrendRow};
use axum::Extension;
use axum::body::{Body, Bytes};
use axum::extract::State;
use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE};
use axum::response::{IntoResponse, Response};
use std::sync::Arc;

pub(super) async fn stream(
    State(shared): State<Shared>,
    Extension(connection): Extension<Arc<Connection>>,
) -> Response {
    let events = match shared.audience.join(Arc::clone(&connection)) {
        Ok(events) => events,
        Err(refusal) => return no_place(refusal),
    };
    let headers = [(CONTENT_TYPE, "text/event-stream"), (CACHE_CONTROL, "no-store")];
    (headers, Body::new(Pieces::of(events, connection))).into_response()
}

/// Sends the news to the audience, once a period.
pub(super) async fn broadcast(shared: Shared) {
    let mut period = tokio::time::interval(PERIOD);
    let mut feed = TrendFeed::default();
    loop {
        period.tick().await;
        let bins = feed.newest(&shared.telemetry);
        shared.audience.send(|| event(&shared, &bins));
    }
}

/// One event of each kind: `overview`, and `bins` with `[[cylinder, time, [least, largest, …]], …]`.
fn event(shared: &Shared, rows: &[TrendRow]) -> Bytes {
    let overview = shared.telemetry.overview(shared.clock.uptime(), shared.clock.system());
    let json = |value: serde_json::Result<String>| value.unwrap_or_else(|_| "null".to_owned());
    let overview = json(serde_json::to_string(&overview));
    let rows = json(serde_json::to_string(rows));
    Bytes::from(format!("event: overview\ndata: {overview}\n\nevent: bins\ndata: {rows}\n\n"))
}
