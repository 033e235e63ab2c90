//! Tertius: a third vote for redundant position transducers on the cylinders of
//! motion-compensated gangways.
//!
//! The way of the data, one room each:
//!
//! ```text
//! bus ─ frames ─→ decode ─ values ─→ sample ─ cycles ─→ observe ─┐ R1, R2
//!  ↑                                          └───────→ compare ─┤ R3
//!  └───── the gateway's own frames ───── alarm ←──── verdict ←───┘
//! ```
//!
//! - [`bus`]: candump recordings as a source of frames, and the log of frames sent. The only room
//!   that knows files of frames.
//! - [`decode`]: a DBC, checked and compiled to bit plans.
//! - [`sample`]: which readings belong to one cycle, and whether they are plausible.
//! - [`observe`]: the discrete model (4-1), its gain from the Riccati equation, the innovation.
//! - [`compare`]: C1 against the corrected C2 (5-20).
//! - [`verdict`]: thresholds with hysteresis, the kind of fault, the suspect (Figure 5-17).
//! - [`alarm`]: warnings that stand, their levels (Table 2-1), the frames that tell of them.
//! - [`monitor`]: the rooms above, from `decode` to `alarm`, as one machine: frames in, records,
//!   warnings and frames out.
//! - [`inject`]: faults put into frames, to see that they are found.
//! - [`config`]: the one table per machine. [`report`]: what people and scripts read.
//!   [`cli`]: the commands.
//!
//! Everything from `decode` to `monitor` is pure: time comes with the frames as integers of
//! nanoseconds ([`time`]), and there is no clock, socket, file, thread or global. That is why a
//! replay says what the gateway said. Deliberately absent: any action on the machine. Tertius
//! advises; the machine's own safety system acts.

#![forbid(unsafe_code)]

pub mod alarm;
pub mod appliance;
pub mod bus;
pub mod calibrate;
pub mod cli;
pub mod compare;
pub mod config;
pub mod decode;
pub mod extremes;
pub mod frame;
pub mod identify;
pub mod inject;
pub mod live;
pub mod monitor;
pub mod observe;
pub mod report;
pub mod sample;
pub mod survey;
pub mod time;
pub mod tune;
pub mod verdict;
