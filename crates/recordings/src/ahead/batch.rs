//! Frames on their way from one thread to another.

use std::ops::ControlFlow;
use tertius_core::frame::{BusNumber, Frame, Id, Kind};
use tertius_core::time::Timestamp;

/// Length of the longest payload that is kept beside its frame's header, bytes: that of a classic frame.
const SHORT: usize = 8;

/// Frames in the order of a recording.
///
/// A frame has room for CAN FD's 64 bytes, and hardly one of a machine uses more than eight. What one processor writes and
/// another one reads costs by the cache line, so that the short ones are packed: three in the place of one.
pub struct Batch {
    packed: Vec<Packed>,
    /// The longer ones, in their order.
    long: Vec<Frame>,
    /// What the packed ones are unpacked into.
    unpacked: Frame,
}

/// A frame, whose payload is elsewhere if it is longer than [`SHORT`].
#[derive(Clone, Copy, Debug)]
struct Packed {
    timestamp: Timestamp,
    id: Id,
    bus: BusNumber,
    kind: Kind,
    length: u8,
    bytes: [u8; SHORT],
}

impl Batch {
    /// An empty batch with room for `capacity` frames; `blank` is any frame.
    pub fn new(capacity: usize, blank: Frame) -> Self {
        Self { packed: Vec::with_capacity(capacity), long: Vec::new(), unpacked: blank }
    }

    /// Number of frames.
    pub fn len(&self) -> usize {
        self.packed.len()
    }

    /// Forgets all frames.
    pub fn clear(&mut self) {
        self.packed.clear();
        self.long.clear();
    }

    /// Adds a frame.
    #[inline]
    pub fn push(&mut self, frame: &Frame) {
        let Frame { timestamp, bus, id, kind, .. } = *frame;
        // A frame has at most 64 bytes.
        let length = frame.length() as u8;
        let bytes = frame.buffer().first_chunk().copied().unwrap_or_default();
        self.packed.push(Packed { timestamp, id, bus, kind, length, bytes });
        if frame.length() > SHORT {
            self.long.push(frame.clone());
        }
    }

    /// Passes the frames to `take`, until it breaks.
    #[inline]
    pub fn try_for_each(
        &mut self,
        mut take: impl FnMut(&Frame) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let Self { packed, long, unpacked: frame } = self;
        let mut long = long.iter();
        for packed in packed.iter() {
            if usize::from(packed.length) > SHORT {
                // There is one for each.
                long.next().map_or(ControlFlow::Continue(()), &mut take)?;
                continue;
            }
            frame.timestamp = packed.timestamp;
            frame.bus = packed.bus;
            frame.id = packed.id;
            frame.kind = packed.kind;
            frame.set_length(packed.length.into());
            frame.buffer_mut()[..SHORT].copy_from_slice(&packed.bytes);
            take(frame)?;
        }
        ControlFlow::Continue(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_of_any_length_come_out_as_they_went_in() {
        assert_eq!(size_of::<Packed>(), 24);
        let frame = |n: u8| {
            let id = Id::extended(n.into()).expect("29 bits");
            let data: Vec<u8> = (0..n % 65).map(|byte| byte ^ n).collect();
            let kind = match n % 4 {
                0 => Kind::Fd { flags: n },
                1 => Kind::Remote { length: n },
                2 => Kind::Error,
                _ => Kind::Data,
            };
            let bus = BusNumber::ALL[usize::from(n) % BusNumber::ALL.len()];
            Frame::new(Timestamp::from_nanos(n.into()), id, kind, &data).on(bus)
        };
        let mut batch = Batch::new(256, frame(255));
        for round in [0..=255, 64..=200, 0..=8] {
            batch.clear();
            round.clone().for_each(|n| batch.push(&frame(n)));
            assert_eq!(batch.len(), round.len());
            let mut expected = round;
            let flow = batch.try_for_each(|got| {
                assert_eq!(Some(got), expected.next().map(frame).as_ref());
                ControlFlow::Continue(())
            });
            assert_eq!((flow, expected.next()), (ControlFlow::Continue(()), None));
        }
    }
}
