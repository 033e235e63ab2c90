//! Frames of others with the gateway's own identifiers.

use crate::live_gateway::{Bench, Notes, gateway};
use tertius::frame::{Frame, Id, Kind};
use tertius::monitor::Notice;
use tertius::sample::dispute::Doubt;
use tertius_testing::machine::Cycle;

impl Notes {
    /// What was told of frames that cannot be relied on.
    fn doubts(&self) -> Vec<(Id, Doubt, bool)> {
        let doubt = |notice: &Notice| match *notice {
            Notice::Doubt { id, doubt, is_over, .. } => Some((id, doubt, is_over)),
            _ => None,
        };
        self.notices.iter().filter_map(doubt).collect()
    }
}

/// Another device says that all is well, with the gateway's own identifiers.
#[test]
fn frames_of_others_with_own_identifiers_are_told_and_counted() {
    let mut bench = Bench::new();
    let own = [0x1D1, 0x2D1].map(|id| Id::standard(id).expect("11 bits"));
    bench.gateway = gateway().with_own_identifiers(own.to_vec());
    let mut frames: Vec<Frame> = (0..100).flat_map(|k| Cycle::new(k).frames()).collect();
    bench.run(&frames, 7);
    assert_eq!(
        (bench.notes.doubts(), bench.gateway.imitated()),
        (vec![], 0),
        "it does not hear itself"
    );
    assert!(bench.heard.iter().any(|frame| frame.id == own[0]));
    frames = (100..800).flat_map(|k| Cycle::new(k).frames()).collect();
    let forged = |frame: &Frame| Frame::new(frame.timestamp, own[0], Kind::Data, &[0x55; 8]);
    let forged: Vec<Frame> = frames.iter().step_by(25).take(40).map(forged).collect();
    frames.extend(forged);
    frames.sort_by_key(|frame| frame.timestamp);
    bench.run(&frames, 7);
    let doubts = [(own[0], Doubt::Imitation, false), (own[0], Doubt::Imitation, true)];
    assert_eq!((bench.notes.doubts(), bench.gateway.imitated()), (doubts.to_vec(), 40));
}
