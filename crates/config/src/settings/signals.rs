//! `[signals]`.

use super::device::{Role, device_name, object_name};
use crate::kinds::text;
use crate::schema::{Kind, table};
use crate::text::{PLACEHOLDER, TextRule, object_of, of_cylinder};

table! {
    /// Where the signals are: `MESSAGE.SIGNAL` of the DBC, on another bus than the first `second:MESSAGE.SIGNAL`.
    pub struct Signals = SIGNALS {
        sync: Option<String> = None => text(TextRule::Message),
            "\"Sync\"", "the message that opens a cycle";
        state: Option<String> = None => text(TextRule::Signal),
            "\"Plc_State.PlatformState\"", "the platform's state";
        supply: Option<String> = None => text(TextRule::Signal),
            "\"Plc_State.SupplyPressure\"", "the supply pressure P_S, bar, for `identify --nonlinear`";
        vessel_roll: Option<String> = None => text(TextRule::Signal),
            "\"Mru_Attitude.Roll\"", "the vessel's roll by its motion sensor, rad; with the other angles and the table hexapod";
        vessel_pitch: Option<String> = None => text(TextRule::Signal),
            "\"Mru_Attitude.Pitch\"", "the vessel's pitch by its motion sensor, rad";
        top_roll: Option<String> = None => text(TextRule::Signal),
            "\"Top_Attitude.Roll\"", "the transfer deck's roll by a sensor on it, rad";
        top_pitch: Option<String> = None => text(TextRule::Signal),
            "\"Top_Attitude.Pitch\"", "the transfer deck's pitch by a sensor on it, rad";
        cylinder: CylinderSignals => Kind::Table(&CYLINDER_SIGNALS),
            "", "the signals of a cylinder";
    }
}

table! {
    /// Signal names of one cylinder; `{n}` stands for its number.
    pub struct CylinderSignals = CYLINDER_SIGNALS {
        c1: String => text(TextRule::CylinderSignal),
            "\"Cyl{n}_C1.Position\"", "the position by transducer C1, m";
        c1_velocity: Option<String> = None => text(TextRule::CylinderSignal),
            "\"Cyl{n}_C1.Velocity\"", "the velocity by transducer C1, m/s";
        c1_status: Option<String> = None => text(TextRule::CylinderSignal),
            "\"Cyl{n}_C1.Status\"", "the status bits of transducer C1";
        c1_counter: Option<String> = None => text(TextRule::CylinderSignal),
            "\"Cyl{n}_C1.Counter\"", "the alive counter of transducer C1";
        c2: Option<String> = None => text(TextRule::CylinderSignal),
            "\"Cyl{n}_C2.Position\"", "the position by transducer C2, m";
        c2_velocity: Option<String> = None => text(TextRule::CylinderSignal),
            "\"Cyl{n}_C2.Velocity\"", "the velocity by transducer C2, m/s";
        c2_status: Option<String> = None => text(TextRule::CylinderSignal),
            "\"Cyl{n}_C2.Status\"", "the status bits of transducer C2";
        c2_counter: Option<String> = None => text(TextRule::CylinderSignal),
            "\"Cyl{n}_C2.Counter\"", "the alive counter of transducer C2";
        control_speed: String => text(TextRule::CylinderSignal),
            "\"Cyl{n}_Valve.ControlSpeed\"", "the commanded speed u of (4-1), m/s";
        pressure_bottom: Option<String> = None => text(TextRule::CylinderSignal),
            "\"Cyl{n}_Valve.PressureBottom\"", "the pressure in the bottom chamber";
        pressure_rod: Option<String> = None => text(TextRule::CylinderSignal),
            "\"Cyl{n}_Valve.PressureRod\"", "the pressure in the rod chamber";
        load_pressure: Option<String> = None => text(TextRule::CylinderSignal),
            "\"Cyl{n}_Load.Pressure\"", "the load pressure P_L itself, bar, where the machine sends it";
        spool: Option<String> = None => text(TextRule::CylinderSignal),
            "\"Cyl{n}_Valve.SpoolPosition\"",
            "the position of the main spool, positive extends, for `identify --nonlinear`";
    }
}

impl CylinderSignals {
    /// Every configured signal with its key; `{n}` is not yet replaced.
    pub fn named(&self) -> impl Iterator<Item = (&'static str, &str)> {
        [
            ("c1", Some(&self.c1)),
            ("c1_velocity", self.c1_velocity.as_ref()),
            ("c1_status", self.c1_status.as_ref()),
            ("c1_counter", self.c1_counter.as_ref()),
            ("c2", self.c2.as_ref()),
            ("c2_velocity", self.c2_velocity.as_ref()),
            ("c2_status", self.c2_status.as_ref()),
            ("c2_counter", self.c2_counter.as_ref()),
            ("control_speed", Some(&self.control_speed)),
            ("pressure_bottom", self.pressure_bottom.as_ref()),
            ("pressure_rod", self.pressure_rod.as_ref()),
            ("load_pressure", self.load_pressure.as_ref()),
            ("spool", self.spool.as_ref()),
        ]
        .into_iter()
        .filter_map(|(key, signal)| signal.map(|signal| (key, signal.as_str())))
    }

    /// Name of a signal for cylinder `n`, which replaces `{n}`; of a list, `{A,B,C}`, it is the name in its place.
    pub fn of_cylinder(signal: &str, n: u8) -> String {
        of_cylinder(signal, n)
    }

    /// Turns each object into the name of a signal of its device, `c1 of cylinder {n}.0x6020:01`.
    pub(crate) fn name_objects(&mut self) {
        for (key, signal) in self.named_mut() {
            if let Some((index, sub_index)) = object_of(signal) {
                let device = device_name(role_of(key), PLACEHOLDER);
                *signal = format!("{device}.{}", object_name(index, sub_index));
            }
        }
    }

    /// Keys whose signals are objects of devices, and the transducer or valve that they are of.
    pub(crate) fn objects(&self) -> impl Iterator<Item = (&'static str, Option<Role>)> {
        let of_object = |(key, signal): (&'static str, &str)| {
            let role = role_of(key);
            signal.starts_with(&device_name(role, PLACEHOLDER)).then_some((key, role))
        };
        self.named().filter_map(of_object)
    }

    fn named_mut(&mut self) -> impl Iterator<Item = (&'static str, &mut String)> {
        [
            ("c1", Some(&mut self.c1)),
            ("c1_velocity", self.c1_velocity.as_mut()),
            ("c1_status", self.c1_status.as_mut()),
            ("c1_counter", self.c1_counter.as_mut()),
            ("c2", self.c2.as_mut()),
            ("c2_velocity", self.c2_velocity.as_mut()),
            ("c2_status", self.c2_status.as_mut()),
            ("c2_counter", self.c2_counter.as_mut()),
            ("control_speed", Some(&mut self.control_speed)),
            ("pressure_bottom", self.pressure_bottom.as_mut()),
            ("pressure_rod", self.pressure_rod.as_mut()),
            ("load_pressure", self.load_pressure.as_mut()),
            ("spool", self.spool.as_mut()),
        ]
        .into_iter()
        .filter_map(|(key, signal)| signal.map(|signal| (key, signal)))
    }
}

/// The transducer that a key of `[signals.cylinder]` is about; `None` for the valve.
fn role_of(key: &str) -> Option<Role> {
    match key.split('_').next() {
        Some("c1") => Some(Role::C1),
        Some("c2") => Some(Role::C2),
        _ => None,
    }
}
