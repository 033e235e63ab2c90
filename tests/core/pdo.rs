//! Where the objects of devices are in their PDOs, what they stand for, and what is said of PDOs that cannot be used.

use tertius::canopen::eds::ObjectDictionary;
use tertius::canopen::pdo::{Direction, Pdos, Scale, scale};
use tertius::frame::{Frame, Id, Kind};
use tertius::time::Timestamp;

const ENCODER: &str = include_str!("../../dbc/encoder.eds");
const VALVE: &str = include_str!("../../dbc/valve.eds");

fn read(text: &str) -> ObjectDictionary {
    ObjectDictionary::parse(text).unwrap()
}

/// `text` with `from`, which is in it once, as `to`.
fn with(text: &str, from: &str, to: &str) -> ObjectDictionary {
    assert_eq!(text.matches(from).count(), 1, "{from:?}");
    read(&text.replace(from, to))
}

/// What the objects of the device's PDO with that identifier stand for in a frame.
fn values(dictionary: &ObjectDictionary, node: u8, id: u32, data: &[u8]) -> Vec<(f64, String)> {
    let id = Id::standard(id).unwrap();
    let pdos = Pdos::of(dictionary, node).sound;
    let pdo = pdos.iter().find(|pdo| pdo.id == id).expect("the device has it");
    assert_eq!(pdo.length, data.len());
    let frame = Frame::new(Timestamp::default(), id, Kind::Data, data);
    let value = |it: &tertius::canopen::pdo::MappedObject| {
        let scale = scale(dictionary, node, it.index).unwrap();
        let value = it.plan(&scale).unwrap().decode(&frame).value().unwrap();
        (value.physical, scale.unit.to_owned())
    };
    pdo.objects.iter().map(value).collect()
}

#[test]
fn an_encoder_tells_metres_and_metres_per_second() {
    let dictionary = read(ENCODER);
    let mut data = (-1_234_567_i32).to_le_bytes().to_vec();
    data.extend((-12_000_i16).to_le_bytes());
    data.push(0x85);
    let expected = [(-1.234567, "m"), (-1.2, "m/s"), (133.0, "bits")];
    assert_eq!(values(&dictionary, 17, 0x191, &data), expected.map(|(n, u)| (n, u.to_owned())));

    // 5 µm and 1 mm/s.
    let text = ENCODER.replace("DefaultValue=1000\n", "DefaultValue=5000\n");
    let dictionary = with(&text, "DefaultValue=10\n", "DefaultValue=100\n");
    let expected = [(-6.172835, "m"), (-12.0, "m/s"), (133.0, "bits")];
    assert_eq!(values(&dictionary, 17, 0x191, &data), expected.map(|(n, u)| (n, u.to_owned())));
}

#[test]
fn a_valve_tells_shares_of_full_scale_and_bar() {
    let dictionary = read(VALVE);
    let words = |words: [i16; 3]| words.map(i16::to_le_bytes).concat();
    let command = values(&dictionary, 33, 0x521, &words([7, -8192, 2100]));
    let own = |values: [(f64, &str); 3]| values.map(|(n, unit)| (n, unit.to_owned()));
    assert_eq!(command, own([(7.0, "bits"), (-0.5, "of full scale"), (210.0, "bar")]));
    let actual = values(&dictionary, 33, 0x1A1, &words([-1, 16384, -10]));
    assert_eq!(actual, own([(65535.0, "bits"), (1.0, "of full scale"), (-1.0, "bar")]));
}

#[test]
fn a_set_point_has_the_unit_of_the_actual_value_if_it_has_none_of_its_own() {
    let unit = |index: &str, code: &str| {
        let start = VALVE.find(&format!("[{index}sub2]")).unwrap();
        let (before, after) = VALVE.split_at(start);
        before.to_owned() + &after.replacen("DefaultValue=0x00", &format!("DefaultValue={code}"), 1)
    };
    let scale_of = |text: &str| scale(&read(text), 33, 0x6300);
    assert_eq!(scale_of(&unit("6300", "0x4E")), Ok(Scale { factor: 1.0, unit: "bar" }));
    let without = |text: &str| text.replace("[6300sub2]", "[6F00sub2]");
    let taken = scale_of(&without(&unit("6301", "0x22")));
    assert_eq!(taken, Ok(Scale { factor: 1e-5, unit: "bar" }));
    let error = scale_of(&unit("6300", "0x99")).unwrap_err().to_string();
    assert!(error.starts_with("its unit, object 0x6300:02, is 0x99; known are"), "{error}");
}

#[test]
fn a_step_that_is_not_in_the_file_is_asked_for() {
    let text = ENCODER.replace("DefaultValue=1000\n", "");
    let error = scale(&read(&text), 17, 0x6020).unwrap_err().to_string();
    assert!(error.starts_with("its scale, object 0x6005:01, has no value above 0"), "{error}");
    let speed = scale(&read(&text), 17, 0x6030);
    assert_eq!(speed, Ok(Scale { factor: 1e-4, unit: "m/s" }));
    // A measuring step of the maker's stands in for it.
    let (before, after) = ENCODER.split_once("[6005sub1]").unwrap();
    let text = format!("{before}[6005sub1]{}", after.replacen("DefaultValue=1000\n", "", 1));
    assert_eq!(scale(&read(&text), 17, 0x6020), Ok(Scale { factor: 1e-6, unit: "m" }));
}

#[test]
fn an_unknown_profile_has_no_scale() {
    let dictionary = with(ENCODER, "DefaultValue=0x000A0196", "DefaultValue=0");
    assert_eq!(scale(&dictionary, 17, 0x6020), Ok(Scale { factor: 1.0, unit: "counts" }));
}

#[test]
fn a_pdo_that_cannot_be_used_says_why() {
    for (from, to, reason) in [
        ("DefaultValue=$NODEID+0x180", "DefaultValue=0x80000191", "TPDO1: it is off: bit 31"),
        (
            "DefaultValue=$NODEID+0x180",
            "DefaultValue=0x891",
            "TPDO1: its COB-ID, 0x1800:01, is 0x891",
        ),
        (
            "DefaultValue=0x60200120",
            "DefaultValue=0x60200110",
            "TPDO1: 0x1A00:01 maps 16 bits of 0x6020:01, which is INTEGER32",
        ),
        (
            "DefaultValue=0x60200120",
            "DefaultValue=0x60210120",
            "TPDO1: 0x1A00:01: there is no object 0x6021 in the EDS; nearest: 0x6020",
        ),
        (
            "DefaultValue=0x64000108",
            "DefaultValue=0x64000120",
            "TPDO1: 0x1A00:03, 0x64000120, ends at bit 80, expected 1 to 64",
        ),
        ("DefaultValue=0x64000108", "DefaultValue=", "TPDO1: 0x1A00:03 has no value in the file"),
        (
            "DefaultValue=3\n",
            "DefaultValue=65\n",
            "TPDO1: 0x1A00:00 says that 65 objects are mapped",
        ),
        ("DefaultValue=3\n", "\n", "TPDO1: how many objects are mapped, 0x1A00:00, has no value"),
    ] {
        let pdos = Pdos::of(&with(ENCODER, from, to), 17);
        assert_eq!(pdos.sound.len(), 0, "{to}");
        let [flaw] = &pdos.refused[..] else { panic!("{to}: {:?}", pdos.refused) };
        assert!(flaw.to_string().starts_with(reason), "{flaw}");
    }
}

#[test]
fn what_is_not_said_is_as_the_standard_has_it() {
    let dictionary = with(ENCODER, "DefaultValue=$NODEID+0x180", "DefaultValue=");
    let pdo = &Pdos::of(&dictionary, 17).sound[0];
    assert_eq!((pdo.direction, pdo.id), (Direction::Sent, Id::standard(0x191).unwrap()));
    assert_eq!((pdo.transmission_type, pdo.event_timer_ms), (Some(254), Some(1)));
    // A DCF says what the device is set to.
    let dictionary = with(ENCODER, "DefaultValue=254", "DefaultValue=254\nParameterValue=1");
    assert_eq!(Pdos::of(&dictionary, 17).sound[0].transmission_type, Some(1));
}
