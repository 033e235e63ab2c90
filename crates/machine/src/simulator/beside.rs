//! Signals that the machine sends beside those that a configuration names.

use serde::Deserialize;

/// What a machine's signals are called in its DBC, `MESSAGE.SIGNAL`. One without a name, or one that the DBC does not have,
/// is not sent unless the configuration names it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SignalTable {
    pub roll: Option<String>,
    pub pitch: Option<String>,
    pub yaw: Option<String>,
    pub surge: Option<String>,
    pub sway: Option<String>,
    pub heave: Option<String>,
    /// The supply pressure.
    pub supply: Option<String>,
    /// A cylinder's spool; `{n}` stands for the cylinder's number.
    pub spool: Option<String>,
    /// Counters that rise by one in each cycle.
    pub counters: Vec<String>,
}

impl SignalTable {
    /// Those of the layout of `dbc/e-type.dbc`, for plants whose file does not say.
    pub fn of_the_e_type() -> Self {
        let named = |name: &str| Some(name.to_owned());
        Self {
            roll: named("Mru_Attitude.Roll"),
            pitch: named("Mru_Attitude.Pitch"),
            yaw: named("Mru_Attitude.Yaw"),
            surge: named("Mru_Translation.Surge"),
            sway: named("Mru_Translation.Sway"),
            heave: named("Mru_Translation.Heave"),
            supply: named("Plc_State.SupplyPressure"),
            spool: named("Cyl{n}_Valve.SpoolPosition"),
            counters: vec!["Plc_State.Counter".to_owned()],
        }
    }
}
