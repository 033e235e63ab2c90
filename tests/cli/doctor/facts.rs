//! A box where all is right, to be changed.

use std::net::SocketAddr;
use tertius::appliance::doctor::Facts;
use tertius::appliance::doctor::facts::{
    Ages, Bus, ClockFacts, DiskFacts, Host, InterfaceFacts, LinkCounts, Message, Receiving, Rights,
    Service, Wanted, Wear,
};
use tertius::appliance::doctor::hearing::Hearing;
use tertius::appliance::doctor::load::Rates;
use tertius::bus::Stamps;
use tertius::bus::socket::{ControllerState, LinkState};
use tertius::config::settings::Realtime;
use tertius::frame::{Frame, Id, Kind};
use tertius::time::{Span, Timestamp};

const CYCLE: i64 = 20_000_000;

/// 2 s of the machine, all of it heard.
pub fn sound() -> Facts {
    machine(|_| true)
}

/// [`sound`] with a change.
pub fn set(change: impl FnOnce(&mut Facts)) -> Facts {
    let mut facts = sound();
    change(&mut facts);
    facts
}

/// The machine with those frames only that `comes` lets through.
pub fn machine(mut comes: impl FnMut(&Frame) -> bool) -> Facts {
    hear(|hearing, frame| {
        if comes(frame) {
            hearing.take(frame);
        }
    })
}

/// The machine, each of its frames given to `take`.
pub fn hear(mut take: impl FnMut(&mut Hearing, &Frame)) -> Facts {
    let wanted = wanted();
    let mut hearing = Hearing::new(Rates { nominal: 5e5, data: 5e5 }, wanted.status);
    for cycle in 0..100 {
        let at = Timestamp::from_nanos(1_700_000_000_000_000_000 + cycle * CYCLE);
        for (id, length) in cycle_frames() {
            take(&mut hearing, &Frame::new(at, standard(id), Kind::Data, &[0; 8][..length]));
        }
    }
    hearing.seconds = 2.0;
    let bus = Bus::Socket(Box::new(interface(hearing)));
    Facts { wanted, bus, others: Vec::new(), host: host() }
}

/// What a machine sends in a cycle: identifiers and lengths, two of them nobody listens to.
fn cycle_frames() -> Vec<(u32, usize)> {
    let mut frames = vec![(0x080, 1)];
    for n in 1..=6 {
        frames.extend([(0x180 + n, 6), (0x190 + n, 6), (0x1A0 + n, 8)]);
    }
    frames.extend([(0x1B1, 6), (0x2B1, 6), (0x1C1, 4)]);
    frames
}

fn wanted() -> Wanted {
    let message = |id, name: String, needs| Message {
        id: standard(id),
        name,
        needs,
        sync: id == 0x80,
        reading: (0x181..0x1A0).contains(&id),
        cyclic: (0x181..0x1B0).contains(&id),
        pages: 1,
    };
    let mut messages = vec![message(0x080, "Sync".to_owned(), 0)];
    for n in 1..=6 {
        messages.push(message(0x180 + n, format!("Cyl{n}_C1"), 6));
        messages.push(message(0x190 + n, format!("Cyl{n}_C2"), 6));
        messages.push(message(0x1A0 + n, format!("Cyl{n}_Valve"), 8));
    }
    messages.push(message(0x1C1, "Plc_State".to_owned(), 1));
    Wanted {
        config: "machine.toml".into(),
        dbc: "machine.dbc".to_owned(),
        dbc_findings: 0,
        interface: "can0".to_owned(),
        bit_rate: 500_000,
        sample_time: 0.02,
        node: 81,
        own: [0x1D1, 0x2D1, 0x3D1, 0x0D1, 0x5D1, 0x751].map(standard).into(),
        status: standard(0x1D1),
        messages,
        others: Vec::new(),
        realtime: Realtime { priority: 20, lock_memory: true },
        files: Vec::new(),
        keeps: Vec::new(),
        calibrated: Some("2026-03-14".to_owned()),
    }
}

fn interface(hearing: Hearing) -> InterfaceFacts {
    InterfaceFacts {
        no_can: None,
        link: Ok(LinkState {
            index: 3,
            up: true,
            mtu: Some(16),
            bit_rate: Some(500_000),
            sample_point: Some(875),
            data_bit_rate: None,
            state: Some(ControllerState::ErrorActive),
            transmit_errors: Some(0),
            receive_errors: Some(0),
            restart_ms: Some(100),
            queue_length: Some(16),
        }),
        is_can: Some(true),
        port: Ok(Receiving { buffer: 13_617_920, lasts: 1.0, stamps: Stamps::Hardware }),
        rmem_max: Some(8 << 20),
        counts: Some([LinkCounts { frames: 1000, ..LinkCounts::default() }; 2]),
        hardware_stamps: Some(true),
        hearing: Some(hearing),
    }
}

fn host() -> Host {
    Host {
        rights: Rights { priority: Some(20), ..Rights::default() },
        clock: ClockFacts { synchronised: Some(true), watched: 2.0, ..ClockFacts::default() },
        service: Service {
            systemd: true,
            unit: Some("/etc/systemd/system/tertius.service".to_owned()),
            watchdog: Some("2".to_owned()),
        },
        disks: vec![DiskFacts {
            keeps: vec!["the events", "the recordings"],
            folder: "/var/lib/tertius".into(),
            free: 20 << 30,
            size: 32 << 30,
            is_read_only: false,
            written_per_day: Some(1.5e9),
            wear: Some(Wear { tenths: 2, reserve: 1 }),
        }],
        ages: Ages { program: span(3e6), configuration: span(7200.0), ..Ages::default() },
        http: Some((SocketAddr::from(([127, 0, 0, 1], 9481)), None)),
        logins: None,
    }
}

pub fn span(seconds: f64) -> Option<Span> {
    Some(Span::from_seconds(seconds))
}

/// A status of a gateway at node 81.
pub fn status(counter: u8) -> Frame {
    let data = [0, 0, counter, 0, 0, 0, 0, 0];
    Frame::new(Timestamp::default(), standard(0x1D1), Kind::Data, &data)
}

/// An error frame of that class.
pub fn error_frame(class: u32) -> Frame {
    let id = Id::extended(class).expect("classes fit an extended identifier");
    Frame::new(Timestamp::default(), id, Kind::Error, &[0; 8])
}

/// An error frame of a controller whose receive buffer was full.
pub fn overflow() -> Frame {
    let id = Id::extended(0x004).expect("classes fit an extended identifier");
    Frame::new(Timestamp::default(), id, Kind::Error, &[0, 0x01, 0, 0, 0, 0, 0, 0])
}

fn standard(id: u32) -> Id {
    Id::standard(id).expect("eleven bits")
}
