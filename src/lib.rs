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
//! - [`bus`]: where frames come from and go to: candump recordings, SocketCAN, a bus inside the
//!   program. The only room that knows files of frames and sockets.
//! - [`decode`]: a DBC, checked and compiled to bit plans.
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
//!   back, and whether the machine can be watched by it. [`learnt`]: what is kept of healthy recordings,
//!   so that those of several days add up.
//! - [`hexapod`], [`sea`], [`plant`], [`controller`], [`transducer`]: a machine in software, part by
//!   part. [`simulator`]: all of it as one, which sends frames. The monitor uses none of them.
//! - [`evaluate`]: what the monitor is worth: Monte Carlo on the simulator.
//! - [`config`]: the one table per machine. [`report`]: what people and scripts read: text, lines of
//!   JSON, pages of HTML with figures.
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
pub mod commission;
pub mod compare;
pub mod config;
pub mod controller;
pub mod decode;
pub mod error_frame;
pub mod estimate;
pub mod evaluate;
pub mod extremes;
pub mod frame;
pub mod hexapod;
pub mod identify;
pub mod inject;
pub mod learnt;
pub mod live;
pub mod monitor;
pub mod observe;
pub mod plant;
pub mod report;
pub mod sample;
pub mod sea;
pub mod sequential;
pub mod simulator;
pub mod survey;
pub mod time;
pub mod transducer;
pub mod tune;
pub mod verdict;
