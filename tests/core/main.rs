//! The library: recordings and DBCs, the monitor with its detectors, and the machine in software. Only `detection`
//! also runs the program, to replay recordings.

mod arrival_healthy;
mod candump;
mod candump_inputs;
mod candump_properties;
mod dbc;
mod dbc_cantools;
mod dbc_properties;
mod dbc_support;
mod detection;
mod devices;
mod e2e;
mod e_type_dbc;
mod eds;
mod eds_canopen;
mod eds_properties;
mod estimate;
mod frozen;
mod hexapod;
mod inject_properties;
mod inject_spec;
mod monitor_arrival;
mod monitor_cycles;
mod monitor_pages;
mod pdo;
mod plant;
mod riccati;
mod sea;
mod sequential;
mod sequential_healthy;
mod sequential_scale;
mod sequential_support;
mod stops;
mod survey;
mod trc;
mod year;
