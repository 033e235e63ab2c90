//! Detects other devices that send frames with the gateway's own identifiers.
//!
//! A socket does not receive the frames that it sends, so each such frame is another device's: a second gateway with the
//! same node number, or an attacker who reports that all is well.

use tertius_core::frame::{BusNumber, Frame, Id, Kind};
use tertius_core::monitor::Notice;
use tertius_core::sample::dispute::Doubt;
use tertius_core::time::{Span, Timestamp};

/// Time without such a frame after which the imitation is over.
const OVER: Span = Span::from_nanos(10_000_000_000);

/// An identifier of the gateway's own.
#[derive(Clone, Copy, Debug)]
struct OwnIdentifier {
    id: Id,
    /// Time of the newest frame of another device, until it is over.
    imitated_at: Option<Timestamp>,
}

/// Watches for frames of other devices with the gateway's own identifiers.
#[derive(Clone, Debug, Default)]
pub struct ImitationWatch {
    own: Vec<OwnIdentifier>,
    /// Number of such frames.
    count: u64,
}

impl ImitationWatch {
    /// A watch for these `own` identifiers.
    pub fn new(own: Vec<Id>) -> Self {
        let own = own.into_iter().map(|id| OwnIdentifier { id, imitated_at: None }).collect();
        Self { own, count: 0 }
    }

    /// Number of frames of other devices with an own identifier.
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// Takes any frame from the bus on which the gateway sends; returns a notice if an imitation begins.
    #[inline]
    pub fn take(&mut self, frame: &Frame) -> Option<Notice> {
        let own = self.own.iter_mut().find(|own| own.id == frame.id)?;
        if !matches!(frame.kind, Kind::Data | Kind::Fd { .. }) {
            return None;
        }
        self.count += 1;
        let is_news = own.imitated_at.replace(frame.timestamp).is_none();
        let (at, id) = (frame.timestamp, own.id);
        is_news.then_some(told(at, id, false))
    }

    /// Advances time to `now`; returns a notice if an imitation is over.
    #[inline]
    pub fn advance(&mut self, now: Timestamp) -> Option<Notice> {
        let is_over =
            |own: &&mut OwnIdentifier| own.imitated_at.is_some_and(|at| now.since(at) >= OVER);
        let own = self.own.iter_mut().find(is_over)?;
        own.imitated_at = None;
        Some(told(now, own.id, true))
    }
}

/// The notice that another device sends frames `id`, or no longer does.
const fn told(at: Timestamp, id: Id, is_over: bool) -> Notice {
    Notice::Doubt { at, id, bus: BusNumber::First, doubt: Doubt::Imitation, is_over }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(second: i64, id: u32) -> Frame {
        let id = Id::standard(id).expect("11 bits");
        Frame::new(Timestamp::from_nanos(second * 1_000_000_000), id, Kind::Data, &[0; 8])
    }

    #[test]
    fn an_imitation_is_told_once_and_is_over_after_ten_seconds_without() {
        let ids = [0x1D1, 0x2D1].map(|id| Id::standard(id).expect("11 bits"));
        let mut watch = ImitationWatch::new(ids.to_vec());
        let at = |second| Timestamp::from_nanos(second * 1_000_000_000);
        assert_eq!(watch.take(&frame(1, 0x181)), None, "a reading");
        let [id, _] = ids;
        assert_eq!(watch.take(&frame(1, 0x1D1)), Some(told(at(1), id, false)));
        for second in 2..20 {
            assert_eq!(watch.take(&frame(second, 0x1D1)), None);
            assert_eq!(watch.advance(at(second)), None);
        }
        assert_eq!(watch.advance(at(28)), None);
        assert_eq!(watch.advance(at(29)), Some(told(at(29), id, true)));
        assert_eq!((watch.advance(at(60)), watch.count()), (None, 19));
        assert!(watch.take(&frame(61, 0x1D1)).is_some());
    }
}
