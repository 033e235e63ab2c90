//! Man pages as text for roff.

/// A file of a package.
pub struct Document {
    /// Where it belongs below `/usr`.
    pub path: String,
    pub text: Vec<u8>,
}

/// Characters of a word that do not fit beside an indentation.
const LONGEST_WORD: usize = 60;

/// A man page that is being written.
#[derive(Default)]
pub struct Page {
    text: String,
}

impl Page {
    /// An empty page of a section of the manual.
    pub fn new(name: &str, section: &str) -> Self {
        let mut page = Self::default();
        let version = env!("CARGO_PKG_VERSION");
        // Without a date, so that the same source gives the same bytes.
        let title = [name, section, "", &format!("tertius {version}"), "Tertius"];
        page.request("TH", &title.map(|text| format!("\"{}\"", words(text))).join(" "));
        page
    }

    pub fn heading(&mut self, text: &str) {
        self.request("SH", &words(text));
    }

    pub fn subheading(&mut self, text: &str) {
        self.request("SS", &words(text));
    }

    /// A paragraph of its own.
    pub fn paragraph(&mut self, text: &str) {
        self.request("PP", "");
        self.line(&words(text));
    }

    /// A name in bold, what follows it on its line, and its description, indented.
    pub fn entry(&mut self, name: &str, more: &str, what: &str) {
        self.request("TP", "");
        let more = if more.is_empty() { String::new() } else { format!(" {}", words(more)) };
        self.line(&format!("\\fB{}\\fR{more}", literal(name)));
        self.line(&words(what));
    }

    /// More of the description before it, on a line of its own.
    pub fn more(&mut self, text: &str) {
        self.request("br", "");
        self.line(&words(text));
    }

    /// Lines as they are, for example commands.
    pub fn block(&mut self, lines: &[&str]) {
        self.request("PP", "");
        self.request("RS", "4");
        self.request("nf", "");
        for line in lines {
            self.line(&literal(line));
        }
        self.request("fi", "");
        self.request("RE", "");
    }

    /// What is roff already.
    pub fn roff(&mut self, text: &str) {
        self.text += text;
        if !text.ends_with('\n') {
            self.text.push('\n');
        }
    }

    /// The page as the file of its section.
    pub fn document(self, name: &str, section: &str) -> Document {
        Document {
            path: format!("share/man/man{section}/{name}.{section}"),
            text: self.text.into_bytes(),
        }
    }

    fn request(&mut self, name: &str, arguments: &str) {
        self.roff(format!(".{name} {arguments}").trim_end());
    }

    fn line(&mut self, text: &str) {
        // A line that begins with one of these would be a request.
        let guard = if text.starts_with(['.', '\'']) { "\\&" } else { "" };
        self.roff(&format!("{guard}{text}"));
    }
}

/// Prose: options keep their hyphens, everything else is as it is read. A word that is longer than a line may be broken.
fn words(text: &str) -> String {
    let text = escaped(text).replace("--", "\\-\\-");
    let breakable = |word: &str| match word.chars().count() {
        0..LONGEST_WORD => word.to_owned(),
        _ => word
            .chars()
            .collect::<Vec<_>>()
            .chunks(16)
            .map(String::from_iter)
            .collect::<Vec<_>>()
            .join("\\:"),
    };
    text.split_whitespace().map(breakable).collect::<Vec<_>>().join(" ")
}

/// What may be copied into a shell or a file, so that no character may become a typographic one.
fn literal(text: &str) -> String {
    let text = escaped(text).replace('-', "\\-").replace('\'', "\\(aq");
    text.replace('`', "\\(ga").replace('^', "\\(ha").replace('~', "\\(ti")
}

fn escaped(text: &str) -> String {
    text.replace('\\', "\\e").replace('"', "\\(dq")
}
