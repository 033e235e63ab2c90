//! What documents and manifests promise: links that lead somewhere, and one oldest compiler everywhere.

use super::none;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn top() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Files of `folder` below the top whose name ends with `extension`.
fn files(folder: &str, extension: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(top().join(folder)).expect("it can be read");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("it is there").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|it| it == extension));
    paths.sort();
    paths
}

/// The targets of `[text](target)` outside of blocks of code.
fn links(text: &str) -> Vec<&str> {
    let prose = text.lines().filter(|line| !line.starts_with("    "));
    let targets = prose.flat_map(|line| line.split("](").skip(1));
    targets.filter_map(|rest| rest.split_once(')')).map(|(target, _)| target).collect()
}

/// The pages at the top, and those for people who use the program and for those who change it.
fn pages() -> Vec<PathBuf> {
    [files("", "md"), files("docs", "md"), files("docs/internals", "md")].concat()
}

/// The anchors of a page's headings, as GitHub makes them.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings = text.lines().filter(|line| line.starts_with('#'));
    let anchor = |line: &str| -> String {
        let heading = line.trim_start_matches('#').trim().to_lowercase();
        let kept = heading.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(anchor).collect()
}

/// Why a link on the page at `page` leads nowhere; `None` where it leads somewhere, or elsewhere.
fn broken(page: &Path, link: &str) -> Option<String> {
    if link.starts_with("https://") {
        return None;
    }
    let (path, anchor) = link.split_once('#').unwrap_or((link, ""));
    let target = match path {
        "" => page.to_owned(),
        path => page.parent().expect("it is in a folder").join(path),
    };
    let name = page.strip_prefix(top()).expect("it is below").display();
    if !target.exists() {
        return Some(format!("{name}: {link} is not there"));
    }
    let known = anchor.is_empty() || anchors(&read(&target)).contains(anchor);
    (!known).then(|| format!("{name}: {link} has no such heading"))
}

#[test]
fn links_of_documents_lead_somewhere() {
    let pages = pages();
    let mut counted = 0;
    let mut found = Vec::new();
    for page in &pages {
        let text = read(page);
        counted += links(&text).len();
        found.extend(links(&text).into_iter().filter_map(|link| broken(page, link)));
    }
    assert!(counted > 30, "{counted} links on {} pages", pages.len());
    none(found, "links that lead nowhere");
}

#[test]
fn the_index_lists_every_page() {
    let index = read(&top().join("docs/README.md"));
    let listed: Vec<String> =
        links(&index).into_iter().map(|link| format!("docs/{link}")).collect();
    let pages = [files("docs", "md"), files("docs/internals", "md")].concat();
    let names = pages.iter().map(|page| page.strip_prefix(top()).expect("it is below"));
    let names = names.map(|name| name.to_str().expect("UTF-8").to_owned());
    let missing = names.filter(|name| name != "docs/README.md" && !listed.contains(name));
    none(missing.collect(), "pages that docs/README.md does not list");
}

/// Lines of `text` whose number of cells is another than that of their table's first row, with their numbers.
fn ragged(text: &str) -> Vec<(usize, &str)> {
    let cells = |line: &str| line.replace("\\|", "").trim().trim_matches('|').split('|').count();
    let (mut width, mut found) = (None, Vec::new());
    for (number, line) in (1..).zip(text.lines()) {
        if !line.starts_with('|') {
            width = None;
        } else if *width.get_or_insert_with(|| cells(line)) != cells(line) {
            found.push((number, line));
        }
    }
    found
}

#[test]
fn rows_of_tables_have_as_many_cells_as_their_head() {
    let mut found = Vec::new();
    for page in pages() {
        let text = read(&page);
        let rows = ragged(&text).into_iter();
        found.extend(rows.map(|(number, row)| format!("{}:{number}: {row}", page.display())));
    }
    none(found, "rows that are wider or narrower than their table");

    let text = "| a | b |\n| --- | --- |\n| 1 | \\|R1\\| |\n| 1 | 2 | 3 |\n\n| c |\n| --- |\n";
    assert_eq!(ragged(text), [(4, "| 1 | 2 | 3 |")]);
}

/// The tests that a page names, as `core/detection::a_step_is_found`: their files, and their functions.
fn named_tests(text: &str) -> Vec<(String, String)> {
    let codes = text.split('`').skip(1).step_by(2);
    let named = codes.filter_map(|code| {
        let (file, name) = code.split_once("::")?;
        let is_path = file.contains('/') && !file.contains(' ') && !name.contains("::");
        is_path.then(|| (format!("tests/{file}.rs"), name.to_owned()))
    });
    named.collect()
}

#[test]
fn tests_that_documents_name_exist() {
    let page = top().join("docs/SAFETY.md");
    let named = named_tests(&read(&page));
    assert!(named.len() > 50, "{} tests are named", named.len());
    let missing = named.into_iter().filter(|(file, name)| {
        let text = fs::read_to_string(top().join(file)).unwrap_or_default();
        !text.contains(&format!("fn {name}()"))
    });
    let missing = missing.map(|(file, name)| format!("{file} has no {name}"));
    none(missing.collect(), "tests that docs/SAFETY.md names and that are not there");
}

/// A function on the way of a frame: the indentation of its line, its file and its name.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Step<'a> {
    indent: usize,
    file: &'a str,
    name: &'a str,
}

/// The steps on a page: lines like `  crates/core/src/x.rs: turn    what it does`. A step that is indented further than the one
/// above is called by it.
fn steps(text: &str) -> Vec<Step<'_>> {
    let step = |line| {
        let (file, rest) = str::split_once(line, ".rs: ")?;
        let name = rest.split(' ').next()?;
        let path = file.trim_start();
        let is_path = !path.contains([' ', '`', '|']);
        let file = &line[file.len() - path.len()..file.len() + ".rs".len()];
        is_path.then_some(Step { indent: line.len() - line.trim_start().len(), file, name })
    };
    text.lines().filter_map(step).collect()
}

/// The step that calls each of `steps`; `None` where a way begins.
fn callers<'a>(steps: &[Step<'a>]) -> Vec<Option<Step<'a>>> {
    let above = |(at, step): (usize, &Step<'a>)| {
        let before = steps[..at].iter().rev();
        before.take_while(|_| step.indent > 0).find(|it| it.indent < step.indent).copied()
    };
    steps.iter().enumerate().map(above).collect()
}

/// Whether `body` calls the function `name`, or names it by a path, outside of comments.
fn calls(body: &str, name: &str) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let code = body.lines().map(|line| line.split("//").next().unwrap_or_default());
    code.flat_map(|line| {
        line.match_indices(name).map(move |(at, _)| (&line[..at], &line[at + name.len()..]))
    })
    .any(|(before, after)| {
        let is_word = !before.ends_with(is_part) && !after.starts_with(is_part);
        let is_called = after.starts_with('(') || after.starts_with("::<");
        is_word && (is_called || before.ends_with("::"))
    })
}

/// The bodies of all functions `name` in `source`, which is formatted: up to the brace below the begin of the first line.
fn bodies(source: &str, name: &str) -> Vec<String> {
    let lines: Vec<&str> = source.lines().collect();
    let begins = |line: &str| {
        ["(", "<"].into_iter().any(|then| {
            line.split_once(&format!("fn {name}{then}")).is_some_and(|(it, _)| !it.contains("//"))
        }) && !line.ends_with(';')
    };
    let body = |at: usize| {
        let indent = lines[at].len() - lines[at].trim_start().len();
        let end = format!("{}}}", " ".repeat(indent));
        let rest = lines[at + 1..].iter().take_while(|line| **line != end);
        rest.copied().collect::<Vec<_>>().join("\n")
    };
    (0..lines.len()).filter(|at| begins(lines[*at])).map(body).collect()
}

/// What is wrong with `step`, which `caller` calls: its file has no such function, or the caller's does not name it.
fn missing(
    step: Step<'_>,
    caller: Option<Step<'_>>,
    source: impl Fn(&str) -> String,
) -> Option<String> {
    let Step { file, name, .. } = step;
    if bodies(&source(file), name).is_empty() {
        return Some(format!("{file} has no function {name}"));
    }
    let caller = caller?;
    let is_called = bodies(&source(caller.file), caller.name).iter().any(|body| calls(body, name));
    (!is_called).then(|| format!("{} in {} does not call {name}", caller.name, caller.file))
}

#[test]
fn each_arrow_of_the_architecture_is_a_call() {
    let page = read(&top().join("ARCHITECTURE.md"));
    let steps = steps(&page);
    assert!(steps.len() > 50, "{} steps", steps.len());
    let source = |file: &str| fs::read_to_string(top().join(file)).unwrap_or_default();
    let found = steps.iter().zip(callers(&steps)).filter_map(|(it, by)| missing(*it, by, source));
    none(found.collect(), "arrows in ARCHITECTURE.md that lead nowhere");
}

/// Most lines of ARCHITECTURE.md: it is read as a whole before the first change.
const LONGEST_ARCHITECTURE: usize = 200;

#[test]
fn the_architecture_is_read_in_one_sitting() {
    let length = read(&top().join("ARCHITECTURE.md")).lines().count();
    assert!(
        length <= LONGEST_ARCHITECTURE,
        "ARCHITECTURE.md has {length} lines; docs/internals/ has room"
    );
}

#[test]
fn arrows_that_lead_nowhere_are_caught() {
    let source = |file: &str| {
        match file {
        "src/a.rs" => "pub fn first() {\n    b::second();\n}\n\nfn other<T>() {\n}\n".to_owned(),
        "src/b.rs" => "// fn third() {\nimpl B {\n    fn second(&self) {\n    }\n}\n".to_owned(),
        // A comment, a variable and a declaration are no calls.
        "src/c.rs" => "trait C {\n    fn declared(&self);\n}\n\nfn caller() {\n    // second()\n    let second = 1;\n}\n"
            .to_owned(),
        _ => String::new(),
    }
    };
    let found = |text: &str| {
        let steps = steps(text);
        let each = steps.iter().zip(callers(&steps));
        each.filter_map(|(it, by)| missing(*it, by, source)).count()
    };
    for text in [
        "src/a.rs: first    what it does\n  src/b.rs: second\nsrc/a.rs: other",
        "See `src/a.rs: none` and a table.\n| src/a.rs: none |",
    ] {
        assert_eq!(found(text), 0, "{text}");
    }
    for text in [
        "src/a.rs: second",
        "src/b.rs: third",
        "src/none.rs: first",
        "src/a.rs: other\n  src/b.rs: second",
        "src/b.rs: second\n  src/a.rs: first",
        "src/c.rs: caller\n  src/b.rs: second",
        "src/c.rs: declared",
        "lib.rs: first",
    ] {
        assert_eq!(found(text), 1, "{text}");
    }
}

#[test]
fn broken_links_are_caught_and_others_are_not() {
    let page = top().join("README.md");
    for link in ["docs/NOWHERE.md", "docs/SPEED.md#nothing-of-it", "#no-such-heading"] {
        assert!(broken(&page, link).is_some(), "{link}");
    }
    for link in ["docs/SPEED.md", "docs/TELEMETRY.md#get-health", "https://example.org/a#b"] {
        assert_eq!(broken(&page, link), None, "{link}");
    }
    assert_eq!(links("a [b](c.md#d), [e](f)\n    [code](g)\n"), ["c.md#d", "f"]);
}

/// The value of `key` in the table of a manifest that is called `table`.
fn value<'a>(manifest: &'a toml::Table, table: &str, key: &str) -> Option<&'a toml::Value> {
    table.split('.').try_fold(manifest, |table, name| table.get(name)?.as_table())?.get(key)
}

#[test]
fn one_oldest_compiler_is_promised_everywhere() {
    let manifest = |path: &Path| -> toml::Table { read(path).parse().expect("it is TOML") };
    let root = manifest(&top().join("Cargo.toml"));
    let promised = value(&root, "workspace.package", "rust-version").and_then(toml::Value::as_str);
    let promised = promised.expect("the workspace promises one");

    let mut found = Vec::new();
    let members = fs::read_dir(top().join("crates")).expect("it can be read");
    let members = members.map(|entry| entry.expect("it is there").path());
    for folder in members.chain([top().to_owned()]) {
        let own = manifest(&folder.join("Cargo.toml"));
        let inherited = value(&own, "package.rust-version", "workspace");
        if inherited.and_then(toml::Value::as_bool) != Some(true) {
            found.push(format!("{}: no rust-version.workspace = true", folder.display()));
        }
    }
    let fuzz = manifest(&top().join("fuzz/Cargo.toml"));
    if value(&fuzz, "package", "rust-version").and_then(toml::Value::as_str) != Some(promised) {
        found.push("fuzz/Cargo.toml: another rust-version".to_owned());
    }
    for (page, words) in [
        ("README.md", format!("Rust ({promised} or newer)")),
        (".github/workflows/ci.yml", format!("rust:{promised}-")),
    ] {
        if !read(&top().join(page)).contains(&words) {
            found.push(format!("{page}: nothing of {words}"));
        }
    }
    none(found, "another oldest compiler than the workspace's");
}
