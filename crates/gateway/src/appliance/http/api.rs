//! What the page asks for, as JSON.

use super::shared::{Shared, json};
use crate::appliance::telemetry::MachineFacts;
use crate::appliance::telemetry::feed::number;
use crate::appliance::telemetry::trend::{Bin, QUANTITIES, merged};
use axum::extract::{Path, Query, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use tertius_core::time::{Span, Timestamp};

/// Most bins of an answer; a screen has no more columns.
const MOST_BINS: usize = 1200;

/// Longest trend that can be asked for, s: all that is kept.
const LONGEST: u32 = 3600;

/// What does not change while the gateway runs with one configuration.
#[derive(Debug, Serialize)]
struct Machine<'a> {
    version: &'static str,
    #[serde(flatten)]
    facts: &'a MachineFacts,
}

pub(super) async fn machine(State(shared): State<Shared>) -> Response {
    let facts = shared.telemetry.facts();
    json(&Machine { version: env!("CARGO_PKG_VERSION"), facts: &facts })
}

pub(super) async fn overview(State(shared): State<Shared>) -> Response {
    json(&shared.telemetry.overview(shared.clock.uptime(), shared.clock.system()))
}

/// How much of a trend is wanted.
#[derive(Debug, Deserialize)]
pub(super) struct Wanted {
    /// Length, s, of frames' time.
    #[serde(default = "longest")]
    seconds: u32,
}

const fn longest() -> u32 {
    LONGEST
}

/// The trend of a cylinder, column by column.
#[derive(Debug, Serialize)]
struct Trend {
    /// Begins of the bins, s.
    time: Vec<f64>,
    /// Least and largest of each quantity in each bin, m; `null` for none.
    quantities: Vec<Column>,
}

#[derive(Debug, Serialize)]
struct Column {
    name: &'static str,
    least: Vec<Option<f64>>,
    largest: Vec<Option<f64>>,
}

pub(super) async fn trend(
    State(shared): State<Shared>,
    Path(cylinder): Path<usize>,
    Query(wanted): Query<Wanted>,
) -> Response {
    let Some(trend) = shared.telemetry.trend(cylinder) else {
        return (StatusCode::NOT_FOUND, "the machine has no such cylinder\n").into_response();
    };
    let length = Span::from_nanos(i64::from(wanted.seconds.min(LONGEST)) * 1_000_000_000);
    let newest = trend.newest().map_or(Timestamp::default(), |bin| bin.begin);
    let bins = trend.after(newest.after(Span::from_nanos(-length.as_nanos())));
    json(&columns(&merged(&bins, MOST_BINS)))
}

fn columns(bins: &[Bin]) -> Trend {
    let column = |(which, name): (usize, &'static str)| {
        let of = |end: usize| bins.iter().map(|bin| number(bin.ranges[which][end])).collect();
        Column { name, least: of(0), largest: of(1) }
    };
    Trend {
        time: bins.iter().map(|bin| bin.begin.as_seconds()).collect(),
        quantities: QUANTITIES.into_iter().enumerate().map(column).collect(),
    }
}
