//! The man pages and completions that a package brings, against what the program says of itself.

#[path = "../../examples/manual/commands.rs"]
pub mod commands;
#[path = "../../examples/manual/configuration.rs"]
pub mod configuration;
#[path = "../../examples/manual/roff.rs"]
pub mod roff;

use roff::Document;
use std::fs;
use std::process::Command;
use tertius_testing::support::{Scratch, tertius, top};

/// A page as it is read, without what only roff reads.
fn read(pages: &[Document], name: &str) -> String {
    let section = if name.ends_with(".toml") { 5 } else { 1 };
    let path = format!("share/man/man{section}/{name}.{section}");
    let page = pages.iter().find(|page| page.path == path);
    let page = page.unwrap_or_else(|| panic!("there is no {path}"));
    let text = String::from_utf8(page.text.clone()).expect("UTF-8");
    ["\\fB", "\\fI", "\\fR", "\\:", "\\&"]
        .iter()
        .fold(text, |text, font| text.replace(font, ""))
        .replace("\\-", "-")
}

/// The first word of each line that is indented by two spaces, below `title`.
fn listed(help: &str, title: &str) -> Vec<String> {
    let lines = help.lines().skip_while(|line| *line != title).skip(1);
    let lines = lines.take_while(|line| !line.is_empty());
    let names = lines.filter_map(|line| line.strip_prefix("  "));
    names
        .filter(|line| !line.starts_with(' '))
        .filter_map(|line| line.split_whitespace().next())
        .map(str::to_owned)
        .collect()
}

/// The long options that a help lists.
fn options(help: &str) -> Vec<&str> {
    let words = help.lines().filter_map(|line| {
        let line = line.trim_start();
        let line = line.strip_prefix("-h, ").or_else(|| line.strip_prefix("-V, ")).unwrap_or(line);
        line.starts_with("--").then(|| line.split_whitespace().next()).flatten()
    });
    words.collect()
}

#[test]
fn every_command_has_its_page_with_all_of_its_options() {
    let pages = commands::pages().expect("they are written");
    let help = tertius(&["--help"], b"").ok().stdout;
    let names = listed(&help, "Commands:");
    assert!(names.len() > 14, "{names:?}");
    for name in names.iter().filter(|name| *name != "help") {
        let page = read(&pages, &format!("tertius-{name}"));
        let help = tertius(&[name, "--help"], b"").ok().stdout;
        for option in options(&help) {
            assert!(
                page.contains(&format!("\n{option}")) || page.contains(&format!(", {option}")),
                "{name}: {option}"
            );
        }
        assert!(page.contains(&format!("tertius {name}")), "{name}: an example");
        let main = read(&pages, "tertius");
        assert!(main.contains(&format!("\ntertius-{name}(1)\n")), "tertius(1) lists {name}");
    }
    assert_eq!(pages.len(), names.len(), "help has no page, and the program has one");
}

#[test]
fn the_page_of_the_configuration_has_every_key_of_the_default_one() {
    let page = read(&[configuration::page()], "tertius.toml");
    let text = fs::read_to_string(top().join("config/e-type.toml")).expect("it is there");
    let default: toml::Table = text.parse().expect("it is TOML");
    let mut counted = 0;
    for (name, table) in default {
        let (_, section) = page
            .split_once(&format!("\n.SS \"[{name}]\"\n"))
            .or_else(|| page.split_once(&format!("\n.SS [{name}]\n")))
            .unwrap_or_else(|| panic!("no [{name}]"));
        let section = section.split("\n.SS").next().expect("it has a first part");
        for (key, value) in
            table.as_table().expect("a table").iter().filter(|(_, value)| !value.is_table())
        {
            assert!(section.contains(&format!("\n.TP\n{key}\n")), "[{name}] {key} = {value}");
            counted += 1;
        }
    }
    assert!(counted > 45, "{counted} keys");
}

#[test]
fn no_line_of_a_block_is_taken_for_a_request() {
    let mut page = roff::Page::new("a", "1");
    page.block(&[".nf", "'quoted' ~ \\n"]);
    page.paragraph(".hidden");
    let text = String::from_utf8(page.document("a", "1").text).expect("UTF-8");
    assert!(text.contains("\n\\&.nf\n\\(aqquoted\\(aq \\(ti \\en\n"), "{text}");
    assert!(text.contains("\n\\&.hidden\n"), "{text}");
}

/// What bash offers after `words`.
fn completed(file: &str, words: &[&str]) -> String {
    let script = format!(
        "source {file}; COMP_WORDS=(tertius {}); COMP_CWORD={}; _tertius tertius \"${{COMP_WORDS[-1]}}\" \"${{COMP_WORDS[-2]}}\"; \
         echo \"${{COMPREPLY[*]}}\"",
        words.join(" "),
        words.len()
    );
    let output = Command::new("bash").args(["--norc", "-c", &script]).output().expect("bash runs");
    String::from_utf8(output.stdout).expect("UTF-8").trim().to_owned()
}

#[test]
fn bash_completes_commands_options_and_values() {
    let scratch = Scratch::new();
    let completions = commands::completions();
    let of_bash = completions.iter().find(|file| file.path.contains("bash")).expect("it is there");
    let file = &scratch.write("tertius.bash", &of_bash.text);
    assert_eq!(completed(file, &["com"]), "commission");
    assert_eq!(completed(file, &["replay", "--resid"]), "--residuals");
    assert_eq!(completed(file, &["run", "--log", "j"]), "json journal");
}
