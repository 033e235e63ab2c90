//! `[signals]`.

use crate::kinds::text;
use crate::schema::{Kind, table};
use crate::text::TextRule;

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
