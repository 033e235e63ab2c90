//! A limit that is met without a kink.

/// The part of the limit up to which nothing is changed.
const FREE: f64 = 0.9;

/// `value` and its `rate` kept within ±`limit`: as they are up to nine tenths, from there on closer
/// and closer to the limit. The rate stays the value's own, so that a cylinder can follow both.
pub fn soft(value: f64, rate: f64, limit: f64) -> (f64, f64) {
    let beyond = value.abs() - FREE * limit;
    if beyond <= 0.0 {
        return (value, rate);
    }
    let room = (1.0 - FREE) * limit;
    let left = (-beyond / room).exp();
    ((FREE * limit + room * (1.0 - left)).copysign(value), rate * left)
}
