//! Frames of the CANopen services that wait to be sent.

use std::collections::VecDeque;
use tertius_core::alarm::{OwnFrame, Service};

/// Emergency messages in the order in which they came; the newest heartbeat and the newest answer,
/// since an older one is of no more use.
#[derive(Clone, Debug)]
pub(super) struct Waiting {
    emergencies: VecDeque<OwnFrame>,
    most: usize,
    heartbeat: Option<OwnFrame>,
    answer: Option<OwnFrame>,
}

impl Waiting {
    /// Room for `most` emergency messages; the oldest gives way.
    pub(super) fn new(most: usize) -> Self {
        Self { emergencies: VecDeque::with_capacity(most), most, heartbeat: None, answer: None }
    }

    pub(super) fn len(&self) -> usize {
        self.emergencies.len() + usize::from(self.heartbeat.is_some()) + self.answers()
    }

    fn answers(&self) -> usize {
        usize::from(self.answer.is_some())
    }

    /// Takes a frame of `service`; returns whether an older one gave way that still meant something.
    pub(super) fn put(&mut self, service: Service, frame: OwnFrame) -> bool {
        match service {
            Service::Heartbeat => self.heartbeat = Some(frame),
            Service::Answer => self.answer = Some(frame),
            Service::Emergency => {
                let full = self.emergencies.len() >= self.most;
                if full {
                    self.emergencies.pop_front();
                }
                self.emergencies.push_back(frame);
                return full;
            }
        }
        false
    }

    /// The emergency message or the heartbeat that comes next.
    pub(super) fn report(&self) -> Option<&OwnFrame> {
        self.emergencies.front().or(self.heartbeat.as_ref())
    }

    pub(super) fn answer(&self) -> Option<&OwnFrame> {
        self.answer.as_ref()
    }

    pub(super) fn take_report(&mut self) {
        if self.emergencies.pop_front().is_none() {
            self.heartbeat = None;
        }
    }

    pub(super) fn take_answer(&mut self) {
        self.answer = None;
    }

    /// Drops emergency messages and answers that are `old`, and returns their number. A heartbeat
    /// stays true.
    pub(super) fn drop_old(&mut self, old: impl Fn(&OwnFrame) -> bool) -> u64 {
        let before = self.len();
        while self.emergencies.front().is_some_and(&old) {
            self.emergencies.pop_front();
        }
        self.answer.take_if(|answer| old(answer));
        (before - self.len()) as u64
    }

    pub(super) fn clear(&mut self) {
        self.emergencies.clear();
        self.heartbeat = None;
        self.answer = None;
    }
}
