//! Those who download and read nothing hold up nobody else, and cost little memory.

use std::fs;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::path::Path;
use std::time::Duration;
use tertius::appliance::flight::MOST_BYTES;
use tertius::appliance::http::{AT_REST, MEMORY};
use tertius_testing::process::{Running, configuration, excerpt, top, wait_for, write};

/// Memory of the process that no file backs, kB.
fn memory(process: &Running) -> usize {
    let status = fs::read_to_string(format!("/proc/{}/status", process.id())).expect("it runs");
    let line = status.lines().find_map(|line| line.strip_prefix("RssAnon:")).expect("Linux");
    line.trim().trim_end_matches(" kB").parse().expect("a number")
}

/// A gateway with a store of 7 MB of text and a recording of 24 MB, and its address.
fn stage(folder: &Path) -> (Running, SocketAddr) {
    let config = configuration(folder, "virtual");
    let text = fs::read_to_string(&config).expect("it was written");
    let own = "[http]\nlisten = \"127.0.0.1:0\"\n[store]\nfile = \"kept.events\"\n\
               [recorder]\nfolder = \"recordings\"\n\n";
    fs::write(&config, own.to_owned() + &text).expect("the folder is ours");
    let recording = folder.join("recordings/20261123T021600Z-on-demand");
    fs::create_dir_all(&recording).expect("the folder is ours");
    fs::write(recording.join("frames.log.zst"), vec![7; 24_000_000]).expect("there is room");
    let log = folder.join("bus.log");
    write(&log, "can0", &excerpt(0.0, 90.0));
    let plain = |path: &Path| path.to_str().expect("temporary folders have plain names").to_owned();
    let (gateway, url) = Running::gateway(&plain(&config), &plain(&log));
    let address =
        url.trim_start_matches("http://").trim_end_matches('/').parse().expect("an address");
    let store = folder.join("kept.events");
    wait_for("the event store", || {
        let (code, text) = ask(address, "/api/alarms");
        code == 200 && !text.contains("\"path\":null")
    });
    let mut store = rusqlite::Connection::open(store).expect("it is there");
    store.busy_timeout(Duration::from_secs(10)).expect("a time");
    let step = store.transaction().expect("it is free");
    let row = "INSERT INTO events (at_ns, run, kind, text) VALUES (?, 1, 'bus_lost', ?)";
    for n in 0..17_000_i64 {
        step.execute(row, (n, "lost ".repeat(70))).expect("there is room");
    }
    step.commit().expect("there is room");
    (gateway, address)
}

fn request(path: &str) -> String {
    format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n")
}

/// An address of this computer, of which each counts as another one.
const fn client(n: u8) -> Ipv4Addr {
    Ipv4Addr::new(127, 0, 0, n)
}

/// A connection of the client `n`, with room for so many bytes that it does not read.
pub fn connect(address: SocketAddr, n: u8, room: u32) -> TcpStream {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let stream = runtime.expect("a runtime").block_on(async {
        let socket = tokio::net::TcpSocket::new_v4().expect("a socket");
        socket.set_recv_buffer_size(room).expect("a size");
        socket.bind((client(n), 0).into()).expect("all of 127.0.0.0/8 is this computer");
        socket.connect(address).await.expect("it listens").into_std().expect("it is a socket")
    });
    stream.set_nonblocking(false).expect("it is a socket");
    stream.set_read_timeout(Some(Duration::from_secs(20))).expect("a time");
    stream
}

/// The code and the text of an answer; 0 if it was cut off.
fn ask(address: SocketAddr, path: &str) -> (u16, String) {
    ask_by(connect(address, 1, 1 << 20), path)
}

fn ask_by(mut stream: TcpStream, path: &str) -> (u16, String) {
    let (mut bytes, sent) = (Vec::new(), stream.write_all(request(path).as_bytes()));
    let read = sent.and_then(|()| stream.read_to_end(&mut bytes));
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let code = text.split(' ').nth(1).and_then(|code| code.parse().ok());
    (read.ok().and(code).unwrap_or(0), text)
}

/// The client `n`, who asks for `path`, or for nothing, and reads nothing, with as little room for it as the kernel allows.
fn unread(address: SocketAddr, n: u8, path: &str) -> TcpStream {
    let mut stream = connect(address, n, 4096);
    if !path.is_empty() {
        // It may be ended meanwhile.
        _ = stream.write_all(request(path).as_bytes());
    }
    stream
}

const RECORDING: &str = "/api/recordings/20261123T021600Z-on-demand.tar";

#[test]
fn clients_of_every_kind_that_read_nothing_cost_little() {
    let folder = tempfile::tempdir().expect("there is room");
    let (gateway, address) = stage(folder.path());
    let export = ask(address, "/api/export/events.csv").1;
    assert!(export.len() > 6_000_000 && export.len() < 8_000_000, "{}", export.len());
    let kinds = [
        "/api/export/events.csv",
        RECORDING,
        "/api/export/events.jsonl",
        "/api/stream",
        "/api/events?limit=500",
        "/metrics",
        "/api/trend/1",
        "",
    ];
    let mut held: Vec<TcpStream> = Vec::new();
    // The thread of the export gives back what it read of the store after its last byte has been read here.
    wait_for("no more memory than at rest", || memory(&gateway) * 1024 < AT_REST);
    let mut most = memory(&gateway);
    for n in 0..64_u8 {
        held.push(unread(address, 2 + n % 7, kinds[usize::from(n) % kinds.len()]));
        most = most.max(memory(&gateway));
    }
    for _ in 0..50 {
        let (code, text) = ask(address, "/api/alarms");
        assert_eq!(code, 200, "after {most} kB: {text}");
        most = most.max(memory(&gateway));
    }
    assert!(most * 1024 < MEMORY - MOST_BYTES, "{most} kB, without much in the recorder's ring");
    let judged = || {
        let metrics = ask(address, "/metrics").1;
        let line = metrics.lines().find_map(|line| line.strip_prefix("tertius_cycles_total "));
        line.and_then(|count| count.trim().parse::<u64>().ok()).expect("it counts")
    };
    let before = judged();
    wait_for("more cycles", || judged() > before + 20);
}

#[test]
fn what_readers_can_hold_fits_into_the_memory_of_the_unit() {
    let unit = fs::read_to_string(top().join("config/systemd/tertius.service")).expect("it ships");
    let most = unit.lines().find_map(|line| line.strip_prefix("MemoryMax=")?.strip_suffix('M'));
    let most: usize = most.expect("it has one").parse().expect("a number of MiB");
    assert!(MEMORY < most << 20, "{MEMORY} of {most} MiB");
}

/// People write notes of two kilobytes: a page of them is shorter, and its next one follows.
#[test]
fn a_page_of_long_texts_is_bounded_and_loses_none() {
    let folder = tempfile::tempdir().expect("there is room");
    let (_gateway, address) = stage(folder.path());
    let mut store = rusqlite::Connection::open(folder.path().join("kept.events")).expect("there");
    store.busy_timeout(Duration::from_secs(10)).expect("a time");
    let step = store.transaction().expect("it is free");
    let row = "INSERT INTO events (at_ns, run, kind, text) VALUES (20000, 1, 'bus_lost', ?)";
    (0..400).for_each(|n| _ = step.execute(row, [format!("{n} {}", "\u{e4}".repeat(1000))]));
    step.commit().expect("there is room");
    let (mut before, mut found) = (String::new(), 0);
    while found < 400 {
        let (code, text) = ask(address, &format!("/api/events?limit=500{before}"));
        assert!(code == 200 && text.len() < 512 * 1024, "{code}, {} bytes", text.len());
        let body = text.split("\r\n\r\n").nth(1).expect("a body");
        let page: serde_json::Value = serde_json::from_str(body).expect("JSON");
        let entries = page["entries"].as_array().expect("a list");
        found += entries
            .iter()
            .filter(|it| it["text"].as_str().is_some_and(|it| it.len() > 2000))
            .count();
        before = format!("&before={}", page["next"]);
    }
    assert_eq!(found, 400);
}

#[test]
fn eight_exports_that_nobody_reads_cost_little() {
    let folder = tempfile::tempdir().expect("there is room");
    let (gateway, address) = stage(folder.path());
    let export = |n| unread(address, n, "/api/export/events.csv");
    let mut held: Vec<TcpStream> = (2..10).map(export).collect();
    // Of an export that is made as a whole, all is in memory when its first bytes come.
    let begun = |stream: &mut TcpStream| {
        let (mut code, mut rest) = ([0; 12], [0; 4096]);
        stream.read_exact(&mut code).expect("it answers");
        code.ends_with(b"200") && stream.read_exact(&mut rest).is_ok()
    };
    assert_eq!(held.iter_mut().filter_map(|it| begun(it).then_some(())).count(), 2);
    let mut most = memory(&gateway);
    for _ in 0..600 {
        assert_ne!(ask(address, "/health").0, 0, "it is served meanwhile");
        most = most.max(memory(&gateway));
    }
    // Less than one export more than at rest.
    assert!(most * 1024 < AT_REST + 6_000_000, "{most} kB");
}

#[test]
fn slow_downloads_hold_up_nobody_and_have_their_number() {
    let folder = tempfile::tempdir().expect("there is room");
    let (_gateway, address) = stage(folder.path());
    let _slow = [unread(address, 2, RECORDING), unread(address, 3, RECORDING)];
    let _exports = [2, 3].map(|n| unread(address, n, "/api/export/events.csv"));
    for path in [RECORDING, "/api/export/events.jsonl"] {
        let told = refused(address, 1, path);
        assert!(told.contains("as much is being downloaded as can be at once"), "{told}");
    }
    for path in ["/api/alarms", "/api/events", "/api/recordings", "/api/incidents/999"] {
        assert!([200, 404].contains(&ask(address, path).0), "{path}");
    }
}

/// The refusal of `path` to the client `n`, once it is refused.
fn refused(address: SocketAddr, n: u8, path: &str) -> String {
    let mut told = String::new();
    wait_for("a refusal", || {
        let (code, text) = ask_by(connect(address, n, 1 << 20), path);
        told = text;
        code == 503
    });
    assert!(told.contains("\r\nretry-after: 10\r\n"), "{told}");
    told
}

#[test]
fn one_address_holds_half_of_the_places_at_most() {
    let folder = tempfile::tempdir().expect("there is room");
    let (_gateway, address) = stage(folder.path());
    for path in [RECORDING, "/api/export/events.csv"] {
        let _own = unread(address, 2, path);
        let told = refused(address, 2, path);
        assert!(told.contains("your address is downloading as much as one may at once"), "{told}");
        assert_eq!(ask(address, path).0, 200, "another one gets {path}");
    }
    let watch = |n| {
        let mut stream = connect(address, n, 1 << 20);
        stream.write_all(request("/api/stream").as_bytes()).expect("it reads");
        let mut code = [0; 12];
        stream.read_exact(&mut code).expect("it answers");
        (stream, String::from_utf8_lossy(&code[9..]).into_owned())
    };
    let watching: Vec<_> = (0..32).map(|_| watch(2)).collect();
    assert!(watching.iter().all(|(_, code)| code == "200"), "{watching:?}");
    let told = refused(address, 2, "/api/stream");
    assert!(told.contains("as many watch from your address as may at once"), "{told}");
    assert_eq!(watch(1).1, "200", "another one watches");

    // Who has begun to ask is not ended for those of another address, however many they are.
    let mut slow = connect(address, 1, 1 << 20);
    let (first, rest) = ("GET /api/alarms HTTP/1.1\r\n", "Host: localhost\r\n\r\n");
    slow.write_all(first.as_bytes()).expect("it reads");
    let _many: Vec<TcpStream> = (0..40).map(|_| unread(address, 2, "")).collect();
    assert_eq!(ask_by(connect(address, 2, 1 << 20), "/api/alarms").0, 200, "one of its own ends");
    slow.write_all(rest.as_bytes()).expect("it reads");
    let mut answer = String::new();
    slow.read_to_string(&mut answer).expect("it answers");
    assert!(answer.starts_with("HTTP/1.1 200 "), "{answer}");
}

#[test]
fn idle_connections_end_no_download() {
    let folder = tempfile::tempdir().expect("there is room");
    let (_gateway, address) = stage(folder.path());
    let mut download = connect(address, 1, 1 << 16);
    download.write_all(request(RECORDING).as_bytes()).expect("it reads");
    let mut first = [0; 16];
    download.read_exact(&mut first).expect("it begins");
    let _idle: Vec<TcpStream> = (0..40).map(|_| unread(address, 1, "")).collect();
    assert_eq!(ask(address, "/api/alarms").0, 200, "an idle one gives way");
    let mut rest = Vec::new();
    download.read_to_end(&mut rest).expect("it goes on");
    assert!(rest.len() > 24_000_000, "{}", rest.len());
}
