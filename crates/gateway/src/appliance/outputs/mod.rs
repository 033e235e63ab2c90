//! The outputs: protocols over which the machine's state is served or published, beside the page.
//!
//! An output only reads what the data path has stored, and a thread of its own does so. A new one is a folder here, its
//! declaration, and its line in [`outputs`].

#[cfg(feature = "surroundings")]
mod listening;
#[cfg(feature = "modbus")]
pub mod modbus;
#[cfg(feature = "mqtt")]
pub mod mqtt;
#[cfg(feature = "opcua")]
pub mod opcua;
mod output;
#[cfg(any(feature = "modbus", feature = "opcua"))]
mod patience;

#[cfg(feature = "surroundings")]
pub(super) use listening::{UNIT, advice_on};
pub use output::{Output, OutputPlan};

/// Every output of this program, each switched off.
#[cfg(feature = "surroundings")]
pub fn outputs() -> Vec<Box<dyn Output>> {
    vec![
        Box::<listening::Listening<modbus::ModbusServer>>::default(),
        #[cfg(feature = "opcua")]
        Box::<listening::Listening<opcua::OpcuaServer>>::default(),
        Box::<mqtt::MqttOutput>::default(),
    ]
}
