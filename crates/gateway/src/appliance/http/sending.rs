//! Answers that take long, in pieces: each is made on a thread of its own, so that whoever reads slowly holds up nobody
//! who looks at alarms, and only so much of it is in memory.

use super::audience::Pieces;
use super::connections::{Connection, share};
use axum::body::{Body, Bytes};
use axum::http::StatusCode;
use axum::http::header::RETRY_AFTER;
use axum::response::{IntoResponse, Response};
use std::io::{self, BufWriter, Write};
use std::net::IpAddr;
use std::sync::{Arc, Mutex, PoisonError};
use tokio::sync::mpsc::{Sender, channel};

/// Most recordings, and most exports, that are sent at once, half of them to one address. An export holds a place in the
/// event store meanwhile.
pub(super) const DOWNLOADS: usize = 2;

/// After how many seconds to try again where there is no place.
const RETRY: &str = "10";

/// Pieces that wait for a slow client, and the size of each, bytes.
pub(super) const WAITING: usize = 2;
pub(super) const PIECE: usize = 64 * 1024;

/// Stack of a thread, bytes.
pub(super) const STACK_SIZE: usize = 512 * 1024;

/// The places of those who are sent something long.
#[derive(Debug, Default)]
pub(super) struct Places {
    pub recordings: Arc<Taken>,
    pub exports: Arc<Taken>,
}

/// The addresses that have places.
#[derive(Debug, Default)]
pub(super) struct Taken(Mutex<Vec<IpAddr>>);

/// A place, until it is dropped.
pub(super) struct Place {
    of: Arc<Taken>,
    by: IpAddr,
}

impl Taken {
    /// A place for who asks by `connection`.
    ///
    /// # Errors
    /// The reason where all places are taken, or all that its address may have.
    pub fn place(self: &Arc<Self>, connection: &Connection) -> Result<Place, &'static str> {
        let by = connection.network();
        let mut taken = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if taken.len() >= DOWNLOADS {
            return Err(
                "as much is being downloaded as can be at once; try again when a download has ended\n",
            );
        }
        if taken.iter().filter(|it| **it == by).count() >= share(DOWNLOADS) {
            return Err(
                "your address is downloading as much as one may at once; try again when that has ended\n",
            );
        }
        taken.push(by);
        Ok(Place { of: Arc::clone(self), by })
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut taken = self.of.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(own) = taken.iter().position(|it| *it == self.by) {
            taken.swap_remove(own);
        }
    }
}

/// The answer where there is no place, in words.
pub(super) fn no_place(told: &'static str) -> Response {
    (StatusCode::SERVICE_UNAVAILABLE, [(RETRY_AFTER, RETRY)], told).into_response()
}

/// A body of what `make` writes, which takes `place` until it has ended.
///
/// # Errors
/// There is no thread for it.
pub(super) fn body(
    connection: &Arc<Connection>,
    place: Place,
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
