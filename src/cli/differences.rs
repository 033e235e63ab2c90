//! What tells the machine of one configuration from that of another, before tables that were learnt by one are put into
//! the other.

use super::machine::Machine;
use crate::decode::SignalPlan;
use crate::frame::{BusNumber, Id};
use crate::monitor::MonitorDesign;
use crate::monitor::subscriptions::Target;
use crate::sample::{Field, Pressure, Transducer};
use crate::text::counted;

/// Most signals of which it is said what they differ by.
const TOLD: usize = 2;

/// What tells the machine of `found` from that of `expected`, in words; empty where nothing does. Signals are compared by
/// where they are in which frames, and not by their names or by what else their DBC has.
pub fn differences(found: &Machine, expected: &Machine) -> Vec<String> {
    let [own, others] = [found, expected].map(|it| &it.loaded.settings.machine);
    let mut differences = Vec::new();
    if own.sample_time != others.sample_time {
        let [own, others] = [own, others].map(|it| it.sample_time);
        differences.push(format!("machine.sample_time is {own} s, expected {others} s"));
    }
    if own.cylinders != others.cylinders {
        let [own, others] = [own, others].map(|it| it.cylinders);
        differences.push(format!("machine.cylinders is {own}, expected {others}"));
        return differences;
    }
    let mut signals = signals(&found.design, &expected.design);
    let more = signals.len().saturating_sub(TOLD) as u64;
    signals.truncate(TOLD);
    differences.extend(signals);
    if more > 0 {
        differences.push(format!("and {}", counted(more, "more signal")));
    }
    differences
}

/// Where a signal is.
#[derive(Clone, Copy, PartialEq)]
struct Place<'a> {
    bus: BusNumber,
    id: Id,
    /// `None` for a message as a whole.
    plan: Option<&'a SignalPlan>,
}

/// The signals that are elsewhere in `found` than in `expected`, in words.
fn signals(found: &MonitorDesign, expected: &MonitorDesign) -> Vec<String> {
    let [own, others] = [found, expected].map(|it| places(it).collect::<Vec<_>>());
    let mut targets: Vec<Option<Target>> = others.iter().map(|(target, _)| *target).collect();
    targets.extend(own.iter().map(|(target, _)| *target).filter(|&it| of(&others, it).is_none()));
    let told = targets.into_iter().filter_map(|target| {
        let told = match (of(&own, target), of(&others, target)) {
            (own, others) if own == others => return None,
            (Some(own), Some(others)) if (own.bus, own.id) == (others.bus, others.id) => {
                format!("has other bits or another scale in {} than expected", frame(own))
            }
            (Some(own), Some(others)) => {
                format!("is in {}, expected in {}", frame(own), frame(others))
            }
            // What is only judged or shown may be named later; tables depend on what is learnt from.
            _ if !is_learnt(target) => return None,
            (Some(own), None) => format!("is in {}, expected in none", frame(own)),
            (None, others) => {
                format!("is not named, expected in {}", others.map_or_else(String::new, frame))
            }
        };
        Some(format!("{} {told}", name(target)))
    });
    told.collect()
}

/// The place of `target` among `places`.
fn of<'a>(places: &[(Option<Target>, Place<'a>)], target: Option<Target>) -> Option<Place<'a>> {
    places.iter().find(|(it, _)| *it == target).map(|(_, place)| *place)
}

/// All signals that `design` reads, and the message that opens its cycles, which has no target.
fn places(design: &MonitorDesign) -> impl Iterator<Item = (Option<Target>, Place<'_>)> {
    design.subscriptions.all().iter().flat_map(|message| {
        let (bus, id) = (message.bus, message.id);
        let signals = message
            .signals
            .iter()
            .map(move |signal| (Some(signal.target), Place { bus, id, plan: Some(&signal.plan) }));
        let sync = message.sync.then_some((None, Place { bus, id, plan: None }));
        signals.chain(sync)
    })
}

/// Whether tables are learnt from every machine's signals of this target.
const fn is_learnt(target: Option<Target>) -> bool {
    use Field::{Command, Position, Velocity};
    matches!(target, Some(Target::Cylinder(_, Position(_) | Velocity(_) | Command)))
}

fn frame(place: Place<'_>) -> String {
    match place.bus {
        BusNumber::First => format!("frame 0x{}", place.id),
        bus => format!("frame 0x{} of the {bus} bus", place.id),
    }
}

/// The key of a signal, and its cylinder if it has one.
fn name(target: Option<Target>) -> String {
    let key = match target {
        None => "sync",
        Some(Target::State) => "state",
        Some(Target::Inclination(_)) => return "an angle in [signals]".to_owned(),
        Some(Target::Cylinder(_, Field::Pressure(Pressure::Supply))) => "supply",
        Some(Target::Cylinder(index, field)) => {
            let n = index + 1;
            return format!("signals.cylinder.{} of cylinder {n}", of_cylinder(field));
        }
    };
    format!("signals.{key}")
}

const fn of_cylinder(field: Field) -> &'static str {
    use Transducer::{C1, C2};
    match field {
        Field::Position(C1) => "c1",
        Field::Position(C2) => "c2",
        Field::Velocity(C1) => "c1_velocity",
        Field::Velocity(C2) => "c2_velocity",
        Field::Status(C1) => "c1_status",
        Field::Status(C2) => "c2_status",
        Field::Counter(C1) => "c1_counter",
        Field::Counter(C2) => "c2_counter",
        Field::Command => "control_speed",
        Field::Pressure(Pressure::Bottom) => "pressure_bottom",
        Field::Pressure(Pressure::Rod) => "pressure_rod",
        Field::Pressure(Pressure::Load | Pressure::Supply) => "load_pressure",
        Field::Spool => "spool",
    }
}
