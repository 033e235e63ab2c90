//! Which rooms and which files of a crate use each other, and whether they do so in circles.
//!
//! A file uses the file that defines what it names: a re-export on the way is followed to the definition, and is
//! no use by itself, so that `mod.rs` may pass on what its files define.

use super::{Source, crates, is_word, none, paths, source, sources_below, text};
use std::collections::{BTreeMap, BTreeSet};

/// Where files still use each other in circles, and how many files that are. A number only falls, and an entry
/// without files goes.
const KNOWN: [(&str, usize); 4] = [
    // The values, and the overview and the points that are made of them.
    ("crates/gateway/src/appliance/telemetry", 5),
    // Several recordings that are read as one are a recording again.
    ("crates/recordings/src/recording", 2),
    // Tables of the evaluation; and `Summary`, with the words and the time zone that all reports share.
    ("crates/report/src/report", 17),
    // The line of an incident, its evidence and its doubts use each other's words.
    ("crates/report/src/story", 3),
];

/// Names, and which others each of them uses.
pub type Uses = BTreeMap<String, BTreeSet<String>>;

/// The circles, each with all that use each other in it.
fn circles(uses: &Uses) -> Vec<BTreeSet<&str>> {
    let reached: BTreeMap<&str, BTreeSet<&str>> =
        uses.keys().map(|name| (name.as_str(), reached_from(uses, name))).collect();
    let circle = |name: &&str| -> BTreeSet<&str> {
        let uses_it = |other: &&&str| reached.get(**other).is_some_and(|it| it.contains(name));
        reached[name].iter().filter(uses_it).copied().collect()
    };
    let circles: BTreeSet<BTreeSet<&str>> = reached.keys().map(circle).collect();
    circles.into_iter().filter(|circle| !circle.is_empty()).collect()
}

/// All that `name` uses, directly or through others.
fn reached_from<'a>(uses: &'a Uses, name: &str) -> BTreeSet<&'a str> {
    let (mut reached, mut left) = (BTreeSet::new(), vec![name]);
    while let Some(name) = left.pop() {
        for other in uses.get(name).into_iter().flatten() {
            if reached.insert(other.as_str()) {
                left.push(other);
            }
        }
    }
    reached
}

/// A line for each member of each circle, with what it uses in that circle.
pub fn described(uses: &Uses) -> Vec<String> {
    let lines = circles(uses).into_iter().flat_map(|circle| {
        let line = |name: &&str| {
            let used = uses[*name].iter().filter(|other| circle.contains(other.as_str()));
            format!("{name} uses {:?}", used.collect::<Vec<_>>())
        };
        circle.iter().map(line).collect::<Vec<_>>()
    });
    lines.collect()
}

/// What is wrong with `known`, which says where circles are and how many files are in them: circles elsewhere or of
/// more files, and places that have fewer by now.
fn unknown(uses: &Uses, known: &[(&str, usize)]) -> Vec<String> {
    let in_circles: BTreeSet<&str> = circles(uses).into_iter().flatten().collect();
    // `src/bus` has `src/bus/merge.rs` and `src/bus.rs`, and not `src/business.rs`.
    let is_in = |file: &str, place: &str| {
        file.strip_prefix(place).is_some_and(|rest| rest.starts_with(['/', '.']))
    };
    let found = |place: &str| in_circles.iter().filter(|file| is_in(file, place)).count();
    let is_known = |line: &str| {
        known.iter().any(|(place, files)| is_in(line, place) && found(place) <= *files)
    };
    let more = described(uses).into_iter().filter(|line| !is_known(line));
    let fewer =
        known.iter().filter(|(place, files)| found(place) < *files).map(|(place, files)| {
            format!(
                "{place} has {} files in circles, and no longer {files}: write that number",
                found(place)
            )
        });
    more.chain(fewer).collect()
}

/// The rooms of a crate, which are the modules of its root, and which of them each uses.
pub fn uses_of_rooms(sources: &[Source]) -> Uses {
    let rooms: BTreeSet<&str> =
        sources.iter().filter_map(|it| it.module().first().copied()).collect();
    let roots = sources.iter().filter(|source| source.module().is_empty());
    // What the root passes on is of the room that it is from.
    let passed_on: BTreeMap<String, String> = roots
        .flat_map(|root| paths(&root.tokens()))
        .filter_map(|path| {
            let (room, rest) = path.split_once("::")?;
            let name = rest.rsplit("::").next()?;
            rooms.contains(room).then(|| (name.to_owned(), room.to_owned()))
        })
        .collect();
    let mut uses = Uses::new();
    for source in sources.iter().filter(|source| !source.module().is_empty()) {
        let module = source.module();
        let used: &mut BTreeSet<String> = uses.entry(module[0].to_owned()).or_default();
        for path in paths(&source.tokens()) {
            let Some(name) = name_in_the_root(&path, module.len()) else { continue };
            let room = passed_on.get(name).map_or(name, String::as_str);
            if room != module[0] && rooms.contains(room) {
                used.insert(room.to_owned());
            }
        }
    }
    uses
}

/// The name in the crate's root with which `path` begins, in a module so `deep`; `None` where it begins
/// elsewhere.
fn name_in_the_root(path: &str, deep: usize) -> Option<&str> {
    let segments: Vec<&str> = path.split("::").collect();
    let up = segments.iter().take_while(|segment| **segment == "super").count();
    match segments[0] {
        "crate" => segments.get(1).copied(),
        "super" if up == deep => segments.get(up).copied(),
        _ => None,
    }
}

/// The files of a crate, and which of them each uses. Files of tests are left out: they may use their parent.
fn uses_of_files(sources: &[Source]) -> Uses {
    // The program is a crate of its own, which uses the library by its name.
    let is_asked = |it: &&Source| !it.name.ends_with("/main.rs") && !it.module().contains(&"tests");
    let sources = sources.iter().filter(is_asked);
    let modules = sources.map(|source| (owned(&source.module()), Module::of(source))).collect();
    let modules = Modules(modules);
    let mut uses = Uses::new();
    for (path, module) in &modules.0 {
        let used = modules.used_by(path, module).into_iter().filter(|used| *used != module.file);
        uses.entry(module.file.clone()).or_default().extend(used.map(str::to_owned));
    }
    modules.add_methods(&mut uses);
    uses
}

fn owned(path: &[&str]) -> Vec<String> {
    path.iter().map(|&name| name.to_owned()).collect()
}

/// The modules of a crate by their paths.
struct Modules(BTreeMap<Vec<String>, Module>);

/// What a file has at its top, and what it names.
struct Module {
    file: String,
    defined: BTreeSet<String>,
    imports: Vec<Import>,
    /// Methods and constants in `impl` blocks without a trait, each with the type.
    methods: Vec<(String, String)>,
    /// What the code names, without the imports.
    named: Vec<String>,
    /// Methods of `self` that it calls.
    called: BTreeSet<String>,
}

/// One name of a `use`, `*` where it takes all.
struct Import {
    name: String,
    path: String,
    is_passed_on: bool,
}

/// What a path leads to.
enum Place<'a> {
    Module(Vec<String>),
    /// Something that this file defines.
    Item(&'a str),
}

impl Module {
    fn of(source: &Source) -> Self {
        let (tokens, file) = (source.tokens(), source.name.clone());
        let (mut imports, mut rest) = (Vec::new(), Vec::new());
        let mut at = 0;
        while at < tokens.len() {
            // `impl Trait + use<'a>` is no import.
            if tokens[at] == "use" && text(&tokens, at + 1) != "<" {
                let is_passed_on = at > 0 && matches!(&*tokens[at - 1], "pub" | ")");
                let mut found = Vec::new();
                at = import(&tokens, at + 1, "", &mut found);
                let found = found.into_iter();
                imports.extend(found.map(|(name, path)| Import { name, path, is_passed_on }));
            } else {
                rest.push(tokens[at].clone());
                at += 1;
            }
        }
        let (defined, methods) = definitions(&rest);
        // Neither methods nor fields are names of the module, nor is a module used where it is declared.
        let is_dot = |at: usize| text(&rest, at) == ".";
        let is_member = |at: &usize| *at > 1 && is_dot(*at - 1) && !is_dot(*at - 2);
        let (members, names): (Vec<usize>, Vec<usize>) = (0..rest.len()).partition(is_member);
        let names = names.into_iter().filter(|at| *at == 0 || rest[at - 1] != "mod");
        let named = paths(&names.map(|at| rest[at].clone()).collect::<Vec<_>>());
        let is_call = |at: &usize| text(&rest, *at - 2) == "self" && text(&rest, *at + 1) == "(";
        let own = members.into_iter().filter(is_call);
        let called = own.map(|at| rest[at].clone()).collect();
        Self { file, defined, imports, methods, named, called }
    }
}

/// Reads the names of a `use` from `at` on, each with its path, and says where they end.
fn import(
    tokens: &[String],
    mut at: usize,
    prefix: &str,
    found: &mut Vec<(String, String)>,
) -> usize {
    let mut path = prefix.to_owned();
    loop {
        match text(tokens, at) {
            "{" => {
                at += 1;
                while !matches!(text(tokens, at), "}" | "") {
                    at = if text(tokens, at) == "," {
                        at + 1
                    } else {
                        import(tokens, at, &path, found)
                    };
                }
                return at + 1;
            }
            ":" => at += 1,
            name if is_word(name) && name != "as" || name == "*" => {
                if !path.is_empty() {
                    path += "::";
                }
                path += name;
                at += 1;
            }
            _ => break,
        }
    }
    let path = path.trim_end_matches("::self").trim_end_matches("::*").to_owned();
    let name = match text(tokens, at) {
        "as" => text(tokens, at + 1),
        _ if text(tokens, at - 1) == "*" => "*",
        _ => path.rsplit("::").next().unwrap_or_default(),
    };
    found.push((name.to_owned(), path.clone()));
    (at..tokens.len()).find(|at| matches!(&*tokens[*at], "," | "}" | ";")).unwrap_or(tokens.len())
}

/// What is defined at the top, and what in `impl` blocks there that are of no trait, with their types.
fn definitions(tokens: &[String]) -> (BTreeSet<String>, Vec<(String, String)>) {
    let (mut defined, mut methods) = (BTreeSet::new(), Vec::new());
    let (mut depth, mut of) = (0, None);
    for at in 0..tokens.len() {
        let name = |further: usize| text(tokens, at + further).to_owned();
        match &*tokens[at] {
            "(" | "{" | "[" => depth += 1,
            ")" | "]" => depth -= 1,
            "}" => {
                depth -= 1;
                of = of.filter(|_| depth > 0);
            }
            "struct" | "enum" | "trait" | "type" | "union" | "fn" | "const" | "static" | "mut"
                if depth == 0 =>
            {
                defined.insert(name(1));
            }
            "macro_rules" if depth == 0 => _ = defined.insert(name(2)),
            "impl" if depth == 0 => of = type_of_impl(&tokens[at + 1..]),
            "fn" | "const" if depth == 1 => methods.extend(of.clone().map(|of| (of, name(1)))),
            _ => {}
        }
    }
    (defined, methods)
}

/// The type of an `impl` block whose head the tokens begin with, unless it is of a trait.
fn type_of_impl(tokens: &[String]) -> Option<String> {
    let (mut head, mut angles) = (Vec::new(), 0);
    for (at, token) in tokens.iter().enumerate() {
        match token.as_str() {
            "<" => angles += 1,
            ">" if tokens[at - 1] != "-" => angles -= 1,
            "{" | "where" if angles == 0 => break,
            "for" if angles == 0 => return None,
            _ if angles == 0 => head.push(token.clone()),
            _ => {}
        }
    }
    paths(&head).into_iter().next()
}

impl Modules {
    /// The files of what `module` names.
    fn used_by<'a>(&'a self, path: &[String], module: &'a Module) -> Vec<&'a str> {
        let first = |named: &'a String| named.split("::").next().unwrap_or_default();
        let firsts: BTreeSet<&str> = module.named.iter().map(first).collect();
        let is_used = |it: &&'a Import| {
            !it.is_passed_on || (it.name != "*" && firsts.contains(it.name.as_str()))
        };
        let imported = module.imports.iter().filter(is_used).filter_map(|it| {
            match self.resolve(path, &it.path)? {
                // A module is used by what is named in it.
                Place::Module(of) => (it.name == "*").then(|| self.0[&of].file.as_str()),
                Place::Item(file) => Some(file),
            }
        });
        let named = module.named.iter().filter(|named| named.contains("::"));
        let named = named.filter_map(|named| match self.resolve(path, named)? {
            Place::Module(_) => None,
            Place::Item(file) => Some(file),
        });
        imported.chain(named).collect()
    }

    /// A type whose methods are in several files is one object: these files use each other where one names what
    /// another has of it.
    fn add_methods(&self, uses: &mut Uses) {
        let mut objects: BTreeMap<(&str, &str), BTreeMap<&str, BTreeSet<&str>>> = BTreeMap::new();
        for (path, module) in &self.0 {
            for (of, method) in &module.methods {
                let Some(Place::Item(file)) = self.resolve(path, of) else { continue };
                let name = of.rsplit("::").next().unwrap_or_default();
                let object = objects.entry((file, name)).or_default();
                object.entry(file).or_default();
                object.entry(&module.file).or_default().insert(method);
            }
        }
        for ((_, object), files) in objects {
            for module in self.0.values().filter(|it| files.contains_key(&*it.file)) {
                let ends_so = |end: String| module.named.iter().any(|path| path.ends_with(&end));
                let is_named = |method: &&str| {
                    module.called.contains(*method)
                        || [object, "Self"].iter().any(|of| ends_so(format!("{of}::{method}")))
                };
                let others = files.iter().filter(|(file, methods)| {
                    **file != module.file && methods.iter().any(is_named)
                });
                let others = others.map(|(file, _)| (*file).to_owned());
                uses.entry(module.file.clone()).or_default().extend(others);
            }
        }
    }

    /// What `path` means in the module `from`; `None` if it is of another crate.
    fn resolve(&self, from: &[String], path: &str) -> Option<Place<'_>> {
        self.resolve_in(from, path, 0)
    }

    fn resolve_in(&self, from: &[String], path: &str, steps: usize) -> Option<Place<'_>> {
        let mut segments = path.split("::").peekable();
        let mut module = from.to_vec();
        let mut is_relative = true;
        while let Some(segment) = segments.next_if(|it| matches!(*it, "crate" | "self" | "super")) {
            is_relative = false;
            match segment {
                "crate" => module.clear(),
                "super" => _ = module.pop(),
                _ => {}
            }
        }
        while let Some(name) = segments.next() {
            let is_last = segments.peek().is_none();
            let found = self.name_in(&module, name, is_last, steps);
            match found {
                Some(Some(Place::Module(of))) => module = of,
                Some(place) => return place,
                // What a macro makes is written nowhere.
                None if !is_relative => return self.0.get(&module).map(|it| Place::Item(&it.file)),
                None => return None,
            }
            is_relative = false;
        }
        Some(Place::Module(module))
    }

    /// What `name` means in `module`; `None` if nothing there is called so, and `Some(None)` if it is of
    /// another crate.
    fn name_in(
        &self,
        module: &[String],
        name: &str,
        is_last: bool,
        steps: usize,
    ) -> Option<Option<Place<'_>>> {
        // Imports in a circle, which the compiler would refuse.
        let steps = Some(steps + 1).filter(|steps| *steps < 20)?;
        let here = self.0.get(module)?;
        let child = [module, &[name.to_owned()]].concat();
        let child = || self.0.contains_key(&child).then(|| Some(Place::Module(child.clone())));
        if !is_last && let Some(child) = child() {
            return Some(child);
        }
        if here.defined.contains(name) {
            return Some(Some(Place::Item(&here.file)));
        }
        if let Some(import) = here.imports.iter().find(|import| import.name == name) {
            return Some(self.resolve_in(module, &import.path, steps));
        }
        if let Some(child) = child() {
            return Some(child);
        }
        let all = here.imports.iter().filter(|import| import.name == "*");
        all.filter_map(|all| match self.resolve_in(module, &all.path, steps)? {
            Place::Module(of) => self.name_in(&of, name, is_last, steps),
            Place::Item(_) => None,
        })
        .next()
    }
}

#[test]
fn the_files_of_a_room_use_each_other_one_way() {
    let uses = crates().iter().flat_map(|folder| uses_of_files(&sources_below(folder))).collect();
    none(
        unknown(&uses, &KNOWN),
        "files that use each other in a circle; move what both need into a file of its own, or to the one that \
         the other uses anyway",
    );
}

/// Files of a crate by their names.
fn made_up(files: &[(&str, &str)]) -> Vec<Source> {
    let made = |(name, text): &(&str, &str)| source(&format!("crates/made_up/src/{name}.rs"), text);
    files.iter().map(made).collect()
}

#[test]
fn circles_are_caught_and_stairs_are_not() {
    let circles = |files: [(&str, &str); 4]| described(&uses_of_rooms(&made_up(&files)));
    let ways = [
        "use crate::a::Kind;",
        "use crate::{b, a::Kind};",
        "fn f() { crate::a::f() }",
        "use super::super::a::Kind;",
        "use super::super::Kind;",
        "fn f() { crate::Kind::f() }",
    ];
    for way in ways {
        let root = ("lib", "mod a; mod b; mod c; pub use a::{Kind, f};");
        let found =
            circles([root, ("a", "use super::b;"), ("b/mod", "use crate::c;"), ("c/d", way)]);
        assert_eq!(found.len(), 3, "{way}: {found:?}");
        let found = circles([root, ("a", ""), ("b/mod", "use crate::c;"), ("c/d", way)]);
        assert_eq!(found.len(), usize::from(way.contains("{b,")) * 2, "{way}: {found:?}");
    }
    let root = ("lib", "mod a; mod b; #[cfg(test)] use b::T;");
    let tests = "#[cfg(test)] mod tests { use crate::b; }";
    assert_eq!(
        circles([
            root,
            ("a", tests),
            ("b/c", "use super::a; use tertius_core::b;"),
            ("b/mod", "use crate::a;")
        ]),
        [] as [String; 0]
    );
}

#[test]
fn files_in_circles_are_caught_and_passing_on_is_not() {
    let found = |files: &[(&str, &str)]| described(&uses_of_files(&made_up(files))).len();
    let between = |way: &str| {
        found(&[
            ("lib", "mod a; mod b; pub use a::y::Y;"),
            ("a/mod", "mod f; mod x; mod y; pub use x::X; pub use y::{Y as Other, Y, f};"),
            ("a/f", ""),
            ("a/x", &format!("pub struct X; {way}")),
            ("a/y", "use super::{X}; pub struct Y; pub fn f() {}"),
            ("b", "pub use super::a::*; pub fn f() {}"),
        ])
    };
    for way in [
        "use super::y::Y;",
        "use super::Y;",
        "use super::Other as Another;",
        "use crate::{b, a::{self, Y}};",
        "use crate::Y;",
        "use crate::b::Y;",
        "fn g() { super::y::f() }",
        "fn g() { crate::a::f() }",
        "use super::y; fn g() { y::f() }",
        "use super::y as z; fn g() { 0..z::f() }",
        "use super::y::*; fn g() { f() }",
        "fn g() -> impl Fn() + use<'a> { super::y::f() }",
        "mod inner { fn g() -> crate::Y { } }",
        "use super::f;",
        "pub use super::f; fn g() { f() }",
        // By a macro.
        "fn g() { super::y::made() }",
    ] {
        assert_eq!(between(way), 2, "{way}");
    }
    for way in [
        "",
        "use super::y;",
        "pub use super::y::f; fn g() { x.f() }",
        "use tertius_core::a::Y; // super::Y",
        "use crate::b::f;",
        "#[cfg(test)] mod tests { use crate::a::Y; }",
    ] {
        assert_eq!(between(way), 0, "{way}");
    }
}

#[test]
fn a_parent_may_pass_on_what_its_children_define_but_not_use_it_if_they_use_the_parent() {
    let found = |parent: &str, child: &str, name: &str| {
        let parent = format!("mod x; #[cfg(test)] mod tests; {parent}");
        let files = [("lib", "mod a;"), ("a/mod", &*parent), (name, child)];
        described(&uses_of_files(&made_up(&files))).len()
    };
    let uses_it = "use super::P; pub struct X(P);";
    for parent in ["use x::X;", "pub use x::X; fn f() -> X {}", "fn f() { x::X::new() }"] {
        let parent = format!("pub struct P; {parent}");
        assert_eq!(found(&parent, uses_it, "a/x"), 2, "{parent}");
        assert_eq!(found(&parent, uses_it, "a/tests"), 0, "{parent}");
        assert_eq!(found(&parent, "pub struct X;", "a/x"), 0, "{parent}");
    }
    assert_eq!(found("pub struct P; pub use x::X; fn f() { a.X() }", uses_it, "a/x"), 0);
    assert_eq!(found("pub struct P; pub use x::x;", "use super::P; pub fn x() {}", "a/x"), 0);
    // Files of tests are left out among themselves, too.
    let tests = [("a/tests/mod", "use x::X; pub struct P;"), ("a/tests/x", uses_it)];
    assert_eq!(described(&uses_of_files(&made_up(&tests))).len(), 0);
}

#[test]
fn methods_in_many_files_are_of_one_object() {
    let found = |parent: &str, child: &str, other: &str| {
        let parent = format!("mod x; mod y; {parent}");
        let child = format!("use super::P; {child}");
        let files = [("lib", "mod a;"), ("a/mod", &*parent), ("a/x", &child), ("a/y", other)];
        described(&uses_of_files(&made_up(&files))).len()
    };
    let method = "impl P { fn f(&self) {} }";
    let calls = "pub struct P; impl P { fn g(&self) { self.f() } }";
    for (parent, child, files) in [
        ("pub struct P;", method, 0),
        (calls, method, 2),
        ("pub struct P; impl P { fn g(&self) { Self::f(self) } }", method, 2),
        ("pub struct P; impl P { const A: u8 = P::B; }", "impl P { const B: u8 = 0; }", 2),
        ("pub struct P; fn g() { f() }", method, 0),
        ("pub struct P; impl P { fn g(&self) { self.p.f() } }", method, 0),
        ("pub struct P; impl P { fn g(&self) { self.f + 1 } }", method, 0),
        (calls, "impl<F: Fn() -> u8> P<F> where F: Copy { fn f() {} }", 2),
        (calls, "impl<const N: usize> P<N> { fn f() {} }", 2),
        (calls, "impl super::T for P { fn f() {} }", 0),
        (calls, "impl<F: for<'a> Fn(&'a u8)> Into<X> for P { fn f() {} }", 0),
        (calls, "pub struct X; impl X { fn f() -> P {} }", 0),
        (calls, "impl P {} made! { fn f() {} }", 0),
    ] {
        let parent = format!("pub trait T {{}} {parent}");
        assert_eq!(found(&parent, child, ""), files, "{parent} {child}");
    }
    let (x, y) = ("impl P { fn f() { Self::g() } }", "impl super::P { fn g() { super::P::f() } }");
    assert_eq!(found("pub struct P;", x, y), 2);
    assert_eq!(found("pub struct P;", x, "impl super::P { fn g() {} }"), 0);
    // What is of no such object may have names of its own.
    let x = format!("{method} use super::y::Y;");
    assert_eq!(found("pub struct P;", &x, "pub struct Y; impl Y { fn g() { self.f() } }"), 0);
}

#[test]
fn circles_that_are_known_only_become_fewer() {
    let room = |name: &str| {
        let names = ["x", "y"].map(|file| format!("src/{name}/{file}.rs"));
        let other = BTreeSet::from([names[1].clone()]);
        [(names[0].clone(), other), (names[1].clone(), BTreeSet::from([names[0].clone()]))]
    };
    let uses: Uses = room("a").into_iter().chain(room("b")).collect();
    let found = |known: &[(&str, usize)]| unknown(&uses, known).len();
    assert_eq!(found(&[("src/a", 2), ("src/b", 2)]), 0);
    assert_eq!(found(&[("src/a", 2)]), 2);
    assert_eq!(found(&[("src/a", 2), ("src/b", 1)]), 2);
    assert_eq!(found(&[("src/a", 2), ("src/b", 3)]), 1);
    assert_eq!(found(&[("src", 4), ("src/c", 2)]), 1);
}
