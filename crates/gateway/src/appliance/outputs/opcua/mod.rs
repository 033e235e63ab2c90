//! The state of the machine and its alarms over OPC UA, read only, for the ship's own control and alarm system.
//!
//! ```text
//! clients ─→ gate ─→ server of async-opcua ─→ values ─→ Telemetry
//!            bounds       sessions, nodes  ←─ watch ←───────┘ changes, alarms
//! ```
//!
//! The server is a thread of its own, which only reads what the data path has stored: the data path never waits for
//! its clients. docs/OPCUA.md lists the nodes, which follow from [`points`](crate::appliance::telemetry::points).

mod alarms;
mod condition;
mod gate;
mod instant;
mod refresh;
mod source;
mod space;
mod values;
mod watch;

use super::listening::{ServedProtocol, StateServer};
use crate::appliance::realtime;
use crate::appliance::telemetry::Recorder;
use opcua::server::node_manager::ServerContext;
use opcua::server::node_manager::memory::{CoreNodeManagerBuilder, InMemoryNodeManagerBuilder};
use opcua::server::{ANONYMOUS_USER_TOKEN_ID, Server, ServerBuilder, ServerEndpoint};
use refresh::Refresher;
pub use source::NAMESPACE;
use source::Source;
use std::io;
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tertius_config::settings::Settings;
use tokio::net::TcpListener;
use tokio::sync::oneshot;
use tracing::subscriber::{NoSubscriber, set_default};
use tracing::warn;
use values::Values;

/// Stack of the thread, bytes.
const STACK_SIZE: usize = 2 * 1024 * 1024;

/// Silence after which a client's connection is closed: the sessions of clients that have something to say are kept
/// alive more often.
const SILENCE: Duration = Duration::from_secs(60);

/// Most sessions; they outlive their connections by [`SILENCE`] at most.
const SESSIONS: usize = 2 * gate::CLIENTS;

/// Most values, nodes or monitored items of one request.
const MOST_OF_A_REQUEST: usize = 500;

/// Shortest interval at which a client is told of changes, ms.
const SHORTEST_INTERVAL: f64 = 100.0;

/// A running server; it ends when this is dropped.
#[derive(Debug)]
pub struct OpcuaServer {
    address: SocketAddr,
    _stop: oneshot::Sender<()>,
}

impl OpcuaServer {
    /// Serves what `recorder` writes on `listen`, or on a free port if its port is 0, to clients that are silent for
    /// at most `silence`.
    ///
    /// # Errors
    /// The address is in use or not available, or the system provides no thread.
    pub fn with_silence(
        listen: SocketAddr,
        recorder: &Recorder,
        silence: Duration,
    ) -> io::Result<Self> {
        let listener = std::net::TcpListener::bind(listen)?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let (telemetry, clock) = (recorder.telemetry().clone(), recorder.clock().clone());
        let source = Source { telemetry, clock, alarms: Arc::default() };
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let (stop, stopped) = oneshot::channel();
        let serve = move || {
            realtime::be_ordinary();
            let trouble = {
                // The library writes a line for whatever a client does; a flood of them would be one of the log.
                let _quiet = set_default(NoSubscriber::default());
                runtime.block_on(async {
                    tokio::select! {
                        trouble = serve(listener, address, source, silence) => Some(trouble),
                        // Ends with an error once the sender is dropped; the runtime takes its tasks along.
                        _ = stopped => None,
                    }
                })
            };
            if let Some(trouble) = trouble {
                warn!("no OPC UA on {address}: {trouble}");
            }
        };
        std::thread::Builder::new().name("opcua".to_owned()).stack_size(STACK_SIZE).spawn(serve)?;
        Ok(Self { address, _stop: stop })
    }
}

impl StateServer for OpcuaServer {
    const PROTOCOL: ServedProtocol = ServedProtocol {
        name: "OPC UA",
        title: "OPC UA, read only: opc.tcp://",
        warning: "nothing is asked of them or encrypted",
        key: "opcua.listen",
    };

    fn wanted(settings: &Settings) -> Option<SocketAddr> {
        settings.opcua.address()
    }

    fn start(listen: SocketAddr, recorder: &Recorder) -> io::Result<Self> {
        Self::with_silence(listen, recorder, SILENCE)
    }

    fn address(&self) -> SocketAddr {
        self.address
    }
}

/// Serves until it cannot; what it gives is the reason.
async fn serve(
    listener: std::net::TcpListener,
    address: SocketAddr,
    source: Source,
    silence: Duration,
) -> String {
    let built = builder(address, &source).build();
    let (server, handle) = match built {
        Ok(built) => built,
        Err(trouble) => return trouble,
    };
    let (inner, listener) = match (local().await, TcpListener::from_std(listener)) {
        (Ok(inner), Ok(listener)) => (inner, listener),
        (Err(error), _) | (_, Err(error)) => return error.to_string(),
    };
    let Ok(within) = inner.local_addr() else { return "no address within".to_owned() };
    let running = tokio::spawn(run(server, inner));
    // Clients are told of the address that they can reach, which the server itself does not know.
    while handle.info().port.load(Ordering::Relaxed) == 0 {
        if running.is_finished() {
            return "the server did not start".to_owned();
        }
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    handle.info().port.store(address.port(), Ordering::Relaxed);
    tokio::select! {
        ended = running => ended.unwrap_or_else(|error| error.to_string()),
        () = watch::watch(source, &handle) => "the watch ended".to_owned(),
        () = gate::admit(listener, within, silence) => "the gate ended".to_owned(),
    }
}

async fn run(server: Server, inner: TcpListener) -> String {
    server.run_with(inner).await.err().unwrap_or_else(|| "the server ended".to_owned())
}

/// Where the library listens: only the gate connects there, as it takes connections without bounds.
async fn local() -> io::Result<TcpListener> {
    TcpListener::bind((IpAddr::from([127, 0, 0, 1]), 0)).await
}

fn builder(address: SocketAddr, source: &Source) -> ServerBuilder {
    let values = source.clone();
    let node_manager =
        InMemoryNodeManagerBuilder::new(move |context: ServerContext, space: &mut _| {
            Values::new(values, &context, space)
        });
    let refresher = source.clone();
    let builder = ServerBuilder::new()
        .without_node_managers()
        // Before that of the standard's own nodes, since the first that knows a method is asked.
        .with_node_manager(move |_: ServerContext| Refresher::new(refresher))
        .with_node_manager(InMemoryNodeManagerBuilder::new(CoreNodeManagerBuilder))
        .with_node_manager(opcua::server::diagnostics::DiagnosticsNodeManagerBuilder)
        .with_node_manager(node_manager)
        .application_name("Tertius")
        .application_uri("urn:tertius")
        .product_uri("urn:tertius")
        .host(host(address.ip()))
        .port(address.port())
        .discovery_urls(vec![format!("opc.tcp://{}:{}/", host(address.ip()), address.port())])
        // No certificates are kept: below a file there are no folders.
        .pki_dir("/dev/null/none")
        .max_session_timeout_ms(SILENCE.as_millis() as u64)
        .add_endpoint("none", ServerEndpoint::new_none("/", &[ANONYMOUS_USER_TOKEN_ID.to_owned()]));
    bounded(builder)
}

/// With bounds on everything that a client may ask for.
fn bounded(mut builder: ServerBuilder) -> ServerBuilder {
    let limits = builder.limits_mut();
    limits.max_sessions = SESSIONS;
    limits.max_message_size = 4 * gate::LARGEST;
    limits.max_chunk_count = 4;
    limits.send_buffer_size = gate::LARGEST;
    limits.receive_buffer_size = gate::LARGEST;
    limits.max_array_length = 10_000;
    limits.max_string_length = 4096;
    limits.max_byte_string_length = 4096;
    limits.max_browse_continuation_points = 10;
    limits.max_history_continuation_points = 1;
    limits.max_query_continuation_points = 1;
    let subscriptions = &mut limits.subscriptions;
    subscriptions.max_subscriptions_per_session = 4;
    subscriptions.max_pending_publish_requests = 8;
    subscriptions.max_monitored_items_per_sub = MOST_OF_A_REQUEST;
    subscriptions.max_monitored_item_queue_size = 32;
    subscriptions.max_queued_notifications = 20;
    subscriptions.max_notifications_per_publish = MOST_OF_A_REQUEST as u64;
    subscriptions.min_sampling_interval_ms = SHORTEST_INTERVAL;
    subscriptions.min_publishing_interval_ms = SHORTEST_INTERVAL;
    let each = &mut limits.operational;
    each.max_nodes_per_read = MOST_OF_A_REQUEST;
    each.max_nodes_per_browse = MOST_OF_A_REQUEST;
    each.max_nodes_per_translate_browse_paths_to_node_ids = MOST_OF_A_REQUEST;
    each.max_monitored_items_per_call = MOST_OF_A_REQUEST;
    each.max_nodes_per_register_nodes = MOST_OF_A_REQUEST;
    each.max_nodes_per_write = 10;
    each.max_nodes_per_method_call = 10;
    each.max_subscriptions_per_call = 10;
    builder
}

/// The host as clients know it: this computer's name if the server listens on all of its addresses.
fn host(address: IpAddr) -> String {
    let named = || std::fs::read_to_string("/proc/sys/kernel/hostname").ok();
    let named = || named().map(|name| name.trim().to_owned()).filter(|name| !name.is_empty());
    match address {
        all if all.is_unspecified() => named().unwrap_or_else(|| "localhost".to_owned()),
        IpAddr::V4(address) => address.to_string(),
        IpAddr::V6(address) => format!("[{address}]"),
    }
}
