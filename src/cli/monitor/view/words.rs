//! Times and numbers in words.

use super::super::news::{WatchedCylinder, WatchedTransducer};
use std::time::Duration;

/// Time of day of a time stamp in seconds, in UTC.
pub fn time_of_day(seconds: f64) -> String {
    let seconds = seconds.max(0.0) as u64 % 86_400;
    format!("{:02}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60)
}

/// A length of time in whole units.
pub fn length(time: Duration) -> String {
    match time.as_secs() {
        0 => "under 1 s".to_owned(),
        seconds @ 1..120 => format!("{seconds} s"),
        seconds @ 120..7200 => format!("{} min", seconds / 60),
        seconds @ 7200..172_800 => format!("{} h", seconds / 3600),
        seconds => format!("{} days", seconds / 86_400),
    }
}

/// A size in mm, in at most five columns.
pub fn five_columns(size: f64) -> String {
    match size.abs() {
        0.0..100.0 => format!("{size:.2}"),
        100.0..1000.0 => format!("{size:.1}"),
        _ => format!("{size:.0}"),
    }
}

/// What the stops say of a transducer; empty where they say nothing.
pub fn drift(name: &str, transducer: &WatchedTransducer) -> String {
    let Some(drift) = transducer.drift_mm_per_month else { return String::new() };
    let error = transducer.error_mm_per_month.map_or(String::new(), |it| format!(" ± {it:.2}"));
    let left = match transducer.months_left {
        [Some(expected), Some(earliest), Some(latest)] => {
            format!(", maintenance in {expected:.0} months ({earliest:.0} to {latest:.0})")
        }
        [Some(expected), ..] => format!(", maintenance in {expected:.0} months"),
        _ => String::new(),
    };
    format!("{name} drifts by {drift:+.2}{error} mm a month{left}")
}

/// The estimate of the virtual sensor; empty without one.
pub fn estimate(cylinder: &WatchedCylinder) -> String {
    let (Some(length), Some(sigma)) = (cylinder.estimate_m, cylinder.sigma_mm) else {
        return String::new();
    };
    format!("virtual sensor {length:.3} m ± {:.2} mm (2 σ)", 2.0 * sigma)
}
