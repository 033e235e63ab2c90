//! Settings as the monitor needs them: one cylinder at a time, with defaults filled in.

use super::settings::{
    Canopen, Cylinder, CylinderProcess, CylinderSequential, Device, Model, Settings,
};
use tertius_core::alarm::OwnMessage;
use tertius_core::alarm::frames::{identifiers, service_identifiers};
use tertius_core::alarm::own::Sending;
use tertius_core::decode::Raw;
use tertius_core::frame::Id;
use tertius_core::sequential::{self, DriftLimits};
use tertius_dbc::Signal;

/// Share of the false alarms that the process detectors may bring.
const PROCESS_SHARE: f64 = 0.05;

/// Least level, nats, however many false alarms are allowed: weaker evidence is never enough.
const LEAST_LEVEL: f64 = 5.0;

/// The sample time of the thesis's machine, on which Table 4-1 was identified, s.
const TABLE_4_1_TIME: f64 = 0.02;

/// The overflow code of an S7 analogue input, which has 16 bits.
const S7_OVERFLOW: i64 = 32767;

impl Settings {
    /// The lengths that a position of `signal` can have, m: the stroke, and the DBC's [min|max] where no
    /// raw counts are configured.
    pub fn valid_lengths(&self, signal: &Signal) -> [f64; 2] {
        let [lowest, highest] = self.machine.stroke;
        match (signal.range, self.plausibility.valid_raw) {
            (Some([minimum, maximum]), None) => [lowest.max(minimum), highest.min(maximum)],
            _ => [lowest, highest],
        }
    }

    /// The raw codes with which a position of `signal` tells a broken wire: those configured; else that
    /// of an S7 analogue input, if the signal has its 16 bits and no healthy reading has that code.
    pub fn broken_wire_codes(&self, signal: &Signal) -> Vec<i64> {
        if let Some(codes) = &self.plausibility.broken_wire_codes {
            return codes.clone();
        }
        let plan = &signal.plan;
        let is_input = plan.bits() == 16 && !plan.is_float();
        let [lowest, highest] = self.valid_lengths(signal);
        let length = plan.physical(Raw::Signed(S7_OVERFLOW));
        let by_count = self.plausibility.valid_raw;
        let is_healthy = (lowest..=highest).contains(&length)
            && by_count.is_none_or(|[low, high]| (low..=high).contains(&S7_OVERFLOW));
        if is_input && !is_healthy { vec![S7_OVERFLOW] } else { Vec::new() }
    }

    /// Number of whole cycles nearest to `seconds`.
    pub fn cycles(&self, seconds: f64) -> u32 {
        (seconds / self.machine.sample_time).round() as u32
    }

    /// Cycles within which repeated findings are one warning and do not raise anew.
    pub fn warning_cycles(&self) -> u32 {
        self.cycles(self.alarm.clear).max(1)
    }

    /// `(theta, gamma)` of (4-1) for cylinder `n`: its own, else those of `[model]`.
    pub fn model_of(&self, n: u8) -> ([f64; 5], [f64; 2]) {
        let own = self.own(n);
        let theta = own.and_then(|cylinder| cylinder.theta);
        let gamma = own.and_then(|cylinder| cylinder.gamma);
        (theta.unwrap_or(self.model.theta), gamma.unwrap_or(self.model.gamma))
    }

    /// The sample time that [`Self::model_of`] was made for, s; `None` where it is not known. Table
    /// 4-1's is known.
    pub fn model_time_of(&self, n: u8) -> Option<f64> {
        let own = self.own(n).filter(|own| own.theta.is_some() || own.gamma.is_some());
        let told = own.map_or(self.model.sample_time, |own| own.sample_time);
        let table = Model::default();
        let is_table = self.model_of(n) == (table.theta, table.gamma);
        told.or(is_table.then_some(TABLE_4_1_TIME))
    }

    /// The command at which cylinder `n` rests, m/s: its own, else that of `[model]`.
    pub fn command_offset_of(&self, n: u8) -> f64 {
        let own = self.own(n).and_then(|cylinder| cylinder.command_offset);
        own.unwrap_or(self.model.command_offset)
    }

    /// `(a, b)` of (5-20) for cylinder `n`, b in metres: Ĉ2 = a·C2 + b; without a table (1, 0).
    pub fn comparator_of(&self, n: u8) -> (f64, f64) {
        self.own(n).map_or((1.0, 0.0), |cylinder| (cylinder.c2_gain, cylinder.c2_offset))
    }

    /// Whether a calibration has told by how much C1 and C2 of cylinder `n` differ; (1, 0) of (5-20) tells nothing.
    pub fn is_aligned(&self, n: u8) -> bool {
        self.comparator_of(n) != (1.0, 0.0) || self.sequential_of(n).is_some()
    }

    /// Cylinders with a C2 that no calibration has compared with their C1.
    pub fn unaligned(&self) -> Vec<u8> {
        (1..=self.machine.cylinders).filter(|&n| self.has_c2(n) && !self.is_aligned(n)).collect()
    }

    /// Whether cylinder `n` has a C2.
    pub fn has_c2(&self, n: u8) -> bool {
        self.signals.cylinder.c2.is_some() && self.own(n).is_none_or(|own| own.c2)
    }

    /// Every signal of cylinder `n` with its key, without those of a C2 that it does not have; `{n}` is not yet
    /// replaced.
    pub fn signals_of(&self, n: u8) -> impl Iterator<Item = (&'static str, &str)> {
        let has_c2 = self.has_c2(n);
        self.signals.cylinder.named().filter(move |(key, _)| has_c2 || !key.starts_with("c2"))
    }

    /// Deadline of readings after the opening of their cycle, s.
    pub fn cycle_deadline(&self) -> f64 {
        self.machine.cycle_deadline.unwrap_or(0.8 * self.machine.sample_time)
    }

    /// Detectors that are switched off, in words; `None` if all judge.
    pub const fn switched_off(&self) -> Option<&'static str> {
        match (self.fde.enabled, self.fde.joint.is_some(), self.comparator.enabled) {
            (true, _, true) => None,
            (true, _, false) => Some("FDE3"),
            (false, false, true) => Some("FDE1 and FDE2"),
            (false, false, false) => Some("FDE1, FDE2 and FDE3"),
            (false, true, true) => Some("FDE1 and FDE2, but for joint evidence"),
            (false, true, false) => Some("FDE3, and FDE1 and FDE2 but for joint evidence"),
        }
    }

    /// Threshold below which |R3| counts towards clearing, m.
    pub fn comparator_low(&self) -> f64 {
        self.comparator.low.unwrap_or(0.75 * self.comparator.bound)
    }

    /// Calibration of the sequential detector of cylinder `n`, if there is one.
    pub fn sequential_of(&self, n: u8) -> Option<&CylinderSequential> {
        self.own(n)?.sequential.as_ref()
    }

    /// Level h of a cylinder that has none of its own, nats.
    pub fn sequential_level(&self) -> f64 {
        let Self { machine, sequential: budget, .. } = self;
        let by_rate =
            sequential::level(budget.false_alarms_per_year, machine.cylinders, machine.sample_time);
        budget.level.unwrap_or(by_rate.max(LEAST_LEVEL))
    }

    /// Level h of cylinder `n`, nats: a level set for all cylinders takes precedence over that of
    /// its calibration.
    pub fn sequential_level_of(&self, n: u8) -> f64 {
        let own = self.sequential_of(n).and_then(|fitted| fitted.level);
        own.filter(|_| self.sequential.level.is_none()).unwrap_or_else(|| self.sequential_level())
    }

    /// Tables of the process detector of cylinder `n`, if there are any.
    pub fn process_of(&self, n: u8) -> Option<&CylinderProcess> {
        self.own(n)?.process.as_ref()
    }

    /// Level of the process detectors, nats: where none is set, beyond that of the sequential ones, of whose budget
    /// they take a twentieth.
    pub fn process_level(&self) -> f64 {
        let Self { machine, sequential: budget, .. } = self;
        let rate = PROCESS_SHARE * budget.false_alarms_per_year;
        let by_rate = sequential::level(rate, machine.cylinders, machine.sample_time);
        self.process.level.unwrap_or(by_rate.max(LEAST_LEVEL))
    }

    /// Limits of how far a reading on the stop may move.
    pub fn drift_limits(&self) -> DriftLimits {
        let critical = self.comparator.critical;
        // As it is reached, nine times the time that it took is left, and each detector works as ever.
        let maintenance = self.sequential.maintenance.unwrap_or(critical / 10.0);
        DriftLimits { maintenance, critical }
    }

    /// Devices that describe themselves.
    pub fn devices(&self) -> &[Device] {
        &self.canopen.device
    }

    /// The gateway as a CANopen node; `None` if it is none.
    pub fn canopen_node(&self) -> Option<&Canopen> {
        Some(&self.canopen).filter(|canopen| canopen.node)
    }

    /// The identifiers that the gateway sends: those of its messages in the order of
    /// [`OwnMessage::ALL`], and those of a node's services.
    pub fn own_identifiers(&self) -> Vec<Id> {
        let node = self.gateway.node;
        let services = self.canopen_node().and_then(|_| service_identifiers(node));
        identifiers(node).into_iter().flatten().chain(services.into_iter().flatten()).collect()
    }

    /// Number of frames with a period that the gateway sends each second: Fd_Status, and heartbeats.
    pub fn reports(&self) -> f64 {
        let messages = OwnMessage::ALL.into_iter().map(OwnMessage::sending);
        let statuses: f64 = messages.filter_map(Sending::frequency).sum();
        statuses + self.canopen_node().map_or(0.0, Canopen::heartbeats)
    }

    /// Number of frames that the gateway sends each second whatever happens: [`Self::reports`], and
    /// Fd_Estimate for each cylinder in each cycle where it is sent.
    pub fn periodic_frames(&self) -> f64 {
        let cyclic = OwnMessage::ALL.iter().filter(|message| message.sending() == Sending::Cycles);
        let a_cycle = f64::from(self.machine.cylinders) * cyclic.count() as f64;
        let estimates = if self.estimate.send { a_cycle / self.machine.sample_time } else { 0.0 };
        self.reports() + estimates
    }

    fn own(&self, n: u8) -> Option<&Cylinder> {
        self.cylinder.iter().find(|cylinder| cylinder.n == n)
    }
}
