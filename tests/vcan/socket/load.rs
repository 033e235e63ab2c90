//! More than one reading takes, and more than the queue holds.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use tertius::bus::socket::{Options, SocketPort};
use tertius::bus::{Port, Sent, Unrestricted, UnrestrictedPort};

use super::traffic::{number, numbered, receive, receive_until, send, standard};
use super::vcan::{Vcan, run};

#[test]
fn what_the_queue_does_not_hold_is_counted_to_the_frame() {
    let vcan = Vcan::new("t-drops");
    let small = Options { receive_buffer: Some(32 * 1024), ..Options::default() };
    let mut gateway = vcan.open(&small);
    let mut machine = vcan.machine();
    let mut lost_before = 0;
    for burst in 1..=3_u32 {
        for n in 1..=1_000 {
            send(&mut machine, &numbered(standard(0x181), n));
        }
        let kept = receive_until(&mut gateway, |frames| frames.len() > 10).len() as u64;
        // The kernel tells the count with the next frame that finds room.
        send(&mut machine, &numbered(standard(0x181), 0));
        receive_until(&mut gateway, |frames| frames.iter().any(|frame| number(frame) == 0));
        let counts = gateway.counts();
        assert_eq!(counts.received + counts.dropped, u64::from(burst) * 1_001);
        assert!(counts.dropped - lost_before >= 500, "{kept} of 1000 fitted into 32 KiB");
        lost_before = counts.dropped;
    }
}

#[test]
fn the_usual_buffer_holds_a_second_of_the_fastest_bus() {
    // 1 Mbit/s and 8 Mbit/s in the data phase, which is assumed where the interface does not say.
    const SECOND: u32 = 30_304;
    let vcan = Vcan::new("t-second");
    let mut gateway = vcan.open_all();
    let mut machine = vcan.machine();
    for n in 0..SECOND {
        send(&mut machine, &numbered(standard(0x181), n));
    }
    let came = receive_until(&mut gateway, |frames| {
        frames.last().is_some_and(|last| number(last) == SECOND - 1)
    });
    assert_eq!(gateway.counts().dropped, 0);
    assert!(came.iter().map(number).eq(0..SECOND));
}

#[test]
fn one_call_takes_a_bounded_number() {
    let vcan = Vcan::new("t-bounded");
    // What the eldest has, all have: the kernel serves the youngest first.
    let mut eldest = vcan.open_all();
    let mut gateway = vcan.open_all();
    let mut machine = vcan.machine();
    for n in 0..300 {
        send(&mut machine, &numbered(standard(0x181), n));
    }
    receive(&mut eldest, 300);
    let first = gateway.receive(Duration::ZERO, &mut |_| {}).unwrap();
    assert_eq!((first.frames, first.drained_at), (256, None));
    // There is more: no waiting.
    let second = gateway.receive(Duration::from_secs(3600), &mut |_| {}).unwrap();
    assert_eq!(second.frames, 44);
    assert!(second.drained_at.is_some());
    let counts = gateway.counts();
    assert_eq!((counts.received, counts.batches, counts.largest_batch), (300, 5, 64));
}

#[test]
fn a_full_queue_is_told_and_its_frames_are_not_kept() {
    let vcan = Vcan::new("t-full");
    hold_back("t-full", 2);
    let mut machine = vcan.machine();
    let mut listener = vcan.open_all();
    let mut results = Vec::new();
    for n in 0..6 {
        results.push(machine.send_unrestricted(&numbered(standard(0x181), n)).unwrap());
    }
    let taken = results.iter().filter(|&&sent| sent == Sent::Taken).count();
    assert!(results.contains(&Sent::Full) && taken >= 2, "{results:?}");
    assert_eq!(machine.counts().sent, taken as u64);
    assert_eq!(machine.counts().refused, (results.len() - taken) as u64);

    // Once there is room again, it is as before.
    run("tc", &["qdisc", "delete", "dev", "t-full", "root"]);
    send(&mut machine, &numbered(standard(0x181), 100));
    let came = receive_until(&mut listener, |frames| {
        frames.last().is_some_and(|frame| number(frame) == 100)
    });
    assert!(came.len() <= taken + 1, "refused frames came");
}

#[test]
fn few_frames_are_under_way_where_that_is_wanted() {
    let vcan = Vcan::new("t-few");
    // netem would not do here: it takes frames off the sender's account.
    queue("t-few", "tbf", &["rate", "8bit", "burst", "32", "limit", "100000"]);
    let few = Options { few_under_way: true, ..Options::default() };
    let mut machine = Unrestricted::<SocketPort>::open("t-few", &few).unwrap();
    let results: Vec<Sent> = (0..100)
        .map(|n| machine.send_unrestricted(&numbered(standard(0x181), n)).unwrap())
        .collect();
    let taken = results.iter().filter(|&&sent| sent == Sent::Taken).count();
    assert!((1..=10).contains(&taken), "{taken} frames wait where the bus cannot have them");
    drop(vcan);
}

/// Lets `frames` wait for a minute and none besides, as a bus without anyone to acknowledge.
fn hold_back(interface: &str, frames: u32) {
    let frames = frames.to_string();
    queue(interface, "netem", &["delay", "60s", "limit", &frames]);
}

/// Gives `interface` a queue of this kind.
fn queue(interface: &str, kind: &str, settings: &[&str]) {
    let arguments = [&["qdisc", "add", "dev", interface, "root", kind], settings].concat();
    if Command::new("tc").args(&arguments).output().is_ok_and(|output| output.status.success()) {
        return;
    }
    // User-mode Linux does not find its modules by itself.
    let release = std::fs::read_to_string("/proc/sys/kernel/osrelease").unwrap();
    let folder = format!("/usr/lib/uml/modules/{}/kernel/net/sched", release.trim());
    let module = format!("{folder}/sch_{kind}.ko");
    if Path::new(&module).exists() {
        run("busybox", &["insmod", &module]);
    }
    run("tc", &arguments);
}
