//! `[calibration]`: where the learnt tables come from.

use crate::kinds::text;
use crate::schema::table;
use crate::text::TextRule;

table! {
    /// Origin of the tables that were learnt from recordings.
    pub struct CalibrationOrigin = CALIBRATION {
        recorded: Option<String> = None => text(TextRule::Day),
            "\"2026-03-14\"",
            "the day (UTC) on which the newest recording ended that the calibration was learnt from, by which its \
             age is told; `tertius calibrate` and `tertius commission` write it";
    }
}
