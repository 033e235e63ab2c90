//! Texts as fields of comma-separated values, and the names of cylinders beside their numbers.

use tertius_config::{MachineNames, visible_lines};
use tertius_core::alarm::status::MAX_CYLINDERS;

/// The column of cylinder numbers, behind which that of their names is.
const NUMBERS: &str = "cylinder";

/// A text as a field: quoted where it has to be, never a formula for a spreadsheet, and without effect on a terminal.
pub fn field(text: &str) -> String {
    let formula = text.starts_with(['=', '+', '-', '@', '\t', '\r']);
    let text = visible_lines(text);
    let text = if formula { format!("'{text}") } else { text.into_owned() };
    if text.contains(['"', ',', '\n', '\r', ';']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text
    }
}

/// The column `name` of a table of cylinders. A machine whose cylinders have no names has no such column.
#[derive(Clone, Debug)]
pub struct NameColumn(Option<[String; MAX_CYLINDERS]>);

impl NameColumn {
    /// The column for a machine with these `names`.
    pub fn new(names: &MachineNames) -> Self {
        let of = |index: usize| names.of_cylinder(index + 1);
        let is_named = (0..MAX_CYLINDERS).any(|index| of(index).is_some());
        let cell = |index| of(index).map_or_else(|| ",".to_owned(), |it| format!(",{}", field(it)));
        Self(is_named.then(|| std::array::from_fn(cell)))
    }

    /// The columns of a table with this one among them.
    pub fn among<'a>(&self, columns: impl IntoIterator<Item = &'a str>) -> String {
        let is_named = self.0.is_some();
        let with_name = |column| {
            let name = (is_named && column == NUMBERS).then_some("name");
            std::iter::once(column).chain(name)
        };
        columns.into_iter().flat_map(with_name).collect::<Vec<_>>().join(",")
    }

    /// What follows the number of a cylinder, from 1, in its row: the name behind a comma, or nothing. `None` is a row of none.
    pub fn after(&self, cylinder: Option<u8>) -> &str {
        let index = cylinder.map_or(MAX_CYLINDERS, |number| usize::from(number).wrapping_sub(1));
        self.0.as_ref().map_or("", |cells| cells.get(index).map_or(",", String::as_str))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_is_one_and_no_formula() {
        for (text, expected) in [
            ("plain", "plain"),
            ("a, b", "\"a, b\""),
            ("say \"no\"", "\"say \"\"no\"\"\""),
            ("=HYPERLINK(1)", "'=HYPERLINK(1)"),
            ("-1+1", "'-1+1"),
            ("@x, y", "\"'@x, y\""),
            ("line\nbreak", "\"line\nbreak\""),
            ("\u{1b}[2J\u{202e}", "\\u001b[2J\\u202e"),
        ] {
            assert_eq!(field(text), expected);
        }
    }

    #[test]
    fn a_name_is_behind_the_number_and_without_names_there_is_no_column() {
        let names = |text| serde_json::from_str::<MachineNames>(text).expect("names");
        let some = NameColumn::new(&names(r#"[{"name":"Fwd, Port"},{},{"name":"=Aft"}]"#));
        assert_eq!(some.among(["t", "cylinder", "r1"]), "t,cylinder,name,r1");
        let found =
            [Some(1), Some(2), Some(3), Some(6), None, Some(0), Some(9)].map(|n| some.after(n));
        assert_eq!(found, [",\"Fwd, Port\"", ",", ",'=Aft", ",", ",", ",", ","]);
        for text in ["[]", r#"[{"c1_name":"LT-101A"}]"#] {
            let none = NameColumn::new(&names(text));
            assert_eq!(none.among(["t", "cylinder"]), "t,cylinder");
            assert_eq!((none.after(Some(1)), none.after(None)), ("", ""));
        }
    }
}
