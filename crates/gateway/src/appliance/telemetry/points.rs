//! The state of the machine value by value, for protocols in which each value has a name, a unit and a quality.

use super::lamp::Lamp;
use super::snapshot::{CylinderSnapshot, Snapshot};
use tertius_core::alarm::status::{Health, Mode};
use tertius_core::alarm::{Detector, Level};
use tertius_core::sample::Transducer;
use tertius_core::time::Timestamp;
use tertius_core::verdict::{Fault, Suspect};

/// Unit of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointUnit {
    /// A number, or a state.
    None,
    Metre,
    Second,
    Millisecond,
}

impl PointUnit {
    /// Its symbol; empty for none.
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::None => "",
            Self::Metre => "m",
            Self::Second => "s",
            Self::Millisecond => "ms",
        }
    }
}

/// What values a point has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointKind {
    /// Whole numbers.
    Whole,
    /// Numbers.
    Real,
    /// Points in time.
    Time,
    /// One of these, by its place.
    Choice(&'static [&'static str]),
}

/// A value that is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointValue {
    Whole(i64),
    Real(f64),
    Time(Timestamp),
    /// Place in the list of choices.
    Choice(u8),
}

/// A value with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// As in the register map of Modbus: `cylinder_2_r1`.
    pub name: String,
    pub unit: PointUnit,
    pub kind: PointKind,
    /// What it is, in words.
    pub meaning: String,
    /// `None` where it is not known, or where there is none.
    pub value: Option<PointValue>,
}

/// All values of a machine, which are of one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Points {
    pub machine: Vec<Point>,
    /// Of each cylinder, from the first.
    pub cylinders: Vec<Vec<Point>>,
}

/// Conditions by the numbers of [`Condition`](super::health::Condition).
const CONDITIONS: [&str; 4] = ["ok", "unknown", "degraded", "down"];

/// Lamps by their numbers over Modbus.
const LAMPS: [&str; 7] = [
    "unknown",
    "good",
    "maintenance_required",
    "out_of_specification",
    "check_function",
    "failure",
    "not_fitted",
];

const FAULTS: [&str; Fault::ALL.len()] = {
    let mut names = [""; Fault::ALL.len()];
    let mut place = 0;
    while place < names.len() {
        names[place] = Fault::ALL[place].name();
        place += 1;
    }
    names
};

impl Points {
    /// The values in the state `now`.
    pub fn new(now: &Snapshot) -> Self {
        let cylinders = (1..).zip(&now.cylinders).map(|(number, it)| of_cylinder(number, it));
        Self { machine: of_machine(now), cylinders: cylinders.collect() }
    }

    /// All of them, the machine's before those of the cylinders.
    pub fn all(&self) -> impl Iterator<Item = &Point> {
        self.machine.iter().chain(self.cylinders.iter().flatten())
    }
}

/// Points one after the other, whose names begin alike.
struct Listing {
    prefix: String,
    points: Vec<Point>,
}

impl Listing {
    fn put(
        &mut self,
        (name, unit, meaning): (&str, PointUnit, &str),
        kind: PointKind,
        value: Option<PointValue>,
    ) {
        let (name, meaning) = (format!("{}{name}", self.prefix), meaning.to_owned());
        self.points.push(Point { name, unit, kind, meaning, value });
    }

    fn whole(&mut self, told: (&str, PointUnit, &str), value: Option<u64>) {
        let value = value.map(|value| i64::try_from(value).unwrap_or(i64::MAX));
        self.put(told, PointKind::Whole, value.map(PointValue::Whole));
    }

    fn choice(
        &mut self,
        (name, meaning): (&str, &str),
        names: &'static [&'static str],
        value: Option<u8>,
    ) {
        let value = value.filter(|place| usize::from(*place) < names.len());
        let told = (name, PointUnit::None, meaning);
        self.put(told, PointKind::Choice(names), value.map(PointValue::Choice));
    }

    fn metres(&mut self, name: &str, meaning: &str, value: Option<f64>) {
        let value = value.filter(|value| value.is_finite()).map(PointValue::Real);
        self.put((name, PointUnit::Metre, meaning), PointKind::Real, value);
    }
}

#[rustfmt::skip]
fn of_machine(now: &Snapshot) -> Vec<Point> {
    use PointUnit::{Millisecond, None, Second};
    let mut list = Listing { prefix: String::new(), points: Vec::new() };
    list.choice(("condition", "as `status` of /health"), &CONDITIONS, Some(now.condition.number() as u8));
    list.choice(("mode", "as in Fd_Status"), &Mode::NAMES, now.mode);
    list.choice(("level", "highest level, as in Fd_Status"), &Level::NAMES, Some(now.level));
    list.whole(("warnings_standing", None, "warnings that stand, as in Fd_Status"), Some(now.warnings_standing.into()));
    list.whole(("incidents_open", None, "incidents that are open"), Some(now.incidents as u64));
    list.whole(("cylinders", None, "cylinders of the machine"), Some(now.cylinders.len() as u64));
    list.put(("platform_state", None, "number of the platform's state"), PointKind::Whole,
        now.platform.map(PointValue::Whole));
    list.whole(("uptime", Second, "time since the gateway's start"), Some(now.uptime.as_secs()));
    list.whole(("since_frame", Millisecond, "time since the newest frame of the machine"),
        now.since_frame.map(|time| u64::try_from(time.as_millis()).unwrap_or(u64::MAX)));
    list.whole(("cycles", None, "cycles since the gateway's start"), Some(now.cycles));
    list.whole(("configuration", None, "identity of the configuration"), now.identity.map(u64::from));
    list.whole(("calibration", None, "identity of the calibration"), now.calibration.map(u64::from));
    list.points
}

#[rustfmt::skip]
fn of_cylinder(number: usize, now: &CylinderSnapshot) -> Vec<Point> {
    let mut list = Listing { prefix: format!("cylinder_{number}_"), points: Vec::new() };
    for (which, health) in Transducer::NAMES.into_iter().zip(now.transducers) {
        let known = (health != Health::Unknown).then_some(health as u8);
        list.choice((which, "state of the transducer"), &Health::NAMES, known);
    }
    for (which, lamp) in ["c1_lamp", "c2_lamp"].into_iter().zip(now.lamps) {
        let known = (lamp != Lamp::Unknown).then_some(lamp.number());
        list.choice((which, "the same as a lamp of NAMUR NE 107"), &LAMPS, known);
    }
    for (which, residual) in ["r1", "r2", "r3"].into_iter().zip(now.residuals) {
        list.metres(which, &format!("|{}| of the newest cycle", which.to_uppercase()), residual);
    }
    list.metres("estimate", "estimated length, as in Fd_Estimate", now.estimate);
    list.metres("sigma", "its standard deviation", now.sigma);
    let open = now.incident;
    list.whole(("incident", PointUnit::None, "number of the worst open incident; 0 for none"),
        Some(open.map_or(0, |it| it.number.into())));
    list.choice(("incident_level", "its level"), &Level::NAMES, open.map(|it| it.level as u8));
    list.choice(("incident_suspect", "whom it is about"), &Suspect::NAMES, open.map(|it| it.suspect as u8));
    list.choice(("incident_fault", "what it is"), &FAULTS, open.map(|it| it.fault as u8));
    list.put(("incident_begin", PointUnit::None, "time of its first warning"), PointKind::Time,
        open.map(|it| PointValue::Time(it.begin)));
    for (detector, raised) in Detector::ALL.into_iter().zip(now.raised) {
        let told = format!("warnings of {} since the gateway's start", detector.label());
        list.whole((&format!("raised_{}", detector.name()), PointUnit::None, &told), Some(raised));
    }
    list.points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appliance::telemetry::OpenSlot;
    use crate::appliance::telemetry::health::Condition;
    use tertius_core::incident::Cylinders;

    /// Nothing of a machine that nobody has heard is known, but what the gateway knows of itself.
    #[test]
    fn what_is_not_known_has_no_value() {
        let points = Points::new(&Snapshot::unknown(2));
        let known: Vec<&str> =
            points.all().filter(|it| it.value.is_some()).map(|it| it.name.as_str()).collect();
        let counted = |name: &&&str| name.contains("raised");
        assert_eq!(known.iter().filter(counted).count(), 2 * Detector::ALL.len());
        let others: Vec<&str> = known.into_iter().filter(|it| !it.contains("raised")).collect();
        let expected = [
            "condition",
            "level",
            "warnings_standing",
            "incidents_open",
            "cylinders",
            "uptime",
            "cycles",
            "cylinder_1_incident",
            "cylinder_2_incident",
        ];
        assert_eq!(others, expected);
        assert_eq!(points.machine[0].value, Some(PointValue::Choice(1)));
    }

    /// A choice is told by its place, which has to be the one that its name has.
    #[test]
    fn places_are_those_of_the_names() {
        let mut now = Snapshot::unknown(1);
        for (place, condition) in
            [Condition::Ok, Condition::Unknown, Condition::Degraded, Condition::Down]
                .into_iter()
                .enumerate()
        {
            let name = serde_json::to_value(condition).expect("a name");
            assert_eq!((usize::from(condition.number()), name), (place, CONDITIONS[place].into()));
        }
        for lamp in [
            Lamp::Unknown,
            Lamp::Good,
            Lamp::MaintenanceRequired,
            Lamp::OutOfSpecification,
            Lamp::CheckFunction,
            Lamp::Failure,
            Lamp::NotFitted,
        ] {
            let name = serde_json::to_value(lamp).expect("a name");
            assert_eq!(name, LAMPS[usize::from(lamp.number())]);
        }
        for (place, fault) in (0..).zip(Fault::ALL) {
            let begin = Timestamp::from_nanos(5);
            let (level, suspect) = (tertius_core::alarm::Level::Red, Suspect::C2);
            now.cylinders[0].incident = Some(OpenSlot {
                number: 7,
                cylinders: Cylinders::NONE,
                level,
                suspect,
                fault,
                is_alone: false,
                begin,
                named: None,
                worst: None,
            });
            let points = Points::new(&now);
            let found = |name: &str| {
                let named = |it: &&Point| it.name == format!("cylinder_1_{name}");
                points.all().find(named).expect("it is listed").clone()
            };
            let named = |name: &str| match (found(name).kind, found(name).value) {
                (PointKind::Choice(names), Some(PointValue::Choice(place))) => {
                    names[usize::from(place)]
                }
                other => panic!("{name}: {other:?}"),
            };
            assert_eq!(found("incident_fault").value, Some(PointValue::Choice(place)));
            assert_eq!(named("incident_fault"), fault.name());
            assert_eq!((named("incident_level"), named("incident_suspect")), ("red", "c2"));
            assert_eq!(found("incident_begin").value, Some(PointValue::Time(begin)));
        }
    }
}
