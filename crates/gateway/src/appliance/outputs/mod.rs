//! The outputs: protocols over which the machine's state is served or published, beside the page.
//!
//! An output only reads what the data path has stored, and a thread of its own does so. A new one is a folder here, its
//! declaration, and its line in [`outputs`].

mod listening;
pub mod modbus;
pub mod mqtt;
#[cfg(feature = "opcua")]
pub mod opcua;
mod output;
mod patience;

pub use listening::{Listening, ServedProtocol, StateServer};
pub(super) use listening::{UNIT, advice_on};
pub use output::{Output, OutputPlan};

/// Every output of this program, each switched off.
pub fn outputs() -> Vec<Box<dyn Output>> {
    vec![
        Box::<Listening<modbus::ModbusServer>>::default(),
        #[cfg(feature = "opcua")]
        Box::<Listening<opcua::OpcuaServer>>::default(),
        Box::<mqtt::MqttOutput>::default(),
    ]
}
