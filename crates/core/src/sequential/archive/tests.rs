use super::*;
use crate::sequential::history::MOST_DWELLS;

/// Six cylinders, most of which have dwelt, with readings of all digits.
fn archive() -> Archive {
    let mut archive = Archive::new("Ampelmann E-type", 6);
    for (n, history) in archive.cylinders.iter_mut().enumerate() {
        let corrected = (n != 4).then_some([1.002, -0.1 / (n + 3) as f64]);
        history.gauge(Gauging { count: 3.0 / 27_648.0, corrected });
        for k in 0..[0, 5, 5, 12, 1, 3][n] {
            let at = Timestamp::from_nanos(1_700_000_000_123_456_789 + k * 86_400_000_000_007);
            let wobble = 1e-5 * ((k * 37 % 11) as f64 / 11.0).sqrt();
            history.add(Dwell {
                at,
                readings: StopReadings::both([-1.4 + wobble, -1.39 - wobble / 3.0]),
            });
        }
    }
    archive
}

fn parse(text: &str) -> Result<Archive, Refusal> {
    Archive::parse(text.as_bytes(), "Ampelmann E-type", 6)
}

/// `text` with another line at its end, which fits its content.
fn sealed(text: &str) -> String {
    let body = text.rsplit_once("crc32").map_or(text, |(body, _)| body);
    format!("{body}{}\n", seal(body))
}

#[test]
fn what_was_kept_reads_back_the_same_to_the_bit() {
    let archive = archive();
    let text = archive.to_text();
    assert_eq!(parse(&text).as_ref(), Ok(&archive));
    assert_eq!(text.lines().count(), 3 + 6 + 26);
    let never = Archive::new("Ampelmann E-type", 6);
    assert_eq!(parse(&never.to_text()), Ok(never));
}

#[test]
fn the_longest_history_fits() {
    let mut archive = Archive::new("a machine", 6);
    for history in &mut archive.cylinders {
        let dwell = |k: i64| Dwell {
            at: Timestamp::from_nanos(i64::MIN + k),
            readings: StopReadings::both([-1.234_567_890_123_456_7e-300; 2]),
        };
        let dwells = (0..MOST_DWELLS as i64).map(dwell).collect();
        let gauging = Gauging { count: 1.0 / 3.0, corrected: Some([-1.0 / 3.0; 2]) };
        let restored = DwellHistory::restore(dwells, vec![u32::MAX; MOST_DWELLS], gauging);
        *history = restored.expect("a history");
    }
    let text = archive.to_text();
    assert!(text.len() < MAX_SIZE / 10, "{}", text.len());
    assert_eq!(Archive::parse(text.as_bytes(), "a machine", 6), Ok(archive));
    let long = text.repeat(20);
    assert_eq!(Archive::parse(long.as_bytes(), "a machine", 6), Err(Refusal::TooLong));
}

#[test]
fn no_part_of_it_is_taken_for_the_whole() {
    let text = archive().to_text();
    for length in 0..text.len() {
        let part = Archive::parse(&text.as_bytes()[..length], "Ampelmann E-type", 6);
        assert!(part.is_err(), "{length} bytes");
    }
    assert!(parse(&(text.clone() + "\n")).is_err());
    assert!(parse(&text.repeat(2)).is_err());
}

#[test]
fn no_flipped_bit_is_overlooked() {
    let text = archive().to_text().into_bytes();
    for place in 0..text.len() {
        for bit in 0..8 {
            let mut changed = text.clone();
            changed[place] ^= 1 << bit;
            let read = Archive::parse(&changed, "Ampelmann E-type", 6);
            assert!(read.is_err(), "bit {bit} of byte {place}");
        }
    }
}

#[test]
fn nonsense_is_refused_also_where_its_last_line_fits() {
    let text = archive().to_text();
    let first = text.lines().nth(4).expect("the first dwell of cylinder 2").to_owned();
    let second = text.lines().nth(5).expect("the second one").to_owned();
    assert!(first.starts_with("1700000000123456789 "), "{first}");
    let cases = [
        (first.clone(), first.replace("-1.39", "NaN"), "line 4 begins the dwells of cylinder 2"),
        (first.clone(), first.replace("-1.4", "inf"), "readings within 1000 m"),
        (first.clone(), first.replace("-1.4", "-1.4e5"), "readings within 1000 m"),
        (first.clone(), first.replace("17", "99"), "line 5 is \"99"),
        (first.clone(), first.replace("17", "18"), "each dwell later than the one before"),
        (first.clone(), format!("{first} 1"), "two readings in m, and of how many dwells"),
        (
            first.clone(),
            format!("{}0", &first[..first.len() - 1]),
            "the mean of one dwell at least",
        ),
        (second, first, "each dwell later than the one before"),
        ("dwells 5 count 0".into(), "dwells 5 count NaN 0".into(), "expected `cylinder 2 dwells D"),
        ("dwells 5 count 0.".into(), "dwells 5 count -0.".into(), "a count and a calibration"),
        ("dwells 5".into(), "dwells 4".into(), "the next cylinder, or the"),
        ("dwells 5".into(), "dwells 6".into(), "line 10 is \"cylinder 3"),
        ("dwells 5".into(), "dwells 513".into(), "D up to 512"),
        ("gain 1.002 offset -0.025".into(), "gain 1.002".into(), "gain A offset B"),
        ("dwells 5".into(), format!("dwells {}", u64::MAX), "D up to 512"),
        ("cylinder 2 ".into(), "cylinder 4 ".into(), "expected `cylinder 2 dwells"),
        ("machine ".into(), "machines ".into(), "`machine` and its name"),
        ("tertius dwells 2".into(), "tertius dwells 0".into(), "expected a version"),
        ("tertius dwells 2".into(), "{\"version\": 1}".into(), "`tertius dwells` and a version"),
    ];
    for (from, to, said) in cases {
        assert!(text.contains(&from), "{from}");
        let wrong = parse(&sealed(&text.replacen(&from, &to, 1))).expect_err(&to).to_string();
        assert!(wrong.contains(said), "{to}: {wrong}");
    }
}

#[test]
fn that_of_another_machine_or_program_is_told_by_name() {
    let text = archive().to_text();
    let foreign = Archive::parse(text.as_bytes(), "Ampelmann A-type", 6);
    let expected = "Ampelmann A-type".to_owned();
    assert_eq!(foreign, Err(Refusal::Foreign { found: "Ampelmann E-type".to_owned(), expected }));
    let fewer = Archive::parse(text.as_bytes(), "Ampelmann E-type", 5);
    assert_eq!(fewer, Err(Refusal::Cylinders { found: 6, expected: 5 }));
    // What a newer one is sealed with is not known.
    let newer = text.replacen("dwells 2", "dwells 4", 1);
    assert_eq!(parse(&newer), Err(Refusal::Newer(4)));
    assert_eq!(Archive::parse(&[0xFF, 0xFE, 0], "", 1), Err(Refusal::Binary));
}

/// A machine whose cylinders have two transducers each is kept as before, for programs that know no others.
#[test]
fn a_cylinder_with_one_transducer_has_no_reading_of_c2() {
    let mut archive = archive();
    assert!(archive.to_text().starts_with("tertius dwells 2\n"));
    let at = Timestamp::from_nanos(1_700_000_000_000_000_000);
    archive.cylinders[0].add(Dwell { at, readings: StopReadings::single(-1.41) });
    let text = archive.to_text();
    assert!(text.starts_with("tertius dwells 3\n"), "{text}");
    assert!(text.contains("\n1700000000000000000 -1.41 - 1\n"), "{text}");
    assert_eq!(parse(&text), Ok(archive));
    let older = parse(&sealed(&text.replacen("dwells 3", "dwells 2", 1)));
    let told = older.expect_err("that version has none").to_string();
    assert!(told.contains("a time in ns and two readings in m, and of how many dwells"), "{told}");
    let wrong = parse(&sealed(&text.replacen("-1.41 - 1", "-1.41 -- 1", 1)));
    let told = wrong.expect_err("no reading").to_string();
    assert!(told.contains("two readings in m, `-` for no C2, and of how many dwells"), "{told}");
}

#[test]
fn what_the_first_version_kept_is_read() {
    let dwells: Vec<String> = (0..300)
        .map(|k| format!("{} -1.4 -1.39\n", 1_700_000_000_000_000_000 + k * 86_400_000_000_000_i64))
        .collect();
    let text = format!(
        "tertius dwells 1\nmachine Ampelmann E-type\ncylinder 1 anchors 10 dwells 300\n{}\
         cylinder 2 anchors 0 dwells 0\n",
        dwells.concat()
    );
    let read = parse(&sealed(&(text.clone() + "crc32"))).expect("an archive");
    let history = &read.cylinders[0];
    assert!(history.dwells().len() <= MOST_DWELLS && history.dwells().len() > MOST_DWELLS / 2);
    assert_eq!(history.counts().iter().sum::<u32>(), 300, "they are put together");
    assert_eq!(history.gauging(), &Gauging::default());
    // It is kept as the newest version has it.
    assert_eq!(parse(&read.to_text()), Ok(read));
    let wrong = text.replacen("anchors 10", "anchors ten", 1);
    let told = parse(&sealed(&(wrong + "crc32"))).expect_err("no number").to_string();
    assert!(told.contains("`cylinder 1 anchors A dwells D`"), "{told}");
}
