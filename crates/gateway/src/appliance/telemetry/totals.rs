//! Totals that only grow, even if their sources restart.

use super::cell::Total;
use crate::bus::PortCounts;
use crate::live::outbox::OutboxCounts;
use tertius_core::monitor::Counts;

/// Totals since the start of the process.
#[derive(Debug, Default)]
pub(super) struct Totals {
    pub received: Total,
    pub error_frames: Total,
    pub dropped: Total,
    pub malformed: Total,
    pub unstamped: Total,
    pub refused: Total,
    pub sent: Total,
    pub too_old: Total,
    pub crowded_out: Total,
    pub superseded: Total,
    pub outdated: Total,
    pub held_back: Total,
    pub used: Total,
    pub ignored: Total,
    pub cycles: Total,
    pub incomplete: Total,
    pub missing: Total,
    pub late: Total,
    pub repeated: Total,
    pub contradicting: Total,
    pub short: Total,
    pub sync_doubted: Total,
    /// Frames of other devices with an own identifier, counted by the gateway.
    pub imitated: Total,
    pub held: Total,
    pub bad_signals: Total,
    pub unnamed_status_bits: Total,
    pub backwards: Total,
    pub time_jumps: Total,
    pub turns: Total,
    pub opens: Total,
    pub losses: Total,
    pub reconnects: Total,
    pub reloads_accepted: Total,
    pub reloads_refused: Total,
    /// Writes of the history, counted by the thread that keeps it.
    pub history_writes: Total,
    /// Failed writes of the history, counted by the thread that keeps it.
    pub history_failures: Total,
    pub history_crowded: Total,
    /// Notes that the event store has written, counted by its thread, as are the next two.
    pub store_written: Total,
    pub store_lost: Total,
    pub store_failures: Total,
    /// Wrong tokens, counted by the thread that serves the page.
    pub login_failures: Total,
    /// Times that an address was locked out, counted by the same thread.
    pub login_lockouts: Total,
    pub recorder_recordings: Total,
    pub recorder_failures: Total,
    pub recorder_left_out: Total,
    pub recorder_lost: Total,
}

impl Totals {
    /// Adds a port's counts, which start when it is opened.
    pub fn port(&self, last: &PortCounts, now: &PortCounts) {
        self.received.follow(last.received, now.received);
        self.error_frames.follow(last.error_frames, now.error_frames);
        self.dropped.follow(last.dropped, now.dropped);
        self.malformed.follow(last.malformed, now.malformed);
        self.unstamped.follow(last.unstamped, now.unstamped);
        self.refused.follow(last.refused, now.refused);
    }

    /// Adds an outbox's counts, which start when the configuration is read.
    pub fn outbox(&self, last: &OutboxCounts, now: &OutboxCounts) {
        self.sent.follow(last.sent, now.sent);
        self.too_old.follow(last.too_old, now.too_old);
        self.crowded_out.follow(last.crowded_out, now.crowded_out);
        self.superseded.follow(last.superseded, now.superseded);
        self.outdated.follow(last.outdated, now.outdated);
        self.held_back.follow(last.held_back, now.held_back);
    }

    /// Adds a monitor's counts, which start when it is made.
    pub fn monitor(&self, last: &Counts, now: &Counts) {
        self.used.follow(last.used, now.used);
        self.ignored.follow(last.ignored, now.ignored);
        self.cycles.follow(last.cycles, now.cycles);
        self.incomplete.follow(last.incomplete, now.incomplete);
        self.missing.follow(last.missing, now.missing);
        self.late.follow(last.late, now.late);
        self.repeated.follow(last.repeated, now.repeated);
        self.contradicting.follow(last.contradicting, now.contradicting);
        self.short.follow(last.short, now.short);
        self.sync_doubted.follow(last.sync_doubted, now.sync_doubted);
        self.held.follow(last.held, now.held);
        self.bad_signals.follow(last.bad_signals, now.bad_signals);
        self.unnamed_status_bits.follow(last.unnamed_status_bits, now.unnamed_status_bits);
        self.backwards.follow(last.backwards, now.backwards);
        self.time_jumps.follow(last.time_jumps, now.time_jumps);
    }
}

type Described<'a> = (&'static str, &'static str, &'a Total);

impl Totals {
    /// Totals that are one number each: name, help, total.
    #[rustfmt::skip]
    pub fn described(&self) -> [Described<'_>; 44] {
        [
            ("frames_received", "Frames taken from the interface, error frames included.", &self.received),
            ("frames_used", "Frames that the monitor uses.", &self.used),
            ("frames_ignored", "Frames of other identifiers, remote frames and error frames.", &self.ignored),
            ("error_frames", "Error messages of the controller.", &self.error_frames),
            ("frames_dropped", "Frames lost because the kernel's receive queue was full.", &self.dropped),
            ("frames_malformed", "Data read from the interface that are not a frame.", &self.malformed),
            ("frames_unstamped", "Frames without a time stamp, which got the time of their reading.", &self.unstamped),
            ("frames_sent", "Frames handed to the interface.", &self.sent),
            ("frames_refused", "Times that the interface had no room for a frame.", &self.refused),
            ("frames_too_old", "Frames dropped instead of being sent late.", &self.too_old),
            ("frames_crowded_out", "Frames dropped because too many waited to be sent.", &self.crowded_out),
            ("statuses_superseded", "Statuses that a newer one replaced before they were sent.", &self.superseded),
            ("estimates_outdated", "Estimates that newer ones replaced before they were sent.", &self.outdated),
            ("frames_held_back", "Times that sending had to wait for the rate limit.", &self.held_back),
            ("cycles", "Cycles that opened.", &self.cycles),
            ("cycles_incomplete", "Cycles in which something configured did not arrive.", &self.incomplete),
            ("cycles_missing", "Cycles that should have opened and did not.", &self.missing),
            ("frames_late", "Frames that came after their cycle was decided.", &self.late),
            ("frames_repeated", "Frames that came twice.", &self.repeated),
            ("frames_contradicting", "Frames with the count of another one and another payload.", &self.contradicting),
            ("frames_short", "Frames that are too short for what is configured of them.", &self.short),
            ("sync_doubted_seconds", "Seconds in which Sync was missing or too frequent.", &self.sync_doubted),
            ("frames_imitated", "Frames of other devices with one of the gateway's own identifiers.", &self.imitated),
            ("frames_held", "Frames that came before their cycle opened, and were kept for it.", &self.held),
            ("signals_bad", "Signals for which the frame was too short, or that are not a finite \
                number.", &self.bad_signals),
            ("status_unnamed", "Bits of status signals that were set without a meaning in the configuration, each of a \
                transducer counted once.", &self.unnamed_status_bits),
            ("frames_backwards", "Frames with a time stamp earlier than that of the previous \
                one.", &self.backwards),
            ("time_jumps", "Jumps in time, after which everything restarted.", &self.time_jumps),
            ("turns", "Turns of the data path.", &self.turns),
            ("port_opens", "Times that the interface was opened.", &self.opens),
            ("port_losses", "Times that the open interface was lost.", &self.losses),
            ("port_reconnects", "Times that the interface was opened after a loss.", &self.reconnects),
            ("history_writes", "Times that the history of the stops was written to its file.", &self.history_writes),
            ("history_failures", "Times that the history of the stops could not be written.", &self.history_failures),
            ("history_crowded", "Times that the history of the stops was not handed over, because \
                too much waited to be written; the next write includes it.", &self.history_crowded),
            ("store_written", "Notes that the event store has written: incidents, warnings, events.", &self.store_written),
            ("store_lost", "Notes that the event store had no room for.", &self.store_lost),
            ("store_failures", "Times that the event store could not be written; it is tried again.", &self.store_failures),
            ("login_failures", "Wrong tokens that were given to the page, to log in or to act.", &self.login_failures),
            ("login_lockouts", "Times that an address was locked out after wrong tokens.", &self.login_lockouts),
            ("recorder_recordings", "Recordings that were written.", &self.recorder_recordings),
            ("recorder_failures", "Recordings that could not be written.", &self.recorder_failures),
            ("recorder_left_out", "Incidents that were not recorded, because too many came at once.",
                &self.recorder_left_out),
            ("recorder_frames_lost", "Frames that are missing in the ring of the recorder.", &self.recorder_lost),
        ]
    }
}
