//! A replay depends on the frames alone: not on how they are kept, split, written or read.

use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;
use tertius_testing::oracle;
use tertius_testing::support::{
    E_TYPE, Run, Scratch, Seeded, between, recorded, recording, replay, tertius, tertius_in_pieces,
};

/// Everything that a replay writes.
#[derive(Debug, PartialEq, Eq)]
struct Outcome {
    lines: String,
    sent: String,
    residuals: String,
}

impl Outcome {
    /// Says which part differs without showing megabytes of it.
    #[track_caller]
    fn assert_same(&self, other: &Self, what: &str) {
        let parts = [
            ("lines of JSON", &self.lines, &other.lines),
            ("frames sent", &self.sent, &other.sent),
            ("residuals", &self.residuals, &other.residuals),
        ];
        for (part, ours, theirs) in parts {
            let differs = ours.lines().zip(theirs.lines()).find(|(ours, theirs)| ours != theirs);
            assert!(ours == theirs, "{part} differ for {what}: {differs:?}");
        }
    }
}

/// A scratch directory and the options that write everything into it.
struct Bench {
    scratch: Scratch,
    sent: String,
    residuals: String,
}

impl Bench {
    fn new() -> Self {
        let scratch = Scratch::new();
        let (sent, residuals) = (scratch.path("sent.log"), scratch.path("residuals.csv"));
        Self { scratch, sent, residuals }
    }

    fn options(&self) -> [&str; 5] {
        ["--force", "--warnings", &self.sent, "--residuals", &self.residuals]
    }

    fn outcome(&self, run: Run) -> Outcome {
        Outcome {
            lines: run.ok().stdout,
            sent: self.scratch.read("sent.log"),
            residuals: self.scratch.read("residuals.csv"),
        }
    }

    fn of_files(&self, logs: &[&str]) -> Outcome {
        self.outcome(replay(logs, E_TYPE, &self.options()))
    }

    fn call<'a>(&'a self, log: &'a str) -> Vec<&'a str> {
        let mut call = vec!["replay", log, "--config", E_TYPE, "--format", "jsonl"];
        call.extend(self.options());
        call
    }
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).and_then(|()| encoder.finish()).expect("memory takes all")
}

fn zstd(bytes: &[u8]) -> Vec<u8> {
    zstd::encode_all(bytes, 1).expect("memory takes all")
}

#[test]
fn twice_compressed_and_piped() {
    let bench = Bench::new();
    let log = recorded("e-type-faults.log.zst");
    let kept = bench.of_files(&[&recording("e-type-faults.log.zst")]);
    assert!(kept.lines.lines().count() > 80 && kept.sent.len() > 200_000);

    let plain = bench.scratch.write("plain", &log);
    kept.assert_same(&bench.of_files(&[&plain]), "the plain file");
    kept.assert_same(&bench.of_files(&[&plain]), "the same once more");
    let packed = bench.scratch.write("packed", gzip(log.as_bytes()));
    kept.assert_same(&bench.of_files(&[&packed]), "gzip, whatever the file is called");
    let piped = tertius(&bench.call("-"), log.as_bytes());
    kept.assert_same(&bench.outcome(piped), "standard input");
    let piped = tertius(&bench.call("-"), &zstd(log.as_bytes()));
    kept.assert_same(&bench.outcome(piped), "zstd on standard input");
}

#[test]
fn read_in_turn_and_read_ahead() {
    let bench = Bench::new();
    let log = recording("e-type-faults.log.zst");
    let on = |threads| {
        let mut call = bench.call(&log);
        call.extend(["--threads", threads]);
        bench.outcome(tertius(&call, b""))
    };
    let one = on("1");
    assert!(one.lines.lines().count() > 80 && one.sent.len() > 200_000);
    one.assert_same(&on("2"), "two threads");
    one.assert_same(&on("64"), "more threads than there is work for");
    let estimates = |threads| {
        let table = bench.scratch.path(&format!("estimates-{threads}.csv"));
        let call =
            ["replay", &log, "--config", E_TYPE, "--threads", threads, "--estimates", &table];
        tertius(&call, b"").ok();
        bench.scratch.read(&format!("estimates-{threads}.csv"))
    };
    let one = estimates("1");
    assert!(one.lines().count() > 10_000 && one == estimates("2"), "the table of estimates");
    tertius(&["replay", &log, "--config", E_TYPE, "--threads", "0"], b"").failed(2, &["--threads"]);
}

/// Half a minute with faults, a change of a warning among them.
fn excerpt() -> String {
    let log = between(&recorded("e-type-faults.log.zst"), 160.0, 190.5);
    assert!(log.lines().count() > 33_000);
    log
}

/// How much is written next.
type Sizes = Box<dyn FnMut() -> usize + Send>;

#[test]
fn standard_input_in_any_pieces() {
    let bench = Bench::new();
    let log = excerpt();
    let whole = bench.of_files(&[&bench.scratch.write("whole.log", &log)]);
    let mut seeded = Seeded(7);
    let mut primes = [2, 3, 5, 7, 11, 41, 43, 4093, 65_537, 262_147].into_iter().cycle();
    let mut sizes: [(&str, Sizes); 3] = [
        ("single bytes", Box::new(|| 1)),
        ("primes", Box::new(move || primes.next().expect("they begin again"))),
        ("random sizes", Box::new(move || 1 << seeded.below(19))),
    ];
    for (what, size) in &mut sizes {
        let run = tertius_in_pieces(&bench.call("-"), log.as_bytes(), size);
        whole.assert_same(&bench.outcome(run), what);
    }
    let run = tertius_in_pieces(&bench.call("-"), &gzip(log.as_bytes()), &mut || 13);
    whole.assert_same(&bench.outcome(run), "gzip in pieces of 13 bytes");
}

#[test]
fn several_files_in_turn() {
    let bench = Bench::new();
    let log = excerpt();
    let whole = bench.of_files(&[&bench.scratch.write("whole.log", &log)]);
    let lines: Vec<&str> = log.split_inclusive('\n').collect();
    let mut seeded = Seeded(3);
    for turn in 0..3 {
        let mut cuts: Vec<usize> =
            (0..4).map(|_| seeded.below(lines.len() as u64) as usize).collect();
        cuts.sort_unstable();
        cuts.push(lines.len());
        let mut begin = 0;
        let mut files = Vec::new();
        for (index, end) in cuts.into_iter().enumerate() {
            let part = lines[begin..end].concat();
            let part = match (index + turn) % 3 {
                0 => part.into_bytes(),
                1 => gzip(part.as_bytes()),
                _ => zstd(part.as_bytes()),
            };
            files.push(bench.scratch.write(&format!("part{index}"), part));
            begin = end;
        }
        let files: Vec<&str> = files.iter().map(String::as_str).collect();
        whole.assert_same(&bench.of_files(&files), "five files");
    }
    let (first, second) = lines.split_at(lines.len() / 2);
    let file = bench.scratch.write("first", first.concat());
    let mut call = bench.call(&file);
    call.insert(2, "-");
    let run = tertius(&call, second.concat().as_bytes());
    whole.assert_same(&bench.outcome(run), "a file and then standard input");
}

/// Every time stamp that is told is found in the recording, digit by digit, whatever it is told in.
#[test]
fn time_stamps_are_digits_of_the_recording() {
    let bench = Bench::new();
    let micros = excerpt();
    // As a controller with a clock of its own stamps frames.
    let nanos: String = (0_u32..)
        .zip(micros.lines())
        .map(|(n, line)| format!("{}{:03}{}\n", &line[..18], n * 7 % 1000, &line[18..]))
        .collect();
    for log in [micros, nanos] {
        let file = bench.scratch.write("log", &log);
        let lines = bench.of_files(&[&file]).lines;
        let stamps = lines
            .split("\"timestamp\":")
            .skip(1)
            .map(|rest| rest.split(',').next().expect("split gives one at least"));
        let (mut count, first) = (0, log[1..].split(')').next().expect("a stamp"));
        for stamp in stamps {
            let found = log.contains(&format!("({stamp}"));
            assert!(found, "{stamp} is not in the recording, which begins at {first}");
            count += 1;
        }
        assert!(count > 5, "{count}");
        let page = tertius(&["replay", &file, "--config", E_TYPE], b"").ok().stdout;
        let words = page.split(|c: char| c.is_whitespace() || "()".contains(c));
        let told: Vec<&str> = words.filter(|word| word.starts_with("17000001")).collect();
        assert_eq!(told.len(), 2, "a stamp for each incident: {page}");
        told.iter().for_each(|stamp| assert!(log.contains(&format!("({stamp})")), "{stamp}"));
    }
}

/// python-can writes the trace, whose time stamps have microseconds as candump's have.
#[test]
fn a_peak_trace_replays_as_the_candump_that_it_was_made_from() {
    let bench = Bench::new();
    let log = bench.scratch.write("log", excerpt());
    let trace = bench.scratch.path("trace");
    oracle::run("trc.py", &["write", "2.1", &log, &trace], "");
    bench.of_files(&[&log]).assert_same(&bench.of_files(&[&trace]), "a PEAK trace");
}

/// A line of `candump -l` as the console form with absolute time stamps writes it (`candump -ta`).
fn console(line: &str) -> String {
    let mut fields = line.split(' ');
    let mut next = || fields.next().expect("a line of candump -l has three fields");
    let (stamp, interface, frame) = (next(), next(), next());
    let (id, data) = frame.split_once('#').expect("an identifier");
    let mut text = format!(" {stamp}  {interface}  {id}   [{}] ", data.len() / 2);
    for byte in 0..data.len() / 2 {
        text += &format!(" {}", &data[2 * byte..2 * byte + 2]);
    }
    text + "\n"
}

#[test]
fn other_line_ends_and_the_console_form() {
    let bench = Bench::new();
    let log = excerpt();
    let whole = bench.of_files(&[&bench.scratch.write("whole.log", &log)]);
    for (name, text) in [
        ("crlf", log.replace('\n', "\r\n")),
        ("no newline at the end", log.trim_end().to_owned()),
        ("console", log.lines().map(console).collect()),
        ("console with crlf", log.lines().map(console).collect::<String>().replace('\n', "\r\n")),
    ] {
        let file = bench.scratch.write("other.log", text);
        whole.assert_same(&bench.of_files(&[&file]), name);
    }
}

#[test]
fn the_page_for_people_is_the_same_but_for_the_name() {
    let scratch = Scratch::new();
    let log = excerpt();
    let files = [scratch.write("one", &log), scratch.write("two", zstd(log.as_bytes()))];
    let pages = files.map(|file| {
        let page = tertius(&["replay", &file, "--config", E_TYPE], b"").ok().stdout;
        page.replace(&file, "LOG")
    });
    assert_eq!(pages[0], pages[1]);
    assert!(pages[0].starts_with("LOG  with Ampelmann E-type, simulated (tests/recordings"));
    assert!(pages[0].contains("Cylinder 4, C1, yellow: noise"), "{}", pages[0]);
}
