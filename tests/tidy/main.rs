//! What the source has to keep to, and no compiler asks for: what is not named below has no clock, socket,
//! file, thread or global, so that a replay says what the gateway said; the rooms of a crate use each
//! other one way; and nothing is left half done. The core is without std, so that the compiler holds it
//! to the first; only functions and globals are left to ask for there.
//!
//! It looks at tokens, so that comments and texts may say what they like, and at code outside of
//! `#[cfg(test)]` only.

mod circles;
mod documents;

use circles::{Uses, described, uses_of_rooms};
use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Rooms that deal with the world. A room that is added here has a reason to: live frames, files of
/// the user's, a terminal. Everything else is pure.
const WORLDLY: [&str; 8] = [
    "crates/config/src/loader.rs",
    "crates/gateway/src/appliance/",
    "crates/gateway/src/bus/",
    "crates/gateway/src/live/",
    "crates/recordings/",
    "src/cli/",
    "src/failure.rs",
    "src/main.rs",
];

/// Crates that bring the world with them.
const WORLDLY_CRATES: [&str; 11] = [
    "tokio",
    "axum",
    "hyper",
    "hyper_util",
    "socketcan",
    "libc",
    "nix",
    "rustix",
    "mio",
    "chrono",
    "getrandom",
];

/// Of `std` what is pure may use these modules, of `std::time` and others only the items named.
const ALLOWED: [&str; 27] = [
    "array",
    "borrow",
    "boxed",
    "char",
    "cmp",
    "collections",
    "convert",
    "error",
    "f64",
    "fmt",
    "hash::Hash",
    "hash::Hasher",
    "iter",
    "marker",
    "mem",
    "net::SocketAddr",
    "num",
    "ops",
    "ptr::eq",
    "slice",
    "str",
    "string",
    "sync::Arc",
    "rc::Rc",
    "time::Duration",
    "vec",
    "cell::Cell",
];

/// What writes reports to whatever it is given may name these, too.
const ALLOWED_IN_REPORTS: [&str; 4] = ["io", "io::Write", "io::Result", "io::Error"];

/// Names that mean the world wherever they come from.
const FORBIDDEN: [&str; 20] = [
    "Instant",
    "SystemTime",
    "OnceLock",
    "LazyLock",
    "OnceCell",
    "LazyCell",
    "thread_local",
    "lazy_static",
    "thread_rng",
    "ThreadRng",
    "OsRng",
    "SysRng",
    "from_entropy",
    "from_os_rng",
    "RandomState",
    "println",
    "eprintln",
    "print",
    "eprint",
    "dbg",
];

/// Their order is another one in every run. `dbc` only looks up in them, or sorts what comes out.
const UNORDERED: [&str; 2] = ["HashMap", "HashSet"];

/// The crate that the compiler keeps from the world.
const CORE: &str = "crates/core/src/";

/// Functions of floats that std has of the platform's C library. Where another crate brings std, the core
/// can call them, too, and would say something else on another platform.
const OF_THE_PLATFORM: [&str; 31] = [
    "acos",
    "asin",
    "atan",
    "atan2",
    "cbrt",
    "ceil",
    "cos",
    "cosh",
    "exp",
    "exp2",
    "exp_m1",
    "floor",
    "fract",
    "hypot",
    "ln",
    "ln_1p",
    "log",
    "log10",
    "log2",
    "mul_add",
    "powf",
    "powi",
    "round",
    "round_ties_even",
    "sin",
    "sin_cos",
    "sinh",
    "sqrt",
    "tan",
    "tanh",
    "trunc",
];

/// What nobody leaves behind, in any room.
const UNFINISHED: [&str; 3] = ["todo", "unimplemented", "dbg"];

/// A file longer than this has more than one noun.
const LONGEST: usize = 700;

/// The page with the drawing of the house.
const HOUSE: &str = "docs/internals/house.md";

/// Names that several public types of one crate may have: the clocks of telemetry and of the embedded
/// bus, which are always used with their module.
const SHARED_NAMES: [&str; 1] = ["Clock"];

struct Source {
    /// Below the top folder, with `/`.
    name: String,
    text: String,
}

impl Source {
    fn is_worldly(&self) -> bool {
        WORLDLY.iter().any(|room| self.name.starts_with(room))
    }

    /// The modules on the way from the root of its crate to it; none for the root itself.
    fn module(&self) -> Vec<&str> {
        let (_, below) = self.name.split_once("src/").expect("it is in a crate");
        let path = below.trim_end_matches(".rs").trim_end_matches("/mod");
        path.split('/').filter(|name| !matches!(*name, "lib" | "main")).collect()
    }

    /// Its code without tests.
    fn tokens(&self) -> Vec<String> {
        let stream: TokenStream = self.text.parse().expect("it compiles, so it has tokens");
        let mut tokens = Vec::new();
        flatten(stream, &mut tokens);
        tokens
    }
}

/// The folders of the crates' sources, but for the one that only tests are made of.
fn crates() -> Vec<String> {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates");
    let names = fs::read_dir(top).expect("it can be read").map(|entry| {
        let name = entry.expect("it is there").file_name();
        format!("crates/{}/src", name.to_str().expect("UTF-8"))
    });
    let of_the_program = |name: &String| name != "crates/testing/src";
    names.filter(of_the_program).chain(["src".to_owned()]).collect()
}

fn sources() -> Vec<Source> {
    crates().iter().flat_map(|folder| sources_below(folder)).collect()
}

fn sources_below(folder: &str) -> Vec<Source> {
    let top = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mut sources, mut rooms) = (Vec::new(), vec![top.join(folder)]);
    while let Some(room) = rooms.pop() {
        for entry in fs::read_dir(room).expect("it can be read") {
            let path: PathBuf = entry.expect("it is there").path();
            if path.is_dir() {
                rooms.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let below = path.strip_prefix(top).expect("it is below");
                let name = below.to_str().expect("UTF-8").replace('\\', "/");
                let text = fs::read_to_string(&path).expect("UTF-8");
                sources.push(Source { name, text });
            }
        }
    }
    sources.sort_by(|a, b| a.name.cmp(&b.name));
    sources
}

/// All words and signs in order, groups with their brackets, items under `#[cfg(test)]` left out.
fn flatten(stream: TokenStream, tokens: &mut Vec<String>) {
    let mut trees = stream.into_iter().peekable();
    while let Some(tree) = trees.next() {
        if tree.to_string() == "#" && trees.peek().is_some_and(is_for_tests) {
            // The item ends with its braces, or with a semicolon.
            _ = trees.find(|tree| match tree {
                TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
                _ => tree.to_string() == ";",
            });
            continue;
        }
        match tree {
            TokenTree::Group(group) => {
                let [open, close] = match group.delimiter() {
                    Delimiter::Parenthesis => ["(", ")"],
                    Delimiter::Brace => ["{", "}"],
                    Delimiter::Bracket => ["[", "]"],
                    Delimiter::None => ["", ""],
                };
                tokens.push(open.to_owned());
                flatten(group.stream(), tokens);
                tokens.push(close.to_owned());
            }
            // Texts and numbers do nothing.
            TokenTree::Literal(_) => tokens.push("0".to_owned()),
            TokenTree::Punct(_) | TokenTree::Ident(_) => tokens.push(tree.to_string()),
        }
    }
}

fn is_for_tests(attribute: &TokenTree) -> bool {
    attribute.to_string().replace(' ', "") == "[cfg(test)]"
}

/// The token at `at`; nothing behind the end.
fn text(tokens: &[String], at: usize) -> &str {
    tokens.get(at).map_or("", String::as_str)
}

fn is_word(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// The paths in the tokens, as `std::io::Write`; those of `use std::{fs, io::{self, Write}}` one by
/// one.
fn paths(tokens: &[String]) -> Vec<String> {
    let (mut paths, mut at) = (Vec::new(), 0);
    while at < tokens.len() {
        at = if is_word(&tokens[at]) { path(tokens, at, "", &mut paths) } else { at + 1 };
    }
    paths
}

/// Reads the path that begins at `at` below `prefix`, and says where it ends.
fn path(tokens: &[String], mut at: usize, prefix: &str, paths: &mut Vec<String>) -> usize {
    let goes_on = |token: &str| is_word(token) || matches!(token, "*" | "{");
    let mut path = prefix.to_owned();
    loop {
        if text(tokens, at) == "{" {
            at += 1;
            while !matches!(text(tokens, at), "}" | "") {
                let more = goes_on(text(tokens, at));
                at = if more { self::path(tokens, at, &path, paths) } else { at + 1 };
            }
            return at + 1;
        }
        if !path.is_empty() {
            path += "::";
        }
        path += text(tokens, at);
        at += 1;
        let separated = text(tokens, at) == ":" && text(tokens, at + 1) == ":";
        if !(separated && goes_on(text(tokens, at + 2))) {
            break;
        }
        at += 2;
    }
    paths.push(path.trim_end_matches("::self").to_owned());
    at
}

/// What `source` names that nothing pure may.
fn worldly_names(source: &Source) -> Vec<String> {
    let tokens = source.tokens();
    let reports = source.name.starts_with("crates/report/src/report/");
    let allowed = |path: &str| {
        let listed = |allowed: &&str| {
            path.strip_prefix(allowed).is_some_and(|more| more.is_empty() || more.starts_with("::"))
        };
        // `io` is a name to write `io::Write` with, not leave for all that is in it.
        ALLOWED.iter().any(listed) || (reports && ALLOWED_IN_REPORTS.contains(&path))
    };
    let looks_up = source.name.starts_with("crates/dbc/");
    let unordered = |segment: &str| !looks_up && UNORDERED.contains(&segment);
    let worldly = |path: &String| {
        let first = path.split("::").next().unwrap_or_default();
        let from_std = match (first, path.split_once("::")) {
            ("std", Some((_, rest))) => !allowed(rest),
            // Imported as a module; `fs` and the like are refused where they are imported.
            ("io", Some(_)) => !allowed(path),
            _ => false,
        };
        from_std
            || WORLDLY_CRATES.contains(&first)
            || matches!(&**path, "rand::rng" | "rand::random")
            || path.split("::").any(|segment| FORBIDDEN.contains(&segment) || unordered(segment))
    };
    let named = paths(&tokens).into_iter().filter(worldly);
    let changed = tokens.windows(2).filter(|pair| pair[0] == "static" && pair[1] == "mut");
    let found = named.chain(changed.map(|pair| pair.join(" ")));
    found.map(|what| format!("{}: {what}", source.name)).collect()
}

/// `.unwrap()`, `todo!` and the like; `expect` says why it cannot fail.
fn unfinished(source: &Source) -> Vec<String> {
    let tokens = source.tokens();
    let at = |at: usize| text(&tokens, at);
    let wrong = |i: &usize| {
        (UNFINISHED.contains(&at(*i)) && at(i + 1) == "!")
            || (at(*i) == "." && at(i + 1) == "unwrap" && at(i + 2) == "(")
            || is_ignored(&tokens[*i..])
    };
    let place = |i: usize| format!("{}: {}", source.name, [at(i), at(i + 1), at(i + 2)].concat());
    (0..tokens.len()).filter(wrong).map(place).collect()
}

/// Whether the tokens begin with `#[ignore`.
fn is_ignored(tokens: &[String]) -> bool {
    text(tokens, 0) == "#" && text(tokens, 1) == "[" && text(tokens, 2) == "ignore"
}

/// Names that more than one public type of a crate has, with the files.
fn shared_names(sources: &[Source]) -> Vec<String> {
    let mut places: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for source in sources {
        for item in source.tokens().windows(3) {
            let is_type = ["struct", "enum", "trait", "type", "union"].contains(&item[1].as_str());
            // A macro names the types that it declares where it is called.
            let is_named = item[2] != "$" && !SHARED_NAMES.contains(&item[2].as_str());
            if item[0] == "pub" && is_type && is_named {
                places.entry(item[2].clone()).or_default().push(&source.name);
            }
        }
    }
    let shared = places.into_iter().filter(|(_, files)| files.len() > 1);
    shared.map(|(name, files)| format!("{name}: {}", files.join(", "))).collect()
}

#[track_caller]
fn none(found: Vec<String>, why: &str) {
    assert!(found.is_empty(), "{why}:\n{}", found.join("\n"));
}

#[test]
fn what_is_pure_knows_no_world() {
    let is_asked = |it: &Source| !it.is_worldly() && !it.name.starts_with(CORE);
    let pure: Vec<Source> = sources().into_iter().filter(is_asked).collect();
    assert!(pure.len() > 40, "{} files", pure.len());
    none(
        pure.iter().flat_map(worldly_names).collect(),
        "a clock, socket, file, thread, global or unseeded chance where all is pure; hand in what is \
         needed as an argument",
    );
}

/// Functions of the platform that `source`, of the core, calls, and globals that can change.
fn of_the_platform(source: &Source) -> Vec<String> {
    let tokens = source.tokens();
    let at = |at: usize| text(&tokens, at);
    let named = |i: &usize| {
        let is_function = OF_THE_PLATFORM.contains(&at(*i));
        let of_a_value = *i > 0 && at(*i - 1) == ".";
        let of_the_type = *i > 2 && matches!(at(*i - 3), "f64" | "f32");
        is_function && (of_a_value || of_the_type) || at(*i) == "atomic"
    };
    let found = (0..tokens.len()).filter(named);
    found.map(|i| format!("{}: {}", source.name, at(i))).collect()
}

#[test]
fn the_core_is_the_same_everywhere() {
    // A file of its own for tests is one for std, too.
    let sources = sources_below(CORE);
    let core = sources.iter().filter(|source| !source.name.ends_with("/tests.rs"));
    none(
        core.flat_map(of_the_platform).collect(),
        "a function of the platform, or a global, in the core; take the function from libm",
    );
}

#[test]
fn functions_of_the_platform_are_caught_and_others_are_not() {
    for text in [
        "fn f() { (a + b).sqrt() }",
        "fn f() { x.iter().map(|y| y\n.powi (2)) }",
        "fn f() { x.map(f64::sqrt) }",
        "static A: core::sync::atomic::AtomicU32 = x;",
    ] {
        assert_eq!(of_the_platform(&pure(text)).len(), 1, "{text}");
    }
    for text in [
        "fn f() { libm::sqrt(x).abs() }",
        "fn f() { x.map(libm::sqrt) }",
        "#[cfg(test)] mod tests { fn f() { x.sqrt() } }",
    ] {
        assert_eq!(of_the_platform(&pure(text)), [] as [String; 0], "{text}");
    }
}

#[test]
fn the_rooms_of_a_crate_use_each_other_one_way() {
    for folder in crates() {
        let uses = uses_of_rooms(&sources_below(&folder));
        none(described(&uses), &format!("{folder}: rooms that use each other"));
    }
}

#[test]
fn a_public_type_has_a_name_of_its_own_in_its_crate() {
    for folder in crates() {
        none(shared_names(&sources_below(&folder)), "types of one name; say of what each is");
    }
    let found = |files: [&str; 2]| {
        let [one, other] = files.map(|text| source("crates/made/src/up.rs", text));
        shared_names(&[one, other]).len()
    };
    assert_eq!(found(["pub struct A;", "mod b { pub enum A { B } }"]), 1);
    assert_eq!(found(["pub trait A {}", "pub type A = f64;"]), 1);
    for other in ["pub(super) struct A;", "struct A;", "pub struct B;", "pub use b::A;"] {
        assert_eq!(found(["pub struct A;", other]), 0, "{other}");
    }
    assert_eq!(found(["pub struct A;", "#[cfg(test)] mod t { pub struct A; }"]), 0);
}

#[test]
fn no_file_is_too_long_and_nothing_is_left_unfinished() {
    let sources = sources();
    let long = sources.iter().map(|source| (source, source.text.lines().count()));
    let long = long.filter(|(_, lines)| *lines > LONGEST);
    none(
        long.map(|(source, lines)| format!("{}: {lines} lines", source.name)).collect(),
        "files with more than one noun",
    );
    none(sources.iter().flat_map(unfinished).collect(), "unfinished or unproven");
    none(sources.iter().flat_map(run_on_headings).collect(), "headings that go on into the text");
    // Tests that do not run test nothing.
    let ignored = |source: &Source| {
        let tokens = source.tokens();
        (0..tokens.len()).any(|at| is_ignored(&tokens[at..]))
    };
    let tests = ["tests", "crates/testing"].into_iter().flat_map(sources_below).filter(ignored);
    none(tests.map(|test| test.name).collect(), "tests that do not run");
}

/// Lines of a doc comment whose heading takes the text behind it along, as pages of documentation would show it.
fn run_on_headings(source: &Source) -> Vec<String> {
    let heading = |line: &str| {
        let text = line.trim_start().strip_prefix("/// # ")?;
        ["Errors ", "Panics ", "Examples "].into_iter().find(|it| text.starts_with(it))
    };
    let lines = (1..).zip(source.text.lines());
    let found = lines.filter(|(_, line)| heading(line).is_some());
    found.map(|(number, line)| format!("{}:{number}: {}", source.name, line.trim())).collect()
}

#[test]
fn headings_that_run_on_are_caught() {
    let found = |text: &str| run_on_headings(&source("crates/core/src/x.rs", text)).len();
    assert_eq!(found("/// A thing.\n///\n/// # Errors\n/// The file is gone.\n/// # use x::Y;"), 0);
    assert_eq!(found("    /// # Errors The file is gone.\n/// # Panics `x` is 0."), 2);
}

fn pure(text: &str) -> Source {
    source("crates/learn/src/made/up.rs", text)
}

fn source(name: &str, text: &str) -> Source {
    Source { name: name.to_owned(), text: text.to_owned() }
}

/// The net is whole: each of these is caught, and what only looks like it is not.
#[test]
fn worldly_code_is_caught_and_talk_is_not() {
    for text in [
        "use std::time::Instant;",
        "use std::{fmt, time::{Duration, SystemTime}};",
        "fn f() { let now = std::time::SystemTime::now(); }",
        "use std::fs;",
        "use std::fs::File as Table;",
        "use std::io::{self, Write};",
        "fn f() { io::stdin(); }",
        "use std::*;",
        "use std::{env, net::UdpSocket};",
        "fn f() { std::thread::sleep(d); }",
        "fn f() { std::process::exit(1) }",
        "static mut COUNT: u32 = 0;",
        "static A: std::sync::Mutex<u32> = x;",
        "static A: std::sync::atomic::AtomicU32 = x;",
        "use std::sync::OnceLock;",
        "thread_local! { static A: u32 = 0; }",
        "fn f() { rand::rng().random() }",
        "fn f() { rand::random::<f64>() }",
        "use rand::rngs::SysRng;",
        "fn f() { println!(\"x\"); }",
        "use std::collections::HashMap;",
        "use tokio::net;",
        "fn f() { libc::time() }",
    ] {
        assert_ne!(worldly_names(&pure(text)), [] as [String; 0], "{text}");
    }
    for text in [
        "//! Like std::time::Instant, but not it.\n/// No std::fs here.\nfn f() {} // std::thread",
        "fn f() -> &'static str { \"std::net::TcpStream\" }",
        "use std::fmt::{self, Write as _}; use std::time::Duration; use std::sync::Arc;",
        "use std::collections::{BTreeMap, VecDeque}; static A: u32 = 0;",
        "fn f() {} #[cfg(test)] mod tests { use std::fs; fn f() { println!(\"x\") } }",
        "#[cfg(test)] use std::fs;\nfn f() {}",
        "fn f(instant: u32) { let time = instant; self.print(time) }",
    ]
    .map(|text| text.replace("self.print(time)", "time;"))
    {
        assert_eq!(worldly_names(&pure(&text)), [] as [String; 0], "{text}");
    }
    let report = |text: &str| source("crates/report/src/report/made_up.rs", text);
    let writes = "use std::io::{self, Write}; fn f(out: &mut impl Write) -> io::Result<()> {}";
    assert_eq!(worldly_names(&report(writes)), [] as [String; 0]);
    for text in ["fn f() { io::stdout() }", "use std::io::stdout;", "use std::fs;"] {
        assert_ne!(worldly_names(&report(text)), [] as [String; 0], "{text}");
    }
}

/// The house as its imports have it, from the top down: each crate with those that it uses, and its rooms
/// with those of the same crate that they use.
fn drawing() -> String {
    let mut drawn = String::new();
    let folders = crates();
    let uses: Uses = folders.iter().map(|it| (it.clone(), crates_used(it))).collect();
    for folder in from_the_top(&uses) {
        drawn += &line(0, folder, &uses[folder]);
        let rooms = uses_of_rooms(&sources_below(folder));
        for room in from_the_top(&rooms) {
            drawn += &line(2, room, &rooms[room]);
        }
    }
    drawn
}

fn line(indent: usize, name: &str, used: &BTreeSet<String>) -> String {
    let short = |name: &str| name.trim_end_matches("/src").to_owned();
    let used: Vec<String> = used.iter().map(|name| short(name).replace("crates/", "")).collect();
    let arrow = if used.is_empty() { "" } else { " → " };
    let line = format!("{:indent$}{:14}{arrow}{}", "", short(name), used.join(" "));
    format!("{}\n", line.trim_end())
}

/// The folders of the crates that the sources in `folder` use.
fn crates_used(folder: &str) -> BTreeSet<String> {
    let sources = sources_below(folder);
    let paths = sources.iter().flat_map(|source| paths(&source.tokens()));
    let crates = paths.filter_map(|path| {
        let (name, _) = path.split_once("::").unwrap_or((&path, ""));
        Some(format!("crates/{}/src", name.strip_prefix("tertius_")?))
    });
    crates.collect()
}

/// What is used by nobody first, and nothing before what uses it.
fn from_the_top(uses: &Uses) -> Vec<&String> {
    let mut left: BTreeSet<&String> = uses.keys().collect();
    let mut ordered = Vec::new();
    while !left.is_empty() {
        let is_used = |room: &&String| left.iter().any(|other| uses[*other].contains(*room));
        let free: Vec<&String> = left.iter().copied().filter(|room| !is_used(room)).collect();
        assert!(!free.is_empty(), "a circle among {left:?}");
        left.retain(|room| !free.contains(room));
        ordered.extend(free);
    }
    ordered
}

#[test]
fn the_house_is_drawn_as_it_stands() {
    let drawn = drawing();
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join(HOUSE);
    let text = fs::read_to_string(page).expect("it can be read");
    assert!(text.contains(&drawn), "{HOUSE} has another house than this:\n{drawn}");
}

#[test]
fn unfinished_code_is_caught_and_proven_code_is_not() {
    for text in [
        "fn f() { x.unwrap() }",
        "fn f() { x\n.unwrap () }",
        "fn f() { todo!() }",
        "fn f() { unimplemented!(\"later\") }",
        "fn f() { dbg!(x); }",
        "#[ignore] fn f() {}",
        "#[ignore = \"slow\"] fn f() {}",
    ] {
        assert_ne!(unfinished(&pure(text)), [] as [String; 0], "{text}");
    }
    for text in [
        "fn f() { x.unwrap_or(1); x.expect(\"it was made\") }",
        "#[cfg(test)] mod tests { #[test] fn f() { x.unwrap() } }",
        "/// No todo!() and x.unwrap() here.\nfn f() {}",
    ] {
        assert_eq!(unfinished(&pure(text)), [] as [String; 0], "{text}");
    }
}
