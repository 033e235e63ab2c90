//! The gateway over HTTP, on a thread of its own: a page for people, its health and its metrics.
//!
//! It only reads what the data path has stored, so the data path never waits for its clients.

mod acts;
mod api;
mod attempts;
mod audience;
mod budget;
mod connections;
mod events;
mod examination;
mod examined;
mod guard;
mod login;
mod page;
mod recordings;
mod sending;
mod sessions;
mod shared;
mod stream;
mod tls;
mod token;
mod trial;

use super::realtime;
use super::telemetry::Recorder;
use super::telemetry::exposition::{CONTENT_TYPE, PLAIN_CONTENT_TYPE, exposition, plain};
pub use attempts::LoginLimits;
use axum::Router;
use axum::extract::{DefaultBodyLimit, State};
use axum::http::header::{ACCEPT, CONTENT_TYPE as TYPE};
use axum::http::{HeaderMap, StatusCode};
use axum::middleware::{from_fn, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
pub use budget::{AT_REST, MEMORY};
use connections::Identities;
use examined::Examined;
pub use shared::{Desk, DeskPlan};
use shared::{Shared, json};
use std::io;
use std::net::SocketAddr;
use std::sync::{Arc, PoisonError, RwLock};
pub use tls::{Identity, IdentityError, TlsFiles};
pub use token::TokenDigest;
use tokio::net::TcpListener;
use tokio::sync::oneshot;

/// Stack of the thread, bytes; what is answered is on the heap.
const STACK_SIZE: usize = 512 * 1024;

/// Most threads that read the event store at once.
const READERS: usize = 2;

/// A running server; it ends when this is dropped.
#[derive(Debug)]
pub struct Server {
    address: SocketAddr,
    identities: Identities,
    _stop: oneshot::Sender<()>,
}

impl Server {
    /// Serves what `recorder` writes, and `desk`, on `listen`, or on a free port if its port is 0: encrypted with an
    /// `identity`, in plain text without one.
    ///
    /// # Errors
    /// The address is in use or not available, or the system provides no thread.
    pub fn start(
        listen: SocketAddr,
        recorder: &Recorder,
        desk: Desk,
        identity: Option<Identity>,
    ) -> io::Result<Self> {
        let identities = Identities::new(RwLock::new(identity));
        let listener = std::net::TcpListener::bind(listen)?;
        connections::bound(&listener)?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let shared = Shared {
            telemetry: recorder.telemetry().clone(),
            clock: recorder.clock().clone(),
            audience: Arc::default(),
            address,
            desk,
            examined: Examined::default(),
            places: Arc::default(),
            sessions: Arc::default(),
            attempts: Arc::default(),
        };
        let accepting = Arc::clone(&identities);
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .max_blocking_threads(READERS)
            .thread_name("http-reader")
            .build()?;
        let (stop, stopped) = oneshot::channel();
        let serve = move || {
            realtime::be_ordinary();
            runtime.spawn(stream::broadcast(shared.clone()));
            runtime.spawn(async move {
                match TcpListener::from_std(listener) {
                    Ok(listener) => connections::accept(listener, router(shared), accepting).await,
                    Err(error) => tracing::warn!("no telemetry over HTTP: {error}"),
                }
            });
            // Ends with an error once the sender is dropped; the runtime takes its tasks along.
            _ = runtime.block_on(stopped);
        };
        std::thread::Builder::new().name("http".to_owned()).stack_size(STACK_SIZE).spawn(serve)?;
        Ok(Self { address, identities, _stop: stop })
    }

    /// Encrypts with `identity` from the next connection on, or not at all.
    pub fn identify(&self, identity: Option<Identity>) {
        *self.identities.write().unwrap_or_else(PoisonError::into_inner) = identity;
    }

    /// Address that the server listens on.
    pub const fn address(&self) -> SocketAddr {
        self.address
    }
}

fn router(shared: Shared) -> Router {
    let acts = Router::new()
        .route("/api/alarms/{incident}/{act}", post(acts::act))
        .route("/api/record", post(acts::record))
        .layer(DefaultBodyLimit::max(acts::LONGEST_ACT));
    let entrance = Router::new()
        .route("/login", get(login::form).post(login::enter))
        .route("/logout", post(login::leave))
        .layer(DefaultBodyLimit::max(login::LONGEST_LOGIN))
        .route_layer(from_fn(guard::only_encrypted));
    let people = Router::new()
        .route("/", get(page::index))
        .route("/assets/{name}", get(page::asset))
        .route("/api/machine", get(api::machine))
        .route("/api/overview", get(api::overview))
        .route("/api/trend/{cylinder}", get(api::trend))
        .route("/api/stream", get(stream::stream))
        .route("/api/alarms", get(events::alarms))
        .route("/api/events", get(events::events))
        .route("/api/export/{name}", get(events::file))
        .route("/api/incidents/{id}", get(events::incident))
        .route("/api/stops/{cylinder}", get(events::stops))
        .route("/api/doctor", get(examination::doctor))
        .route("/api/recordings", get(recordings::list))
        .route("/api/recordings/{name}", get(recordings::archive))
        .layer(from_fn(guard::without_body))
        .merge(acts)
        .layer(from_fn_with_state(shared.clone(), guard::only_known_hosts))
        .merge(entrance);
    // What machines read.
    Router::new()
        .route("/health", get(health))
        .route("/metrics", get(metrics))
        .layer(from_fn(guard::without_body))
        .layer(from_fn_with_state(shared.clone(), guard::only_known_machines))
        .merge(people)
        .layer(from_fn(guard::with_policy))
        .with_state(shared)
}

async fn health(State(shared): State<Shared>) -> Response {
    let report = shared.telemetry.health(shared.clock.uptime());
    let code = if report.is_serving() { StatusCode::OK } else { StatusCode::SERVICE_UNAVAILABLE };
    let mut response = json(&report);
    if response.status() == StatusCode::OK {
        *response.status_mut() = code;
    }
    response
}

async fn metrics(State(shared): State<Shared>, headers: HeaderMap) -> Response {
    let accepted = headers.get(ACCEPT).and_then(|accepted| accepted.to_str().ok());
    let modern = accepted.is_some_and(|accepted| accepted.contains("application/openmetrics-text"));
    match exposition(&shared.telemetry, &*shared.clock) {
        Ok(text) if modern => ([(TYPE, CONTENT_TYPE)], text).into_response(),
        Ok(text) => ([(TYPE, PLAIN_CONTENT_TYPE)], plain(&text)).into_response(),
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, error.to_string()).into_response(),
    }
}
