//! Times as OPC UA has them.

use opcua::types::DateTime;
use tertius_core::time::Timestamp;

/// 100 ns in a second, and the seconds from 1601, with which OPC UA begins, to 1970.
const TICKS: i64 = 10_000_000;
const SINCE_1601: i64 = 11_644_473_600;

/// `at` in the standard's steps of 100 ns.
pub(super) fn date_time(at: Timestamp) -> DateTime {
    let ticks = at.as_nanos().div_euclid(100) + SINCE_1601 * TICKS;
    DateTime::from(ticks)
}
