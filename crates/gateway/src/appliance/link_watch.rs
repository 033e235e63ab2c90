//! Watches the interface beside the data path, because a driver may report its controller's state
//! without sending error frames.

use super::realtime;
use crate::bus::socket::LinkState;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;
use tertius_core::error_frame::ControllerState;
use tracing::{info, warn};

/// Period of the checks. The kernel answers them under a lock that others hold while they set
/// interfaces up, so the data path does not ask.
const PERIOD: Duration = Duration::from_secs(1);

/// Most interfaces that may be named before the first one is checked.
const WAITING: usize = 4;

/// A thread that checks the interface; it ends when this is dropped.
#[derive(Debug)]
pub struct LinkWatch {
    names: Option<SyncSender<String>>,
    thread: Option<JoinHandle<()>>,
}

impl LinkWatch {
    /// Starts the checks as soon as an interface is named. `seen` gets each state, `None` where
    /// there is no such interface; changes are logged.
    ///
    /// # Errors
    /// No thread can be started.
    pub fn start(seen: impl FnMut(Option<&LinkState>) + Send + 'static) -> std::io::Result<Self> {
        let (names, named) = sync_channel(WAITING);
        let builder = std::thread::Builder::new().name("link".to_owned());
        let thread = builder.spawn(move || look(&named, seen))?;
        Ok(Self { names: Some(names), thread: Some(thread) })
    }

    /// Checks `interface` from now on. Never waits.
    pub fn name(&self, interface: &str) {
        if let Some(names) = &self.names {
            // A queue that is full holds names that are as new.
            _ = names.try_send(interface.to_owned());
        }
    }
}

impl Drop for LinkWatch {
    fn drop(&mut self) {
        self.names = None;
        if let Some(thread) = self.thread.take() {
            // It may have panicked; the gateway stops either way.
            _ = thread.join();
        }
    }
}

fn look(named: &Receiver<String>, mut seen: impl FnMut(Option<&LinkState>)) {
    realtime::be_ordinary();
    let Ok(mut interface) = named.recv() else { return };
    let mut last = None;
    loop {
        // An interface that is not there is the data path's to tell.
        let link = LinkState::read(&interface).ok();
        let state = link.as_ref().and_then(|link| link.state);
        log_change(&interface, last, state);
        last = state;
        seen(link.as_ref());
        match named.recv_timeout(PERIOD) {
            Ok(name) if name != interface => (interface, last) = (name, None),
            Ok(_) | Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}

fn log_change(interface: &str, last: Option<ControllerState>, now: Option<ControllerState>) {
    let Some(state) = now.filter(|_| now != last) else { return };
    let name = state.name();
    match state {
        ControllerState::ErrorActive => info!("{interface}: the controller is {name}"),
        _ => warn!("{interface}: the controller is {name}"),
    }
}
