//! Counts of the flight recorder.

use super::Telemetry;

impl Telemetry {
    /// Counts frames that the recorder could not take; for the data path alone.
    pub fn recorder_lost(&self, frames: u64) {
        self.totals.recorder_lost.add(frames);
    }

    /// Counts incidents that are not recorded; for the recorder's worker alone, as what follows.
    pub fn recorder_left_out(&self, incidents: u64) {
        self.totals.recorder_left_out.add(incidents);
    }

    /// Counts a recording, written or not.
    pub fn recorder_written(&self, written: bool) {
        self.totals.recorder_recordings.add(u64::from(written));
        self.totals.recorder_failures.add(u64::from(!written));
    }
}
