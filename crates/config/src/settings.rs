//! The configuration file as types, and its keys: each is declared once, by a row of a `table!`. Lengths are
//! metres, times seconds, speeds metres per second. A key that is absent in the file has the default of its
//! row.

mod calibration;
mod canopen;
mod cylinder;
mod device;
mod estimate;
mod fitted;
mod gateway;
mod hexapod;
mod judging;
mod levels;
mod machine;
mod nonlinear;
mod process;
mod recorder;
mod sequential;
mod signals;

use calibration::CALIBRATION;
pub use calibration::CalibrationOrigin;
use canopen::CANOPEN;
pub use canopen::Canopen;
use cylinder::CYLINDER;
pub use cylinder::Cylinder;
pub use device::{Device, DeviceKind, Role, object_name};
use estimate::ESTIMATE;
pub use estimate::Estimate;
use gateway::{GATEWAY, HTTP, MODBUS, MQTT, OPCUA, REALTIME, STORE};
pub use gateway::{Gateway, Http, Modbus, Mqtt, Opcua, Realtime, Store};
use hexapod::HEXAPOD;
pub use hexapod::Hexapod;
use judging::{ALARM, COMPARATOR, FDE, MODEL, OBSERVER, PLAUSIBILITY};
pub use judging::{Alarm, Comparator, Fde, Model, Observer, Plausibility};
use machine::{BUS, MACHINE};
pub use machine::{Bus, Machine, OtherBus};
pub use nonlinear::{CylinderNonlinear, Stribeck, ValveCurve, ValveFlow};
use process::PROCESS;
pub use process::{
    ChambersTable, CylinderProcess, FlowTable, FrictionTable, ProcessSettings, SpoolTable,
    SupplyTable,
};
use recorder::RECORDER;
pub use recorder::Recorder;
use sequential::SEQUENTIAL;
pub use sequential::{CylinderExcursions, CylinderSequential, Sequential};
use signals::SIGNALS;
pub use signals::{CylinderSignals, Signals};

use super::schema::{Kind, table};
pub use super::text::{LISTEN_OFF, PLACEHOLDER, SYSTEM, bus_of, object_of};

table! {
    /// The whole file.
    pub struct Settings = ROOT {
        machine: Machine => Kind::Table(&MACHINE),
            "", "what the machine is";
        bus: Bus => Kind::Table(&BUS),
            "", "where its frames are and what they mean";
        signals: Signals => Kind::Table(&SIGNALS),
            "", "which signals of the DBC are monitored";
        plausibility: Plausibility = Plausibility::default() => Kind::Table(&PLAUSIBILITY),
            "", "when a reading is rejected before any model is asked";
        model: Model = Model::default() => Kind::Table(&MODEL),
            "", "the discrete model (4-1)";
        observer: Observer = Observer::default() => Kind::Table(&OBSERVER),
            "", "weights of the Riccati equation";
        fde: Fde = Fde::default() => Kind::Table(&FDE),
            "", "thresholds of R1 and R2, m";
        comparator: Comparator = Comparator::default() => Kind::Table(&COMPARATOR),
            "", "thresholds of R3, m";
        alarm: Alarm = Alarm::default() => Kind::Table(&ALARM),
            "", "how warnings are raised and cleared";
        sequential: Sequential = Sequential::default() => Kind::Table(&SEQUENTIAL),
            "", "the sequential detectors, of cylinders that are calibrated for it";
        process: ProcessSettings = ProcessSettings::default() => Kind::Table(&PROCESS),
            "", "the process detectors, of cylinders that are calibrated for it";
        hexapod: Option<Hexapod> = None => Kind::Table(&HEXAPOD),
            "", "the platform's geometry, for an attitude sensor on the deck";
        estimate: Estimate = Estimate::default() => Kind::Table(&ESTIMATE),
            "", "the virtual third sensor: each cylinder's length with its standard deviation";
        gateway: Gateway = Gateway::default() => Kind::Table(&GATEWAY),
            "", "the gateway's own node on the bus";
        canopen: Canopen = Canopen::default() => Kind::Table(&CANOPEN),
            "", "CANopen: the gateway as a node, and devices on the bus";
        http: Http = Http::default() => Kind::Table(&HTTP),
            "", "the gateway's own state over HTTP";
        modbus: Modbus = Modbus::default() => Kind::Table(&MODBUS),
            "", "the machine's state over Modbus TCP";
        opcua: Opcua = Opcua::default() => Kind::Table(&OPCUA),
            "", "the machine's state and alarms over OPC UA, of a program that is built with it";
        mqtt: Mqtt = Mqtt::default() => Kind::Table(&MQTT),
            "", "state and events, published over MQTT 5";
        store: Store = Store::default() => Kind::Table(&STORE),
            "", "what is kept of incidents and events";
        recorder: Recorder = Recorder::default() => Kind::Table(&RECORDER),
            "", "the flight recorder: the frames around each incident";
        realtime: Realtime = Realtime::default() => Kind::Table(&REALTIME),
            "", "what the gateway asks of the kernel";
        calibration: CalibrationOrigin = CalibrationOrigin::default() => Kind::Table(&CALIBRATION),
            "", "where the learnt tables come from";
        cylinder: Vec<Cylinder> = Vec::new() => Kind::Tables(&CYLINDER),
            "", "overrides for one cylinder";
    }
}

#[cfg(test)]
mod tests;
