//! What `tertius doctor` says of this computer, without listening to the bus.

use super::examined::Report;
use super::shared::{Shared, json};
use crate::appliance::doctor::examine;
use crate::appliance::doctor::facts::Logins;
use crate::appliance::doctor::gather::gather;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use std::sync::Arc;
use std::time::Duration;

/// Examinations are at least so far apart, however many ask.
const APART: Duration = Duration::from_secs(60);

pub(super) async fn doctor(State(shared): State<Shared>) -> Response {
    let Some(patient) = shared.desk.plan().patient else {
        return (StatusCode::NOT_FOUND, "nothing is known of this computer\n").into_response();
    };
    let mut examined = Arc::clone(&shared.examined).lock_owned().await;
    let uptime = shared.clock.uptime();
    if let Some((at, report)) = &*examined
        && uptime.saturating_sub(*at) < APART
    {
        return json(report);
    }
    let (clock, telemetry) = (Arc::clone(&shared.clock), Arc::clone(&shared.telemetry));
    let examination = tokio::task::spawn_blocking(move || {
        let mut facts = gather(patient, None, Duration::ZERO);
        let [failures, lockouts] = telemetry.logins();
        facts.host.logins = Some(Ok(Logins { failures, lockouts }));
        let mut findings = examine(&facts);
        // Whoever reads this knows that the page is served, and its address is in use by it.
        findings.retain(|finding| finding.subject != "http");
        let report = Report { at_s: clock.system().as_seconds(), findings };
        let answer = json(&report);
        *examined = Some((uptime, report));
        answer
    });
    examination.await.unwrap_or_else(|_| StatusCode::INTERNAL_SERVER_ERROR.into_response())
}
