//! A limit without a kink.

/// Part of the limit up to which nothing changes.
const FREE: f64 = 0.9;

/// `value` and its `rate` kept within ±`limit`: unchanged up to nine tenths, and approaching the
/// limit asymptotically from there on. The rate stays the value's derivative, so that a cylinder
/// can follow both.
pub fn soft(value: f64, rate: f64, limit: f64) -> (f64, f64) {
    let beyond = value.abs() - FREE * limit;
    if beyond <= 0.0 {
        return (value, rate);
    }
    let room = (1.0 - FREE) * limit;
    let left = (-beyond / room).exp();
    ((FREE * limit + room * (1.0 - left)).copysign(value), rate * left)
}
