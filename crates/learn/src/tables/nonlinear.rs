//! Flow curve and friction of one cylinder, as the configuration and the plant read them.

use super::digits::six;
use crate::identify::friction::FrictionCurve;
use crate::identify::nonlinear::Nonlinear;
use crate::identify::valve::IdentifiedValve;
use std::fmt::Write as _;
use tertius_config::settings::ValveCurve;

/// `[cylinder.nonlinear]` of cylinder `n`; `None` where neither its flow nor its friction was identified.
pub fn table(nonlinear: &Nonlinear, n: u8) -> Option<String> {
    let place = usize::from(n).checked_sub(1)?;
    let valve = nonlinear.valves.get(place).and_then(|it| it.as_ref().ok());
    let friction = nonlinear.friction.get(place).and_then(|it| it.as_ref().ok());
    if valve.is_none() && friction.is_none() {
        return None;
    }
    let mut text = String::new();
    if let Some(valve) = valve {
        text += &of_valve(valve);
    }
    if let Some(friction) = friction {
        text += &of_friction(friction);
    }
    Some(text)
}

fn of_valve(valve: &IdentifiedValve) -> String {
    let ValveCurve { limit, curve, samples, between, leakage, compression } = &valve.curve;
    let [inward, outward] = valve.reach;
    let share = valve.score.velocity.vaf();
    let mut text = "\n[cylinder.nonlinear.flow]\n".to_owned();
    _ = write!(
        text,
        "# known from {inward:.3} to {outward:.3}; explains {share:.2} % of the velocity in the trial\n\
         limit = {limit:?}\ncurve = {}\nsamples = {samples:?}\nbetween = {between:?}\n\
         leakage = {leakage:e}\ncompression = {compression:e}\n",
        six(curve),
    );
    text
}

fn of_friction(curve: &FrictionCurve) -> String {
    // What measurement makes of nothing may be below it.
    let [viscous, coulomb] = [curve.viscous, curve.coulomb].map(|it| it.max(0.0));
    let mut text = "\n[cylinder.nonlinear.friction]\n".to_owned();
    _ = write!(text, "viscous = {viscous:e}\ncoulomb = {coulomb:e}\n");
    if let Some((stiction, speed)) = curve.stribeck {
        _ = write!(text, "stiction = {stiction:e}\nstribeck_speed = {speed:e}\n");
    }
    text
}
