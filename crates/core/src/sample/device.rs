//! What a CANopen device says of itself, beside its readings: emergency messages and heartbeats (CiA 301).
//!
//! An emergency message is the device's own word that it is faulty, until it says that the error is over. A
//! heartbeat has the device's state: in *pre-operational* and *stopped* it sends no PDOs, so that a missing
//! reading is explained and nobody is to blame. Heartbeats that stop after they have begun mean that the
//! device is lost. Nothing is expected of a device that has sent none.

mod saved;

use super::emergency::{Emergency, Severity};
use core::fmt;

/// Device of a cylinder, as an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceRole {
    C1 = 0,
    C2 = 1,
    Valve = 2,
}

impl DeviceRole {
    pub const ALL: [Self; 3] = [Self::C1, Self::C2, Self::Valve];

    /// Name for people.
    pub const fn label(self) -> &'static str {
        match self {
            Self::C1 => "C1",
            Self::C2 => "C2",
            Self::Valve => "the valve",
        }
    }

    /// Name in files and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::C1 => "c1",
            Self::C2 => "c2",
            Self::Valve => "valve",
        }
    }
}

/// Design of the watch on one device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeviceDesign {
    /// CANopen node-ID, 1 to 127.
    pub node: u8,
    /// Cycles without a heartbeat after which the device is lost; `None`: its heartbeats may stop.
    pub heartbeat: Option<u32>,
}

/// State of a device in the network (NMT, CiA 301).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceState {
    /// It has just started, and will be pre-operational.
    Initialising,
    Stopped,
    Operational,
    PreOperational,
}

impl DeviceState {
    /// The state in a heartbeat; `None` if there is none of that number. The highest bit is the toggle bit
    /// of an answer to node guarding, which has the same identifier.
    pub fn read(data: &[u8]) -> Option<Self> {
        match data.first()? & 0x7F {
            0 => Some(Self::Initialising),
            4 => Some(Self::Stopped),
            5 => Some(Self::Operational),
            127 => Some(Self::PreOperational),
            _ => None,
        }
    }

    /// Name in files and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Initialising => "initialising",
            Self::Stopped => "stopped",
            Self::Operational => "operational",
            Self::PreOperational => "pre-operational",
        }
    }
}

/// What a device says of itself in a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DeviceWord {
    #[default]
    Nothing,
    /// It is not operational, and sends no readings.
    NotOperational,
    /// Its heartbeats have stopped.
    Lost,
    /// It has an error.
    Failed,
}

/// Why a device is faulty, by its own word or its silence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeviceReport {
    /// CANopen node-ID of the device.
    pub node: u8,
    pub reason: DeviceReason,
}

/// Reason of a [`DeviceReport`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceReason {
    /// The device says that it has an error.
    Emergency(Emergency),
    /// Its heartbeats have stopped.
    HeartbeatLost,
}

impl DeviceReport {
    /// Node-ID and error code, without what may change while the report means the same to a person.
    pub const fn meaning(&self) -> (u8, Option<u16>) {
        match self.reason {
            DeviceReason::Emergency(emergency) => (self.node, Some(emergency.code)),
            DeviceReason::HeartbeatLost => (self.node, None),
        }
    }
}

impl fmt::Display for DeviceReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.reason {
            DeviceReason::Emergency(emergency) => write!(f, "node {} says {emergency}", self.node),
            DeviceReason::HeartbeatLost => write!(f, "node {} has lost its heartbeat", self.node),
        }
    }
}

/// What a device said that is no fault of its readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceNews {
    /// It is now in this state.
    State(DeviceState),
    /// It complains about the network.
    Network(Emergency),
}

/// Follows one device.
#[derive(Clone, Copy, Debug)]
pub struct DeviceWatch {
    design: DeviceDesign,
    /// Whether it sends readings, which it does only while it is operational.
    sends_readings: bool,
    /// Live cycles since the newest heartbeat; `None` before the first.
    age: Option<u32>,
    state: DeviceState,
    /// Whether the state came after the last cycle.
    fresh: bool,
    fault: Option<Emergency>,
    /// State that was reported last.
    reported: DeviceState,
    complaint: Option<Emergency>,
}

impl DeviceWatch {
    /// A watch on a device of which nothing was heard yet.
    pub const fn new(design: DeviceDesign, role: DeviceRole) -> Self {
        Self {
            design,
            sends_readings: !matches!(role, DeviceRole::Valve),
            age: None,
            state: DeviceState::Operational,
            fresh: false,
            fault: None,
            reported: DeviceState::Operational,
            complaint: None,
        }
    }

    /// Takes an emergency message.
    pub fn emergency(&mut self, emergency: Emergency) {
        match emergency.severity() {
            Severity::Faulty => self.fault = Some(emergency),
            // Which of its errors it still has only the register tells.
            Severity::Remaining => self.fault = self.fault.map(|_| emergency),
            Severity::Over => self.fault = None,
            Severity::Network => self.complaint = Some(emergency),
        }
    }

    /// Takes a heartbeat, or the boot-up message, which begins it. A device that starts has no error until
    /// it says so again.
    pub fn heartbeat(&mut self, state: DeviceState) {
        let starts = state == DeviceState::Initialising;
        if starts {
            (self.fault, self.age) = (None, self.age.map(|_| 0));
        } else {
            self.age = Some(0);
        }
        // Without heartbeats nothing would tell when a valve becomes operational.
        if !starts || self.sends_readings || self.age.is_some() {
            (self.state, self.fresh) = (state, true);
        }
    }

    /// Takes a cycle. In one that is not `live` nothing ages; `reads` tells whether a reading of the device
    /// came.
    pub fn step(&mut self, live: bool, reads: bool) -> DeviceWord {
        // It is operational again, and its next heartbeat will say so.
        if reads && !self.fresh {
            self.state = DeviceState::Operational;
        }
        self.fresh = false;
        if live {
            self.age = self.age.map(|age| age.saturating_add(1));
        }
        self.word()
    }

    /// What the device says of itself now.
    pub fn word(&self) -> DeviceWord {
        let lost = self.design.heartbeat.zip(self.age).is_some_and(|(most, age)| age > most);
        match self.state {
            _ if self.fault.is_some() => DeviceWord::Failed,
            _ if lost => DeviceWord::Lost,
            DeviceState::Operational => DeviceWord::Nothing,
            _ => DeviceWord::NotOperational,
        }
    }

    /// Why the device is faulty, if it is.
    pub fn report(&self) -> Option<DeviceReport> {
        let reason = match self.word() {
            DeviceWord::Failed => DeviceReason::Emergency(self.fault?),
            DeviceWord::Lost => DeviceReason::HeartbeatLost,
            DeviceWord::Nothing | DeviceWord::NotOperational => return None,
        };
        Some(DeviceReport { node: self.design.node, reason })
    }

    /// CANopen node-ID of the device.
    pub const fn node(&self) -> u8 {
        self.design.node
    }

    /// News that was not reported yet, one at a time.
    pub fn take_news(&mut self) -> Option<DeviceNews> {
        if self.reported != self.state {
            self.reported = self.state;
            return Some(DeviceNews::State(self.state));
        }
        self.complaint.take().map(DeviceNews::Network)
    }

    /// Restarts the time since the newest heartbeat, after a jump in time or a loss of the bus. What the
    /// device has said stands.
    pub fn interrupt(&mut self) {
        self.age = self.age.map(|_| 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DESIGN: DeviceDesign = DeviceDesign { node: 3, heartbeat: Some(5) };
    const MAGNET: Emergency = Emergency { code: 0x5000, register: 0x81, detail: [0; 5] };
    const OVER: Emergency = Emergency { code: 0, register: 0, detail: [0; 5] };
    const HEATED: Emergency = Emergency { code: 0x4210, register: 0x09, detail: [0; 5] };

    fn watch() -> DeviceWatch {
        DeviceWatch::new(DESIGN, DeviceRole::C1)
    }

    /// What it says in each of `cycles` live cycles, with readings or without.
    fn words(watch: &mut DeviceWatch, cycles: usize, reads: bool) -> Vec<DeviceWord> {
        (0..cycles).map(|_| watch.step(true, reads)).collect()
    }

    #[test]
    fn an_error_lasts_until_the_device_says_that_it_is_over() {
        let mut watch = watch();
        assert_eq!(watch.report(), None);
        watch.emergency(MAGNET);
        assert_eq!(words(&mut watch, 100, true), [DeviceWord::Failed; 100]);
        let report = DeviceReport { node: 3, reason: DeviceReason::Emergency(MAGNET) };
        assert_eq!(watch.report(), Some(report));
        // The newest error is told; one that is over leaves the others.
        watch.emergency(HEATED);
        let left = Emergency { register: 0x81, ..OVER };
        watch.emergency(left);
        assert_eq!(watch.report().map(|it| it.reason), Some(DeviceReason::Emergency(left)));
        watch.emergency(OVER);
        assert_eq!((watch.word(), watch.report()), (DeviceWord::Nothing, None));
        watch.emergency(left);
        assert_eq!(
            watch.word(),
            DeviceWord::Nothing,
            "without a code nothing was said to be wrong"
        );
    }

    #[test]
    fn a_complaint_about_the_network_is_told_once_and_blames_nobody() {
        let mut watch = watch();
        let missed = Emergency { code: 0x8130, register: 0x11, detail: [0; 5] };
        watch.emergency(missed);
        assert_eq!((watch.word(), watch.report()), (DeviceWord::Nothing, None));
        assert_eq!(watch.take_news(), Some(DeviceNews::Network(missed)));
        assert_eq!(watch.take_news(), None);
        watch.emergency(MAGNET);
        watch.emergency(missed);
        assert_eq!(watch.word(), DeviceWord::Failed, "and clears nobody");
    }

    #[test]
    fn heartbeats_that_stop_are_a_loss_and_those_that_never_came_are_none() {
        let mut never = watch();
        assert_eq!(words(&mut never, 100, false), [DeviceWord::Nothing; 100]);
        let mut watch = watch();
        watch.heartbeat(DeviceState::Operational);
        assert_eq!(words(&mut watch, 5, true), [DeviceWord::Nothing; 5]);
        for _ in 0..100 {
            assert_eq!(watch.step(false, true), DeviceWord::Nothing, "in silence nothing ages");
        }
        assert_eq!(watch.step(true, true), DeviceWord::Lost, "readings do not stand in for it");
        assert_eq!(watch.report().map(|it| it.reason), Some(DeviceReason::HeartbeatLost));
        watch.interrupt();
        assert_eq!(words(&mut watch, 6, true)[4..], [DeviceWord::Nothing, DeviceWord::Lost]);
        watch.heartbeat(DeviceState::Operational);
        assert_eq!(watch.word(), DeviceWord::Nothing);
    }

    #[test]
    fn heartbeats_of_an_unknown_period_may_stop() {
        let design = DeviceDesign { heartbeat: None, ..DESIGN };
        let mut watch = DeviceWatch::new(design, DeviceRole::C1);
        watch.heartbeat(DeviceState::Operational);
        assert_eq!(words(&mut watch, 1000, true), [DeviceWord::Nothing; 1000]);
    }

    #[test]
    fn who_is_not_operational_says_so_until_readings_come() {
        use DeviceNews::State;
        use DeviceState::{Operational, PreOperational, Stopped};
        let mut watch = watch();
        watch.heartbeat(Operational);
        assert_eq!(watch.take_news(), None, "this was to be expected");
        for state in [PreOperational, Stopped] {
            watch.heartbeat(state);
            assert_eq!(
                watch.step(true, true),
                DeviceWord::NotOperational,
                "the reading came before"
            );
            assert_eq!(watch.take_news(), Some(State(state)));
            assert_eq!((watch.take_news(), watch.report()), (None, None));
        }
        assert_eq!(words(&mut watch, 2, false), [DeviceWord::NotOperational; 2]);
        assert_eq!(
            watch.step(true, true),
            DeviceWord::Nothing,
            "it was started between heartbeats"
        );
        assert_eq!(watch.take_news(), Some(State(Operational)));
        assert_eq!(words(&mut watch, 2, false), [DeviceWord::Nothing, DeviceWord::Lost]);
    }

    #[test]
    fn a_device_that_starts_has_no_error_and_owes_no_heartbeat() {
        let mut watch = watch();
        watch.emergency(MAGNET);
        watch.heartbeat(DeviceState::Initialising);
        assert_eq!(words(&mut watch, 100, false), [DeviceWord::NotOperational; 100]);
        // A valve without heartbeats would never be said to be operational.
        let mut valve = DeviceWatch::new(DESIGN, DeviceRole::Valve);
        valve.heartbeat(DeviceState::Initialising);
        assert_eq!((valve.step(true, false), valve.take_news()), (DeviceWord::Nothing, None));
        valve.heartbeat(DeviceState::Operational);
        valve.heartbeat(DeviceState::Initialising);
        assert_eq!(valve.step(true, false), DeviceWord::NotOperational);
        assert_eq!(words(&mut valve, 5, false)[4], DeviceWord::Lost, "it owes them now");
    }

    #[test]
    fn states_are_the_numbers_of_cia_301() {
        use DeviceState::{Initialising, Operational, PreOperational, Stopped};
        let states = [(0, Initialising), (4, Stopped), (5, Operational), (127, PreOperational)];
        for number in 0..=u8::MAX {
            let expected = states.iter().find(|(known, _)| *known == number & 0x7F);
            assert_eq!(DeviceState::read(&[number]), expected.map(|(_, state)| *state), "{number}");
        }
        assert_eq!(DeviceState::read(&[]), None);
    }
}
