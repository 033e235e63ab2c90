//! The connections of the server: how many there are, and how long each lasts.

use super::tls::Identity;
use axum::Router;
use axum::body::Body;
use axum::http::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{Service, service_fn};
use hyper_util::rt::TokioIo;
use hyper_util::service::TowerToHyperService;
use std::collections::VecDeque;
use std::net::IpAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock, PoisonError, RwLock};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::AbortHandle;
use tokio_rustls::TlsAcceptor;

/// Most connections at once, those of streams apart; the oldest one gives way. An honest one lasts for milliseconds.
const CONNECTIONS: usize = 16;

/// Time limit from the opening of a connection to the last byte of its answer, unless it is a stream.
const TIME_LIMIT: Duration = Duration::from_secs(5);

/// Time limit of a handshake, before that.
const HANDSHAKE_LIMIT: Duration = Duration::from_secs(3);

/// Time limit of an answer that takes long, such as a recording over a slow link.
const LONG_LIMIT: Duration = Duration::from_secs(120);

/// Most bytes of request line and headers together; the least that the parser works with.
const HEAD_SIZE: usize = 8192;
const HEADERS: usize = 64;

/// Pause after a connection that could not be accepted, for example for lack of file descriptors.
const PAUSE: Duration = Duration::from_millis(100);

/// A connection, as its request sees it.
#[derive(Debug)]
pub(super) struct Connection {
    /// Address of who has opened it.
    peer: IpAddr,
    /// Whether its answer is a stream, which lasts.
    streams: AtomicBool,
    /// Whether its answer takes long.
    takes_long: AtomicBool,
    /// Whether what is sent on it is encrypted.
    encrypted: AtomicBool,
    /// Ends it.
    abort: OnceLock<AbortHandle>,
}

impl Connection {
    fn new(peer: IpAddr) -> Self {
        Self {
            peer,
            streams: AtomicBool::default(),
            takes_long: AtomicBool::default(),
            encrypted: AtomicBool::default(),
            abort: OnceLock::default(),
        }
    }

    /// Address of who has opened it.
    pub const fn peer(&self) -> IpAddr {
        self.peer
    }

    /// Notes that the answer is a stream; whoever feeds it ends the connection.
    pub fn becomes_stream(&self) {
        self.streams.store(true, Ordering::Relaxed);
    }

    /// Notes that the answer takes long.
    pub fn takes_long(&self) {
        self.takes_long.store(true, Ordering::Relaxed);
    }

    /// Whether what is sent on it is encrypted.
    pub fn is_encrypted(&self) -> bool {
        self.encrypted.load(Ordering::Relaxed)
    }

    /// Ends the connection at once, whatever it still has to send.
    pub fn end(&self) {
        if let Some(abort) = self.abort.get() {
            abort.abort();
        }
    }

    fn is_over(&self) -> bool {
        self.abort.get().is_none_or(AbortHandle::is_finished)
    }

    fn is_stream(&self) -> bool {
        self.streams.load(Ordering::Relaxed)
    }
}

/// The identity of the server, which a reload may change; `None`: it does not encrypt.
pub(super) type Identities = Arc<RwLock<Option<Identity>>>;

/// Accepts connections until the task is dropped.
pub(super) async fn accept(listener: TcpListener, router: Router, identities: Identities) {
    let mut connections: VecDeque<Arc<Connection>> = VecDeque::with_capacity(CONNECTIONS);
    loop {
        let Ok((stream, peer)) = listener.accept().await else {
            tokio::time::sleep(PAUSE).await;
            continue;
        };
        // Streams are counted where they are fed.
        connections.retain(|connection| !(connection.is_over() || connection.is_stream()));
        if connections.len() == CONNECTIONS
            && let Some(oldest) = connections.pop_front()
        {
            oldest.end();
        }
        let connection = Arc::new(Connection::new(peer.ip()));
        let identity = identities.read().unwrap_or_else(PoisonError::into_inner).clone();
        let answer = answer(stream, identity, router.clone(), Arc::clone(&connection));
        let task = tokio::spawn(answer);
        // The runtime has one thread: the task does not begin before this is set.
        _ = connection.abort.set(task.abort_handle());
        connections.push_back(connection);
    }
}

/// Serves one request, after the handshake if there is an `identity`. Errors concern the client alone.
async fn answer(
    stream: TcpStream,
    identity: Option<Identity>,
    router: Router,
    connection: Arc<Connection>,
) {
    let Some(identity) = identity else { return serve(stream, router, connection).await };
    let handshake = TlsAcceptor::from(identity.config).accept(stream);
    if let Ok(Ok(stream)) = tokio::time::timeout(HANDSHAKE_LIMIT, handshake).await {
        connection.encrypted.store(true, Ordering::Relaxed);
        serve(stream, router, connection).await;
    }
}

/// Serves one request that comes by `stream`.
async fn serve<S: AsyncRead + AsyncWrite + Unpin>(
    stream: S,
    router: Router,
    connection: Arc<Connection>,
) {
    let own = Arc::clone(&connection);
    let service = service_fn(move |request: Request<Incoming>| {
        let mut request = request.map(Body::new);
        request.extensions_mut().insert(Arc::clone(&own));
        TowerToHyperService::new(router.clone()).call(request)
    });
    let served = http1::Builder::new()
        .keep_alive(false)
        .max_buf_size(HEAD_SIZE)
        .max_headers(HEADERS)
        .header_read_timeout(None)
        .serve_connection(TokioIo::new(stream), service);
    let mut served = std::pin::pin!(served);
    let in_time = tokio::time::timeout(TIME_LIMIT, served.as_mut()).await;
    if in_time.is_ok() {
        return;
    }
    if connection.is_stream() {
        _ = served.await;
    } else if connection.takes_long.load(Ordering::Relaxed) {
        _ = tokio::time::timeout(LONG_LIMIT - TIME_LIMIT, served).await;
    }
}
