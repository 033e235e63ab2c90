//! The skeleton of a page: one file, without network or script, also valid as XML.

use super::drawing;
use super::escaping::escaped;
use super::figure::{Entry, Figure, Sample};
use crate::report::sheet::Section;
pub use crate::report::wording::capitalised;
use plotters::style::RGBColor;
use std::fmt::Write as _;

/// A figure and its caption.
pub type Captioned = (Figure, String);

/// Number of columns beyond which a table is written smaller.
const WIDE: usize = 10;

/// Content security policy: loads nothing and runs nothing, whatever names are in the page.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'";

const STYLE: &str = "
:root { color-scheme: light dark; --ink: #222; --paper: #fff; --line: #ccc; --faint: #eee; --quiet: #595959;
  --link: #00508c; --alarm: #fdecee; --good: #edf7ed; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e6e6; --paper: #161a1f; --line: #4a4f55; --faint: #2b3036; --quiet: #a8adb3;
    --link: #7cc0f5; --alarm: #3a1a20; --good: #17301b; }
  figure { background: #fff; color: #222; padding: .5rem; border-radius: 4px; }
}
body { margin: 0 auto; padding: 1.5rem 1rem 3rem; max-width: 960px; background: var(--paper); color: var(--ink);
  font: 14px/1.45 system-ui, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif; }
h1 { font-size: 1.5rem; margin: 0 0 .2rem; }
h2 { font-size: 1.15rem; margin: 2rem 0 .5rem; border-bottom: 1px solid var(--line); }
h3 { font-size: 1rem; margin: 1.4rem 0 .3rem; }
h4 { font-size: .95rem; margin: 1.1rem 0 .2rem; }
p { margin: .4rem 0; max-width: 52rem; }
.alarm { margin: .8rem 0; padding: .3rem .8rem; border-left: 5px solid #b00020; background: var(--alarm); }
.good { margin: .8rem 0; padding: .3rem .8rem; border-left: 5px solid #2e7d32; background: var(--good); }
a { color: var(--link); }
.contents { list-style: none; display: flex; flex-wrap: wrap; gap: .2rem 1.2rem; margin: .8rem 0; padding: 0; }
.incident { margin: 0 0 1.6rem; scroll-margin-top: 1rem; }
.incident:target h3 { outline: 2px solid var(--link); outline-offset: 3px; }
.back { font-size: 12px; }
.level { display: inline-block; padding: 0 .4em; border: 1px solid #222; border-radius: 3px; font-size: .85em;
  font-weight: 600; white-space: nowrap; background: #fff; color: #222; }
.level.yellow { background: #ffe27a; }
.level.orange { background: #ffb066; }
.level.red { background: #b00020; color: #fff; }
.level.black { background: #000; color: #fff; border-color: #888; }
summary { cursor: pointer; padding: .3rem 0; }
ul.lines { list-style: none; margin: .4rem 0; padding: 0; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; margin: .5rem 0; font-variant-numeric: tabular-nums; }
caption { text-align: left; padding: .2rem 0; }
th, td { padding: .15rem .7rem .15rem 0; text-align: left; white-space: nowrap; }
thead { border-bottom: 1px solid var(--line); }
tbody tr + tr { border-top: 1px solid var(--faint); }
.n { text-align: right; }
.wide { font-size: 12px; }
.wide th, .wide td { padding-right: .5rem; }
figure { box-sizing: border-box; margin: .6rem 0 1.2rem; break-inside: avoid; }
figure svg { display: block; max-width: 100%; height: auto; }
figure .title { margin: 0 0 .1rem; font-weight: 600; }
figcaption { font-size: 13px; padding-left: 76px; }
figcaption p { margin: .15rem 0; }
.pair { display: flex; flex-wrap: wrap; gap: 0 20px; }
.pair figure { width: 470px; max-width: 100%; }
.legend { list-style: none; display: flex; flex-wrap: wrap; gap: .1rem 1.1rem; margin: .1rem 0 .3rem;
  padding: 0 0 0 76px; font-size: 12px; }
.legend li { display: flex; align-items: center; gap: .35rem; }
.legend i { display: inline-block; box-sizing: border-box; width: 22px; }
.legend .line { height: 0; border-top: 2px solid; }
.legend .dot { width: 8px; height: 8px; border: 4px solid; border-radius: 50%; }
.legend .area { height: 10px; border-top: 10px solid; opacity: .5; }
.legend .upright { width: 0; height: 13px; border-left: 3px solid; opacity: .6; }
footer { margin-top: 2.5rem; color: var(--quiet); font-size: 12px; }
@media (max-width: 480px) {
  table { font-size: 12px; }
  th, td, .wide th, .wide td { padding-right: .35rem; }
}
@page { margin: 12mm; }
@media print {
  :root { --ink: #000; --paper: #fff; --line: #999; --faint: #ddd; --quiet: #444; --link: #000; --alarm: #fff; --good: #fff; }
  nav, .back { display: none; }
  body { padding: 0; max-width: none; font-size: 10pt; }
  h2, h3 { break-after: avoid; }
  tr { break-inside: avoid; }
  .scroll { overflow: visible; }
  table, .wide { font-size: 7.5pt; }
  .pair figure { width: 48%; }
}
";

/// A page that is being written.
#[derive(Clone, Debug)]
pub struct Page {
    command: &'static str,
    title: String,
    body: String,
    /// Sections: their anchors and their headings.
    sections: Vec<(String, String)>,
    /// Place of the list of contents in the body.
    contents: Option<usize>,
    /// Whether headings are those of a part, and not of the page.
    within: bool,
}

impl Page {
    /// An empty page by `command`, which the page names as its generator.
    pub fn new(command: &'static str, title: &str) -> Self {
        Self {
            command,
            title: title.to_owned(),
            body: String::new(),
            sections: Vec::new(),
            contents: None,
            within: false,
        }
    }

    /// Puts a list of the sections that follow here.
    pub fn contents(&mut self) {
        self.contents = Some(self.body.len());
    }

    /// Adds markup, in which every text is escaped.
    pub fn raw(&mut self, markup: &str) {
        self.body += markup;
    }

    /// Adds what most readers do not want to see, to be opened by `title`.
    pub fn folded(&mut self, title: &str, add: impl FnOnce(&mut Self)) {
        _ = writeln!(self.body, "<details>\n<summary>{}</summary>", escaped(title));
        add(self);
        self.body += "</details>\n";
    }

    /// Begins a section.
    pub fn heading(&mut self, text: &str) {
        if self.within {
            return self.element("h3", text);
        }
        self.anchored(text);
    }

    /// Begins a section of the page, with an anchor.
    fn anchored(&mut self, text: &str) {
        let word = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
        let anchor: String = text.chars().map(word).collect();
        _ = writeln!(self.body, "<h2 id=\"{anchor}\">{}</h2>", escaped(text));
        self.sections.push((anchor, text.to_owned()));
    }

    /// Begins a part of a section.
    pub fn subheading(&mut self, text: &str) {
        self.element(if self.within { "h4" } else { "h3" }, text);
    }

    /// Adds what would be a page of its own as a part of this one.
    pub fn part(&mut self, text: &str, add: impl FnOnce(&mut Self)) {
        self.anchored(text);
        let within = std::mem::replace(&mut self.within, true);
        add(self);
        self.within = within;
    }

    /// Adds a paragraph; nothing if `text` is empty.
    pub fn paragraph(&mut self, text: &str) {
        if !text.trim().is_empty() {
            self.element("p", text);
        }
    }

    /// Adds a text that must be read first, each line on a line of its own; nothing if `text` is
    /// empty.
    pub fn alarm(&mut self, text: &str) {
        if !text.trim().is_empty() {
            self.body += "<div class=\"alarm\" role=\"alert\">\n";
            self.lines(text);
            self.body += "</div>\n";
        }
    }

    /// Adds a text as [`Self::alarm`] does, where all is well.
    pub fn good(&mut self, text: &str) {
        self.body += "<div class=\"good\">\n";
        self.lines(text);
        self.body += "</div>\n";
    }

    /// Adds a verdict: whether all is well, and the sentence that says it.
    pub fn verdict(&mut self, (good, text): &(bool, String)) {
        if *good { self.good(text) } else { self.alarm(text) }
    }

    /// Adds each line of `text` on a line of its own, without empty ones.
    pub fn lines(&mut self, text: &str) {
        let lines: Vec<&str> =
            text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        if lines.is_empty() {
            return;
        }
        self.body += "<ul class=\"lines\">\n";
        for line in lines {
            self.element("li", line);
        }
        self.body += "</ul>\n";
    }

    /// Adds a table; nothing if it has no rows. Numbers are right-aligned.
    pub fn table<T: AsRef<str>>(&mut self, header: &[T], rows: &[Vec<String>]) {
        if rows.is_empty() {
            return;
        }
        let numeric = |column: usize| {
            rows.iter().filter_map(|row| row.get(column)).all(|cell| is_number(cell))
        };
        let classes: Vec<&str> = (0..header.len())
            .map(|column| if numeric(column) { " class=\"n\"" } else { "" })
            .collect();
        let row = |name: &str, cells: &mut dyn Iterator<Item = &str>| {
            let cells = cells.zip(classes.iter().chain(std::iter::repeat(&"")));
            cells.fold("<tr>".to_owned(), |mut line, (cell, class)| {
                _ = write!(line, "<{name}{class}>{}</{name}>", escaped(cell));
                line
            }) + "</tr>\n"
        };
        let wide = if header.len() > WIDE { " class=\"wide\"" } else { "" };
        // Where it is wider than the screen it is scrolled, by keys too.
        let title = self.sections.last().map_or(self.title.as_str(), |(_, title)| title);
        let named = format!("role=\"group\" aria-label=\"{}\"", escaped(title));
        _ = write!(
            self.body,
            "<div class=\"scroll\" tabindex=\"0\" {named}><table{wide}>\n<thead>"
        );
        self.body += &row("th", &mut header.iter().map(AsRef::as_ref));
        self.body += "</thead>\n<tbody>\n";
        for cells in rows {
            self.body += &row("td", &mut cells.iter().map(String::as_str));
        }
        self.body += "</tbody></table></div>\n";
    }

    /// Adds a table with its introduction; nothing if it has no rows.
    pub fn section(&mut self, section: &Section) {
        if !section.sheet.rows.is_empty() {
            self.paragraph(&capitalised(&section.about));
            self.table(&section.sheet.header, &section.sheet.rows);
        }
    }

    /// Adds a figure under the first line of `caption`, with its legend and the other lines below.
    pub fn figure(&mut self, figure: &Figure, caption: &str) {
        let mut lines = caption.lines().filter(|line| !line.is_empty());
        let title = lines.next().unwrap_or_default();
        _ = writeln!(self.body, "<figure>\n<p class=\"title\">{}</p>", escaped(title));
        self.body += &drawing::svg(figure, title);
        self.body += &legend(&figure.legend());
        let notes: String = lines.map(|line| format!("<p>{}</p>\n", escaped(line))).collect();
        if !notes.is_empty() {
            _ = writeln!(self.body, "<figcaption>\n{notes}</figcaption>");
        }
        self.body += "</figure>\n";
    }

    /// Adds captioned figures beside each other, if there are any.
    pub fn captioned(&mut self, figures: &[Captioned]) {
        if !figures.is_empty() {
            self.figures(figures.iter().map(|(figure, caption)| (figure, caption.as_str())));
        }
    }

    /// Adds figures of half the width beside each other, two in a row.
    pub fn figures<'a>(&mut self, figures: impl IntoIterator<Item = (&'a Figure, &'a str)>) {
        self.body += "<div class=\"pair\">\n";
        for (figure, caption) in figures {
            self.figure(figure, caption);
        }
        self.body += "</div>\n";
    }

    /// Text of the whole file.
    pub fn finish(mut self) -> String {
        let title = escaped(&self.title);
        if let Some(place) = self.contents.filter(|_| self.sections.len() > 1) {
            self.body.insert_str(place, &contents(&self.sections));
        }
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\" xmlns=\"http://www.w3.org/1999/xhtml\">\n<head>\n\
             <meta charset=\"utf-8\"/>\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\"/>\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
             <meta name=\"generator\" content=\"tertius {} {}\"/>\n\
             <title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n{}</main>\n\
             <footer>tertius {}</footer>\n</body>\n</html>\n",
            env!("CARGO_PKG_VERSION"),
            self.command,
            self.body,
            env!("CARGO_PKG_VERSION")
        )
    }

    fn element(&mut self, name: &str, text: &str) {
        _ = writeln!(self.body, "<{name}>{}</{name}>", escaped(text));
    }
}

fn contents(sections: &[(String, String)]) -> String {
    let mut text = "<nav aria-label=\"Contents\"><ul class=\"contents\">\n".to_owned();
    for (anchor, title) in sections {
        _ = writeln!(text, "<li><a href=\"#{anchor}\">{}</a></li>", escaped(title));
    }
    text + "</ul></nav>\n"
}

fn legend(entries: &[Entry]) -> String {
    if entries.is_empty() {
        return String::new();
    }
    let mut text = "<ul class=\"legend\">".to_owned();
    for Entry { name, colour, sample } in entries {
        let class = match sample {
            Sample::Line => "line",
            Sample::Dot => "dot",
            Sample::Area => "area",
            Sample::Upright => "upright",
        };
        let RGBColor(r, g, b) = *colour;
        _ = write!(
            text,
            "<li><i class=\"{class}\" style=\"border-color:#{r:02x}{g:02x}{b:02x}\"></i>{}</li>",
            escaped(name)
        );
    }
    text + "</ul>\n"
}

/// Whether a cell is a number: it begins with a digit, after an optional sign, or stands for a
/// missing number.
fn is_number(cell: &str) -> bool {
    let cell = cell.trim_start_matches(['-', '−', '+', '±', ' ', '<', '>', '≥', '≤']);
    cell.is_empty() || matches!(cell, "–" | "?") || cell.starts_with(|c: char| c.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_begin_with_a_capital_and_symbols_stay() {
        assert_eq!(capitalised("learnt from all"), "Learnt from all");
        assert_eq!(capitalised("δ_h is 2 mm"), "δ_h is 2 mm");
        assert_eq!(capitalised(""), "");
    }

    #[test]
    fn nothing_that_is_said_becomes_markup() {
        let evil = "</title><script>alert('1')</script>\u{0}\u{1b}[2J&\"";
        let mut page = Page::new("replay", evil);
        page.heading(evil);
        page.paragraph(evil);
        page.lines(evil);
        page.table(&[evil], &[vec![evil.to_owned()]]);
        let html = page.finish();
        assert!(!html.contains("<script"), "{html}");
        let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
        let document = roxmltree::Document::parse_with_options(&html, options).expect("sound XML");
        let cell = document.descendants().find(|node| node.has_tag_name("td")).expect("a cell");
        assert!(cell.text().expect("text").starts_with("</title><script>alert('1')</script>"));
    }

    #[test]
    fn nothing_is_said_where_there_is_nothing() {
        let mut page = Page::new("replay", "Empty");
        let before = page.body.clone();
        page.paragraph(" ");
        page.lines("\n\n");
        page.table(&["a"], &[]);
        assert_eq!(page.body, before);
    }

    #[test]
    fn numbers_stand_at_the_right() {
        let mut page = Page::new("replay", "");
        let row = |cells: [&str; 3]| cells.map(str::to_owned).to_vec();
        page.table(
            &["name", "size", "mixed"],
            &[row(["C1", "−1.2 mm", "1"]), row(["C2", "–", "x"])],
        );
        assert!(page.body.contains("<th>name</th><th class=\"n\">size</th><th>mixed</th>"));
        assert!(page.body.contains("<td class=\"n\">−1.2 mm</td>"), "{}", page.body);
    }
}
