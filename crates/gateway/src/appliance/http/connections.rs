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
use nix::sys::socket::{setsockopt, sockopt};
use std::cmp::Reverse;
use std::collections::VecDeque;
use std::io;
use std::net::{IpAddr, Ipv6Addr};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock, PoisonError, RwLock};
use std::time::{Duration, Instant};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::AbortHandle;
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::ServerConnection;

/// Most connections at once, those of streams apart; the oldest one gives way. An honest one lasts for milliseconds.
pub(super) const CONNECTIONS: usize = 16;

/// Places that one address may hold of `places`: half, so that one reader cannot keep all others out.
pub(super) const fn share(places: usize) -> usize {
    places / 2
}

/// Time limit from the opening of a connection to the last byte of its answer, unless it is a stream.
const TIME_LIMIT: Duration = Duration::from_secs(5);

/// Time limit of a handshake, before that.
const HANDSHAKE_LIMIT: Duration = Duration::from_secs(3);

/// Time limit of an answer that takes long, such as a recording over a slow link, and the time in which its client takes a
/// piece of 64 KiB at least: less than 4 kB/s is no download that ends.
const LONG_LIMIT: Duration = Duration::from_secs(3600);
const PIECE_LIMIT: Duration = Duration::from_secs(20);

/// Most bytes of request line and headers together; the least that the parser works with.
pub(super) const HEAD_SIZE: usize = 8192;
const HEADERS: usize = 64;

/// Socket buffers of a connection, bytes; the kernel makes them twice as large. By default a client that reads nothing would make
/// it keep megabytes.
pub(super) const SEND_BUFFER: usize = 32 * 1024;
pub(super) const RECEIVE_BUFFER: usize = 16 * 1024;

/// Encrypted bytes that wait to be sent.
pub(super) const ENCRYPTED: usize = 16 * 1024;

/// Pause after a connection that could not be accepted, for example for lack of file descriptors.
const PAUSE: Duration = Duration::from_millis(100);

/// A connection, as its request sees it.
#[derive(Debug)]
pub(super) struct Connection {
    /// Address of who has opened it.
    peer: IpAddr,
    /// Whether its answer is a stream, which lasts.
    streams: AtomicBool,
    /// Whether a whole request has come.
    asks: AtomicBool,
    /// Whether its answer takes long.
    takes_long: AtomicBool,
    /// Pieces of such an answer that its client has taken.
    taken: AtomicU64,
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
            asks: AtomicBool::default(),
            takes_long: AtomicBool::default(),
            taken: AtomicU64::default(),
            encrypted: AtomicBool::default(),
            abort: OnceLock::default(),
        }
    }

    /// Address of who has opened it.
    pub const fn peer(&self) -> IpAddr {
        self.peer
    }

    /// The address that counts.
    pub fn network(&self) -> IpAddr {
        network(self.peer)
    }

    /// Notes that the answer is a stream; whoever feeds it ends the connection.
    pub fn becomes_stream(&self) {
        self.streams.store(true, Ordering::Relaxed);
    }

    /// Notes that the answer takes long.
    pub fn takes_long(&self) {
        self.takes_long.store(true, Ordering::Relaxed);
    }

    /// Notes that its client has taken a piece of the answer.
    pub fn took_piece(&self) {
        self.taken.fetch_add(1, Ordering::Relaxed);
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

/// Bounds what the kernel keeps of each connection that `listener` will accept.
///
/// # Errors
/// The kernel refuses it.
pub(super) fn bound(listener: &std::net::TcpListener) -> io::Result<()> {
    setsockopt(listener, sockopt::SndBuf, &SEND_BUFFER)?;
    setsockopt(listener, sockopt::RcvBuf, &RECEIVE_BUFFER)?;
    Ok(())
}

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
        if let Some(one) =
            gives_way(&connections, peer.ip()).and_then(|place| connections.remove(place))
        {
            one.end();
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

/// Which connection gives way to another one of `peer`; `None` if there is room. An address that has its share loses one of
/// its own. One that asks for nothing is the first, then one of the address that has most, then the oldest. A download never
/// gives way: how many there are is bounded elsewhere.
fn gives_way(connections: &VecDeque<Arc<Connection>>, peer: IpAddr) -> Option<usize> {
    let of = |peer: IpAddr| connections.iter().filter(|it| it.network() == peer).count();
    let own = network(peer);
    let has_its_share = of(own) >= share(CONNECTIONS);
    if !has_its_share && connections.len() < CONNECTIONS {
        return None;
    }
    let places = connections.iter().enumerate();
    let mine = places.filter(|(_, it)| !has_its_share || it.network() == own);
    let short = mine.filter(|(_, it)| !it.takes_long.load(Ordering::Relaxed));
    let rank = |(place, it): &(usize, &Arc<Connection>)| {
        (it.asks.load(Ordering::Relaxed), Reverse(of(it.network())), *place)
    };
    short.min_by_key(rank).map(|(place, _)| place)
}

/// The address that counts: of IPv6 the network, of which one computer has all addresses.
pub(super) fn network(from: IpAddr) -> IpAddr {
    match from.to_canonical() {
        IpAddr::V6(it) => {
            let [a, b, c, d, ..] = it.segments();
            Ipv6Addr::new(a, b, c, d, 0, 0, 0, 0).into()
        }
        other => other,
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
    let bounded = |session: &mut ServerConnection| session.set_buffer_limit(Some(ENCRYPTED));
    let handshake = TlsAcceptor::from(identity.config).accept_with(stream, bounded);
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
        own.asks.store(true, Ordering::Relaxed);
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
        let (mut pace, begin) = (Pace::default(), Instant::now());
        let mut look = || pace.look(begin.elapsed(), connection.taken.load(Ordering::Relaxed));
        while let Some(wait) = look() {
            if tokio::time::timeout(wait, served.as_mut()).await.is_ok() {
                return;
            }
        }
    }
}

/// The pace at which a client takes an answer that takes long.
#[derive(Debug, Default)]
struct Pace {
    /// Pieces that it had taken at the last look.
    taken: Option<u64>,
}

impl Pace {
    /// How long the download may go on before the next look; `None` ends it. It began `since` ago, and `taken` pieces are sent.
    fn look(&mut self, since: Duration, taken: u64) -> Option<Duration> {
        let before = self.taken.replace(taken);
        let left = LONG_LIMIT.saturating_sub(since);
        (before != Some(taken) && !left.is_zero()).then(|| left.min(PIECE_LIMIT))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nix::sys::socket::getsockopt;

    #[test]
    fn idle_connections_and_those_of_the_greedy_give_way_and_downloads_never() {
        let of = |peer: [u8; 4]| Arc::new(Connection::new(peer.into()));
        let (download, greedy) = (of([10, 0, 0, 1]), [of([10, 0, 0, 2]), of([10, 0, 0, 2])]);
        let (other, idle) = (of([10, 0, 0, 3]), of([10, 0, 0, 4]));
        download.takes_long();
        for one in [&download, &other, &greedy[0], &greedy[1]] {
            one.asks.store(true, Ordering::Relaxed);
        }
        let mut all: VecDeque<_> =
            [&download, &other, &greedy[0], &greedy[1], &idle].map(Arc::clone).into();
        let newest = IpAddr::from([10, 0, 0, 9]);
        assert_eq!(gives_way(&all, newest), None, "there is room");
        let more = || {
            let download = of([10, 0, 0, 1]);
            download.takes_long();
            download
        };
        for expected in [&idle, &greedy[0], &other, &greedy[1]] {
            all.resize_with(CONNECTIONS, more);
            let place = gives_way(&all, newest).expect("one gives way");
            assert!(Arc::ptr_eq(&all.remove(place).expect("it is there"), expected));
        }
        all.resize_with(CONNECTIONS, more);
        assert_eq!(gives_way(&all, newest), None, "a download stays");
    }

    /// How long a download goes on, s; `taken` is how many pieces its client has at a time after its begin, s.
    fn downloading(taken: impl Fn(u64) -> u64) -> u64 {
        let (mut pace, mut since) = (Pace::default(), Duration::ZERO);
        while let Some(wait) = pace.look(since, taken(since.as_secs())) {
            assert!(!wait.is_zero(), "it would look without end");
            since += wait;
        }
        since.as_secs()
    }

    #[test]
    fn a_download_ends_when_its_client_takes_less_than_a_piece_in_20_s() {
        assert_eq!(downloading(|_| 0), 20, "who reads nothing");
        assert_eq!(downloading(|since| since.min(99)), 120, "who stops after 99 s");
        assert_eq!(downloading(|since| since / 21), 20, "a piece in 21 s is too little");
        assert_eq!(downloading(|since| since / 20), 3600, "one in 20 s is enough for an hour");
        assert_eq!(downloading(|since| 1000 * since), 3600, "and no more than that");
    }

    #[test]
    fn the_kernel_keeps_little_of_a_connection() {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
        bound(&listener).expect("it may be less");
        let address = listener.local_addr().expect("it has one");
        let _client = std::net::TcpStream::connect(address).expect("it listens");
        let (accepted, _) = listener.accept().expect("there is one");
        let sent = getsockopt(&accepted, sockopt::SndBuf).expect("it has one");
        let come = getsockopt(&accepted, sockopt::RcvBuf).expect("it has one");
        assert_eq!((sent, come), (2 * SEND_BUFFER, 2 * RECEIVE_BUFFER));
    }

    #[test]
    fn an_address_that_has_half_of_the_places_takes_none_of_others() {
        let of = |peer: IpAddr| Arc::new(Connection::new(peer));
        let [one, other] = [[10, 0, 0, 1], [10, 0, 0, 2]].map(IpAddr::from);
        // The other's is the oldest and asks for nothing, which is the first to go otherwise.
        let mut all: VecDeque<_> = [of(other)].into();
        all.extend((1..CONNECTIONS / 2).map(|_| of(one)));
        assert_eq!(gives_way(&all, one), None);
        all.push_back(of(one));
        assert_eq!(gives_way(&all, one), Some(1), "its own oldest");
        assert_eq!(gives_way(&all, other), None, "there is room for others");
        let [near, far] = ["2001:db8::1", "2001:db8::2:3"].map(|it| it.parse().expect("IPv6"));
        let mut all: VecDeque<_> = (0..CONNECTIONS / 2).map(|_| of(near)).collect();
        all.push_front(of(one));
        assert_eq!(gives_way(&all, far), Some(1), "one computer has all of them");
    }
}
