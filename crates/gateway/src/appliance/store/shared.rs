//! What the threads around the store know of each other.

use super::act::{ActError, ActRequest, AlarmAct};
use super::note::Note;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, PoisonError};
use tokio::sync::oneshot;

/// Most acts that wait for the writer. More people than these do not act at once.
const ACTS: usize = 8;

/// State of the store, for people and scripts.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct StoreState {
    /// Database; `None`: nothing is kept.
    pub path: Option<PathBuf>,
    /// Why nothing is written, in words; `None` while all is well.
    pub trouble: Option<String>,
}

/// What the writer tells, and what never reached it.
#[derive(Debug, Default)]
pub(super) struct Shared {
    /// Locked by the writer and by readers of it, never by the data path.
    pub state: Mutex<StoreState>,
    /// Notes that found no room on the way to the writer.
    pub dropped: AtomicU64,
    pub acts: AtomicUsize,
}

impl Shared {
    pub fn set(&self, state: StoreState) {
        *self.state.lock().unwrap_or_else(PoisonError::into_inner) = state;
    }
}

/// Access to the store for the threads beside the data path.
#[derive(Clone, Debug)]
pub struct StoreHandle {
    pub(super) shared: Arc<Shared>,
    pub(super) notes: SyncSender<Note>,
}

impl StoreHandle {
    /// State of the store now.
    pub fn state(&self) -> StoreState {
        self.shared.state.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Hands over an act. The answer comes once it is on the disk, or refused, within a few seconds.
    ///
    /// # Errors
    /// Too many acts wait, or the writer is gone.
    pub fn act(&self, act: AlarmAct) -> Result<oneshot::Receiver<Result<(), ActError>>, ActError> {
        if self.shared.acts.fetch_add(1, Ordering::AcqRel) >= ACTS {
            self.shared.acts.fetch_sub(1, Ordering::AcqRel);
            return Err(ActError::Busy);
        }
        let (answer, answered) = oneshot::channel();
        let request = ActRequest { act: Box::new(act), answer };
        match self.notes.try_send(Note::Act(request)) {
            Ok(()) => Ok(answered),
            Err(_) => {
                self.shared.acts.fetch_sub(1, Ordering::AcqRel);
                Err(ActError::Busy)
            }
        }
    }
}
