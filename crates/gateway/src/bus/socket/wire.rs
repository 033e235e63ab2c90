//! Frames and filters as SocketCAN's sockets carry them: `struct can_frame`, `struct canfd_frame`
//! and `struct can_filter` of linux/can.h.

use tertius_core::frame::{Frame, Id, Kind};

/// Size of `struct can_frame`: identifier 4, length 1, padding 3, data 8.
pub(super) const CLASSIC: usize = 16;
/// Size of `struct canfd_frame`: identifier 4, length 1, flags 1, padding 2, data 64.
pub(super) const FD: usize = 72;
/// Size of `struct can_filter`.
pub(super) const FILTER: usize = 8;

const EXTENDED_FLAG: u32 = libc::CAN_EFF_FLAG;
const REMOTE_FLAG: u32 = libc::CAN_RTR_FLAG;
const ERROR_FLAG: u32 = libc::CAN_ERR_FLAG;

/// Flags that are kept: bit-rate switch and error state. The kernel may also set CANFD_FDF, which
/// only says that it is an FD frame.
const FD_FLAGS: u8 = (libc::CANFD_BRS | libc::CANFD_ESI) as u8;

const CLASSIC_DATA: u8 = 8;
const DATA: usize = 8;

/// An identifier with its flags, as the kernel expects it.
fn to_kernel(id: Id) -> u32 {
    if id.is_extended() { id.value() | EXTENDED_FLAG } else { id.value() }
}

fn from_kernel(word: u32) -> Id {
    let id = if word & EXTENDED_FLAG == 0 {
        Id::standard(word & libc::CAN_SFF_MASK)
    } else {
        Id::extended(word & libc::CAN_EFF_MASK)
    };
    id.expect("a masked identifier is in range")
}

/// Fills everything except the time stamp; returns `false`, with `frame` undefined, if `bytes` are
/// not a frame.
pub(super) fn read(bytes: &[u8], frame: &mut Frame) -> bool {
    let Some((&[i0, i1, i2, i3, length, flags, ..], data)) = bytes.split_first_chunk::<DATA>()
    else {
        return false;
    };
    let word = u32::from_ne_bytes([i0, i1, i2, i3]);
    let size = match bytes.len() {
        CLASSIC if length <= CLASSIC_DATA => CLASSIC - DATA,
        FD if usize::from(length) <= FD - DATA => FD - DATA,
        _ => return false,
    };
    (frame.id, frame.kind) = match bytes.len() {
        FD => (from_kernel(word), Kind::Fd { flags: flags & FD_FLAGS }),
        // As candump's recordings are read: the error class in an extended identifier.
        _ if word & ERROR_FLAG != 0 => (from_kernel(word | EXTENDED_FLAG), Kind::Error),
        _ if word & REMOTE_FLAG != 0 => (from_kernel(word), Kind::Remote { length }),
        _ => (from_kernel(word), Kind::Data),
    };
    frame.buffer_mut()[..size].copy_from_slice(data);
    let length = if matches!(frame.kind, Kind::Remote { .. }) { 0 } else { length };
    frame.set_length(usize::from(length));
    true
}

/// A frame in the kernel's format; see [`Self::as_bytes`].
pub(super) struct Outgoing {
    bytes: [u8; FD],
    size: usize,
}

impl Outgoing {
    /// Converts a frame that a bus can carry.
    pub(super) fn new(frame: &Frame) -> Self {
        let data = frame.data();
        let (size, flags, word, length) = match frame.kind {
            Kind::Data => (CLASSIC, 0, to_kernel(frame.id), frame.length() as u8),
            Kind::Remote { length } => (CLASSIC, 0, to_kernel(frame.id) | REMOTE_FLAG, length),
            Kind::Error => (CLASSIC, 0, frame.id.value() | ERROR_FLAG, frame.length() as u8),
            Kind::Fd { flags } => (FD, flags & FD_FLAGS, to_kernel(frame.id), frame.length() as u8),
        };
        let mut bytes = [0; FD];
        bytes[..4].copy_from_slice(&word.to_ne_bytes());
        (bytes[4], bytes[5]) = (length, flags);
        bytes[DATA..][..data.len()].copy_from_slice(data);
        Self { bytes, size }
    }

    pub(super) fn as_bytes(&self) -> &[u8] {
        &self.bytes[..self.size]
    }
}

/// Value of CAN_RAW_FILTER that passes the data frames (classic and FD) of exactly these
/// identifiers, each once: `struct can_filter` is identifier and mask.
///
/// The masks are those for which the kernel has a look-up by identifier (`can_rcv_list_find`).
pub(super) fn filters(ids: &[Id]) -> Vec<u8> {
    let mut ids = ids.to_vec();
    ids.sort_unstable();
    ids.dedup();
    ids.iter()
        .flat_map(|&id| {
            let bits = if id.is_extended() { libc::CAN_EFF_MASK } else { libc::CAN_SFF_MASK };
            [to_kernel(id), bits | EXTENDED_FLAG | REMOTE_FLAG]
        })
        .flat_map(u32::to_ne_bytes)
        .collect()
}

/// Value of CAN_RAW_FILTER that passes everything, remote frames included.
pub(super) fn no_filter() -> Vec<u8> {
    vec![0; FILTER]
}

#[cfg(test)]
mod tests {
    use super::*;
    use tertius_core::time::Timestamp;

    fn standard(id: u32) -> Id {
        Id::standard(id).unwrap()
    }

    fn extended(id: u32) -> Id {
        Id::extended(id).unwrap()
    }

    fn frame(id: Id, kind: Kind, data: &[u8]) -> Frame {
        Frame::new(Timestamp::default(), id, kind, data)
    }

    fn blank() -> Frame {
        frame(standard(0x7FF), Kind::Error, &[0xEE; 64])
    }

    #[test]
    fn every_kind_of_frame_comes_back_as_it_went() {
        let long: Vec<u8> = (0..64).collect();
        for sent in [
            frame(standard(0), Kind::Data, &[]),
            frame(standard(0x7FF), Kind::Data, &long[..8]),
            frame(extended(0x7FF), Kind::Data, &[1]),
            frame(extended(0x1FFF_FFFF), Kind::Data, &long[..3]),
            frame(standard(0x123), Kind::Remote { length: 5 }, &[]),
            frame(extended(0x80), Kind::Remote { length: 0 }, &[]),
            frame(extended(0x44), Kind::Error, &long[..8]),
            frame(standard(0x181), Kind::Fd { flags: 0 }, &long[..2]),
            frame(extended(0x181), Kind::Fd { flags: 3 }, &long),
            frame(extended(0x181), Kind::Fd { flags: 1 }, &long[..48]),
        ] {
            let mut read_back = blank();
            assert!(read(Outgoing::new(&sent).as_bytes(), &mut read_back), "{sent:?}");
            assert_eq!(read_back, sent);
        }
    }

    #[test]
    fn bytes_stand_where_the_kernel_has_them() {
        let sent = frame(extended(0x0012_3456), Kind::Fd { flags: 1 }, &[0xA1, 0xA2]);
        let bytes = Outgoing::new(&sent);
        assert_eq!(bytes.as_bytes().len(), 72);
        assert_eq!(bytes.as_bytes()[..4], 0x8012_3456_u32.to_ne_bytes());
        assert_eq!(bytes.as_bytes()[4..11], [2, 1, 0, 0, 0xA1, 0xA2, 0]);
        let remote = frame(standard(0x123), Kind::Remote { length: 5 }, &[]);
        let bytes = Outgoing::new(&remote);
        assert_eq!(bytes.as_bytes()[..5], [&0x4000_0123_u32.to_ne_bytes()[..], &[5]].concat());
        assert_eq!(bytes.as_bytes().len(), 16);
    }

    #[test]
    fn the_flag_that_only_says_fd_is_not_kept() {
        let mut bytes = [0; FD];
        bytes[5] = 0x04 | 0x01;
        let mut found = blank();
        assert!(read(&bytes, &mut found));
        assert_eq!(found.kind, Kind::Fd { flags: 1 });
    }

    #[test]
    fn what_is_no_frame_is_refused() {
        let mut frame = blank();
        for size in [0, 1, 7, 8, 15, 17, 71] {
            assert!(!read(&[0; FD][..size], &mut frame), "{size} bytes");
        }
        let mut classic = [0; CLASSIC];
        classic[4] = 9;
        assert!(!read(&classic, &mut frame));
        let mut fd = [0; FD];
        fd[4] = 65;
        assert!(!read(&fd, &mut frame));
    }

    #[test]
    fn a_filter_names_the_format_and_shuts_out_remote_frames() {
        let words: Vec<u32> = filters(&[extended(0x181), standard(0x181), standard(0x181)])
            .chunks(4)
            .map(|word| u32::from_ne_bytes(word.try_into().unwrap()))
            .collect();
        assert_eq!(words, [0x181, 0xC000_07FF, 0x8000_0181, 0xDFFF_FFFF]);
    }
}
