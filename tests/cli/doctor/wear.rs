//! What wears out, what is too slow, and what has grown old.

use super::{changed, hear, judged, set, sound};
use tertius::appliance::doctor::Verdict;
use tertius::appliance::doctor::facts::{ClockSource, DiskFacts, Facts, LinkCounts, Wear};
use tertius::bus::Stamps;

/// With what the kernel counted until listening began, and in the end.
fn counted(before: LinkCounts, after: LinkCounts) -> Facts {
    changed(|interface| interface.counts = Some([before, after]))
}

fn disk(change: impl FnOnce(&mut DiskFacts)) -> Facts {
    set(|facts| change(&mut facts.host.disks[0]))
}

#[test]
fn a_computer_that_is_too_slow_is_told_from_a_bus_that_is_disturbed() {
    let before = LinkCounts { frames: 5000, overruns: 3, dropped: 4, errors: 0 };
    let after = LinkCounts { frames: 6000, overruns: 5, dropped: 4, errors: 0 };
    let words = ["2 frames were lost while listening: 2 in the controller", "of 1000", "too slow"];
    judged(&counted(before, after), "overload", Verdict::Warn, &words);
    judged(&counted(before, after), "error frames", Verdict::Ok, &["none"]);
    let words = ["no frame was lost while listening", "appeared 7 were: 3 in the controller"];
    judged(&counted(before, before), "overload", Verdict::Ok, &words);
    // A driver may count errors without telling them in frames.
    let disturbed = LinkCounts { errors: 9, frames: 5100, ..before };
    let words = ["0, 9 errors on the wire", "not overload, but the wire", "sample point"];
    judged(&counted(before, disturbed), "error frames", Verdict::Warn, &words);
    judged(&counted(before, disturbed), "overload", Verdict::Ok, &["no frame was lost while"]);
}

#[test]
fn an_overflow_of_the_controller_is_no_fault_of_the_wire() {
    // CAN_ERR_CRTL with CAN_ERR_CRTL_RX_OVERFLOW in its second byte.
    let facts = hear(|hearing, frame| {
        hearing.take(frame);
        if frame.id.value() == 0x80 && hearing.errors.frames < 2 {
            hearing.take(&super::facts::overflow());
        }
    });
    let words = ["2, 2 overflows of the controller", "too slow", "[realtime]"];
    judged(&facts, "error frames", Verdict::Warn, &words);
}

#[test]
fn time_stamps_that_the_controller_has_and_nobody_gets() {
    let facts = changed(|interface| {
        interface.port.as_mut().expect("there is one").stamps = Stamps::Software;
    });
    let words =
        ["the kernel's (software)", "its own, which are turned off", "Sync vary by 0.000 ms"];
    judged(&facts, "time stamps", Verdict::Ok, &words);
    let facts = changed(|interface| {
        interface.port.as_mut().expect("there is one").stamps = Stamps::Software;
        interface.hardware_stamps = Some(false);
    });
    judged(&facts, "time stamps", Verdict::Ok, &["the controller has none"]);
}

#[test]
fn whom_the_clock_follows_and_how_closely() {
    let clock = |bound| {
        set(|facts| {
            let name = "192.0.2.2".to_owned();
            facts.host.clock.source = Some(ClockSource { name, stratum: 3, bound });
        })
    };
    let words = ["with 192.0.2.2 (chrony, stratum 3), wrong by 2.6 ms at most"];
    judged(&clock(2.6e-3), "clock", Verdict::Ok, &words);
    judged(&clock(0.2), "clock", Verdict::Warn, &["200.0 ms at most", "nearer source"]);
}

#[test]
fn a_disk_that_is_full_or_worn_or_cannot_be_written() {
    let words =
        ["20 GiB of 32 GiB free in /var/lib/tertius (the events, the recordings)", "1.4 GiB a day"];
    judged(&disk(|disk| disk.wear = None), "disk", Verdict::Ok, &words);
    for free in [1 << 30, 100 << 20] {
        judged(&disk(|disk| disk.free = free), "disk", Verdict::Warn, &["make room", "store.size"]);
    }
    // Of a small one a twentieth is too little to be waited for.
    let small = |disk: &mut DiskFacts| (disk.free, disk.size) = (150 << 20, 1 << 30);
    judged(&disk(small), "disk", Verdict::Warn, &["150 MiB of 1.0 GiB"]);
    judged(&disk(|disk| disk.is_read_only = true), "disk", Verdict::Fail, &["read-only", "dmesg"]);
    for (tenths, reserve, words) in [
        (10, 1, "used up by 90 to 100 %"),
        (11, 1, "beyond its promised life"),
        (3, 2, "four fifths of its blocks in reserve"),
        (0, 3, "nearly all of its blocks in reserve"),
    ] {
        let facts = disk(|disk| disk.wear = Some(Wear { tenths, reserve }));
        judged(&facts, "disk", Verdict::Warn, &[words, "replace it"]);
    }
    judged(&set(|facts| facts.host.disks.clear()), "disk", Verdict::Ok, &["nothing is kept"]);
}

#[test]
fn how_old_program_and_configuration_are() {
    judged(&sound(), "program", Verdict::Ok, &["tertius 0.1.0, installed 34.7 days ago"]);
    let words = ["is sound, changed 2.0 h ago; calibrated by recordings of 2026-03-14"];
    judged(&sound(), "configuration", Verdict::Ok, &words);
    let running = |seconds, is_replaced| {
        set(|facts| {
            facts.host.rights.gateway = Some(77);
            facts.host.ages.gateway = super::facts::span(seconds);
            facts.host.ages.is_replaced = is_replaced;
        })
    };
    let late = ["changed 2.0 h ago, after the gateway was started", "reloaded"];
    judged(&running(9000.0, false), "configuration", Verdict::Ok, &late);
    let facts = running(90.0, false);
    judged(
        &facts,
        "program",
        Verdict::Ok,
        &["the gateway (process 77) has been running for 90.0 s"],
    );
    let words = ["its program has been replaced", "systemctl restart tertius"];
    judged(&running(90.0, true), "program", Verdict::Warn, &words);
}
