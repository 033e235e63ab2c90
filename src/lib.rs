//! Tertius: a third vote for redundant position transducers on the cylinders of
//! motion-compensated gangways.
//!
//! This package is the program; its crates, below `crates/`, are passed on here room by room. The way of the
//! data, one room each:
//!
//! ```text
//! bus ─ frames ─→ decode ─ values ─→ sample ─ cycles ─→ observe ─┐ R1, R2
//!  ↑                                          └───────→ compare ─┤ R3
//!  └───── the gateway's own frames ───── alarm ←──── verdict ←───┘
//! ```
//!
//! - [`bus`]: where frames come from and go to: candump recordings, SocketCAN, a bus inside the
//!   program. The only room that knows files of frames and sockets.
//! - [`decode`]: bit plans, from frames to values. [`dbc`]: a DBC, checked and compiled to them.
//! - [`sample`]: which readings belong to one cycle, and whether they are plausible.
//! - [`observe`]: the discrete model (4-1), its gain from the Riccati equation, the innovation.
//! - [`compare`]: C1 against the corrected C2 (5-20).
//! - [`verdict`]: thresholds with hysteresis, the kind of fault, the suspect (Figure 5-17).
//! - [`sequential`]: the detectors beyond the thesis: the evidence of many samples weighed at once, which
//!   transducer it is, and the end stop as a reference, whose history outlives the program.
//! - [`estimate`]: the virtual third sensor: each cylinder's length with its standard deviation, of the
//!   transducers that nobody blames and of the command.
//! - [`alarm`]: warnings that stand, their levels (Table 2-1), the frames that tell of them.
//! - [`monitor`]: the rooms above, from `decode` to `alarm`, as one machine: frames in, records,
//!   warnings and frames out.
//! - [`live`]: the monitor on a port: what waits to be sent, what befalls the bus, and going on after
//!   it; the proxy that puts faults between two interfaces of a test bench. [`appliance`]: the box
//!   around it: signals, the service manager, the log, the history of the stops on disk, its health
//!   and metrics over HTTP.
//! - [`inject`]: faults put into frames, to see that they are found.
//! - [`survey`]: the readings of a recording, cycle by cycle, for what learns from it. [`identify`]: the
//!   model (4-1) from a healthy recording (chapter 4): census, streaming QR, validation on data held
//!   back. [`calibrate`]: a and b of (5-20), and the band of R3. [`extremes`]: how large a healthy
//!   residual gets, and how seldom. [`tune`]: Q, R, δ_l and δ_h for a wanted rate of false alarms, and
//!   the smallest faults that follow. [`commission`]: all of them in turn, a trial on what was held
//!   back, and whether the machine can be watched by it. [`tables`]: what was learnt, as text that the
//!   configuration reads. [`learnt`]: what is kept of healthy recordings, so that those of several days
//!   add up.
//! - [`hexapod`], [`sea`], [`plant`], [`controller`], [`transducer`]: a machine in software, part by
//!   part. [`simulator`]: all of it as one, which sends frames. The monitor uses none of them.
//! - [`evaluate`]: what the monitor is worth: Monte Carlo on the simulator.
//! - [`config`]: the one table per machine, and the design of a monitor that follows from it and from the
//!   DBC. [`report`]: what people and scripts read: text, lines of JSON, pages of HTML with figures.
//!   [`cli`]: the commands. [`failure`]: why one of them did not do what it was asked.
//!
//! Everything from `decode` to `monitor` is one crate, `tertius_core`, without std: time comes with the
//! frames as integers of nanoseconds ([`time`]), and there is no clock, socket, file, thread or global. That
//! is why a replay says what the gateway said. Deliberately absent: any action on the machine. Tertius
//! advises; the machine's own safety system acts.
//!
//! Three features leave rooms out when they are off, and all of them are on by default: `cli` has the commands, the
//! program and what surrounds the gateway in it; `http` has health and metrics ([`appliance::http`],
//! [`appliance::telemetry`]); `plots` has [`report`]. `cli` needs the other two. Without them there are the bus, the
//! live monitor and all crates.
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

#[cfg(feature = "cli")]
#[macro_use]
pub mod failure;

#[cfg(feature = "http")]
pub mod appliance;
pub mod bus;
#[cfg(feature = "cli")]
pub mod cli;
pub mod live;
#[cfg(feature = "plots")]
pub mod report;

pub use tertius_assess::{commission, evaluate};
pub use tertius_config as config;
pub use tertius_core::{
    alarm, compare, decode, error_frame, estimate, frame, monitor, observe, sample, sequential,
    time, verdict,
};
pub use tertius_dbc as dbc;
pub use tertius_learn::{calibrate, extremes, identify, learnt, survey, tables, tune};
pub use tertius_machine::{controller, hexapod, inject, plant, sea, simulator, transducer};
