//! The state of the machine over Modbus TCP, read only, for the ship's own control and alarm system.
//!
//! The server is a thread of its own, which only reads what the data path has stored: the data path never waits for
//! its clients. docs/MODBUS.md has the register map, which follows from [`map`].

pub mod map;
mod service;
pub mod sheet;

use super::listening::{ServedProtocol, StateServer};
use super::patience::Patience;
use crate::appliance::realtime;
use crate::appliance::telemetry::Recorder;
use crate::appliance::telemetry::Telemetry;
use crate::appliance::telemetry::clock::Clock;
use service::{PACE, Reading};
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use tertius_config::settings::Settings;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Semaphore, oneshot};
use tokio_modbus::server::tcp::Server;
use tracing::warn;

/// Stack of the thread, bytes.
const STACK_SIZE: usize = 512 * 1024;

/// Most clients at once; further ones are turned away.
const CLIENTS: usize = 8;

/// Silence after which a client's connection is closed; masters poll every few seconds at the latest.
const SILENCE: Duration = Duration::from_secs(60);

/// Pause after a connection that could not be accepted, for example for lack of file descriptors.
const PAUSE: Duration = Duration::from_millis(100);

/// A running server; it ends when this is dropped.
#[derive(Debug)]
pub struct ModbusServer {
    address: SocketAddr,
    _stop: oneshot::Sender<()>,
}

impl ModbusServer {
    /// Serves what `recorder` writes on `listen`, or on a free port if its port is 0, to clients that are silent for
    /// at most `silence`.
    ///
    /// # Errors
    /// The address is in use or not available, or the system provides no thread.
    fn with_silence(
        listen: SocketAddr,
        recorder: &Recorder,
        silence: Duration,
    ) -> io::Result<Self> {
        let listener = std::net::TcpListener::bind(listen)?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let (telemetry, clock) = (recorder.telemetry().clone(), recorder.clock().clone());
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let (stop, stopped) = oneshot::channel();
        let serve = move || {
            realtime::be_ordinary();
            runtime.spawn(accept(listener, telemetry, clock, silence));
            // Ends with an error once the sender is dropped; the runtime takes its tasks along.
            _ = runtime.block_on(stopped);
        };
        std::thread::Builder::new()
            .name("modbus".to_owned())
            .stack_size(STACK_SIZE)
            .spawn(serve)?;
        Ok(Self { address, _stop: stop })
    }
}

impl StateServer for ModbusServer {
    const PROTOCOL: ServedProtocol = ServedProtocol {
        name: "Modbus",
        title: "Modbus TCP, read only: ",
        warning: "Modbus knows no login",
        key: "modbus.listen",
    };

    fn wanted(settings: &Settings) -> Option<SocketAddr> {
        settings.modbus.address()
    }

    fn start(listen: SocketAddr, recorder: &Recorder) -> io::Result<Self> {
        Self::with_silence(listen, recorder, SILENCE)
    }

    fn address(&self) -> SocketAddr {
        self.address
    }
}

/// Accepts clients until the task is dropped.
async fn accept(
    listener: std::net::TcpListener,
    telemetry: Arc<Telemetry>,
    clock: Arc<dyn Clock>,
    silence: Duration,
) {
    let server = match TcpListener::from_std(listener) {
        Ok(listener) => Server::new(listener),
        Err(error) => return warn!("no Modbus: {error}"),
    };
    let places = Arc::new(Semaphore::new(CLIENTS));
    let connected = |stream: TcpStream, _: SocketAddr| {
        let places = Arc::clone(&places);
        let (telemetry, clock) = (Arc::clone(&telemetry), Arc::clone(&clock));
        async move {
            // The next one is accepted after this, so that whoever connects without end costs little.
            tokio::time::sleep(PACE).await;
            let place = places.try_acquire_owned();
            telemetry.modbus_connected(place.is_ok());
            // Without a place the stream is closed here.
            let Ok(_place) = place else { return Ok(None) };
            _ = stream.set_nodelay(true);
            let reading = Reading { telemetry, clock, _place };
            Ok(Some((reading, Patience::new(stream, silence))))
        }
    };
    loop {
        // Ends where a connection could not be accepted; what a client does ends only its own.
        _ = server.serve(&connected, |_| {}).await;
        tokio::time::sleep(PAUSE).await;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appliance::telemetry::clock::SystemClock;
    use std::io::{Read, Write};
    use std::net::TcpStream;

    /// Half of a request never becomes a whole one, and an open connection takes a place.
    #[test]
    fn a_client_that_hangs_loses_its_place() {
        let recorder = Recorder::new(Arc::new(SystemClock::new()));
        let listen = "127.0.0.1:0".parse().expect("an address");
        let silence = Duration::from_millis(50);
        let server = ModbusServer::with_silence(listen, &recorder, silence).expect("a free port");
        let hanging = (0..CLIENTS).map(|_| {
            let mut stream = TcpStream::connect(server.address()).expect("it listens");
            stream.set_read_timeout(Some(Duration::from_secs(60))).expect("a time limit");
            stream.write_all(&[0, 1, 0, 0, 0, 6, 1]).expect("it reads");
            stream
        });
        for mut stream in hanging.collect::<Vec<_>>() {
            // The end of the stream, or its reset.
            assert!(stream.read(&mut [0; 16]).is_ok_and(|read| read == 0));
        }
        let mut stream = TcpStream::connect(server.address()).expect("it listens");
        stream.write_all(&[0, 1, 0, 0, 0, 6, 1, 4, 0, 0, 0, 1]).expect("it reads");
        let mut answer = [0; 11];
        stream.read_exact(&mut answer).expect("it has a place");
        assert_eq!(answer, [0, 1, 0, 0, 0, 5, 1, 4, 2, 0, 1]);
    }
}
