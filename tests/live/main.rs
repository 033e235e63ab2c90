//! The gateway and the proxy on buses that are not in the kernel, and the HTTP of the gateway.

mod acts;
mod buses;
mod canopen;
mod devices;
mod downloads;
mod embedded_bus;
mod event_store;
mod flight_recorder;
mod imitation;
mod inject_proxy;
mod live_gateway;
mod logins;
mod metrics;
mod metrics_command;
mod metrics_support;
mod modbus;
mod modbus_document;
mod monitor_command;
mod mqtt;
#[cfg(feature = "opcua")]
mod opcua;
mod opcua_document;
mod overview;
mod page;
mod realtime;
mod run_virtual;
mod sparkplug;
mod tls;
