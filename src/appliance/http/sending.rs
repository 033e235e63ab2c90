//! Answers that take long, in pieces: each is made on a thread of its own, so that whoever reads slowly holds up nobody
//! who looks at alarms, and only so much of it is in memory.

use super::connections::Connection;
use super::stream::Pieces;
use axum::body::{Body, Bytes};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use std::io::{self, BufWriter, Write};
use std::sync::Arc;
use tokio::sync::mpsc::{Sender, channel};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// Most recordings and exports that are sent at once. An export holds a place in the event store meanwhile.
const RECORDINGS: usize = 2;
const EXPORTS: usize = 1;

/// Pieces that wait for a slow client, and the size of each, bytes.
const WAITING: usize = 2;
const PIECE: usize = 64 * 1024;

/// Stack of a thread, bytes.
const STACK_SIZE: usize = 512 * 1024;

/// The places of those who are sent something long.
#[derive(Debug)]
pub(super) struct Places {
    pub recordings: Arc<Semaphore>,
    pub exports: Arc<Semaphore>,
}

impl Default for Places {
    fn default() -> Self {
        let of = |places| Arc::new(Semaphore::new(places));
        Self { recordings: of(RECORDINGS), exports: of(EXPORTS) }
    }
}

/// A place; `None` where all are taken.
pub(super) fn place(of: &Arc<Semaphore>) -> Option<OwnedSemaphorePermit> {
    Arc::clone(of).try_acquire_owned().ok()
}

/// The answer where all places are taken.
pub(super) fn no_place() -> Response {
    let told =
        "as much is being downloaded as can be at once; try again when a download has ended\n";
    (StatusCode::SERVICE_UNAVAILABLE, told).into_response()
}

/// A body of what `make` writes, which takes `place` until it has ended.
///
/// # Errors
/// There is no thread for it.
pub(super) fn body(
    connection: &Arc<Connection>,
    place: OwnedSemaphorePermit,
    make: impl FnOnce(&mut dyn Write) -> io::Result<()> + Send + 'static,
) -> io::Result<Body> {
    connection.takes_long();
    let (sender, pieces) = channel(WAITING);
    let own = Arc::clone(connection);
    let work = move || {
        crate::appliance::realtime::be_ordinary();
        let mut out = BufWriter::with_capacity(PIECE, Sending(sender));
        let made = make(&mut out).and_then(|()| out.flush());
        if made.is_err() {
            // Else what is cut would look like a whole file.
            own.end();
        }
        // What is left in the buffer of a cut one is of no use.
        drop(out.into_parts());
        drop(place);
    };
    let builder = std::thread::Builder::new().name("http-sender".to_owned());
    builder.stack_size(STACK_SIZE).spawn(work)?;
    Ok(Body::new(Pieces::of(pieces, Arc::clone(connection))))
}

/// The answer where there is no thread.
pub(super) fn no_thread(error: &io::Error) -> Response {
    let told = format!("there is no thread to send it: {error}; try again later\n");
    (StatusCode::SERVICE_UNAVAILABLE, told).into_response()
}

/// Sends what is written as pieces of an answer.
struct Sending(Sender<Bytes>);

impl Write for Sending {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // No piece is longer, whatever is written at once.
        let piece = &bytes[..bytes.len().min(PIECE)];
        let sent = self.0.blocking_send(Bytes::copy_from_slice(piece));
        sent.map(|()| piece.len()).map_err(|_| io::ErrorKind::BrokenPipe.into())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
