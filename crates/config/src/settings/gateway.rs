//! The gateway itself: `[gateway]`, `[http]`, `[modbus]`, `[opcua]`, `[mqtt]`, `[store]` and `[realtime]`.

use crate::kinds::{DURATION, number, text, whole};
use crate::schema::{Kind, Limits, Scalar, table};
use crate::text::{TextRule, broker_of};
use std::net::SocketAddr;

table! {
    /// The gateway's own node on the bus.
    pub struct Gateway = GATEWAY {
        node: u8 = 81 => whole(1, 127, "CANopen has nodes 1 to 127"),
            "81", "the gateway's CANopen node; Fd_Status is 0x180 + node";
        bus_share: f64 = 0.05 =>
            number(Limits::above(0.0, "the part of the bus that the gateway may take").most(0.5)),
            "0.05", "the largest part of the bus that the gateway takes, 0 to 0.5";
        max_age: f64 = 0.2 => number(Limits::above(0.0, DURATION).most(10.0)),
            "0.2", "a frame that could not be sent for this long is dropped, s";
        guard: f64 = 0.01 => number(Limits::least(0.0, DURATION).most(1.0)),
            "0.01", "deadlines are kept this far behind the clock, for frames still on their way, s";
    }
}

table! {
    /// HTTP server of the gateway's own state.
    pub struct Http = HTTP {
        /// [`LISTEN_OFF`](super::LISTEN_OFF) is the word for none.
        listen: String = "127.0.0.1:9481".to_owned() => text(TextRule::Listen),
            "\"127.0.0.1:9481\"", "where the page, /health and /metrics are served, ADDRESS:PORT; or off";
        token: Option<String> = None => text(TextRule::Digest),
            "\"8d1d2c4c9f6a1b1be0a6e4a77c6f9b0d5a0fbf2f5e0c4f4f7f0f4a3b2a7d6c19\"",
            "SHA-256 of the token for acts on alarms (`tertius token`); absent: no acts";
        login_failures: u32 = 10 => whole(3, 1000, "people mistype"),
            "10", "wrong tokens after which an address is locked out; before that each waits longer than the one before";
        lockout: f64 = 300.0 => number(Limits::least(1.0, DURATION).most(86_400.0)),
            "300.0", "how long an address is locked out, s";
        certificate: Option<String> = None => text(TextRule::Path),
            "\"/etc/tertius/page.crt\"",
            "the certificate (PEM, with its chain) by which the page is served over https, relative to this file";
        key: Option<String> = None => text(TextRule::Path),
            "\"/etc/tertius/page.key\"", "the private key of the certificate (PEM), which others must not be able to read";
    }
}

table! {
    /// Modbus TCP server of the machine's state.
    pub struct Modbus = MODBUS {
        /// [`LISTEN_OFF`](super::LISTEN_OFF) is the word for none.
        listen: String = super::LISTEN_OFF.to_owned() => text(TextRule::Listen),
            "\"off\"", "where the machine's state can be read over Modbus TCP, ADDRESS:PORT; or off";
    }
}

table! {
    /// OPC UA server of the machine's state and alarms.
    pub struct Opcua = OPCUA {
        /// [`LISTEN_OFF`](super::LISTEN_OFF) is the word for none.
        listen: String = super::LISTEN_OFF.to_owned() => text(TextRule::Listen),
            "\"off\"", "where the machine's state and alarms can be read over OPC UA, ADDRESS:PORT; or off";
    }
}

table! {
    /// Publisher of state and events over MQTT 5.
    pub struct Mqtt = MQTT {
        /// [`LISTEN_OFF`](super::LISTEN_OFF) is the word for none.
        broker: String = super::LISTEN_OFF.to_owned() => text(TextRule::Broker),
            "\"off\"", "the broker to which state and events are published over MQTT 5, HOST:PORT; or off";
        topic: String = "tertius".to_owned() => text(TextRule::Topic),
            "\"tertius\"", "first levels of the topics, others for each gateway of a broker";
        user: Option<String> = None => text(TextRule::Name),
            "\"gateway\"", "the user by whose name the broker knows the gateway";
        password: Option<String> = None => text(TextRule::Path),
            "\"/etc/tertius/mqtt-password\"", "the file with the user's password in a line, relative to this file, which others must not be able to read";
        /// [`SYSTEM`](super::SYSTEM) is the word for whom the computer trusts.
        authority: Option<String> = None => text(TextRule::Authority),
            "\"/etc/tertius/mqtt-ca.crt\"", "who certifies the broker (PEM), relative to this file, or system for whom the computer trusts; without it nothing is encrypted";
        period: f64 = 10.0 => number(Limits::least(1.0, DURATION).most(3600.0)),
            "10.0", "s, the longest time from one published state to the next";
        sparkplug: Option<String> = None => text(TextRule::EdgeNode),
            "\"ship/gangway\"", "the edge node, GROUP/NODE, as which everything is published by Sparkplug B instead of as JSON";
    }
}

table! {
    /// The event store: what happened on the machine, kept for years.
    pub struct Store = STORE {
        file: Option<String> = None => text(TextRule::Path),
            "\"/var/lib/tertius/e-type.events\"",
            "the database in which the gateway keeps incidents and events, relative to this file; absent: \
             nothing is kept";
        size: u32 = 256 => whole(4, 65_536, "the disk has to have room for it"),
            "256", "the largest size of the database, MB; the oldest incidents and events give way";
        days: u32 = 1825 => whole(1, 36_500, "an age"),
            "1825", "closed incidents and events that are older give way, days; hourly statistics stay";
    }
}

table! {
    /// Scheduling and memory that the gateway requests from the kernel at its start. A reload changes
    /// neither.
    #[derive(Copy, Eq)]
    pub struct Realtime = REALTIME {
        priority: u8 = 0 => whole(0, 99, "SCHED_FIFO has priorities 1 to 99; 0 is ordinary"),
            "0", "the real-time priority of the data path, from the gateway's start on; 0 for none";
        lock_memory: bool = false => Kind::One(Scalar::Switch),
            "false", "whether the gateway's memory is locked, from its start on";
    }
}

impl Http {
    /// Address to listen on; `None` if HTTP is off.
    pub fn address(&self) -> Option<SocketAddr> {
        self.listen.parse().ok()
    }
}

impl Mqtt {
    /// Host and port of the broker; `None` if MQTT is off.
    pub fn address(&self) -> Option<(&str, u16)> {
        broker_of(&self.broker)
    }

    /// Group and name of the edge node of Sparkplug B; `None` if what is published is JSON.
    pub fn edge(&self) -> Option<(&str, &str)> {
        self.sparkplug.as_deref()?.split_once('/')
    }
}

impl Modbus {
    /// Address to listen on; `None` if Modbus is off.
    pub fn address(&self) -> Option<SocketAddr> {
        self.listen.parse().ok()
    }
}

impl Opcua {
    /// Address to listen on; `None` if OPC UA is off.
    pub fn address(&self) -> Option<SocketAddr> {
        self.listen.parse().ok()
    }
}
