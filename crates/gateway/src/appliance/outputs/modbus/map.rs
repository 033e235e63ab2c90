//! The register map: what of the telemetry stands where.

use super::sheet::{RegisterEntry, RegisterSheet};
use crate::appliance::telemetry::OpenSlot;
use crate::appliance::telemetry::snapshot::{CylinderSnapshot, Snapshot};
use std::time::Duration;
use tertius_core::alarm::Detector;
use tertius_core::alarm::status::MAX_CYLINDERS;
use tertius_core::verdict::{Fault, Suspect};

/// Version of the map: another one where a register changes its meaning, not where some are added behind a block.
const VERSION: u16 = 1;

/// First register of cylinder 1, and registers from one cylinder to the next.
const CYLINDER: u16 = 100;
const STEP: u16 = 100;

/// In place of a whole number that is not known.
const NONE: u16 = u16::MAX;

/// The registers of a machine that is in the state `now`.
pub fn registers(now: &Snapshot) -> RegisterSheet {
    laid_out(RegisterSheet::default(), now)
}

/// Descriptions of all registers of a machine with the most cylinders.
pub fn described() -> Vec<RegisterEntry> {
    let nothing = Snapshot::unknown(MAX_CYLINDERS);
    laid_out(RegisterSheet::described(), &nothing).entries().to_vec()
}

fn laid_out(mut sheet: RegisterSheet, now: &Snapshot) -> RegisterSheet {
    sheet.block(0);
    machine(&mut sheet, now);
    for (first, cylinder) in (CYLINDER..).step_by(usize::from(STEP)).zip(&now.cylinders) {
        sheet.block(first);
        of_cylinder(&mut sheet, first / STEP, cylinder);
    }
    sheet
}

#[rustfmt::skip]
fn machine(sheet: &mut RegisterSheet, now: &Snapshot) {
    let whole = |number: u64| u32::try_from(number).unwrap_or(u32::MAX);
    let small = |number: usize| u16::try_from(number).unwrap_or(NONE);
    let millis = |time: Duration| u32::try_from(time.as_millis()).unwrap_or(u32::MAX);
    sheet.u16(("map_version", "", "version of this map"), VERSION);
    sheet.u16(("condition", "", "as `status` of /health: 0 ok, 1 unknown, 2 degraded, 3 down"), now.condition.number());
    sheet.u16(("mode", "", "as in Fd_Status: 0 starting, 1 monitoring, 2 gated, 3 degraded, 4 stopping; 65535 not known"),
        now.mode.map_or(NONE, u16::from));
    sheet.u16(("level", "", "highest level, as in Fd_Status: 0 none, 1 yellow, 2 orange, 3 red, 4 black"), now.level.into());
    sheet.u16(("warnings_standing", "", "warnings that stand, as in Fd_Status"), small(now.warnings_standing as usize));
    sheet.u16(("incidents_open", "", "incidents that are open"), small(now.incidents));
    sheet.u16(("cylinders", "", "cylinders of the machine; those beyond have no registers"), small(now.cylinders.len()));
    sheet.u16(("platform_state", "", "number of the platform's state; 65535 not known"),
        now.platform.and_then(|number| u16::try_from(number).ok()).unwrap_or(NONE));
    sheet.u32(("uptime", "s", "time since the gateway's start"), whole(now.uptime.as_secs()));
    sheet.u32(("since_frame", "ms", "time since the newest frame of the machine; 4294967295 none yet"),
        now.since_frame.map_or(u32::MAX, millis));
    sheet.u32(("cycles", "", "cycles since the gateway's start, modulo 4294967296"), now.cycles as u32);
    sheet.u32(("configuration", "", "identity of the configuration; 0 without one"), now.identity.unwrap_or(0));
    sheet.u32(("calibration", "", "identity of the calibration; 0 without one"), now.calibration.unwrap_or(0));
    for number in 0..MAX_CYLINDERS {
        for which in 0..2 {
            let name = format!("cylinder_{}_c{}", number + 1, which + 1);
            let state = now.cylinders.get(number).map(|cylinder| cylinder.transducers[which]);
            sheet.u16((&name, "", "state of the transducer: 0 unknown, 1 healthy, 2 suspect, 3 faulty, 4 not fitted"),
                state.unwrap_or_default() as u16);
        }
    }
}

fn of_cylinder(sheet: &mut RegisterSheet, number: u16, now: &CylinderSnapshot) {
    let name = |what: &str| format!("cylinder_{number}_{what}");
    for (which, lamp) in now.lamps.into_iter().enumerate() {
        let told = "NAMUR NE 107: 0 unknown, 1 good, 2 maintenance required, 3 out of specification, 4 check function, \
                    5 failure, 6 not fitted";
        sheet.u16((&name(&format!("c{}_lamp", which + 1)), "", told), lamp.number().into());
    }
    for (which, residual) in now.residuals.into_iter().enumerate() {
        let told = format!("|R{}| of the newest cycle", which + 1);
        sheet.f32((&name(&format!("r{}", which + 1)), "m", &told), residual);
    }
    sheet.f32((&name("estimate"), "m", "estimated length, as in Fd_Estimate"), now.estimate);
    sheet.f32((&name("sigma"), "m", "its standard deviation"), now.sigma);
    incident(sheet, &name, now.incident);
    for (detector, raised) in Detector::ALL.into_iter().zip(now.raised) {
        let told = format!("warnings of {} since the gateway's start", detector.label());
        sheet.u32((&name(&format!("raised_{}", detector.name())), "", &told), raised as u32);
    }
}

fn incident(sheet: &mut RegisterSheet, name: &dyn Fn(&str) -> String, now: Option<OpenSlot>) {
    let listed = |names: Vec<&str>| {
        let numbered: Vec<String> =
            names.iter().enumerate().map(|(number, name)| format!("{number} {name}")).collect();
        numbered.join(", ")
    };
    let suspects = listed(Suspect::NAMES.to_vec());
    let faults = listed(Fault::ALL.iter().map(|it| it.name()).collect());
    let number = |of: fn(&OpenSlot) -> u16| now.as_ref().map_or(NONE, of);
    let told = "number of the worst open incident; 0 for none";
    sheet.u32((&name("incident"), "", told), now.map_or(0, |it| it.number));
    let told = "its level, as `level` above; 65535 without an incident, here and in the next two";
    sheet.u16((&name("incident_level"), "", told), number(|it| it.level as u16));
    sheet.u16((&name("incident_suspect"), "", &suspects), number(|it| it.suspect as u16));
    sheet.u16((&name("incident_fault"), "", &faults), number(|it| it.fault as u16));
    let begin = |it: OpenSlot| u32::try_from(it.begin.as_nanos() / 1_000_000_000).ok();
    let told = "time of its first warning, since 1970; 0 without an incident";
    sheet.u32((&name("incident_begin"), "s", told), now.and_then(begin).unwrap_or(0));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A client reads a block in one request, of which the protocol allows 125 registers, so that its values are of
    /// one moment.
    #[test]
    fn a_block_is_one_request() {
        let entries = described();
        for first in (0..=MAX_CYLINDERS as u16).map(|number| number * STEP) {
            let of: Vec<u16> = entries
                .iter()
                .map(|it| it.address)
                .filter(|it| it / STEP == first / STEP)
                .collect();
            assert_eq!(of.first(), Some(&first));
            assert!(of.last().is_some_and(|last| last - first < STEP - 1), "{of:?}");
        }
        let mut names: Vec<&str> = entries.iter().map(|it| it.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), entries.len());
    }
}
