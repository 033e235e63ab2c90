//! Many frames in one system call.

use std::io::IoSliceMut;
use std::os::fd::RawFd;

use nix::sys::socket::{ControlMessageOwned, MsgFlags, MultiHeaders, RecvMsg, recvmmsg};
use nix::sys::time::TimeSpec;

use super::wire;
use tertius_core::time::Timestamp;

/// Number of frames read in one system call.
pub(super) const BATCH: usize = 64;

/// Buffers for one system call's frames.
pub(super) struct Batch {
    buffers: Box<[[u8; wire::FD]; BATCH]>,
}

/// A frame as the kernel delivers it.
pub(super) struct Message<'a> {
    /// A `struct can_frame` or `struct canfd_frame`; empty if it was longer than either.
    pub(super) bytes: &'a [u8],
    /// Time stamp of the kernel.
    pub(super) software: Option<Timestamp>,
    /// Time stamp of the controller.
    pub(super) hardware: Option<Timestamp>,
    /// Kernel's count of dropped frames, if there are any.
    pub(super) drops: Option<u32>,
}

impl Batch {
    pub(super) fn new() -> Self {
        Self { buffers: Box::new([[0; wire::FD]; BATCH]) }
    }

    /// Passes the frames in the queue to `each`, oldest first, at most [`BATCH`], and returns their
    /// number. A smaller number means that the queue is empty, or that the next call will return an
    /// error. With `wait` it waits for the first frame, for as long as the socket is set to.
    ///
    /// # Errors
    /// EAGAIN if there are no frames; otherwise the socket's error.
    pub(super) fn read(
        &mut self,
        socket: RawFd,
        wait: bool,
        mut each: impl FnMut(&Message<'_>),
    ) -> nix::Result<usize> {
        let mut slices = self.buffers.each_mut().map(|buffer| [IoSliceMut::new(buffer)]);
        // Made anew for each call (three allocations of 11 KiB in all): nix does not set the room
        // for control messages back, so that after a frame without a drop count there would be none
        // for the next one's.
        let space = nix::cmsg_space!([TimeSpec; 3], TimeSpec, u32);
        let flags = if wait { MsgFlags::MSG_WAITFORONE } else { MsgFlags::MSG_DONTWAIT };
        let mut headers = MultiHeaders::<()>::preallocate(BATCH, Some(space));
        let messages = recvmmsg(socket, &mut headers, &mut slices, flags, None)?;
        let mut count = 0;
        for message in messages {
            each(&Message::from(&message));
            count += 1;
        }
        Ok(count)
    }
}

impl<'a> From<&RecvMsg<'_, 'a, ()>> for Message<'a> {
    fn from(message: &RecvMsg<'_, 'a, ()>) -> Self {
        let whole = !message.flags.contains(MsgFlags::MSG_TRUNC);
        let bytes = message.iovs().next().filter(|_| whole).unwrap_or_default();
        let mut found = Self { bytes, software: None, hardware: None, drops: None };
        // No error but of our own making: a buffer too small for the control messages. The frame
        // then counts as unstamped.
        for control in message.cmsgs().into_iter().flatten() {
            match control {
                ControlMessageOwned::ScmTimestampsns(stamps) => {
                    found.software = timestamp(stamps.system);
                    found.hardware = timestamp(stamps.hw_raw);
                }
                ControlMessageOwned::ScmTimestampns(stamp) => found.software = timestamp(stamp),
                ControlMessageOwned::RxqOvfl(count) => found.drops = Some(count),
                _ => {}
            }
        }
        found
    }
}

/// The time stamp; `None` for zero, which the kernel writes where it has none.
fn timestamp(spec: TimeSpec) -> Option<Timestamp> {
    let nanos = spec.tv_sec().saturating_mul(1_000_000_000).saturating_add(spec.tv_nsec());
    (nanos != 0).then(|| Timestamp::from_nanos(nanos))
}
