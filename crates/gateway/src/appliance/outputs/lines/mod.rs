//! The highest level and the number of cycles, one line a connection, over TCP: the least that an output can be.

use super::listening::{ServedProtocol, StateServer};
use crate::appliance::realtime;
use crate::appliance::telemetry::Recorder;
use std::io::{self, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use tertius_config::settings::Settings;

/// Pause between two connections, so that clients take little.
const PACE: Duration = Duration::from_millis(10);

/// A running server; it ends when this is dropped.
#[derive(Debug)]
pub struct LineServer {
    address: SocketAddr,
    stop: Arc<AtomicBool>,
}

impl StateServer for LineServer {
    const PROTOCOL: ServedProtocol = ServedProtocol {
        name: "lines",
        title: "state in lines: ",
        warning: "no login is asked for",
        key: "lines.listen",
    };

    fn wanted(settings: &Settings) -> Option<SocketAddr> {
        settings.lines.address()
    }

    fn start(listen: SocketAddr, recorder: &Recorder) -> io::Result<Self> {
        let listener = TcpListener::bind(listen)?;
        let (address, stop) = (listener.local_addr()?, Arc::new(AtomicBool::new(false)));
        let (telemetry, clock) = (recorder.telemetry().clone(), recorder.clock().clone());
        let stopped = Arc::clone(&stop);
        let serve = move || {
            realtime::be_ordinary();
            for stream in listener.incoming().flatten() {
                if stopped.load(Ordering::Relaxed) {
                    return;
                }
                let now = telemetry.snapshot(clock.uptime());
                let mut stream = stream;
                _ = writeln!(stream, "level {} cycles {}", now.level, now.cycles);
                std::thread::sleep(PACE);
            }
        };
        std::thread::Builder::new().name("lines".to_owned()).spawn(serve)?;
        Ok(Self { address, stop })
    }

    fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for LineServer {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        // It waits for a connection.
        _ = TcpStream::connect(self.address);
    }
}
