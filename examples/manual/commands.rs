//! A man page for each command, and completions of the shells, from what clap knows of them.

use super::roff::{Document, Page};
use clap::{Command, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;
use std::io;
use tertius::cli::Arguments;

const PROGRAM: &str = "tertius";

/// Where each shell looks for what a package brings.
const SHELLS: [(Shell, &str); 3] = [
    (Shell::Bash, "share/bash-completion/completions/tertius"),
    (Shell::Zsh, "share/zsh/vendor-completions/_tertius"),
    (Shell::Fish, "share/fish/vendor_completions.d/tertius.fish"),
];

const FILES: [(&str, &str); 4] = [
    (
        "/etc/tertius/machine.toml",
        "The configuration of the service, which does not start without it.",
    ),
    (
        "/etc/tertius/config, /etc/tertius/dbc",
        "The default configurations and their DBC, to begin from.",
    ),
    (
        "/var/lib/tertius",
        "The event store, the history of the stops and the recordings of the service.",
    ),
    ("/usr/share/doc/tertius", "Documentation, examples and licences."),
];

const EXITS: [(&str, &str); 3] = [
    ("0", "Done."),
    ("1", "It failed, or the result is not what was asked for; the message says why."),
    (
        "2",
        "The call or a file is wrong; the message says which file and line, and what was expected.",
    ),
];

/// The page of the program, and one of each command.
///
/// # Errors
/// Never: they are written into memory.
pub fn pages() -> io::Result<Vec<Document>> {
    let mut program = program();
    program.build();
    let commands = program.get_subcommands().filter(|command| !command.is_hide_set());
    let mut all = vec![page(&program, None)?];
    for command in commands {
        all.push(page(command, Some(&program))?);
    }
    Ok(all)
}

/// The completions of each shell.
pub fn completions() -> Vec<Document> {
    let of_shell = |(shell, path): (Shell, &str)| {
        let mut text = Vec::new();
        clap_complete::generate(shell, &mut program(), PROGRAM, &mut text);
        Document { path: path.to_owned(), text }
    };
    SHELLS.map(of_shell).into()
}

fn program() -> Command {
    Arguments::command().disable_help_subcommand(true)
}

fn page(command: &Command, parent: Option<&Command>) -> io::Result<Document> {
    let name = command.get_display_name().unwrap_or(command.get_name());
    let about = command.get_about().map(ToString::to_string).unwrap_or_default();
    let man = Man::new(command.clone());
    let part = |write: &dyn Fn(&mut dyn io::Write) -> io::Result<()>| {
        let mut text = Vec::new();
        write(&mut text)?;
        String::from_utf8(text).map_err(io::Error::other)
    };

    let mut page = Page::new(name, "1");
    page.heading("NAME");
    // What `apropos` lists is the first sentence.
    let first = about.split(". ").next().unwrap_or_default();
    page.roff(&format!("{} \\- {first}", name.replace('-', "\\-")));
    page.heading("SYNOPSIS");
    let usage = command.clone().render_usage().to_string();
    let call = usage.trim_start_matches("Usage:").trim();
    let bin = command.get_bin_name().unwrap_or(name);
    page.entry(bin, call.trim_start_matches(bin).trim(), "");
    page.roff(&part(&|to| man.render_description_section(to))?);
    page.roff(&part(&|to| man.render_options_section(to))?);
    if parent.is_none() {
        page.roff(&part(&|to| man.render_subcommands_section(to))?);
    }
    if let Some(text) = command.get_after_help() {
        after_help(&mut page, &text.to_string());
    }
    list(&mut page, "EXIT STATUS", &EXITS);
    list(&mut page, "FILES", &FILES);
    page.heading("SEE ALSO");
    page.paragraph(&see_also(parent.unwrap_or(command), name));
    Ok(page.document(name, "1"))
}

fn list(page: &mut Page, heading: &str, entries: &[(&str, &str)]) {
    page.heading(heading);
    for (name, what) in entries {
        page.entry(name, "", what);
    }
}

fn see_also(program: &Command, own: &str) -> String {
    let commands = program.get_subcommands().filter(|command| !command.is_hide_set());
    let names = commands.map(|command| format!("{PROGRAM}-{}", command.get_name()));
    let others = [PROGRAM.to_owned()].into_iter().chain(names).filter(|name| name != own);
    let mut pages: Vec<String> = others.map(|name| format!("{name}(1)")).collect();
    pages.push("tertius.toml(5)".to_owned());
    pages.join(", ")
}

/// What the help of a command says below its options: examples, lists of names, and prose.
fn after_help(page: &mut Page, text: &str) {
    let lines: Vec<&str> = text.lines().collect();
    let (mut prose, mut block) = (Vec::new(), Vec::new());
    for line in lines.into_iter().chain([""]) {
        let listed = line.strip_prefix("  ").and_then(|inner| inner.split_once("  "));
        let listed = listed.filter(|(name, _)| !name.is_empty() && !name.contains(' '));
        let is_indented = line.starts_with("  ") && listed.is_none();
        if !is_indented && !block.is_empty() {
            page.block(&block);
            block.clear();
        }
        let is_prose = !line.is_empty() && !line.starts_with("  ") && !is_title(line);
        if !is_prose && !prose.is_empty() {
            page.paragraph(&prose.join(" "));
            prose.clear();
        }
        match listed {
            Some((name, what)) => page.entry(name, "", what.trim()),
            None if is_title(line) => page.heading("EXAMPLES"),
            None if is_indented => block.push(&line[2..]),
            None if is_prose => prose.push(line),
            None => {}
        }
    }
}

fn is_title(line: &str) -> bool {
    matches!(line, "Example:" | "Examples:")
}
