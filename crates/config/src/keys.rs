//! Every key of the configuration file: its purpose, type and limits.

mod appliance;
mod canopen;
mod estimate;
mod fitted;

use super::schema::{Key, Kind, Limits, Scalar, Table, WholeLimits};
use super::text::TextRule;

/// Most cylinders: Fd_Status has two state bits for each transducer of six cylinders.
pub(super) const MOST_CYLINDERS: u8 = 6;

const DURATION: &str = "a duration in seconds";
const FINITE: &str = "nan and inf cannot be computed with";
const THRESHOLD: &str = "a threshold in metres; residuals are compared by their size";

const fn text(rule: TextRule) -> Kind {
    Kind::One(Scalar::Text(rule))
}

const fn number(limits: Limits) -> Kind {
    Kind::One(Scalar::Number(limits))
}

const fn numbers(count: usize, limits: Limits) -> Kind {
    Kind::List { least: count, most: count, of: Scalar::Number(limits) }
}

const fn whole(low: i128, high: i128, why: &'static str) -> Kind {
    Kind::One(Scalar::Whole(WholeLimits::new(low, high, why)))
}

const fn counts(least: usize, most: usize) -> Kind {
    let limits = WholeLimits::new(i64::MIN as i128, i64::MAX as i128, "raw counts of a signal");
    Kind::List { least, most, of: Scalar::Whole(limits) }
}

const fn level() -> Kind {
    Kind::One(Scalar::Choice(&["none", "yellow", "orange", "red", "black"]))
}

#[rustfmt::skip]
pub(super) static ROOT: Table = Table { keys: &[
    Key::required("machine", Kind::Table(&MACHINE), "", "what the machine is"),
    Key::required("bus", Kind::Table(&BUS), "", "where its frames are and what they mean"),
    Key::required("signals", Kind::Table(&SIGNALS), "", "which signals of the DBC are monitored"),
    Key::optional("plausibility", Kind::Table(&PLAUSIBILITY), "",
        "when a reading is rejected before any model is asked"),
    Key::optional("model", Kind::Table(&MODEL), "", "the discrete model (4-1)"),
    Key::optional("observer", Kind::Table(&OBSERVER), "", "weights of the Riccati equation"),
    Key::optional("fde", Kind::Table(&FDE), "", "thresholds of R1 and R2, m"),
    Key::optional("comparator", Kind::Table(&COMPARATOR), "", "thresholds of R3, m"),
    Key::optional("alarm", Kind::Table(&ALARM), "", "how warnings are raised and cleared"),
    Key::optional("sequential", Kind::Table(&fitted::SEQUENTIAL), "",
        "the sequential detectors, of cylinders that are calibrated for it"),
    Key::optional("estimate", Kind::Table(&estimate::ESTIMATE), "",
        "the virtual third sensor: each cylinder's length with its standard deviation"),
    Key::optional("gateway", Kind::Table(&GATEWAY), "", "the gateway's own node on the bus"),
    Key::optional("canopen", Kind::Table(&canopen::CANOPEN), "",
        "CANopen devices on the bus"),
    Key::optional("http", Kind::Table(&appliance::HTTP), "", "the gateway's own state over HTTP"),
    Key::optional("realtime", Kind::Table(&appliance::REALTIME), "", "what the gateway asks of the kernel"),
    Key::optional("cylinder", Kind::Tables(&CYLINDER), "", "overrides for one cylinder"),
] };

#[rustfmt::skip]
static MACHINE: Table = Table { keys: &[
    Key::required("name", text(TextRule::Name), "\"Ampelmann E-type\"", "the machine's name"),
    Key::required("cylinders",
        whole(1, MOST_CYLINDERS as i128, "Fd_Status, the gateway's own frame, has room for six"),
        "6", "how many cylinders there are"),
    Key::required("sample_time",
        number(Limits::least(1e-3, "the time between two SYNC frames, in seconds: below 1 ms CAN carries few \
            frames, and one that waits is in the next cycle; beyond 1 s a clock set back passes for disorder").most(1.0)),
        "0.02", "the sample time Ts, s"),
    Key::required("stroke",
        numbers(2, Limits::finite("the ends of the cylinder's reach in metres")),
        "[-1.5, 1.5]", "the cylinder's reach, retracted and extended, m"),
    Key::optional("area_ratio",
        number(Limits::above(0.0, "the rod side's area by the bottom side's, (3-5)").most(1.0)),
        "0.5", "the area ratio of (3-5), by which P_L follows from the chambers' pressures"),
    Key::optional("monitored_states",
        Kind::List { least: 1, most: 64, of: Scalar::Text(TextRule::Name) },
        "[\"engaged\"]", "the platform states in which FDE1 and FDE2 judge; absent: always"),
    Key::optional("cycle_deadline",
        number(Limits::above(0.0, DURATION)),
        "0.016", "readings later than this in their cycle are late, s; absent: 0.8 sample_time"),
    Key::optional("max_gap",
        number(Limits::least(0.0, "an observer that predicts for longer is only guessing").most(60.0)),
        "0.1", "an observer predicts over at most this long a gap, s"),
] };

#[rustfmt::skip]
static BUS: Table = Table { keys: &[
    Key::required("interface", text(TextRule::Interface), "\"can0\"",
        "a SocketCAN interface, or virtual: the embedded bus"),
    Key::required("dbc", text(TextRule::Path), "\"../dbc/e-type.dbc\"",
        "the DBC file, relative to this file"),
    Key::optional("bitrate", whole(10_000, 8_000_000, "CAN has 10 kbit/s to 8 Mbit/s"), "500000",
        "bit rate of the bus, bit/s; the gateway's share is computed from it"),
] };

#[rustfmt::skip]
static SIGNALS: Table = Table { keys: &[
    Key::optional("sync", text(TextRule::Message), "\"Sync\"", "the message that opens a cycle"),
    Key::optional("state", text(TextRule::Signal), "\"Plc_State.PlatformState\"",
        "the platform's state"),
    Key::optional("supply", text(TextRule::Signal), "\"Plc_State.SupplyPressure\"",
        "the supply pressure P_S, bar, for `identify --nonlinear`"),
    Key::required("cylinder", Kind::Table(&CYLINDER_SIGNALS), "", "the signals of a cylinder"),
] };

#[rustfmt::skip]
static CYLINDER_SIGNALS: Table = Table { keys: &[
    Key::required("c1", text(TextRule::CylinderSignal), "\"Cyl{n}_C1.Position\"",
        "the position by transducer C1, m"),
    Key::optional("c1_velocity", text(TextRule::CylinderSignal), "\"Cyl{n}_C1.Velocity\"",
        "the velocity by transducer C1, m/s"),
    Key::optional("c1_status", text(TextRule::CylinderSignal), "\"Cyl{n}_C1.Status\"",
        "the status bits of transducer C1"),
    Key::optional("c1_counter", text(TextRule::CylinderSignal), "\"Cyl{n}_C1.Counter\"",
        "the alive counter of transducer C1"),
    Key::optional("c2", text(TextRule::CylinderSignal), "\"Cyl{n}_C2.Position\"",
        "the position by transducer C2, m"),
    Key::optional("c2_velocity", text(TextRule::CylinderSignal), "\"Cyl{n}_C2.Velocity\"",
        "the velocity by transducer C2, m/s"),
    Key::optional("c2_status", text(TextRule::CylinderSignal), "\"Cyl{n}_C2.Status\"",
        "the status bits of transducer C2"),
    Key::optional("c2_counter", text(TextRule::CylinderSignal), "\"Cyl{n}_C2.Counter\"",
        "the alive counter of transducer C2"),
    Key::required("control_speed", text(TextRule::CylinderSignal), "\"Cyl{n}_Valve.ControlSpeed\"",
        "the commanded speed u of (4-1), m/s"),
    Key::optional("pressure_bottom", text(TextRule::CylinderSignal), "\"Cyl{n}_Valve.PressureBottom\"",
        "the pressure in the bottom chamber"),
    Key::optional("pressure_rod", text(TextRule::CylinderSignal), "\"Cyl{n}_Valve.PressureRod\"",
        "the pressure in the rod chamber"),
    Key::optional("load_pressure", text(TextRule::CylinderSignal), "\"Cyl{n}_Load.Pressure\"",
        "the load pressure P_L itself, bar, where the machine sends it"),
    Key::optional("spool", text(TextRule::CylinderSignal), "\"Cyl{n}_Valve.SpoolPosition\"",
        "the position of the main spool, positive extends, for `identify --nonlinear`"),
] };

#[rustfmt::skip]
static PLAUSIBILITY: Table = Table { keys: &[
    Key::optional("stale", number(Limits::above(0.0, DURATION).most(3600.0)), "0.1",
        "without a new reading for this long a signal is stale, s"),
    Key::optional("broken_wire_codes", counts(0, 64), "[32767]",
        "raw counts that mean a broken wire; absent: 32767 of a signal of 16 bits, unless it is valid"),
    Key::optional("status_mask", whole(0, u64::MAX as i128, "bits of an unsigned signal"), "3",
        "the bits of a status signal that mean a broken wire"),
    Key::optional("valid_raw", counts(2, 2), "[1, 27648]",
        "the lowest and the highest raw count of a healthy reading"),
    Key::optional("frozen", number(Limits::above(0.0, DURATION).most(3600.0)), "0.1",
        "a reading exactly constant for this long while the command moves is frozen, s"),
    Key::optional("frozen_speed",
        number(Limits::least(0.0, "the size of a speed in metres per second")), "0.02",
        "the command moves when it is beyond this, m/s"),
    Key::optional("state_stale", number(Limits::above(0.0, DURATION).most(3600.0)), "1.0",
        "without a new platform state for this long the state is not known, s"),
] };

#[rustfmt::skip]
static MODEL: Table = Table { keys: &[
    Key::optional("theta", numbers(5, Limits::finite(FINITE)),
        "[-0.0101, -0.1231, -1.6891e-5, -10.7104, -0.0023]", "theta of (4-1)"),
    Key::optional("gamma", numbers(2, Limits::finite(FINITE)), "[0.0926, 6.5427]",
        "gamma of (4-1)"),
    Key::optional("command_offset", number(Limits::finite(FINITE)), "0.0",
        "the command at which a cylinder rests, m/s; (4-1) takes u less this"),
    Key::optional("sample_time", number(Limits::above(0.0, DURATION)), "0.02",
        "the sample time of theta and gamma, s; absent: not known, except for Table 4-1"),
] };

#[rustfmt::skip]
static OBSERVER: Table = Table { keys: &[
    Key::optional("q", numbers(3, Limits::least(0.0, "a variance of the process")),
        "[5e-9, 2e-4, 1e4]", "the diagonal of Q: position, velocity, load pressure"),
    Key::optional("r",
        numbers(2, Limits::above(0.0, "the variance of a measurement; without noise there is no gain")),
        "[1e-8, 5.0]", "the diagonal of R: position, velocity"),
    Key::optional("settle", number(Limits::least(0.0, DURATION).most(600.0)), "1.0",
        "an observer judges after it has followed its readings for this long, s"),
    Key::optional("sample_time", number(Limits::above(0.0, DURATION)), "0.02",
        "the sample time that q and r were tuned at, s; absent: not known"),
] };

#[rustfmt::skip]
static FDE: Table = Table { keys: &[
    Key::optional("low", number(Limits::above(0.0, THRESHOLD)), "7.5e-4",
        "below this R1 and R2 count towards clearing, m"),
    Key::optional("high", number(Limits::above(0.0, THRESHOLD)), "1.0e-3",
        "above this R1 and R2 raise a warning, m"),
] };

#[rustfmt::skip]
static COMPARATOR: Table = Table { keys: &[
    Key::optional("bound", number(Limits::above(0.0, THRESHOLD)), "1.5e-3",
        "above this R3 raises a warning, m"),
    Key::optional("low", number(Limits::above(0.0, THRESHOLD)), "1.125e-3",
        "below this R3 counts towards clearing, m; absent: three quarters of bound"),
    Key::optional("critical", number(Limits::above(0.0, THRESHOLD)), "0.05",
        "the machine's own limit of the measured difference, m"),
] };

#[rustfmt::skip]
static ALARM: Table = Table { keys: &[
    Key::optional("clear", number(Limits::least(0.0, DURATION).most(3600.0)), "1.0",
        "a warning clears after its residual stayed below the lower threshold this long, s"),
    Key::optional("coincidence", number(Limits::least(0.0, DURATION).most(3600.0)), "0.2",
        "FDEs that raise within this time of each other saw the same event, s"),
    Key::optional("levels", Kind::Table(&LEVELS), "", "which finding has which level of Table 2-1"),
] };

#[rustfmt::skip]
static LEVELS: Table = Table { keys: &[
    Key::optional("located", level(), "\"yellow\"", "one transducer is blamed by its FDE"),
    Key::optional("undecided", level(), "\"yellow\"", "R3 beyond its bound, location not decided"),
    Key::optional("process", level(), "\"yellow\"",
        "both observers disagree with readings that agree with each other"),
    Key::optional("implausible", level(), "\"orange\"",
        "a reading is stale, out of range, frozen or has a broken wire"),
    Key::optional("both", level(), "\"black\"", "neither transducer can be relied on"),
    Key::optional("critical", level(), "\"black\"", "the measured C1 - C2 beyond the critical limit"),
] };

#[rustfmt::skip]
static GATEWAY: Table = Table { keys: &[
    Key::optional("node", whole(1, 127, "CANopen has nodes 1 to 127"), "81",
        "the gateway's CANopen node; Fd_Status is 0x180 + node"),
    Key::optional("bus_share",
        number(Limits::above(0.0, "the part of the bus that the gateway may take").most(0.5)),
        "0.05", "the largest part of the bus that the gateway takes, 0 to 0.5"),
    Key::optional("max_age", number(Limits::above(0.0, DURATION).most(10.0)), "0.2",
        "a frame that could not be sent for this long is dropped, s"),
    Key::optional("guard", number(Limits::least(0.0, DURATION).most(1.0)), "0.01",
        "deadlines are kept this far behind the clock, for frames still on their way, s"),
] };

#[rustfmt::skip]
static CYLINDER: Table = Table { keys: &[
    Key::required("n",
        whole(1, MOST_CYLINDERS as i128, "cylinders are numbered from 1 to machine.cylinders"),
        "1", "which cylinder"),
    Key::optional("c2_gain",
        number(Limits::least(0.5, "both transducers measure the same stroke, so a is close to 1").most(2.0)),
        "1.0", "a of (5-20)"),
    Key::optional("c2_offset", number(Limits::finite(FINITE)), "0.0", "b of (5-20), m"),
    Key::optional("theta", numbers(5, Limits::finite(FINITE)),
        "[-0.0101, -0.1231, -1.6891e-5, -10.7104, -0.0023]", "theta of (4-1) for this cylinder"),
    Key::optional("gamma", numbers(2, Limits::finite(FINITE)), "[0.0926, 6.5427]",
        "gamma of (4-1) for this cylinder"),
    Key::optional("command_offset", number(Limits::finite(FINITE)), "0.0",
        "the command at which this cylinder rests, m/s"),
    Key::optional("sample_time", number(Limits::above(0.0, DURATION)), "0.02",
        "the sample time of theta and gamma of this cylinder, s; absent: not known"),
    Key::optional("sequential", Kind::Table(&fitted::CYLINDER_SEQUENTIAL), "",
        "what `calibrate` has fitted for the sequential detector"),
] };

#[cfg(test)]
mod tests {
    use serde::de::value::Error;
    use serde::de::{Deserialize, Deserializer, Error as _, Visitor};
    use serde::forward_to_deserialize_any;

    use super::super::settings;
    use super::*;

    /// Deserializer that collects the names of a type's fields.
    struct Fields<'a>(&'a mut Vec<&'static str>);

    impl<'de> Deserializer<'de> for Fields<'_> {
        type Error = Error;

        fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Error> {
            Err(Error::custom("asks for fields only"))
        }

        fn deserialize_struct<V: Visitor<'de>>(
            self,
            _: &'static str,
            fields: &'static [&'static str],
            _: V,
        ) -> Result<V::Value, Error> {
            self.0.extend(fields);
            Err(Error::custom("has them"))
        }

        forward_to_deserialize_any! {
            bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf
            option unit unit_struct newtype_struct seq tuple tuple_struct map enum identifier
            ignored_any
        }
    }

    fn fields<T: for<'de> Deserialize<'de>>() -> Vec<&'static str> {
        let mut names = Vec::new();
        assert!(T::deserialize(Fields(&mut names)).is_err());
        names.sort_unstable();
        names
    }

    #[test]
    fn every_table_has_the_keys_of_its_type() {
        let tables = [
            (&ROOT, fields::<settings::Settings>()),
            (&MACHINE, fields::<settings::Machine>()),
            (&BUS, fields::<settings::Bus>()),
            (&SIGNALS, fields::<settings::Signals>()),
            (&CYLINDER_SIGNALS, fields::<settings::CylinderSignals>()),
            (&PLAUSIBILITY, fields::<settings::Plausibility>()),
            (&MODEL, fields::<settings::Model>()),
            (&OBSERVER, fields::<settings::Observer>()),
            (&FDE, fields::<settings::Fde>()),
            (&COMPARATOR, fields::<settings::Comparator>()),
            (&ALARM, fields::<settings::Alarm>()),
            (&LEVELS, fields::<settings::ReadLevels>()),
            (&estimate::ESTIMATE, fields::<settings::Estimate>()),
            (&GATEWAY, fields::<settings::Gateway>()),
            (&canopen::CANOPEN, fields::<settings::Canopen>()),
            (&canopen::DEVICE, fields::<settings::Device>()),
            (&appliance::HTTP, fields::<settings::Http>()),
            (&appliance::REALTIME, fields::<settings::Realtime>()),
            (&CYLINDER, fields::<settings::Cylinder>()),
        ];
        for (table, fields) in tables {
            let mut names: Vec<_> = table.names().collect();
            names.sort_unstable();
            assert_eq!(names, fields);
        }
    }

    /// The file of all examples, or only of those that are required.
    fn examples(path: &str, table: &Table, all: bool, text: &mut String) {
        let wanted = || table.keys.iter().filter(|key| all || key.required);
        for key in wanted().filter(|key| !key.example.is_empty()) {
            text.push_str(&format!("{}\n", key.written()));
        }
        for key in wanted() {
            let full = format!("{path}{}", key.name);
            let (header, inner) = match key.kind {
                Kind::Table(inner) => (format!("[{full}]\n"), inner),
                Kind::Tables(inner) => (format!("[[{full}]]\n"), inner),
                Kind::One(_) | Kind::List { .. } => continue,
            };
            text.push_str(&header);
            examples(&format!("{full}."), inner, all, text);
        }
    }

    #[test]
    fn the_examples_are_a_sound_configuration() {
        for all in [true, false] {
            let mut text = String::new();
            examples("", &ROOT, all, &mut text);
            if let Err(error) = super::super::parse("examples", &text) {
                panic!("{error}\n{text}");
            }
        }
    }

    #[test]
    fn what_is_required_is_what_the_types_cannot_do_without() {
        fn visit(path: &str, table: &Table, whole: &toml::Table) {
            for key in table.keys {
                let full = format!("{path}{}", key.name);
                let mut without = whole.clone();
                remove(&mut without, &full);
                let sound = without.try_into::<settings::Settings>().is_ok();
                assert_eq!(sound, !key.required, "{full}");
                if let Kind::Table(inner) = key.kind {
                    visit(&format!("{full}."), inner, whole);
                }
            }
        }
        fn remove(table: &mut toml::Table, path: &str) {
            match path.split_once('.') {
                None => drop(table.remove(path)),
                Some((first, rest)) => {
                    let inner = table.get_mut(first).and_then(toml::Value::as_table_mut);
                    remove(inner.expect("the examples have every table"), rest);
                }
            }
        }
        let mut text = String::new();
        examples("", &ROOT, true, &mut text);
        visit("", &ROOT, &text.parse().expect("the examples are TOML"));
        let no_number = text.replace("n = 1\n", "");
        assert!(toml::from_str::<settings::Settings>(&no_number).is_err());
    }
}
