//! Runs lessons and trials: on one thread here, on many where there are threads.

use super::stand::StandError;

/// Does jobs that do not depend on each other.
pub trait Workers {
    /// Does the job of every index below `count`, and hands each result over to `take` in any order, until one fails.
    ///
    /// # Errors
    /// That of a job.
    fn each<T: Send>(
        &self,
        count: usize,
        job: impl Fn(usize) -> Result<T, StandError> + Sync,
        take: impl FnMut(usize, T),
    ) -> Result<(), StandError>;
}

/// Does one job after the other, from the first to the last or the other way round.
#[derive(Clone, Copy, Debug, Default)]
pub struct Serial {
    pub reversed: bool,
}

impl Workers for Serial {
    fn each<T: Send>(
        &self,
        count: usize,
        job: impl Fn(usize) -> Result<T, StandError> + Sync,
        mut take: impl FnMut(usize, T),
    ) -> Result<(), StandError> {
        for index in 0..count {
            let index = if self.reversed { count - 1 - index } else { index };
            take(index, job(index)?);
        }
        Ok(())
    }
}
