//! The frames of the gateway's CANopen services: EMCY, the answers of its SDO server, and heartbeat.

use super::own::{NODES, OwnContent, OwnFrame, Service};
use crate::frame::Id;
use crate::time::Timestamp;

/// The further identifiers that the gateway sends as a CANopen node, in the order of
/// [`Service::ALL`]; `None` unless `node` is 1 to 127.
pub fn service_identifiers(node: u8) -> Option<[Id; 3]> {
    let [emergency, answer, heartbeat] = Service::ALL.map(|service| {
        Id::standard(service as u32 + u32::from(node)).filter(|_| NODES.contains(&node))
    });
    Some([emergency?, answer?, heartbeat?])
}

/// Makes the frames of the gateway's CANopen services. Their contents are the node's.
#[derive(Clone, Copy, Debug)]
pub struct ServiceEncoder([Id; 3]);

impl ServiceEncoder {
    /// The encoder of the gateway with CANopen node number `node`; `None` unless it is 1 to 127.
    pub fn new(node: u8) -> Option<Self> {
        service_identifiers(node).map(Self)
    }

    /// An emergency message.
    pub fn emergency(&self, at: Timestamp, data: [u8; 8]) -> OwnFrame {
        self.frame(0, at, &data)
    }

    /// An answer of the SDO server.
    pub fn answer(&self, at: Timestamp, data: [u8; 8]) -> OwnFrame {
        self.frame(1, at, &data)
    }

    /// A heartbeat; with state 0 it is the boot-up message.
    pub fn heartbeat(&self, at: Timestamp, state: u8) -> OwnFrame {
        self.frame(2, at, &[state])
    }

    fn frame(&self, index: usize, at: Timestamp, data: &[u8]) -> OwnFrame {
        OwnFrame::new(OwnContent::Service(Service::ALL[index]), at, self.0[index], data)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alarm::frames::{Encoder, identifiers};
    use crate::alarm::status::Status;

    #[test]
    fn the_services_of_a_node_have_its_identifiers_and_no_others() {
        let at = Timestamp::from_nanos(7);
        for node in 0..=u8::MAX {
            let Some(encoder) = ServiceEncoder::new(node) else {
                assert!(node == 0 || node > 127, "{node}");
                continue;
            };
            let sent = [
                encoder.emergency(at, [1; 8]),
                encoder.answer(at, [2; 8]),
                encoder.heartbeat(at, 5),
            ];
            let base = [0x080, 0x580, 0x700].map(|base| base + u32::from(node));
            let ids = service_identifiers(node).expect("it has an encoder");
            assert_eq!(ids.map(Id::value), base);
            for (frame, (id, service)) in sent.iter().zip(ids.into_iter().zip(Service::ALL)) {
                assert_eq!((frame.as_frame().id, frame.service()), (id, Some(service)));
                assert_eq!(frame.message(), None);
            }
            assert!(identifiers(node).expect("a node").iter().all(|id| !ids.contains(id)));
        }
        let status = Encoder::new(81).expect("a node").status(at, &Status::default());
        assert_eq!(status.service(), None);
    }
}
