//! Those who watch, and what waits for each.

use super::connections::{Connection, share};
use axum::body::{Bytes, HttpBody};
use hyper::body::Frame;
use std::convert::Infallible;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll};
use tokio::sync::mpsc::{Receiver, Sender, channel};

/// Most who watch at once, half of them at one address; a further one is refused.
pub(super) const MOST_WATCHERS: usize = 64;

/// Events that wait for a watcher, 4 s of them. Whoever does not read them by then is dropped, not waited for.
pub(super) const WAITING: usize = 8;

/// Those who watch.
#[derive(Debug, Default)]
pub(super) struct Audience(Mutex<Vec<Watcher>>);

#[derive(Debug)]
struct Watcher {
    events: Sender<Bytes>,
    connection: Arc<Connection>,
}

impl Audience {
    /// Adds who watches on `connection`.
    ///
    /// # Errors
    /// The reason if there are too many, in all or at its address.
    pub fn join(&self, connection: Arc<Connection>) -> Result<Receiver<Bytes>, &'static str> {
        let mut watchers = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        watchers.retain(|watcher| !watcher.events.is_closed());
        if watchers.len() >= MOST_WATCHERS {
            return Err("as many watch as can be served; close another window of this page\n");
        }
        let by = connection.network();
        let own = watchers.iter().filter(|watcher| watcher.connection.network() == by);
        if own.count() >= share(MOST_WATCHERS) {
            return Err(
                "as many watch from your address as may at once; close another window of this page\n",
            );
        }
        let (events, receiver) = channel(WAITING);
        connection.becomes_stream();
        watchers.push(Watcher { events, connection });
        Ok(receiver)
    }

    /// Sends what `event` makes to all who watch; it is not called if none do.
    pub fn send(&self, event: impl FnOnce() -> Bytes) {
        let mut watchers = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if watchers.is_empty() {
            return;
        }
        let event = event();
        watchers.retain(|watcher| {
            let taken = watcher.events.try_send(event.clone()).is_ok();
            if !taken {
                watcher.connection.end();
            }
            taken
        });
    }
}

/// What waits for one client, as the body of an answer.
pub(super) struct Pieces {
    pieces: Receiver<Bytes>,
    connection: Arc<Connection>,
}

impl Pieces {
    pub const fn of(pieces: Receiver<Bytes>, connection: Arc<Connection>) -> Self {
        Self { pieces, connection }
    }
}

impl HttpBody for Pieces {
    type Data = Bytes;
    type Error = Infallible;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Infallible>>> {
        let polled = self.pieces.poll_recv(context);
        if matches!(polled, Poll::Ready(Some(_))) {
            self.connection.took_piece();
        }
        polled.map(|piece| piece.map(|piece| Ok(Frame::data(piece))))
    }
}
