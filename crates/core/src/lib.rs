//! The core of Tertius: time-stamped frames in, records, warnings and the gateway's own frames out.
//!
//! ```text
//! frames ─→ decode ─ values ─→ sample ─ cycles ─→ observe ─┐ R1, R2
//!                                 └─────────────→ compare ─┤ R3
//! the gateway's own frames ←─── alarm ←─── blame ←─ verdict ←┘
//! ```
//!
//! - [`frame`], [`error_frame`]: CAN and CAN FD frames with their time stamps. [`time`]: points and spans,
//!   integers of nanoseconds.
//! - [`decode`]: bit plans, from frames to values.
//! - [`sample`]: groups readings into cycles and checks whether they are plausible, also by what their devices say of
//!   themselves.
//! - [`observe`]: the discrete model (4-1), its gain from the Riccati equation, the innovation.
//! - [`compare`]: C1 against the corrected C2 (5-20).
//! - [`verdict`]: thresholds with hysteresis and the kind of fault.
//! - [`sequential`]: the detectors beyond the thesis: the evidence of many samples together, which
//!   transducer it is, and the end stop as a reference.
//! - [`process`]: faults of the cylinder itself: what spool and pressures say of each other.
//! - [`estimate`]: the virtual third sensor.
//! - [`hexapod`]: all cylinders together: the deck's attitude by their lengths, against a sensor on it.
//! - [`blame`]: whose fault a finding is (Figure 5-17), rule by rule.
//! - [`alarm`]: standing warnings, their levels (Table 2-1), and the frames that report them.
//! - [`incident`]: the warnings of a cylinder that have one cause, as one story.
//! - [`text`]: lengths, lists and counts in words.
//! - [`monitor`]: all of them as one machine.
//! - [`state`]: what of each of them is saved, so that another monitor goes on where one has stopped.
//!
//! Time comes with the frames: there is no clock, socket, file, thread or global. The caller
//! provides the [`monitor::MonitorDesign`] from which a monitor is made; the configuration crate
//! makes one from a TOML file and a DBC.
//!
//! The crate needs no operating system and takes its floating-point functions from libm: the same
//! frames give the same bytes with every C library and on every processor. [`frame::Frame`] is an
//! [`embedded_can::Frame`], so that any such driver can deliver frames and send the monitor's.

// Tests compare with the functions of std.
#![cfg_attr(not(test), no_std)]

extern crate alloc;

pub mod alarm;
pub mod blame;
pub mod compare;
pub mod decode;
pub mod error_frame;
pub mod estimate;
pub mod frame;
pub mod hexapod;
pub mod incident;
pub mod monitor;
pub mod observe;
pub mod process;
pub mod sample;
pub mod sequential;
pub mod state;
pub mod text;
pub mod time;
pub mod verdict;
