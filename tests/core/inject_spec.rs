//! The words for faults, in arguments and tables.

use tertius::config;
use tertius::dbc::{Database, text};
use tertius::inject::{
    Code, Fault, PlaceError, SENSORS, Shape, SpecError, Wanted, Window, grammar, place, table,
};
use tertius::time::Span;

fn parse(text: &str) -> Fault {
    Fault::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn shape(text: &str) -> Shape {
    match parse(text).wanted {
        Wanted::Shape(shape) => shape,
        other => panic!("{text}: {other:?}"),
    }
}

#[test]
fn every_kind_is_read_with_its_keys_and_defaults() {
    let fault = parse("step, cylinder=3 ,sensor=C2,at=60,size=0.00175,until=65");
    let window = Window { from: Span::from_seconds(60.0), until: Some(Span::from_seconds(65.0)) };
    let wanted = Wanted::Shape(Shape::Step { size: 0.00175 });
    assert_eq!(fault, Fault { cylinder: 3, sensor: "c2", wanted, window });
    assert_eq!(parse("freeze,cylinder=1").window, Window { from: Span::ZERO, until: None });
    assert_eq!(parse("freeze,cylinder=1").sensor, "c1");
    for (text, expected) in [
        ("noise,cylinder=1,size=-1e-3", Shape::Noise { size: -1e-3 }),
        ("incipient,cylinder=1,size=0.07", Shape::Incipient { size: 0.07, b: 1.0 }),
        ("incipient,cylinder=1,size=0.07,b=0.5", Shape::Incipient { size: 0.07, b: 0.5 }),
        ("drift,cylinder=1,rate=1e-5", Shape::Drift { rate: 1e-5 }),
        ("scale,cylinder=1,gain=0.01", Shape::Scale { gain: 0.01 }),
        ("stuck,cylinder=1", Shape::Freeze),
        ("spike,cylinder=1,size=1,probability=0.1", Shape::Spike { size: 1.0, probability: 0.1 }),
        ("stale,cylinder=1", Shape::Stale),
        ("loss,cylinder=1", Shape::Loss { probability: 1.0 }),
        ("LOSS,cylinder=1,probability=0.5", Shape::Loss { probability: 0.5 }),
    ] {
        assert_eq!(shape(text), expected, "{text}");
    }
    let code = |text| parse(text).wanted;
    assert_eq!(code("broken-wire,cylinder=1"), Wanted::BrokenWire(None));
    assert_eq!(code("broken_wire,cylinder=1,code=-5"), Wanted::BrokenWire(Some(-5)));
    assert_eq!(code("out_of_range,cylinder=1"), Wanted::OutOfRange(None));
    let value = Wanted::OutOfRange(Some(Code::Physical(1.6)));
    assert_eq!(code("out_of_range,cylinder=1,value=1.6"), value);
    let raw = Wanted::OutOfRange(Some(Code::Raw(0)));
    assert_eq!(code("out_of_range,cylinder=1,raw=0"), raw);
    assert_eq!(grammar().lines().count(), 11, "a line for each kind");
}

#[test]
fn what_is_wrong_is_told_with_what_was_expected() {
    let error = |text: &str| Fault::parse(text).unwrap_err().to_string();
    for (text, expected) in [
        ("", "no fault is called \"\"; there are step, noise"),
        ("incipent,cylinder=1", "(nearest: incipient)"),
        ("step,cylinder=1,size", "\"size\" is not of the form key=value"),
        (
            "step,cylinder=1,untill=3",
            "step has no key \"untill\" (nearest: until); it has cylinder",
        ),
        ("freeze,cylinder=1,size=1", "freeze has no key \"size\""),
        ("step,cylinder=1,size=1,size=2", "size is given twice"),
        ("step,cylinder=1", "step needs size (m)"),
        ("step,size=1", "step needs cylinder (from 1)"),
        ("step,cylinder=0,size=1", "cylinder is \"0\", expected the number of a cylinder"),
        ("step,cylinder=1,size=3mm", "size is \"3mm\", expected a number without unit"),
        ("step,cylinder=1,size=NaN", "size is \"NaN\""),
        ("step,cylinder=1,size=inf", "size is \"inf\""),
        ("incipient,cylinder=1,size=1,b=0", "b is \"0\", expected a number above 0"),
        ("loss,cylinder=1,probability=1.1", "expected a number above 0 and at most 1"),
        ("loss,cylinder=1,probability=NaN", "expected a number above 0 and at most 1"),
        ("broken_wire,cylinder=1,code=1.5", "code is \"1.5\", expected a whole number"),
        ("out_of_range,cylinder=1,raw=1,value=2", "value and raw are both given"),
        ("freeze,cylinder=1,sensor=c3", "there is no sensor \"c3\" (nearest: c"),
        ("freeze,cylinder=1,at=-1", "at is \"-1\", expected seconds since the first frame"),
        ("freeze,cylinder=1,at=5,until=5", "until (5 s) is not after at (5 s)"),
    ] {
        let found = error(text);
        assert!(found.contains(expected), "{text}: {found}");
    }
    assert!(matches!(Fault::parse("x"), Err(SpecError::Kind { nearest: None, .. })));
}

#[test]
fn the_tables_of_the_recordings_are_read() {
    let truth = include_str!("../recordings/e-type-faults.truth.csv");
    let faults = table::parse(truth).unwrap();
    assert_eq!(faults.len(), 14);
    let named = |text| parse(text);
    assert_eq!(faults[3], (5, named("step,cylinder=2,at=105,size=-0.00175,until=110")));
    assert_eq!(faults[7], (9, named("noise,cylinder=4,at=170,size=0.000868,until=180")));
    assert_eq!(faults[9], (11, named("incipient,cylinder=5,at=220,size=0.07,b=1,until=224")));
    assert_eq!(faults[12], (14, named("freeze,cylinder=6,sensor=c2,at=430,until=435")));
    assert_eq!(faults[13], (15, named("scale,cylinder=1,at=445,gain=0.01,until=470")));
    let error = |rows: &str| {
        let text = format!("cylinder,sensor,kind,t0,magnitude,parameter,t1\r\n# so\r\n\r\n{rows}");
        table::parse(&text).unwrap_err().to_string()
    };
    for (rows, expected) in [
        ("1,C1,step,1,2,0", "line 4: 6 columns, expected 7"),
        ("1,C1,step,1,,,", "line 4: column magnitude or parameter: step needs size (m)"),
        ("1,C1,drift,1,1,0,\n1,C1,step,1,1,3,", "line 5: parameter is \"3\", but step has no such"),
        ("1,C1,broken_wire,1,5,,", "line 4: magnitude is \"5\", but broken_wire"),
        ("1,C1,steq,1,1,,", "line 4: no fault is called \"steq\" (nearest: step)"),
        ("1,C1,step,9,1,,8", "line 4: column t1: until (8 s) is not after"),
    ] {
        let found = error(rows);
        assert!(found.starts_with(expected), "{rows}: {found}");
    }
    let found = table::parse("").unwrap_err().to_string();
    assert!(found.contains("expected the header cylinder,sensor,kind"), "{found}");
}

const TOML: &str = include_str!("../recordings/e-type.toml");

fn placed(toml: &str, dbc: &str, spec: &str) -> Result<Shape, PlaceError> {
    let (settings, _) = config::parse("e.toml", toml).unwrap();
    let database = Database::parse(&text::from_bytes(dbc.as_bytes())).unwrap();
    place(&parse(spec), &settings, &database).map(|placed| placed.shape)
}

const DBC: &str = include_str!("../../dbc/e-type.dbc");

#[test]
fn codes_come_from_the_configuration() {
    let raw = |code| Ok(Shape::Constant(Code::Raw(code)));
    assert_eq!(placed(TOML, DBC, "broken_wire,cylinder=1"), raw(32767));
    let other = TOML.replace("broken_wire_codes = [32767]", "broken_wire_codes = [40000]");
    assert_eq!(placed(&other, DBC, "broken_wire,cylinder=1"), raw(40000));
    assert_eq!(placed(TOML, DBC, "out_of_range,cylinder=1"), raw(27649));
    assert_eq!(placed(TOML, DBC, "out_of_range,cylinder=1,raw=0"), raw(0));
    let unlimited = TOML.replace("valid_raw = [1, 27648]", "");
    let Ok(Shape::Constant(Code::Physical(value))) =
        placed(&unlimited, DBC, "out_of_range,cylinder=1")
    else {
        panic!("no value");
    };
    assert!((value - 1.8).abs() < 1e-3, "{value}: a tenth of the range above 1.5 m");
}

#[test]
fn every_sensor_is_a_key_of_the_configuration() {
    let (settings, _) = config::parse("e.toml", TOML).unwrap();
    let named: Vec<&str> = settings.signals.cylinder.named().map(|(key, _)| key).collect();
    assert_eq!(named, SENSORS);
    for sensor in SENSORS {
        let spec = format!("step,cylinder=6,sensor={sensor},size=1");
        assert!(placed(TOML, DBC, &spec).is_ok(), "{sensor}");
    }
}

#[test]
fn what_the_machine_does_not_have_is_refused() {
    let without = TOML.replace("c2_velocity = ", "# ");
    let error = placed(&without, DBC, "step,cylinder=1,sensor=c2_velocity,size=1").unwrap_err();
    assert!(error.to_string().contains("add signals.cylinder.c2_velocity"), "{error}");
    // 0x1A1, the valve of cylinder 1, is then the gateway's.
    let own = format!("{TOML}\n[gateway]\nnode = 33\n");
    let error = placed(&own, DBC, "step,cylinder=1,sensor=pressure_rod,size=1").unwrap_err();
    assert!(matches!(error, PlaceError::OwnFrame { .. }), "{error}");
    let error = placed(TOML, DBC, "out_of_range,cylinder=1,value=1.4").unwrap_err();
    assert!(matches!(error, PlaceError::WithinRange { .. }), "{error}");
    let full = TOML.replace("valid_raw = [1, 27648]", "valid_raw = [0, 65535]");
    let full = full.replace("stroke = [-1.5, 1.5]", "stroke = [-9.0, 9.0]");
    let error = placed(&full, DBC, "out_of_range,cylinder=1").unwrap_err();
    assert!(matches!(error, PlaceError::WithinRange { .. }), "no room: {error}");
}
