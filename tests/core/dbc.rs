//! What a DBC may have wrong, and what is said about it.

use tertius::dbc::{Concern, Database, LookupError, MAX_TEXT, ParseError, Severity};
use tertius::decode::{Decoded, Inserted, Raw};
use tertius::frame::{Frame, Id, Kind};
use tertius::time::Timestamp;

/// A DBC with a message 1 "M" of 8 bytes and these signal lines, then more statements.
fn dbc<S: AsRef<str>>(signals: &[S], more: &str) -> String {
    let mut text = "BO_ 1 M: 8 A\n".to_owned();
    for signal in signals {
        text += &format!(" SG_ {} A\n", signal.as_ref());
    }
    text + more
}

const PLAIN: &str = "S : 0|8@1+ (1,0) [0|0] \"\"";

/// The single finding of a DBC: severity, concern, line, signal, text.
fn finding(text: &str) -> (Severity, Concern, usize, Option<String>, String) {
    let database = Database::parse(text).unwrap();
    let [finding] = database.findings() else { panic!("{:#?}", database.findings()) };
    assert_eq!(database.findings_left_out(), 0);
    let message = finding.message.clone();
    if finding.severity == Severity::Error {
        let name = message.unwrap();
        assert!(matches!(database.message(&name), Err(LookupError::Refused { .. })));
    }
    let text = finding.to_string();
    (finding.severity, finding.concern, finding.line, finding.signal.clone(), text)
}

fn assert_error(text: &str, concern: Concern, line: usize, signal: Option<&str>, part: &str) {
    let found = finding(text);
    let expected = (Severity::Error, concern, line, signal.map(str::to_owned));
    assert_eq!((found.0, found.1, found.2, found.3), expected, "{}", found.4);
    assert!(found.4.contains(part), "{}", found.4);
}

fn assert_warning(text: &str, concern: Concern, line: usize, part: &str) {
    let found = finding(text);
    assert_eq!((found.0, found.1, found.2), (Severity::Warning, concern, line), "{}", found.4);
    assert!(found.4.contains(part), "{}", found.4);
}

fn frame(data: &[u8]) -> Frame {
    Frame::new(Timestamp::default(), Id::standard(1).unwrap(), Kind::Data, data)
}

#[test]
fn identifiers_that_the_parser_cuts_are_refused() {
    let error = |id: &str, part| {
        let text = format!("\nBO_ {id} M: 8 A\n SG_ {PLAIN} A\n");
        assert_error(&text, Concern::IdOutOfRange, 2, None, part);
    };
    error("70000", "standard identifier 70000 (0x11170) is above 0x7FF");
    error("2048", "add 2147483648");
    error("3758096384", "extended identifier 0x60000000");
    error("4294967296", "beyond 32 bits");
    error("99999999999999999999999", "beyond 32 bits");
    let typed = "BO_ 4294967296 M: 8 A\n SG_ S : 0|32@1+ (1,0) [0|0] \"\" A\n\
                 SIG_VALTYPE_ 4294967296 S : 1;\n";
    assert_error(typed, Concern::IdOutOfRange, 1, None, "beyond 32 bits");
    for (id, expected) in [
        ("2047", Id::standard(2047)),
        ("2147483648", Id::extended(0)),
        ("2684354559", Id::extended(Id::EXTENDED_MAX)),
    ] {
        let database = Database::parse(&format!("BO_ {id} M: 8 A\n")).unwrap();
        assert_eq!(Some(database.messages()[0].id), expected);
        assert_eq!(database.findings(), []);
    }
}

#[test]
fn statements_about_an_identifier_do_not_reach_the_one_it_is_cut_to() {
    // 65537 cut to 16 bits is 1.
    let text = dbc(
        &["S : 0|32@1+ (1,0) [0|0] \"\""],
        "SIG_VALTYPE_ 65537 S : 1;\nVAL_ 65537 S 0 \"off\" ;\n",
    );
    let database = Database::parse(&text).unwrap();
    let (_, signal) = database.signal("M.S").unwrap();
    assert!(!signal.plan.is_float() && signal.values.is_empty());
    let concerns: Vec<_> = database.findings().iter().map(|f| (f.concern, f.line)).collect();
    assert_eq!(concerns, [(Concern::Reference, 3), (Concern::Reference, 4)]);
}

#[test]
fn twins_are_both_refused_and_others_stay() {
    let text = "BO_ 1 A: 8 X\nBO_ 2 B: 8 X\nBO_ 1 C: 8 X\nBO_ 3 B: 8 X\nBO_ 2147483649 D: 8 X\n";
    let database = Database::parse(text).unwrap();
    let found: Vec<_> = database.findings().iter().map(|f| (f.line, f.concern)).collect();
    let (id, name) = (Concern::DuplicateId, Concern::DuplicateName);
    assert_eq!(found, [(1, id), (2, name), (3, id), (4, name)]);
    let names: Vec<_> = database.messages().iter().map(|message| &message.name).collect();
    assert_eq!(names, ["D"]);
    let reason = database.message("A").unwrap_err().to_string();
    assert!(reason.contains("line 1: message A: message C in line 3"), "{reason}");
    assert_eq!(database.refused().count(), 3);
    assert_error(&dbc(&[PLAIN, "S : 8|8@1+ (1,0) [0|0] \"\""], ""), name, 3, Some("S"), "second");
}

#[test]
fn signals_stay_in_their_message() {
    let error = |signal: &str, concern, part| {
        let text = dbc(&[PLAIN, &format!("T : {signal} (1,0) [0|0] \"\"")], "");
        assert_error(&text, concern, 3, Some("T"), part);
    };
    error("57|8@1+", Concern::OutsideMessage, "it ends in byte 9, counted from 1");
    error("56|8@0+", Concern::OutsideMessage, "it ends in byte 9");
    error("505|8@1+", Concern::OutsideMessage, "8 bits from bit 505 on");
    error("18446744073709551615|64@0+", Concern::OutsideMessage, "18446744073709551615");
    error("8|0@1+", Concern::SignalLength, "0 bits");
    error("8|65@1+", Concern::SignalLength, "65 bits");
    for fits in ["56|8@1+", "63|8@0+", "15|56@0-"] {
        let text = dbc(&[&format!("T : {fits} (1,0) [0|0] \"\"")], "");
        assert_eq!(Database::parse(&text).unwrap().findings(), [], "{fits}");
    }
    let fd = "BO_ 1 M: 64 A\n SG_ S : 448|64@1+ (1,0) [0|0] \"\" A\n";
    assert_eq!(Database::parse(fd).unwrap().findings(), []);
}

#[test]
fn message_lengths_are_those_of_frames() {
    assert_error("BO_ 1 M: 65 A\n", Concern::MessageLength, 1, None, "65 bytes");
    assert_warning("BO_ 1 M: 10 A\n", Concern::MessageLength, 1, "not a length of a CAN FD frame");
}

#[test]
fn overlaps_are_found_unless_multiplexing_excludes_them() {
    let at = |mark: &str, place: &str| format!("{mark} : {place} (1,0) [0|0] \"\"");
    let overlap = |signals: &[String], more: &str, other: &str| {
        let line = signals.len() + 1;
        assert_error(&dbc(signals, more), Concern::Overlap, line, Some("T"), other);
    };
    let none = |signals: &[String]| {
        assert_eq!(Database::parse(&dbc(signals, "")).unwrap().findings(), []);
    };
    let with_s = "shares bits with S";
    overlap(&[at("S", "0|9@1+"), at("T", "8|8@1+")], "", with_s);
    overlap(&[at("S", "0|16@1+"), at("T", "0|16@1+")], "", with_s);
    // Motorola 7|12 holds byte 0 and the upper half of byte 1.
    overlap(&[at("S", "7|12@0+"), at("T", "12|4@1+")], "", with_s);
    none(&[at("S", "7|12@0+"), at("T", "8|4@1+")]);
    let root = || at("R M", "0|8@1+");
    overlap(&[root(), at("S m1", "8|8@1+"), at("T m1", "8|8@1+")], "", with_s);
    overlap(&[root(), at("S", "8|8@1+"), at("T m1", "8|8@1+")], "", with_s);
    overlap(&[root(), at("T m1", "7|2@1+")], "", "shares bits with R");
    let apart = [root(), at("S m1", "8|8@1+"), at("T m2", "8|8@1+")];
    none(&apart);
    overlap(&apart, "SG_MUL_VAL_ 1 S R 1-2;\nSG_MUL_VAL_ 1 T R 2-3;\n", with_s);
}

#[test]
fn an_overlap_below_different_inner_multiplexors_is_found() {
    let signals = [
        "R M : 0|4@1+ (1,0) [0|0] \"\"",
        "A m0M : 4|4@1+ (1,0) [0|0] \"\"",
        "B m0M : 8|4@1+ (1,0) [0|0] \"\"",
        "S m0 : 16|8@1+ (1,0) [0|0] \"\"",
        "T m1 : 16|8@1+ (1,0) [0|0] \"\"",
    ];
    let ways = |b: &str| {
        format!(
            "SG_MUL_VAL_ 1 A R 0-0;\nSG_MUL_VAL_ 1 B R {b};\nSG_MUL_VAL_ 1 S A 0-0;\n\
             SG_MUL_VAL_ 1 T B 1-1;\n"
        )
    };
    let text = dbc(&signals, &ways("0-1"));
    assert_error(&text, Concern::Overlap, 6, Some("T"), "shares bits with S");
    // Selected by different values of the root, they never meet.
    let text = dbc(&signals, &ways("1-1"));
    let database = Database::parse(&text).unwrap();
    assert!(database.findings().iter().all(|finding| finding.severity == Severity::Warning));
    database.message("M").unwrap();
}

#[test]
fn scale_and_limits_must_make_sense() {
    let error = |scale: &str| {
        let text = dbc(&[&format!("S : 0|8@1+ {scale} [0|0] \"\"")], "");
        assert_error(&text, Concern::Scale, 2, Some("S"), "must not be zero");
    };
    error("(0,0)");
    error("(1e999,0)");
    error("(1,-1e999)");
    for range in ["[5|1]", "[0|1e999]"] {
        let text = dbc(&[&format!("S : 0|8@1+ (1,0) {range} \"\"")], "");
        assert_warning(&text, Concern::Limits, 2, "the range is ignored");
        assert_eq!(Database::parse(&text).unwrap().signal("M.S").unwrap().1.range, None);
    }
}

#[test]
fn floats_have_the_length_of_floats() {
    let text = |length, kind| {
        let signal = format!("S : 0|{length}@1- (1,0) [0|0] \"\"");
        dbc(&[&signal], &format!("SIG_VALTYPE_ 1 S : {kind};\n"))
    };
    let concern = Concern::SignalLength;
    assert_error(&text(16, 1), concern, 2, Some("S"), "a 32-bit float in 16 bits");
    assert_error(&text(64, 1), concern, 2, Some("S"), "a 32-bit float in 64 bits");
    assert_error(&text(32, 2), concern, 2, Some("S"), "a 64-bit float in 32 bits");
    let twice = text(32, 1) + "SIG_VALTYPE_ 1 S : 0;\n";
    assert_error(&twice, Concern::Reference, 4, Some("S"), "two types");
}

#[test]
fn multiplexors_are_there_and_fit() {
    let root = "R M : 0|4@1+ (1,0) [0|0] \"\"";
    let signal = "S m1 : 8|8@1+ (1,0) [0|0] \"\"";
    let error = |signals: &[&str], more: &str, line, part| {
        let text = dbc(signals, more);
        let found = finding(&text);
        assert_eq!((found.0, found.1, found.2), (Severity::Error, Concern::Multiplexing, line));
        assert!(found.4.contains(part), "{}", found.4);
    };
    error(&[signal], "", 2, "has no multiplexor");
    error(&["S m1M : 8|8@1+ (1,0) [0|0] \"\""], "", 2, "has no multiplexor");
    error(&["S m : 8|8@1+ (1,0) [0|0] \"\""], "", 2, "without a number");
    error(&[root, signal], "SG_MUL_VAL_ 1 S Q 1-1;\n", 4, "multiplexor Q that is not there");
    error(&[root, signal], "SG_MUL_VAL_ 1 S S 1-1;\n", 4, "S, which is not a multiplexor");
    error(&[root, signal], "SG_MUL_VAL_ 1 S R 3-1;\n", 4, "range 3-1");
    error(
        &[root, PLAIN.replace("0|8", "8|8").as_str()],
        "SG_MUL_VAL_ 1 S R 1-1;\n",
        4,
        "not multi",
    );
    let second = "Q M : 16|4@1+ (1,0) [0|0] \"\"";
    error(&[root, second, signal], "", 4, "several multiplexors");
    let float = "R M : 0|32@1+ (1,0) [0|0] \"\"";
    let other = "S m1 : 32|8@1+ (1,0) [0|0] \"\"";
    error(&[float, other], "SIG_VALTYPE_ 1 R : 1;\n", 2, "a multiplexor that is a float");
    let text = dbc(&[root, signal], "SG_MUL_VAL_ 1 S R 1-1;\nSG_MUL_VAL_ 1 S R 2-2;\n");
    let found = Database::parse(&text).unwrap();
    assert_eq!(found.findings()[0].concern, Concern::Multiplexing, "the mark is not in the range");
    assert_eq!((found.findings()[1].concern, found.findings()[1].line), (Concern::Reference, 5));
    assert_warning(
        &dbc(&[root, "S m16 : 8|8@1+ (1,0) [0|0] \"\""], ""),
        Concern::Multiplexing,
        3,
        "beyond its highest value 15",
    );
    assert_warning(
        &dbc(&["R M : 0|4@1+ (2,0) [0|0] \"\"", signal], ""),
        Concern::Multiplexing,
        2,
        "raw number",
    );
}

#[test]
fn circles_and_depths_of_multiplexors_end() {
    let chain = |depth: usize, circle: bool| {
        let mut text = "BO_ 1 M: 64 A\n SG_ R M : 0|4@1+ (1,0) [0|0] \"\" A\n".to_owned();
        let mut more = String::new();
        for i in 1..=depth {
            text += &format!(" SG_ R{i} m0M : {}|4@1+ (1,0) [0|0] \"\" A\n", 4 * i);
            let above = if i > 1 { format!("R{}", i - 1) } else { "R".to_owned() };
            let above = if circle && i == 1 { format!("R{depth}") } else { above };
            more += &format!("SG_MUL_VAL_ 1 R{i} {above} 0-0;\n");
        }
        Database::parse(&(text + &more)).unwrap()
    };
    assert_eq!(chain(8, false).findings(), []);
    assert!(chain(9, false).message("M").is_err());
    assert!(chain(100, false).message("M").is_err());
    assert!(chain(2, true).findings()[0].what.contains("circle"));
    assert!(chain(100, true).message("M").is_err());
}

#[test]
fn an_error_refuses_its_message_only() {
    let text = dbc(
        &["S : 60|8@1+ (1,0) [0|0] \"\""],
        "BO_ 2 N: 8 A\n SG_ T : 0|8@1+ (1,0) [0|0] \"\" A\n",
    );
    let database = Database::parse(&text).unwrap();
    let error = database.signal("M.S").unwrap_err().to_string();
    assert!(
        error.starts_with("message M cannot be used: line 2: message M, signal S: "),
        "{error}"
    );
    assert_eq!(database.signal("N.T").unwrap().1.name, "T");
}

#[test]
fn unknown_names_bring_their_neighbours() {
    let text =
        "BO_ 1 Cyl1_C1: 8 A\n SG_ Position : 0|8@1+ (1,0) [0|0] \"\" A\nBO_ 2 Cyl1_C2: 8 A\n";
    let database = Database::parse(text).unwrap();
    let message = |error: LookupError| error.to_string();
    assert_eq!(
        message(database.signal("Cyl1_C1.position").unwrap_err()),
        "message Cyl1_C1 has no signal \"position\"; nearest: Position"
    );
    let text = message(database.signal("cyl1_c2.Position").unwrap_err());
    assert_eq!(text, "there is no message \"cyl1_c2\" in the DBC; nearest: Cyl1_C2, Cyl1_C1");
    assert!(message(database.signal("Position").unwrap_err()).contains("MESSAGE.SIGNAL"));
    assert!(message(database.message("Xyz").unwrap_err()).ends_with("in the DBC"));
    database.message(&"C".repeat(100_000)).unwrap_err();
}

#[test]
fn line_ends_marks_and_bare_points_change_nothing() {
    let text = include_str!("../dbc/intel.dbc");
    let plain = Database::parse(text).unwrap();
    let comment = plain.message("Narrow").unwrap().comment.as_deref();
    assert_eq!(comment, Some("A message\nover two lines: BO_ 1 No: 8 X"));
    for other in [
        format!("\u{FEFF}{text}"),
        text.replace('\n', "\r\n"),
        text.replace('\n', "\r"),
        text.replace("SG_ Bit :", "SG_\tBit:"),
    ] {
        assert_eq!(Database::parse(&other).unwrap().messages(), plain.messages());
    }
    let database = Database::parse(&dbc(&["S : 0|8@1+ (1.,-2.) [0.|8.] \"1.\""], "")).unwrap();
    let (_, signal) = database.signal("M.S").unwrap();
    assert_eq!((signal.plan.factor(), signal.plan.offset()), (1.0, -2.0));
    assert_eq!((signal.range, signal.unit.as_str()), (Some([0.0, 8.0]), "1."));
}

#[test]
fn unknown_and_broken_by_the_way_are_noted() {
    let fine = dbc(&[PLAIN], "BA_DEF_ BO_ garbage here;\nSIG_GROUP_ 1 G 1 : S;\n");
    assert_eq!(Database::parse(&fine).unwrap().findings(), []);
    assert_warning(&dbc(&[PLAIN], "NEW_KEYWORD_ 1 x;\n"), Concern::Statement, 3, "NEW_KEYWORD_");
    let broken = dbc(&[PLAIN], "VAL_ 1 S 0.5 \"x\" ;\n");
    assert_warning(&broken, Concern::Statement, 3, "not understood from");
    assert_warning(&dbc(&[PLAIN], "VAL_ 1 T 0 \"x\" ;\n"), Concern::Reference, 3, "no such signal");
    let comment = dbc(&[PLAIN], "CM_ BU_ A \"x\";\nCM_ SG_ 2 S \"x\";\n");
    assert_warning(&comment, Concern::Reference, 4, "identifier 2");
    let table = dbc(&[PLAIN], "VAL_ EnvironmentVariable 0 \"x\" ;\n");
    assert_eq!(Database::parse(&table).unwrap().findings(), []);
}

#[test]
fn syntax_errors_say_where_and_what() {
    let error = |text: &str, line: usize, parts: &[&str]| {
        let error = Database::parse(text).unwrap_err();
        assert_eq!(error.line(), Some(line), "{error}");
        parts.iter().for_each(|part| assert!(error.to_string().contains(part), "{error}"));
    };
    let good = "S : 0|8@1+ (1,0) [0|0] \"\"";
    error(&dbc(&[good, "T : 8|8@2+ (1,0) [0|0] \"\""], ""), 3, &["\"2+ (1,0)", "start|length"]);
    error(&dbc(&[good, "T : 8@1+ (1,0) [0|0] \"\""], ""), 3, &["no length in bits"]);
    error(&dbc(&[good, "T : -8|8@1+ (1,0) [0|0] \"\""], ""), 3, &["-8 is not a number"]);
    error(
        &dbc(&[good, "T : 8|99999999999999999999@1+ (1,0) [0|0] \"\""], ""),
        3,
        &["not a number"],
    );
    error(
        &dbc(&[good, "T m99999999999999999999 : 8|8@1+ (1,0) [0|0] \"\""], ""),
        3,
        &["out of range"],
    );
    error("VERSION \"\"\nBO_ 1 M: A\n", 2, &["BO_ 1 M: A", "BO_ identifier Name"]);
    error("\n\nBO_ x M: 8 A\n", 3, &["\"x M: 8 A\""]);
    error(&dbc(&[PLAIN], "SIG_VALTYPE_ 1 S : 7;\n"), 3, &["SIG_VALTYPE_"]);
    error(&dbc(&[PLAIN], "SG_MUL_VAL_ 1 S R 1;\n"), 3, &["SG_MUL_VAL_"]);
    error("SG_ S : 0|8@1+ (1,0) [0|0] \"\" A\n", 1, &["outside of a message"]);
    error("BO_ 1 M: 8 A\nCM_ \"no end;\n", 2, &["never closed"]);
    error("hello\n", 1, &["\"hello\""]);
    error("B\0O\0_\0", 1, &["UTF-16"]);
    error("BO_ 1 M: 8 A BO_ 2 N: 8 A\n", 1, &["2 statements on one line"]);
    assert_eq!(Database::parse("VERSION \"\"\n").unwrap_err(), ParseError::NoMessages);
}

#[test]
fn everything_is_bounded() {
    let error = |text: String| Database::parse(&text).unwrap_err();
    assert_eq!(error(" ".repeat(MAX_TEXT + 1)), ParseError::TooLong { bytes: MAX_TEXT + 1 });
    let messages: String = (0..8193).map(|i| format!("BO_ {i} M{i}: 8 A\n")).collect();
    assert!(matches!(error(messages), ParseError::TooMany { what: "messages", .. }));
    let signals = |count: usize, length: u32| {
        let one = |i| format!(" SG_ S{i} : 0|{length}@1+ (1,0) [0|0] \"\" A\n");
        "BO_ 1 M: 8 A\n".to_owned() + &(0..count).map(one).collect::<String>()
    };
    assert!(matches!(error(signals(100_000, 8)), ParseError::TooMany { line: 1, .. }));
    // Each signal but the first overlaps: findings are bounded, too.
    let database = Database::parse(&signals(2000, 8)).unwrap();
    assert_eq!((database.findings().len(), database.findings_left_out()), (1000, 999));
    let line = format!("BO_ 1 M: 8 A\n SG_ {PLAIN} A{}\n", ",A".repeat(1 << 19));
    assert!(matches!(error(line), ParseError::TooMany { what: "bytes in one statement", .. }));
    // Statements about twins take no time for each twin.
    let twins = "BO_ 1 M: 8 A\n".repeat(8000) + &"VAL_ 1 S 0 \"x\" ;\n".repeat(50_000);
    let database = Database::parse(&twins).unwrap();
    assert!(database.messages().is_empty() && database.message("M").is_err());
    let long = format!("BO_ 1 {}: 8 A\n", "M".repeat(129));
    assert_eq!(error(long), ParseError::LongName { line: 1, bytes: 129 });
    let ranges: Vec<String> = (0..1025).map(|i| format!("{i}-{i}")).collect();
    let text = dbc(&["R M : 0|8@1+ (1,0) [0|0] \"\"", "S m0 : 8|8@1+ (1,0) [0|0] \"\""], "");
    let many = format!("{text}SG_MUL_VAL_ 1 S R {};\n", ranges.join(","));
    assert!(matches!(error(many), ParseError::TooMany { line: 4, .. }));
}

#[test]
fn entangled_multiplexing_is_refused_not_suffered() {
    let mut text = "BO_ 1 M: 8 A\n SG_ R M : 0|32@1+ (1,0) [0|0] \"\" A\n".to_owned();
    let mut more = String::new();
    for i in 0..1500_u32 {
        text += &format!(" SG_ S{i} m{i} : 32|8@1+ (1,0) [0|0] \"\" A\n");
        // Apart from each other, yet only at the very end.
        let ranges: Vec<String> =
            (0..600).map(|k| format!("{0}-{0}", k * 100_000 + 2 * i)).collect();
        more += &format!("SG_MUL_VAL_ 1 S{i} R {};\n", ranges.join(","));
    }
    assert!(matches!(Database::parse(&(text + &more)), Err(ParseError::TooComplex { .. })));
}

#[test]
fn short_frames_and_other_frames_carry_nothing() {
    let database = Database::parse(&dbc(
        &["A : 0|8@1+ (1,0) [0|0] \"\"", "B : 15|16@0+ (1,0) [0|0] \"\""],
        "",
    ))
    .unwrap();
    let plan = |name| &database.signal(name).unwrap().1.plan;
    let (a, b) = (plan("M.A"), plan("M.B"));
    assert_eq!((a.needed_length(), b.needed_length()), (1, 3));
    assert_eq!(a.decode(&frame(&[7, 1])).value().unwrap().raw, Raw::Unsigned(7));
    assert_eq!(b.decode(&frame(&[7, 1])), Decoded::Short);
    assert_eq!(b.decode(&frame(&[7, 1, 2])).value().unwrap().physical, 258.0);
    assert_eq!(a.decode(&frame(&[])), Decoded::Short);
    for kind in [Kind::Error, Kind::Remote { length: 8 }] {
        let other = Frame::new(Timestamp::default(), Id::standard(1).unwrap(), kind, &[0; 8]);
        assert_eq!(a.decode(&other), Decoded::Absent);
    }
}

#[test]
fn value_tables_are_found_by_number_and_name() {
    let text = dbc(
        &[PLAIN],
        "VAL_ 1 S 0 \"safe\" 3 \"Engaged\" 4 \"reserved\" 5 \"reserved\" -1 \"odd\" ;\n",
    );
    let database = Database::parse(&text).unwrap();
    let (_, signal) = database.signal("M.S").unwrap();
    assert_eq!(signal.value_name(3), Some("Engaged"));
    assert_eq!(signal.value_name(2), None);
    assert_eq!(signal.numbers_named("ENGAGED").collect::<Vec<_>>(), [3]);
    assert_eq!(signal.numbers_named("reserved").collect::<Vec<_>>(), [4, 5]);
    assert_eq!(signal.numbers_named("neutral").count(), 0);
}

#[test]
fn numbers_that_do_not_fit_are_reported() {
    let text = dbc(
        &[
            "U : 0|12@1+ (0.5,-10) [0|0] \"\"",
            "I : 15|12@0- (1,0) [0|0] \"\"",
            "F : 32|32@1- (1,0) [0|0] \"\"",
        ],
        "SIG_VALTYPE_ 1 F : 1;\n",
    )
    .replace("I : 15|12", "I : 23|12");
    let database = Database::parse(&text).unwrap();
    let plan = |name| &database.signal(name).unwrap().1.plan;
    let mut frame = frame(&[0; 8]);
    let mut put = |name, raw| {
        let outcome = plan(name).insert(raw, frame.buffer_mut());
        (outcome, plan(name).decode(&frame).value().unwrap().raw)
    };
    let clamped = |raw| (Inserted::Clamped(raw), raw);
    assert_eq!(put("M.U", Raw::Signed(4095)), (Inserted::Whole, Raw::Unsigned(4095)));
    assert_eq!(put("M.U", Raw::Signed(4096)), clamped(Raw::Unsigned(4095)));
    assert_eq!(put("M.U", Raw::Signed(-1)), clamped(Raw::Unsigned(0)));
    assert_eq!(put("M.I", Raw::Signed(-2048)), (Inserted::Whole, Raw::Signed(-2048)));
    assert_eq!(put("M.I", Raw::Signed(-2049)), clamped(Raw::Signed(-2048)));
    assert_eq!(put("M.I", Raw::Unsigned(u64::MAX)), clamped(Raw::Signed(2047)));
    assert_eq!(put("M.I", Raw::Float(2.5)), (Inserted::Whole, Raw::Signed(2)));
    assert_eq!(put("M.I", Raw::Float(f64::NAN)), (Inserted::NotANumber, Raw::Signed(2)));
    assert_eq!(put("M.I", Raw::Float(f64::NEG_INFINITY)), clamped(Raw::Signed(-2048)));
    assert_eq!(put("M.F", Raw::Float(1e300)), clamped(Raw::Float(f64::from(f32::MAX))));
    assert_eq!(put("M.F", Raw::Float(-0.5)), (Inserted::Whole, Raw::Float(-0.5)));
    let infinity = Raw::Float(f64::INFINITY);
    assert_eq!(put("M.F", infinity), (Inserted::Whole, infinity));
    let outcome = plan("M.U").insert_physical(3.3, frame.buffer_mut());
    assert_eq!(outcome, Inserted::Whole);
    assert_eq!(plan("M.U").decode(&frame).value().unwrap().physical, 3.5);
    assert_eq!(plan("M.U").raw_limits(), Some((0, 4095)));
    assert_eq!(plan("M.I").raw_limits(), Some((-2048, 2047)));
    assert_eq!(plan("M.F").raw_limits(), None);
}

/// Vector's tools keep names beyond 32 characters beside the short ones: a configuration may use either.
#[test]
fn messages_and_signals_go_by_their_long_names_and_their_short_ones() {
    let text = std::fs::read_to_string("tests/dbc/long_names.dbc").unwrap();
    let database = Database::parse(&text).unwrap();
    assert_eq!(database.findings(), []);
    let long = "Position_of_the_transducer_in_cylinder_1.Length_of_the_cylinder_as_it_is_changing";
    let (message, signal) = database.signal(long).unwrap();
    assert_eq!((message.id, message.length), (Id::standard(385).unwrap(), 8));
    assert_eq!(signal.unit, "mm/s");
    let short = "Position_of_the_transducer_in_cy.Length_of_the_cylinder_as_i_0001";
    assert_eq!(database.signal(short).unwrap(), (message, signal));
    // What other statements say by the short name is of the same signal.
    let length = message.signal("Length_of_the_cylinder_as_it_is_read_at_the_rod").unwrap();
    assert_eq!(length.comment.as_deref(), Some("As read."));
    let page = message.signal("Which_of_the_pages_is_meant_in_this_frame").unwrap();
    assert_eq!(page.value_name(1), Some("one"));
    let Err(LookupError::Signal { nearest, .. }) =
        database.signal("Position_of_the_transducer_in_cylinder_1.Length_of_the_cylinder_as_it_is")
    else {
        panic!("there is no such signal")
    };
    assert!(nearest.contains(&"Length_of_the_cylinder_as_it_is_changing".to_owned()));
}

#[test]
fn a_long_name_that_is_none_is_told_and_changes_nothing() {
    let name = |about: &str, name: &str| {
        let attribute = if about.starts_with("BO_") { "Message" } else { "Signal" };
        dbc(&[PLAIN], &format!("BA_ \"System{attribute}LongSymbol\" {about} \"{name}\";\n"))
    };
    let long = "L".repeat(129);
    for (about, given, part) in [
        ("SG_ 1 T", "Long", "no such signal"),
        ("SG_ 2 S", "Long", "no message with identifier 2"),
        ("BO_ 2", "Long", "no message with identifier 2"),
        ("SG_ 1", "Long", "not understood as a long name"),
        ("BO_ 1", &long, "a long name of 129 bytes, expected 1 to 128"),
        ("SG_ 1 S", "", "a long name of 0 bytes"),
    ] {
        let (severity, _, line, _, told) = finding(&name(about, given));
        assert_eq!((severity, line), (Severity::Warning, 3), "{about}: {told}");
        assert!(told.contains(part), "{about}: {told}");
        assert!(Database::parse(&name(about, given)).unwrap().signal("M.S").is_ok());
    }
    // Two of one name cannot be told apart.
    let two = dbc(
        &[PLAIN, "T : 8|8@1+ (1,0) [0|0] \"\""],
        "BA_ \"SystemSignalLongSymbol\" SG_ 1 S \"T\";\n",
    );
    assert_error(&two, Concern::DuplicateName, 3, Some("T"), "a second signal of this name");
}
