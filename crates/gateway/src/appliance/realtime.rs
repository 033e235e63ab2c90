//! Real-time scheduling of the data path, where the configuration requests it.

use nix::errno::Errno;
use nix::sys::mman::{MlockAllFlags, mlockall};
use tertius_config::settings::Realtime;
use thread_priority::{
    NormalThreadSchedulePolicy, RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue,
    ThreadSchedulePolicy, set_thread_priority_and_policy, thread_native_id,
};
use tracing::{info, warn};

/// Value of the crate for a niceness of zero.
const NICE_ZERO: u8 = 48;

/// What the kernel refused, and what to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refused {
    #[error(
        "no real-time priority {priority}: {}; as a service, install tertius-realtime.conf \
         (LimitRTPRIO, RestrictRealtime=no); by hand, `ulimit -r {priority}` or CAP_SYS_NICE",
        .errno.desc()
    )]
    Priority { priority: u8, errno: Errno },
    #[error(
        "memory is not locked: {}; as a service, install tertius-realtime.conf (LimitMEMLOCK); by \
         hand, `ulimit -l unlimited` or CAP_IPC_LOCK",
        .errno.desc()
    )]
    Memory { errno: Errno },
}

/// Applies the requested settings to the calling thread, and logs the result. The gateway runs
/// without those that the kernel refuses. Threads that this one starts afterwards have to be made
/// [ordinary](be_ordinary).
pub fn apply(wanted: Realtime) {
    if wanted.lock_memory {
        match lock_memory() {
            Ok(()) => info!("memory is locked"),
            Err(refused) => warn!("{refused}; continuing without it"),
        }
    }
    if wanted.priority > 0 {
        match set_priority(wanted.priority) {
            Ok(()) => info!(priority = wanted.priority, "the data path runs in real time"),
            Err(refused) => warn!("{refused}; continuing without it"),
        }
    }
}

/// Locks all memory, present and future.
///
/// # Errors
/// RLIMIT_MEMLOCK is too small and CAP_IPC_LOCK is missing.
pub fn lock_memory() -> Result<(), Refused> {
    mlockall(MlockAllFlags::MCL_CURRENT | MlockAllFlags::MCL_FUTURE)
        .map_err(|errno| Refused::Memory { errno })
}

/// Sets SCHED_FIFO for the calling thread.
///
/// # Errors
/// RLIMIT_RTPRIO is too small and CAP_SYS_NICE is missing.
pub fn set_priority(priority: u8) -> Result<(), Refused> {
    let fifo = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    let value = ThreadPriorityValue::try_from(priority);
    let value = value.map_err(|_| Refused::Priority { priority, errno: Errno::EINVAL })?;
    let value = ThreadPriority::Crossplatform(value);
    set_thread_priority_and_policy(thread_native_id(), value, fifo).map_err(|error| {
        let errno = match error {
            thread_priority::Error::OS(code) => Errno::from_raw(code),
            _ => Errno::EINVAL,
        };
        Refused::Priority { priority, errno }
    })
}

/// Resets what the calling thread has inherited from the data path, which every thread beside it
/// does first. The kernel has a flag that prevents the inheritance; no safe interface to it was
/// found.
pub fn be_ordinary() {
    let other = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Other);
    let inherited = thread_priority::thread_schedule_policy();
    if inherited.is_ok_and(|policy| matches!(policy, ThreadSchedulePolicy::Realtime(_)))
        && let Ok(value) = ThreadPriorityValue::try_from(NICE_ZERO)
    {
        // Giving up a priority is always allowed; where the niceness that this sets too is not, it
        // stays as it is.
        let nice = ThreadPriority::Crossplatform(value);
        _ = set_thread_priority_and_policy(thread_native_id(), nice, other);
    }
}
