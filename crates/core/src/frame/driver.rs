//! Frames to and from the drivers of `embedded_can`.

use super::{CLASSIC_DATA, Frame, Id, Kind};
use crate::time::Timestamp;
use embedded_can::{ExtendedId, StandardId};

impl Frame {
    /// A frame that a driver has received, at `timestamp`.
    pub fn received(timestamp: Timestamp, frame: &impl embedded_can::Frame) -> Self {
        let id = frame.id().into();
        if frame.is_remote_frame() {
            let kind = Kind::Remote { length: frame.dlc() as u8 };
            return Self::new(timestamp, id, kind, &[]);
        }
        let data = frame.data();
        Self::new(timestamp, id, Kind::Data, &data[..data.len().min(CLASSIC_DATA)])
    }

    /// The frame for a driver to send; `None` if the driver's type cannot represent it: CAN FD and
    /// error frames.
    pub fn for_driver<F: embedded_can::Frame>(&self) -> Option<F> {
        match self.kind {
            Kind::Data => F::new(self.id, self.data()),
            Kind::Remote { length } => F::new_remote(self.id, usize::from(length)),
            Kind::Fd { .. } | Kind::Error => None,
        }
    }
}

impl From<Id> for embedded_can::Id {
    fn from(id: Id) -> Self {
        const FITS: &str = "an identifier is within its format";
        if id.is_extended() {
            Self::Extended(ExtendedId::new(id.value()).expect(FITS))
        } else {
            Self::Standard(StandardId::new(id.value() as u16).expect(FITS))
        }
    }
}

impl From<embedded_can::Id> for Id {
    fn from(id: embedded_can::Id) -> Self {
        match id {
            embedded_can::Id::Standard(id) => Self(id.as_raw().into()),
            embedded_can::Id::Extended(id) => Self(id.as_raw() | Self::EXTENDED),
        }
    }
}

/// A frame made through this trait has the time stamp 0. Its payload is longer than eight bytes
/// only in a CAN FD frame.
impl embedded_can::Frame for Frame {
    fn new(id: impl Into<embedded_can::Id>, data: &[u8]) -> Option<Self> {
        let id: embedded_can::Id = id.into();
        let fits = data.len() <= CLASSIC_DATA;
        fits.then(|| Self::new(Timestamp::default(), id.into(), Kind::Data, data))
    }

    fn new_remote(id: impl Into<embedded_can::Id>, dlc: usize) -> Option<Self> {
        let id: embedded_can::Id = id.into();
        let kind = Kind::Remote { length: dlc as u8 };
        (dlc <= CLASSIC_DATA).then(|| Self::new(Timestamp::default(), id.into(), kind, &[]))
    }

    fn is_extended(&self) -> bool {
        self.id.is_extended()
    }

    fn is_remote_frame(&self) -> bool {
        matches!(self.kind, Kind::Remote { .. })
    }

    fn is_data_frame(&self) -> bool {
        matches!(self.kind, Kind::Data | Kind::Fd { .. })
    }

    fn id(&self) -> embedded_can::Id {
        self.id.into()
    }

    fn dlc(&self) -> usize {
        match self.kind {
            Kind::Remote { length } => usize::from(length),
            Kind::Data | Kind::Fd { .. } | Kind::Error => self.length(),
        }
    }

    fn data(&self) -> &[u8] {
        self.data()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_driver_is_told_the_kind_the_format_and_the_length() {
        use embedded_can::Frame as Driven;
        let [short, long] = [Id::standard(0x181), Id::extended(0x181)].map(|id| id.expect("fits"));
        let payload: &[u8] = &[1, 2, 3];
        for (id, kind, data, expected) in [
            (short, Kind::Data, payload, (false, false, true, 3)),
            (long, Kind::Fd { flags: 0 }, payload, (true, false, true, 3)),
            (short, Kind::Remote { length: 5 }, &[], (false, true, false, 5)),
            (long, Kind::Error, payload, (true, false, false, 3)),
        ] {
            let frame = Frame::new(Timestamp::default(), id, kind, data);
            let told = (
                Driven::is_extended(&frame),
                Driven::is_remote_frame(&frame),
                Driven::is_data_frame(&frame),
                Driven::dlc(&frame),
            );
            assert_eq!(told, expected, "{kind:?}");
            assert_eq!((Id::from(Driven::id(&frame)), Driven::data(&frame)), (id, data));
        }
    }

    #[test]
    fn what_a_driver_brings_and_takes_is_the_same_frame() {
        let ids =
            [Id::standard(0), Id::standard(0x7FF), Id::extended(0), Id::extended(0x1FFF_FFFF)];
        for id in ids.map(|id| id.expect("it is in range")) {
            let at = Timestamp::from_nanos(7);
            for length in 0..=8 {
                let remote = Frame::new(at, id, Kind::Remote { length: length as u8 }, &[]);
                for frame in [Frame::new(at, id, Kind::Data, &[0xA5; 8][..length]), remote] {
                    let driven: Frame = frame.for_driver().expect("it is a classic frame");
                    assert_eq!((driven.timestamp, driven.id), (Timestamp::default(), id));
                    assert_eq!(Frame::received(at, &driven), frame);
                }
            }
            for kind in [Kind::Error, Kind::Fd { flags: 0 }] {
                assert!(Frame::new(at, id, kind, &[0; 8]).for_driver::<Frame>().is_none());
            }
            assert!(<Frame as embedded_can::Frame>::new(id, &[0; 9]).is_none());
            assert!(<Frame as embedded_can::Frame>::new_remote(id, 9).is_none());
        }
    }
}
