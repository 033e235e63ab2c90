//! Tertius: a third vote for redundant position transducers on the cylinders of
//! motion-compensated gangways.
//!
//! This package is the program: the commands, and why one failed. It re-exports the modules of its crates, which are below
//! `crates/`.
//! The path of the data, one module each:
//!
//! ```text
//! bus ─ frames ─→ decode ─ values ─→ sample ─ cycles ─→ observe ─┐ R1, R2
//!  ↑                                          └───────→ compare ─┤ R3
//!  └───── the gateway's own frames ───── alarm ←──── verdict ←───┘
//! ```
//!
//! - [`bus`]: sources and destinations of frames: recordings, SocketCAN, a bus inside the
//!   program.
//! - [`decode`]: bit plans, from frames to values. [`dbc`]: a DBC, checked and compiled to them.
//! - [`sample`]: groups readings into cycles and checks whether they are plausible, also by what their devices say of
//!   themselves.
//! - [`observe`]: the discrete model (4-1), its gain from the Riccati equation, the innovation.
//! - [`compare`]: C1 against the corrected C2 (5-20).
//! - [`verdict`]: thresholds with hysteresis, the kind of fault, the suspect (Figure 5-17).
//! - [`sequential`]: the detectors beyond the thesis: the evidence of many samples together, which
//!   transducer it is, and the end stop as a reference, whose history outlives the program.
//! - [`process`]: faults of the cylinder itself: what spool and pressures say of each other.
//! - [`estimate`]: the virtual third sensor: each cylinder's length with its standard deviation, from the
//!   transducers that nobody blames and of the command.
//! - [`alarm`]: standing warnings, their levels (Table 2-1), and the frames that report them.
//! - [`incident`]: the warnings that have one cause, as one story, and [`story`]: that in words.
//! - [`monitor`]: the modules above, from `decode` to `alarm`, as one machine: frames in, records,
//!   warnings and frames out.
//! - [`canopen`]: the gateway as a CANopen node, which watches the monitor and answers the network.
//! - [`live`]: the monitor on a port: frames that wait to be sent, the state of the bus, and recovery; on a port that
//!   only listens;
//!   the proxy that puts faults between two interfaces of a test bench. [`appliance`]: the computer
//!   around it: signals, the service manager, the log, the history of the stops on disk, the flight
//!   recorder, the event store, a page for people, its health and metrics over HTTP, its state over Modbus, OPC UA and MQTT. [`alarm_list`]: incidents as
//!   alarms that people acknowledge.
//! - [`inject`]: puts faults into frames, to test whether they are found.
//! - [`survey`]: the readings of a recording, cycle by cycle, for learning. [`identify`]: the
//!   model (4-1) from a healthy recording (chapter 4): census, streaming QR, validation on data held
//!   back. [`calibrate`]: a and b of (5-20), and the band of R3. [`relate`]: the relations between spool, pressures, rods and
//!   supply, for the process detectors. [`extremes`]: extremes of healthy
//!   residuals. [`tune`]: Q, R, δ_l and δ_h for a wanted rate of false alarms, and
//!   the smallest faults that follow. [`commission`]: all of them in turn, a trial on what was held
//!   back, and a verdict on whether the result is fit for use. [`tables`]: what was learnt, as text that the
//!   configuration reads. [`learnt`]: frames kept of healthy recordings, so that those of several days
//!   add up. [`propose`]: a configuration from a DBC and a recording: which signals are what.
//! - [`hexapod`], [`sea`], [`plant`], [`controller`], [`transducer`]: a machine in software, part by
//!   part. [`simulator`]: the whole machine, which sends frames. The monitor uses none of these.
//! - [`evaluate`]: assessment of the monitor by Monte Carlo on the simulator.
//! - [`config`]: the one table per machine, and the design of a monitor that follows from it and from the
//!   DBC. [`report`]: output for people and scripts: text, lines of JSON, pages of HTML with figures.
//!   [`cli`]: the commands. [`failure`]: why a command failed.
//!
//! Everything from `decode` to `monitor` is one crate, `tertius_core`, without std: time comes with
//! the frames as integers of nanoseconds ([`time`]), and there is no clock, socket, file, thread or
//! global. Therefore a replay agrees with the gateway. Tertius deliberately does not act on the
//! machine: it advises, and the machine's own safety system acts.
//!
//! Features leave rooms out when they are off. All but two are on by default: `cli` has the commands and [`appliance`], `plots`
//! has [`report`], `learning` has what learns from recordings and what assesses a monitor, and `zstd` reads compressed
//! recordings. `cli` needs all of them, and `demo`, which has the program with `tertius demo` alone. Without any there are the
//! bus, the live monitor and the other crates. Two are off: `parquet` has the results of a replay as tables in Parquet files,
//! and `opcua` the server of OPC UA.
//!
//! Frames in, warnings out:
//!
//! ```
//! use tertius::alarm::{Detector, Warning};
//! use tertius::config::{self, design};
//! use tertius::dbc::Database;
//! use tertius::frame::{Frame, Id, Kind};
//! use tertius::monitor::Monitor;
//! use tertius::time::{Span, Timestamp};
//!
//! let dbc = r#"VERSION ""
//! BU_: Machine
//! BO_ 385 C1: 2 Machine
//!  SG_ Position : 0|16@1+ (0.0001,-1.5) [-1.5|1.5] "m" Machine
//! BO_ 401 C2: 2 Machine
//!  SG_ Position : 0|16@1+ (0.0001,-1.5) [-1.5|1.5] "m" Machine
//! BO_ 417 Valve: 2 Machine
//!  SG_ ControlSpeed : 0|16@1- (0.0001,0) [0|0] "m/s" Machine
//! "#;
//! let toml = r#"
//! machine = { name = "One cylinder", cylinders = 1, sample_time = 0.02, stroke = [-1.5, 1.5] }
//! bus = { interface = "virtual", dbc = "machine.dbc" }
//! signals.cylinder = { c1 = "C1.Position", c2 = "C2.Position", control_speed = "Valve.ControlSpeed" }
//! "#;
//! let (settings, _) = config::parse("machine.toml", toml)?;
//! let design = design::judging(&settings, &Database::parse(dbc)?).expect("they fit");
//! let mut monitor = Monitor::new(design);
//!
//! let mut warnings: Vec<Warning> = Vec::new();
//! for cycle in 0..200 {
//!     let at = Timestamp::default().after(Span::from_seconds(0.02 * f64::from(cycle)));
//!     // From the hundredth cycle on C1 reads 3 mm too much.
//!     let c1 = if cycle < 100 { 15_000_u16 } else { 15_030 };
//!     for (id, count) in [(385, c1), (401, 15_000), (417, 0)] {
//!         let id = Id::standard(id).expect("it has 11 bits");
//!         monitor.take(&Frame::new(at, id, Kind::Data, &count.to_le_bytes()), &mut warnings);
//!     }
//! }
//! let first = warnings.first().expect("3 mm are more than 1.5 mm");
//! assert_eq!((first.cylinder, first.timestamp.as_nanos()), (1, 2_000_000_000));
//! assert!(warnings.iter().any(|warning| warning.detector == Detector::Fde3));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[cfg(feature = "demo")]
#[macro_use]
pub mod failure;

#[cfg(feature = "demo")]
pub mod cli;

/// Sources and destinations of frames: recordings, and live interfaces.
pub mod bus {
    pub use tertius_gateway::bus::{
        Identifiers, ListeningPort, Port, PortCounts, PortError, Received, Sent, Stamps,
        Unrestricted, UnrestrictedPort, embedded, socket,
    };
    pub use tertius_recordings::*;
}

pub use tertius_canopen as canopen;
pub use tertius_config as config;
pub use tertius_core::{
    alarm, blame, compare, decode, error_frame, estimate, frame, incident, monitor, observe,
    process, sample, sequential, text, time, verdict,
};
pub use tertius_dbc as dbc;
#[cfg(feature = "cli")]
pub use tertius_gateway::appliance;
pub use tertius_gateway::{alarm_list, live};
#[cfg(feature = "learning")]
pub use tertius_lab::{commission, evaluate};
#[cfg(feature = "learning")]
pub use tertius_learn::{
    calibrate, extremes, identify, learnt, propose, relate, survey, tables, tune,
};
pub use tertius_machine::{controller, hexapod, inject, plant, sea, simulator, transducer};
#[cfg(feature = "plots")]
pub use tertius_report::report;
pub use tertius_report::story;
