//! The gateway's telemetry over HTTP, on a thread of its own.
//!
//! It only reads what the data path has stored, so the data path never waits for its clients.

use super::realtime;
use super::telemetry::clock::Clock;
use super::telemetry::exposition::{CONTENT_TYPE, exposition};
use super::telemetry::{Recorder, Telemetry};
use axum::Router;
use axum::extract::{Request, State};
use axum::http::header::{CACHE_CONTROL, CONTENT_LENGTH, CONTENT_TYPE as TYPE, TRANSFER_ENCODING};
use axum::http::{HeaderValue, StatusCode};
use axum::middleware::{Next, from_fn};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use hyper::server::conn::http1;
use hyper_util::rt::TokioIo;
use hyper_util::service::TowerToHyperService;
use std::collections::VecDeque;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::oneshot;
use tokio::task::AbortHandle;

/// Most connections at once; the oldest one gives way. An honest one lasts for milliseconds.
const CONNECTIONS: usize = 16;

/// Time limit from the opening of a connection to the last byte of its answer.
const TIME_LIMIT: Duration = Duration::from_secs(5);

/// Most bytes of request line and headers together; the least that the parser works with.
const HEAD_SIZE: usize = 8192;
const HEADERS: usize = 64;

/// Pause after a connection that could not be accepted, for example for lack of file descriptors.
const PAUSE: Duration = Duration::from_millis(100);

/// Stack of the thread, bytes; a text of metrics is on the heap.
const STACK_SIZE: usize = 512 * 1024;

const OVERVIEW: &str = "tertius, the gateway's own state\n\
                        /health   whether it works and what it knows, as JSON\n\
                        /metrics  all of its counts, for Prometheus\n";

/// A running server; it ends when this is dropped.
#[derive(Debug)]
pub struct Server {
    address: SocketAddr,
    _stop: oneshot::Sender<()>,
}

impl Server {
    /// Serves what `recorder` writes on `listen`, or on a free port if its port is 0.
    ///
    /// # Errors The address is in use or not available, or the system provides no thread.
    pub fn start(listen: SocketAddr, recorder: &Recorder) -> io::Result<Self> {
        let listener = std::net::TcpListener::bind(listen)?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let shared =
            Shared { telemetry: recorder.telemetry().clone(), clock: recorder.clock().clone() };
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let (stop, stopped) = oneshot::channel();
        let serve = move || {
            realtime::be_ordinary();
            runtime.spawn(async move {
                match TcpListener::from_std(listener) {
                    Ok(listener) => accept(listener, router(shared)).await,
                    Err(error) => tracing::warn!("no telemetry over HTTP: {error}"),
                }
            });
            // Ends with an error once the sender is dropped; the runtime takes its tasks along.
            _ = runtime.block_on(stopped);
        };
        std::thread::Builder::new().name("http".to_owned()).stack_size(STACK_SIZE).spawn(serve)?;
        Ok(Self { address, _stop: stop })
    }

    /// Address that the server listens on.
    pub const fn address(&self) -> SocketAddr {
        self.address
    }
}

#[derive(Clone)]
struct Shared {
    telemetry: Arc<Telemetry>,
    clock: Arc<dyn Clock>,
}

fn router(shared: Shared) -> Router {
    Router::new()
        .route("/", get(OVERVIEW))
        .route("/health", get(health))
        .route("/metrics", get(metrics))
        .layer(from_fn(without_body))
        .with_state(shared)
}

async fn health(State(shared): State<Shared>) -> Response {
    let report = shared.telemetry.health(shared.clock.uptime());
    let code = if report.is_serving() { StatusCode::OK } else { StatusCode::SERVICE_UNAVAILABLE };
    match serde_json::to_string(&report) {
        Ok(json) => {
            let headers = [(TYPE, "application/json"), (CACHE_CONTROL, "no-store")];
            (code, headers, json + "\n").into_response()
        }
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, error.to_string()).into_response(),
    }
}

async fn metrics(State(shared): State<Shared>) -> Response {
    match exposition(&shared.telemetry, &*shared.clock) {
        Ok(text) => ([(TYPE, CONTENT_TYPE)], text).into_response(),
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, error.to_string()).into_response(),
    }
}

/// Refuses requests with a body, which nothing here takes.
async fn without_body(request: Request, next: Next) -> Response {
    let headers = request.headers();
    let empty = headers.get(CONTENT_LENGTH).is_none_or(|length| length == HeaderValue::from(0));
    if empty && !headers.contains_key(TRANSFER_ENCODING) {
        return next.run(request).await;
    }
    (StatusCode::PAYLOAD_TOO_LARGE, "a request here has no body\n").into_response()
}

async fn accept(listener: TcpListener, router: Router) {
    let mut connections: VecDeque<AbortHandle> = VecDeque::with_capacity(CONNECTIONS);
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(PAUSE).await;
            continue;
        };
        connections.retain(|connection| !connection.is_finished());
        if connections.len() == CONNECTIONS
            && let Some(oldest) = connections.pop_front()
        {
            oldest.abort();
        }
        let connection = tokio::spawn(answer(stream, router.clone()));
        connections.push_back(connection.abort_handle());
    }
}

/// Serves one request. Errors concern the client alone.
async fn answer(stream: TcpStream, router: Router) {
    let connection = http1::Builder::new()
        .keep_alive(false)
        .max_buf_size(HEAD_SIZE)
        .max_headers(HEADERS)
        .header_read_timeout(None)
        .serve_connection(TokioIo::new(stream), TowerToHyperService::new(router));
    _ = tokio::time::timeout(TIME_LIMIT, connection).await;
}
