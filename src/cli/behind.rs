//! Writing behind: a thread of its own makes text of a table's rows while the next ones are judged.

use std::io;
use std::mem;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{self, JoinHandle};

/// Rows of a batch: enough that handing one over costs nothing, and few enough to stay in a processor's cache.
const BATCH: usize = 256;

/// Batches, those that are filled and written included.
const BATCHES: usize = 8;

/// Something that is written row by row.
pub trait Table: Send + 'static {
    type Row: Send + 'static;

    /// Writes a row.
    ///
    /// # Errors
    /// Those of the output.
    fn write(&mut self, row: &Self::Row) -> io::Result<()>;
}

/// A table, and who writes it: what it holds in the end does not depend on that.
pub struct Behind<T: Table>(State<T>);

enum State<T: Table> {
    /// The caller, at once.
    InTurn(T),
    Beside(Beside<T>),
    /// Nobody any more: it failed, which was said.
    Failed,
}

/// A thread that writes.
struct Beside<T: Table> {
    /// The batch that is being filled.
    rows: Vec<T::Row>,
    full: SyncSender<Vec<T::Row>>,
    empty: Receiver<Vec<T::Row>>,
    thread: JoinHandle<io::Result<T>>,
}

impl<T: Table> Behind<T> {
    /// Writes `table` on a thread of its own if there are more than one of `threads`.
    pub fn new(table: T, threads: usize) -> Self {
        Self(if threads < 2 { State::InTurn(table) } else { State::Beside(Beside::new(table)) })
    }

    /// Takes a row. It is written by the time of [`Self::catch_up`].
    ///
    /// # Errors
    /// Those of the output, of this row or of one before; said once.
    #[inline]
    pub fn write(&mut self, row: T::Row) -> io::Result<()> {
        match &mut self.0 {
            State::InTurn(table) => table.write(&row),
            State::Beside(beside) => {
                beside.rows.push(row);
                if beside.rows.len() < BATCH || beside.hand_over() {
                    return Ok(());
                }
                self.catch_up()
            }
            State::Failed => Ok(()),
        }
    }

    /// Waits until all rows so far are written; what comes is written by the caller.
    ///
    /// # Errors
    /// Those of the output, of any row before; said once.
    pub fn catch_up(&mut self) -> io::Result<()> {
        self.0 = match mem::replace(&mut self.0, State::Failed) {
            State::Beside(beside) => State::InTurn(beside.end()?),
            other => other,
        };
        Ok(())
    }

    /// The table, after [`Self::catch_up`]; `None` if it failed.
    pub fn into_inner(mut self) -> Option<T> {
        match mem::replace(&mut self.0, State::Failed) {
            State::InTurn(table) => Some(table),
            State::Beside(beside) => beside.end().ok(),
            State::Failed => None,
        }
    }
}

/// Nobody writes on to what is given up, and its temporary file is gone when this returns.
impl<T: Table> Drop for Behind<T> {
    fn drop(&mut self) {
        let _ = self.catch_up();
    }
}

impl<T: Table> Beside<T> {
    fn new(table: T) -> Self {
        let (full, to_write) = sync_channel(BATCHES);
        let (written, empty) = sync_channel(BATCHES);
        for _ in 1..BATCHES {
            // There is room for all of them, and the other end is held here.
            let _ = written.send(Vec::with_capacity(BATCH));
        }
        let thread = thread::spawn(move || write(table, &to_write, &written));
        Self { rows: Vec::with_capacity(BATCH), full, empty, thread }
    }

    /// Passes the filled batch on for an empty one; false if nobody writes any more.
    #[cold]
    fn hand_over(&mut self) -> bool {
        let Ok(empty) = self.empty.recv() else { return false };
        let rows = mem::replace(&mut self.rows, empty);
        self.full.send(rows).is_ok()
    }

    /// The table with all rows, or why it could not be written.
    fn end(self) -> io::Result<T> {
        let Self { rows, full, empty, thread } = self;
        // A thread that has failed takes none.
        let _ = full.send(rows);
        drop((full, empty));
        thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

/// Writes what comes until no more does.
fn write<T: Table>(
    mut table: T,
    to_write: &Receiver<Vec<T::Row>>,
    written: &SyncSender<Vec<T::Row>>,
) -> io::Result<T> {
    for mut rows in to_write {
        rows.iter().try_for_each(|row| table.write(row))?;
        rows.clear();
        // Whoever is at the end takes none back.
        let _ = written.send(rows);
    }
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Takes so many rows, and fails then.
    struct Numbers {
        taken: Vec<usize>,
        most: usize,
    }

    impl Table for Numbers {
        type Row = usize;

        fn write(&mut self, row: &usize) -> io::Result<()> {
            if self.taken.len() == self.most {
                return Err(io::ErrorKind::StorageFull.into());
            }
            self.taken.push(*row);
            Ok(())
        }
    }

    #[test]
    fn all_rows_are_written_in_their_order_whoever_writes_them() {
        for threads in [1, 2] {
            for count in [0, 1, BATCH - 1, BATCH, BATCH + 1, 100 * BATCH + 7] {
                let table = Numbers { taken: Vec::new(), most: usize::MAX };
                let mut behind = Behind::new(table, threads);
                (0..count).for_each(|row| behind.write(row).expect("there is room"));
                behind.catch_up().expect("there is room");
                behind.write(count).expect("there is room");
                let table = behind.into_inner().expect("nothing has failed");
                assert!(table.taken.into_iter().eq(0..=count), "{threads} {count}");
            }
        }
    }

    #[test]
    fn what_cannot_be_written_is_said_once() {
        for threads in [1, 2] {
            for most in [0, 10, 3 * BATCH, 20 * BATCH] {
                let mut behind = Behind::new(Numbers { taken: Vec::new(), most }, threads);
                let said = (0..=most).filter(|row| behind.write(*row).is_err()).count();
                let last = usize::from(behind.catch_up().is_err());
                assert_eq!(said + last, 1, "{threads} {most}");
            }
        }
    }

    /// Tells when it is dropped.
    struct DropSignal(SyncSender<()>);

    impl Drop for DropSignal {
        fn drop(&mut self) {
            let _ = self.0.send(());
        }
    }

    impl Table for DropSignal {
        type Row = ();

        fn write(&mut self, (): &()) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_table_that_is_given_up_is_gone() {
        let (told, gone) = sync_channel(1);
        let mut behind = Behind::new(DropSignal(told), 2);
        (0..3 * BATCH).for_each(|_| behind.write(()).expect("it takes everything"));
        drop(behind);
        assert!(gone.try_recv().is_ok());
    }
}
