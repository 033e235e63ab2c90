//! What an EDS may have wrong or leave out, and what is said about it.

use tertius::canopen::eds::{
    AccessType, Concern, DataType, LookupError, MAX_FINDINGS, MAX_NAME, MAX_SUB_OBJECTS, MAX_VALUE,
    ObjectDictionary, ObjectType, ParseError, Severity, Value,
};

/// An EDS with this text behind `[DeviceInfo]` in line 1.
fn read(text: &str) -> ObjectDictionary {
    ObjectDictionary::parse(&format!("[DeviceInfo]\n{text}")).unwrap()
}

/// Its single finding: severity, concern and text.
fn finding(text: &str) -> (Severity, Concern, String) {
    let dictionary = read(text);
    let [finding] = dictionary.findings() else { panic!("{:#?}", dictionary.findings()) };
    assert_eq!(dictionary.findings_left_out(), 0);
    assert_eq!(dictionary.refused().count(), usize::from(finding.severity == Severity::Error));
    (finding.severity, finding.concern, finding.to_string())
}

/// An object from line 2 on, with these further lines.
fn object(more: &str) -> String {
    format!("[6004]\nParameterName=Position\n{more}")
}

const WHOLE: &str = "ObjectType=7\nDataType=7\nAccessType=ro\n";

#[test]
fn letter_case_comments_and_octal_numbers_do_not_matter() {
    let dictionary = read(
        "[6004SUB00] # repeated\nparametername=Number ; of all\nDATATYPE=05 # UNSIGNED8\n\
         accesstype=Rw # or ro\nDefaultvalue=017\npdomapping=01\n[6004]\nPARAMETERNAME=A # b\nObjectType=0x08 # ARRAY",
    );
    assert_eq!(dictionary.findings(), []);
    let object = dictionary.object(0x6004).unwrap();
    assert_eq!((object.name.as_str(), object.object_type), ("A # b", ObjectType::Array));
    let variable = dictionary.variable(0x6004, 0).unwrap();
    assert_eq!((variable.name.as_str(), variable.data_type), ("Number", DataType::Unsigned(8)));
    assert_eq!((variable.access, variable.pdo_mapping), (AccessType::ReadWrite, true));
    assert_eq!(variable.default, Some(Value::Whole { number: 15, plus_node_id: false }));
}

#[test]
fn a_variable_without_a_type_is_refused_and_the_others_are_not() {
    let (severity, concern, text) = finding(&object("ObjectType=7\nAccessType=ro"));
    assert_eq!((severity, concern), (Severity::Error, Concern::Missing));
    assert!(text.starts_with("line 2: object 0x6004:00: it has no DataType; expected"), "{text}");
    let text = object("DataType=x\nAccessType=ro\n[6005]\nParameterName=b\n") + WHOLE;
    let dictionary = read(&text);
    assert!(dictionary.variable(0x6005, 0).is_ok());
    let error = dictionary.variable(0x6004, 0).unwrap_err().to_string();
    let expected = "object 0x6004:00 cannot be used: line 4: object 0x6004:00: DataType is \"x\"; \
                    expected the number of a data type, such as 0x0007 for UNSIGNED32";
    assert_eq!(error, expected);
    let (severity, concern, text) = finding(&object("ObjectType=5"));
    assert_eq!((severity, concern), (Severity::Error, Concern::Type));
    assert!(text.starts_with("line 4: object 0x6004: ObjectType is \"5\"; expected 0x2"), "{text}");
}

#[test]
fn oddities_are_told_and_what_can_be_used_is() {
    for (more, concern, start) in [
        ("DataType=7", Concern::Missing, "line 2: object 0x6004:00: it has no AccessType"),
        ("DataType=7\nAccessType=r", Concern::Access, "line 5: object 0x6004:00: AccessType is"),
        (
            "DataType=5\nAccessType=ro\nDefaultValue=256",
            Concern::Number,
            "line 6: object 0x6004:00: DefaultValue of UNSIGNED8 is \"256\"; the number does not fit",
        ),
        (
            "DataType=7\nAccessType=ro\nPDOMapping=yes",
            Concern::Number,
            "line 6: object 0x6004:00: PDOMapping is \"yes\"; expected 0 or 1",
        ),
        ("DataType=7\nAccessType=ro\nx", Concern::Line, "line 6: found \"x\"; a line is"),
        (
            "DataType=7\nAccessType=ro\naccesstype=rw",
            Concern::Duplicate,
            "line 6: [6004] has accesstype twice; the first one counts",
        ),
        (
            "DataType=7\nAccessType=ro\n[6004sub1]\nParameterName=b\nDataType=7\nAccessType=ro",
            Concern::Type,
            "line 2: object 0x6004: it is a single variable by its ObjectType, and has sub-objects; \
             its",
        ),
        (
            "DataType=7\nAccessType=ro\n[6004sub100]",
            Concern::Section,
            "line 6: found [6004sub100]; a sub-index has one or two",
        ),
        (
            "DataType=7\nAccessType=ro\n[OptionalObjects]\nSupportedObjects=2\n1=0x6004\n2=0x6005",
            Concern::Count,
            "line 9: [OptionalObjects] lists \"0x6005\"; expected the index of an object",
        ),
    ] {
        let text = object(more);
        let (severity, found, message) = finding(&text);
        assert_eq!((severity, found), (Severity::Warning, concern), "{more}");
        assert!(message.starts_with(start), "{message}");
        let variable = read(&text);
        let variable = variable.variable(0x6004, 0).unwrap();
        assert_eq!((variable.access, variable.default.as_ref()), (AccessType::ReadOnly, None));
    }
}

#[test]
fn what_has_two_sections_is_refused() {
    let twice = object(WHOLE) + &object(WHOLE);
    let (severity, concern, text) = finding(&twice);
    assert_eq!((severity, concern), (Severity::Error, Concern::Duplicate));
    assert!(text.starts_with("line 7: object 0x6004: [6004] stands in line 2, too"), "{text}");
    assert!(matches!(read(&twice).variable(0x6004, 0), Err(LookupError::Refused { .. })));
    let sub = format!("ParameterName=b\n{WHOLE}");
    let text =
        object(&format!("ObjectType=9\n[6004sub1]\n{sub}[6004sub01]\n{sub}[6004sub2]\n{sub}"));
    let dictionary = read(&text);
    assert!(matches!(dictionary.variable(0x6004, 1), Err(LookupError::Refused { .. })));
    assert!(dictionary.variable(0x6004, 2).is_ok());
}

#[test]
fn sub_objects_alone_are_a_record() {
    let text = format!("[1018sub1]\nParameterName=Vendor-ID\n{WHOLE}");
    let (severity, concern, message) = finding(&text);
    assert_eq!((severity, concern), (Severity::Warning, Concern::Section));
    assert!(message.starts_with("line 2: object 0x1018: there is no section [1018]"), "{message}");
    assert!(read(&text).variable(0x1018, 1).is_ok());
}

#[test]
fn what_is_not_there_is_told_with_what_is() {
    let sub = |sub: u32| format!("[6020sub{sub}]\nParameterName=b\n{WHOLE}");
    let text = format!("[6020]\nParameterName=a\nObjectType=8\n{}{}", sub(0), sub(1));
    let dictionary = read(&(object(WHOLE) + &text));
    let told = |index, sub| dictionary.variable(index, sub).unwrap_err().to_string();
    assert_eq!(told(0x6020, 2), "object 0x6020 has no sub-index 02; it has 00, 01");
    assert_eq!(told(0x6030, 1), "there is no object 0x6030 in the EDS; nearest: 0x6020, 0x6004");
}

#[test]
fn a_compact_list_has_names_values_and_denotations_of_its_own() {
    let text = "[2000]\nParameterName=Channel\nObjectType=8\nDataType=3\nAccessType=rw\n\
        DefaultValue=7\nPDOMapping=1\nCompactSubObj=3\n[2000Name]\nNrOfEntries=1\n2=Rod\n\
        [2000Value]\nNrOfEntries=1\n3=-5\n[2000Denotation]\n1=Bottom\n4=Nothing\n";
    let dictionary = read(text);
    assert_eq!(dictionary.findings(), []);
    let variables: Vec<_> = (1..=3).map(|sub| dictionary.variable(0x2000, sub).unwrap()).collect();
    assert_eq!(
        variables.iter().map(|it| it.name.as_str()).collect::<Vec<_>>(),
        ["Channel1", "Rod", "Channel3"]
    );
    let configured = variables.iter().map(|it| it.configured().unwrap().whole(None).unwrap());
    assert_eq!(configured.collect::<Vec<_>>(), [7, 7, -5]);
    assert_eq!(variables[0].denotation.as_deref(), Some("Bottom"));
    assert!(variables.iter().all(|it| it.pdo_mapping && it.data_type == DataType::Integer(16)));
    let number = dictionary.variable(0x2000, 0).unwrap().configured().cloned();
    assert_eq!(number.and_then(|it| it.whole(None)), Some(3));
    assert!(dictionary.variable(0x2000, 4).is_err());
}

#[test]
fn a_makers_own_type_is_what_it_stands_for() {
    let definition = "[A0]\nParameterName=Range\nObjectType=9\n[A0sub1]\nParameterName=Type\n\
                      DefaultValue=0x3\n";
    let dictionary = read(&(definition.to_owned() + &object("DataType=0xA0\nAccessType=ro")));
    assert_eq!(dictionary.variable(0x6004, 0).unwrap().data_type, DataType::Integer(16));
    assert_eq!(dictionary.objects().count(), 1);
    let dictionary = read(&object("DataType=0xA0\nAccessType=ro"));
    assert_eq!(dictionary.variable(0x6004, 0).unwrap().data_type, DataType::Other(0xA0));
}

#[test]
fn the_device_and_its_place_on_the_bus_are_read() {
    let text = "VendorName=Maker\nVendorNumber=0x29A\nNrOfTXPDO=4\nBaudRate_1000=1\nBaudRate_125=1\n\
        [DeviceComissioning]\nNodeID=0x11\nNodeName=C1\nBaudrate=250\n\
        [DummyUsage]\nDummy0005=1\nDummy0006=0\n";
    let dictionary = read(&(text.to_owned() + &object(WHOLE)));
    assert_eq!(dictionary.findings(), []);
    let device = &dictionary.device;
    assert_eq!((device.vendor_name.as_str(), device.vendor_number), ("Maker", Some(666)));
    assert_eq!((device.tx_pdos, device.bit_rates_kbit_s.as_slice()), (Some(4), &[125, 1000][..]));
    let place = dictionary.commissioning.as_ref().unwrap();
    assert_eq!((place.node_id, place.node_name.as_str()), (Some(17), "C1"));
    assert_eq!(place.bit_rate_kbit_s, Some(250));
    assert_eq!(dictionary.dummies, [DataType::Unsigned(8)]);
    let wrong = object(WHOLE) + "[DeviceCommissioning]\nNodeID=128\n";
    let (_, concern, text) = finding(&wrong);
    assert_eq!(concern, Concern::Number);
    assert!(text.starts_with("line 8: NodeID is 128; a node-ID is from 1 to 127"), "{text}");
    assert_eq!(read(&wrong).commissioning.unwrap().node_id, None);
}

#[test]
fn texts_without_objects_are_refused() {
    for text in ["", "x", "[DeviceInfo]\nVendorName=a\n", "[0005]\nParameterName=a\n", "[2000Name]"]
    {
        let error = ObjectDictionary::parse(text).unwrap_err();
        assert_eq!(error, ParseError::NoObjects, "{text}");
    }
}

#[test]
fn everything_has_a_bound() {
    let mut text = String::new();
    for index in 0..=MAX_SUB_OBJECTS / 255 {
        text += &format!(
            "[{:04X}]\nParameterName=a\nObjectType=8\nDataType=5\nAccessType=ro\nCompactSubObj=254\n",
            0x2000 + index
        );
    }
    let limit = MAX_SUB_OBJECTS;
    let line = 6 * (MAX_SUB_OBJECTS / 255) + 1;
    assert_eq!(
        ObjectDictionary::parse(&text).unwrap_err(),
        ParseError::TooMany { line, what: "sub-objects", limit }
    );

    let name = "é".repeat(MAX_NAME);
    let (_, concern, _) = finding(&format!("[6004]\nParameterName={name}\n{WHOLE}"));
    assert_eq!(concern, Concern::Length);
    let value = "a".repeat(MAX_VALUE + 1);
    let text = object(&format!("DataType=9\nAccessType=ro\nDefaultValue={value}"));
    assert_eq!(finding(&text).1, Concern::Number);
    assert_eq!(read(&text).variable(0x6004, 0).unwrap().default, None);

    let text = object(WHOLE) + &"x\n".repeat(MAX_FINDINGS + 5);
    let dictionary = read(&text);
    assert_eq!((dictionary.findings().len(), dictionary.findings_left_out()), (MAX_FINDINGS, 5));
}
