//! What everything that answers shares.

use super::attempts::{Attempts, LoginLimits};
use super::audience::Audience;
use super::examined::Examined;
use super::sending::Places;
use super::sessions::Sessions;
use super::token::TokenDigest;
use crate::appliance::doctor::facts::Wanted;
use crate::appliance::store::{StoreHandle, StoreState};
use crate::appliance::telemetry::Telemetry;
use crate::appliance::telemetry::clock::Clock;
use axum::http::StatusCode;
use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE};
use axum::response::{IntoResponse, Response};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, PoisonError, RwLock};

/// Longest answer that is made as a whole, bytes; the longest of the page has a half of it. What is longer is sent in pieces.
pub(super) const LARGEST_ANSWER: usize = 512 * 1024;

/// What is served beside the telemetry.
#[derive(Clone, Debug, Default)]
pub struct Desk {
    /// The event store.
    pub(super) store: Option<StoreHandle>,
    /// Asks the flight recorder for a recording of now.
    pub(super) demand: Arc<AtomicBool>,
    pub(super) plan: Arc<RwLock<DeskPlan>>,
}

/// What a configuration says of the desk; a reload may change it.
#[derive(Clone, Debug, Default)]
pub struct DeskPlan {
    /// Digest of the token that acts need; `None`: there are no acts.
    pub token: Option<TokenDigest>,
    /// What wrong tokens lead to.
    pub logins: LoginLimits,
    /// Folder of the flight recorder; `None`: nothing is recorded.
    pub recordings: Option<PathBuf>,
    /// What the doctor has to know of the configuration; `None`: nothing is examined.
    pub patient: Option<Wanted>,
}

impl Desk {
    /// A desk with what `store` keeps, where people may ask for a recording by `demand`.
    pub fn new(store: StoreHandle, demand: Arc<AtomicBool>) -> Self {
        Self { store: Some(store), demand, ..Self::default() }
    }

    /// Goes by `plan` from now on.
    pub fn follow(&self, plan: DeskPlan) {
        *self.plan.write().unwrap_or_else(PoisonError::into_inner) = plan;
    }

    pub(super) fn plan(&self) -> DeskPlan {
        self.plan.read().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

#[derive(Clone)]
pub(super) struct Shared {
    pub(super) telemetry: Arc<Telemetry>,
    pub(super) clock: Arc<dyn Clock>,
    /// Those who watch the page.
    pub(super) audience: Arc<Audience>,
    pub(super) address: SocketAddr,
    pub(super) desk: Desk,
    pub(super) examined: Examined,
    /// Those who are sent something long.
    pub(super) places: Arc<Places>,
    /// Who has logged in.
    pub(super) sessions: Arc<Sessions>,
    /// Who has tried to.
    pub(super) attempts: Arc<Attempts>,
}

impl Shared {
    pub(super) fn store_state(&self) -> StoreState {
        self.desk.store.as_ref().map(StoreHandle::state).unwrap_or_default()
    }
}

/// `value` as the answer to a request, on a line of its own.
pub(super) fn json(value: &impl serde::Serialize) -> Response {
    match serde_json::to_string(value) {
        Ok(json) if json.len() >= LARGEST_ANSWER => {
            let told = "the answer would be too long; ask for less, or export the events\n";
            (StatusCode::INTERNAL_SERVER_ERROR, told).into_response()
        }
        Ok(json) => {
            let headers = [(CONTENT_TYPE, "application/json"), (CACHE_CONTROL, "no-store")];
            (headers, json + "\n").into_response()
        }
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, error.to_string()).into_response(),
    }
}
