//! The object dictionary over SDO, and the sheet of it.

use super::*;

#[test]
fn objects_have_what_the_node_knows() {
    let mut bench = Bench::new(&design());
    let text = |bench: &mut Bench, index, sub| {
        String::from_utf8(bench.read(index, sub).expect("it is there")).expect("ASCII")
    };
    assert_eq!(text(&mut bench, 0x1008, 0).len(), 58, "longer than the crate's 32 bytes");
    assert_eq!(text(&mut bench, 0x100A, 0), "1.2.3");
    let machine = "Ein Ger?t mit einem langen Namen, der nicht in ein Segment passt";
    assert_eq!(text(&mut bench, 0x2000, 1), machine);
    for (index, sub, value) in [
        (0x1000, 0, 0),
        (0x1014, 0, 0x0D1),
        (0x1017, 0, 1000),
        (0x1018, 0, 4),
        (0x1018, 3, 0x0001_0002),
        (0x1200, 1, 0x651),
        (0x1200, 2, 0x5D1),
        (0x1800, 0, 5),
        (0x1800, 1, 0x4000_01D1),
        (0x1801, 1, 0x4000_02D1),
        (0x1802, 1, 0xC000_03D1),
        (0x1A00, 0, 4),
        (0x1A00, 3, 0x2010_0318),
        (0x2000, 2, 6),
        (0x2000, 3, 20_000),
        (0x2002, 1, COUNTS.used),
        (0x2002, 13, 13),
        (0x2003, 1, 0x1234_5678),
        (0x2003, 3, 0b101),
        (0x2003, 4, 0x9ABC_DEF0),
    ] {
        assert_eq!(bench.number(index, sub), value, "{index:04X}:{sub}");
    }
    let real = |bench: &mut Bench, index, sub| {
        f32::from_le_bytes(bench.read(index, sub).expect("it is there").try_into().expect("four"))
    };
    assert_eq!(real(&mut bench, 0x2206, 2), 0.001);
    assert!(real(&mut bench, 0x2103, 3).is_nan(), "no residual yet");
    let count = (1..=13).map(|sub| bench.number(0x2002, sub)).collect::<Vec<_>>();
    assert_eq!(count[1..], [2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13]);
    let mut encoder = Encoder::new(81).expect("a node");
    let status = Status { active_warnings: 3, level: Level::Red, ..Status::default() };
    let frame = encoder.status(at(0), &status);
    assert!(bench.node.transmit(&frame));
    bench.status = Some(status);
    assert_eq!((bench.number(0x2001, 1), bench.number(0x2001, 3)), (3, 3));
    // The parts of the PDO are its bytes.
    let parts = (1..=4).flat_map(|sub| bench.read(0x2010, sub).expect("a part"));
    assert_eq!(parts.collect::<Vec<_>>(), frame.as_frame().data());
}

#[test]
fn what_cannot_be_had_is_refused_with_its_reason() {
    let mut bench = Bench::new(&design());
    assert_eq!(bench.read(0x3000, 0), Err(0x0602_0000));
    assert_eq!(bench.read(0x1018, 5), Err(0x0609_0011));
    assert_eq!(bench.write(0x3000, 0, &[0]), Err(0x0602_0000));
    assert_eq!(bench.write(0x1000, 1, &[0]), Err(0x0609_0011));
    for (index, sub) in [(0x1000, 0), (0x1800, 1), (0x1A00, 0), (0x2101, 1), (0x2201, 2)] {
        let before = bench.read(index, sub);
        assert_eq!(bench.write(index, sub, &[0; 4]), Err(0x0601_0002), "{index:04X}");
        assert_eq!(bench.read(index, sub), before);
    }
    assert_eq!(bench.write(0x1017, 0, &[1, 2, 3]), Err(0x0607_0012));
    // Segments out of turn, blocks, and requests that are too short.
    bench.request([0x40, 0x08, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(bench.request([0x70, 0, 0, 0, 0, 0, 0, 0])[4..], 0x0503_0000_u32.to_le_bytes());
    assert_eq!(bench.request([0x60, 0, 0, 0, 0, 0, 0, 0])[0], 0x80, "it was ended");
    assert_eq!(
        bench.request([0xA0, 0x08, 0x10, 0, 0, 0, 0, 0])[4..],
        0x0504_0001_u32.to_le_bytes()
    );
    assert_eq!(bench.send(0x651, &[0x40, 0, 0x10]), []);
    assert_eq!(bench.send(0x651, &[0x80, 0, 0x10, 0, 0, 0, 0, 0]), []);
    // There is one transfer at a time: who begins another one ends it.
    let text = [0x40, 0x08, 0x10, 0, 0, 0, 0, 0];
    for other in [[0x40, 0, 0x10, 0, 0, 0, 0, 0], [0x2B, 0x17, 0x10, 0, 0xE8, 3, 0, 0]] {
        assert_eq!(bench.request(text)[0], 0x41);
        assert_ne!(bench.request(other)[0], 0x80);
        assert_eq!(bench.request([0x60, 0, 0, 0, 0, 0, 0, 0])[0], 0x80, "{other:?}");
    }
    // In segments, too: two bytes.
    let [begun, done] = [
        bench.request([0x21, 0x17, 0x10, 0, 2, 0, 0, 0]),
        bench.request([0x0B, 0xF4, 0x01, 0, 0, 0, 0, 0]),
    ];
    assert_eq!((begun[0], done[0], bench.number(0x1017, 0)), (0x60, 0x20, 500));
}

#[test]
fn remote_and_extended_frames_are_nothing_to_it() {
    let mut bench = Bench::new(&design());
    let standard = |id| Id::standard(id).expect("11 bits");
    let remote = Kind::Remote { length: 1 };
    // No node guarding.
    assert_eq!(bench.take(&Frame::new(at(0), standard(0x751), remote, &[])), []);
    let extended = Id::extended(0x651).expect("29 bits");
    let request = [0x40, 0, 0x10, 0, 0, 0, 0, 0];
    assert_eq!(bench.take(&Frame::new(at(0), extended, Kind::Data, &request)), []);
    assert_eq!(
        bench.take(&Frame::new(at(0), standard(0x651), Kind::Fd { flags: 0 }, &request)),
        []
    );
    assert_eq!(bench.send(0x650, &request), []);
    assert_eq!(Node::inputs(81).map(Id::value).collect::<Vec<_>>(), [0x000, 0x651]);
}

#[test]
fn a_sheet_has_every_object_of_the_dictionary_and_says_the_same_each_time() {
    let design = design();
    let eds = sheet::write(&design, sheet::SheetKind::Device, "tertius.eds");
    assert_eq!(eds, sheet::write(&design, sheet::SheetKind::Device, "tertius.eds"));
    for object in objects::dictionary(&design).objects() {
        assert!(eds.contains(&format!("\r\n[{:04X}]\r\n", object.index)), "{:04X}", object.index);
        for entry in object.entries.iter().filter(|_| object.entries.len() > 1) {
            let section = format!("\r\n[{:04X}sub{:X}]\r\n", object.index, entry.sub);
            assert_eq!(eds.matches(&section).count(), 1, "{section}");
        }
    }
    assert!(eds.is_ascii() && eds.contains("DefaultValue=$NODEID+0x40000180\r\n"));
    let dcf = sheet::write(&design, sheet::SheetKind::Configured, "tertius.dcf");
    assert!(dcf.contains("[DeviceComissioning]\r\nNodeID=0x51\r\n") && !dcf.contains("$NODEID"));
    assert!(dcf.contains("DefaultValue=1000\r\nPDOMapping=0\r\nLowLimit=0\r\n"));
}
