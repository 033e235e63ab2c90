//! Writes tables that a command has learnt into a configuration: values change in place, and
//! comments, order and everything else stay.

use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, TomlError, Value};

/// Start of the comment in which a command describes its tables, before its version and its name.
const BY: &str = "# By tertius ";

/// Start of a comment in the tables that applies only to a file of their own.
const OF_A_FILE: &str = "# Keys of [[cylinder]]";

/// The configuration `text` with `tables` in it. `[[cylinder]]` tables are matched by `n`. Keys in
/// `anew` that `tables` do not give are removed from those in `text`, as they would be out of date.
/// The comment with which `tables` begin, which tells their origin, goes to the end and replaces
/// the one that the same command has left there before.
///
/// # Errors
/// One of the two texts is not TOML.
pub fn put(text: &str, tables: &str, anew: &[&str]) -> Result<String, TomlError> {
    let mut document: DocumentMut = text.parse()?;
    let learnt: DocumentMut = tables.parse()?;
    if is_calibration(&learnt) {
        forget_supply(&mut document);
    }
    // A threshold that was learnt is one to judge by, whatever an earlier recording gave.
    for (table, threshold) in [("fde", "high"), ("comparator", "bound")] {
        if learnt.get(table).and_then(|it| it.get(threshold)).is_some() {
            switch_on(&mut document, table);
        }
    }
    for (key, item) in learnt.iter() {
        match item.as_array_of_tables().filter(|_| key == "cylinder") {
            Some(learnt) => put_cylinders(document.as_table_mut(), learnt),
            None => put_item(document.as_table_mut(), key, item),
        }
    }
    forget(&mut document, &learnt, anew);
    let trailing = document.trailing().as_str().unwrap_or_default();
    let trailing = signed(trailing, tables);
    document.set_trailing(trailing);
    Ok(document.to_string())
}

/// The configuration `text` without the table `key` of cylinder `n`.
///
/// # Errors
/// `text` is not TOML.
pub fn without(text: &str, n: u8, key: &str) -> Result<String, TomlError> {
    let mut document: DocumentMut = text.parse()?;
    let cylinders = document.get_mut("cylinder").and_then(Item::as_array_of_tables_mut);
    let of_n = |cylinder: &&mut Table| number(cylinder) == Some(i64::from(n));
    for cylinder in cylinders.into_iter().flat_map(ArrayOfTables::iter_mut).filter(of_n) {
        cylinder.remove(key);
    }
    Ok(document.to_string())
}

/// The configuration `text` without what a calibration has learnt of the supply.
///
/// # Errors
/// `text` is not TOML.
pub fn without_supply(text: &str) -> Result<String, TomlError> {
    let mut document: DocumentMut = text.parse()?;
    forget_supply(&mut document);
    Ok(document.to_string())
}

fn put_table(table: &mut Table, learnt: &Table) {
    for (key, item) in learnt {
        put_item(table, key, item);
    }
}

fn put_item(table: &mut Table, key: &str, learnt: &Item) {
    if let Some(inline) = table.get(key).and_then(Item::as_inline_table)
        && learnt.is_table()
    {
        let inline = inline.clone();
        table.insert(key, Item::Table(inline.into_table()));
    }
    match (table.get_mut(key), learnt) {
        (Some(Item::Table(old)), Item::Table(new)) => put_table(old, new),
        (Some(Item::Value(old)), Item::Value(new)) => {
            let decor = old.decor().clone();
            *old = new.clone();
            *old.decor_mut() = decor;
        }
        _ => {
            table.insert(key, unplaced(learnt));
        }
    }
}

/// `item` without its position in its source text; a value also without its comments.
fn unplaced(item: &Item) -> Item {
    match item {
        Item::Value(value) => {
            let mut value: Value = value.clone();
            value.decor_mut().clear();
            Item::Value(value)
        }
        Item::Table(table) => Item::Table(table_unplaced(table)),
        other => other.clone(),
    }
}

fn table_unplaced(table: &Table) -> Table {
    let mut fresh = Table::new();
    *fresh.decor_mut() = table.decor().clone();
    for (key, item) in table {
        fresh.insert(key, unplaced(item));
    }
    fresh
}

/// Whether `learnt` are the tables of a calibration.
fn is_calibration(learnt: &DocumentMut) -> bool {
    let cylinders = learnt.get("cylinder").and_then(Item::as_array_of_tables);
    let learnt =
        |cylinder: &Table| cylinder.contains_key("c2_gain") || cylinder.contains_key("process");
    cylinders.is_some_and(|all| all.iter().any(learnt))
}

/// Removes what an earlier calibration has learnt of the supply.
fn forget_supply(document: &mut DocumentMut) {
    if let Some(process) = document.get_mut("process").and_then(Item::as_table_like_mut) {
        process.remove("supply");
    }
}

/// Lets the detectors of `table` judge again; the comments at the switch stay.
fn switch_on(document: &mut DocumentMut, table: &str) {
    let table = document.get_mut(table).and_then(Item::as_table_like_mut);
    let switch = table.and_then(|it| it.get_mut("enabled")).and_then(Item::as_value_mut);
    if let Some(switch) = switch.filter(|it| it.as_bool() == Some(false)) {
        let decor = switch.decor().clone();
        *switch = Value::from(true);
        *switch.decor_mut() = decor;
    }
}

fn put_cylinders(root: &mut Table, learnt: &ArrayOfTables) {
    let cylinders = root
        .entry("cylinder")
        .or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new()))
        .as_array_of_tables_mut();
    // `cylinder = [{ … }]` is refused before anything is learnt: see `schema`.
    let Some(cylinders) = cylinders else { return };
    for new in learnt {
        let place = cylinders.iter().position(|old| number(old) == number(new));
        match place.and_then(|place| cylinders.get_mut(place)) {
            Some(old) => {
                if ["sequential", "c2_gain", "process"].iter().any(|key| new.contains_key(key)) {
                    // Their keys belong together, and are of one calibration with a and b of (5-20).
                    old.remove("sequential");
                    old.remove("process");
                }
                put_table(old, new);
            }
            None => cylinders.push(table_unplaced(new)),
        }
    }
}

fn number(cylinder: &Table) -> Option<i64> {
    cylinder.get("n").and_then(Item::as_integer)
}

/// Removes the keys `anew` of cylinders to which `learnt` gives none.
fn forget(document: &mut DocumentMut, learnt: &DocumentMut, anew: &[&str]) {
    let learnt = learnt.get("cylinder").and_then(Item::as_array_of_tables);
    let given = |n: Option<i64>, key: &str| {
        let mut of_n = learnt.into_iter().flatten().filter(|cylinder| number(cylinder) == n);
        of_n.any(|cylinder| cylinder.contains_key(key))
    };
    let cylinders = document.get_mut("cylinder").and_then(Item::as_array_of_tables_mut);
    for cylinder in cylinders.into_iter().flat_map(ArrayOfTables::iter_mut) {
        let n = number(cylinder);
        for key in anew.iter().filter(|key| !given(n, key)) {
            cylinder.remove(key);
        }
    }
}

/// The end of a configuration, with the origin of `tables`.
fn signed(trailing: &str, tables: &str) -> String {
    let comment: Vec<&str> = tables.lines().take_while(|line| line.starts_with('#')).collect();
    let by = comment.first().and_then(|line| command(line));
    let mut kept = Vec::new();
    let mut skipped = false;
    for line in trailing.lines() {
        match command(line) {
            Some(command) => skipped = Some(command) == by,
            None if !line.starts_with('#') => skipped = false,
            None => {}
        }
        // One empty line is between two of them.
        let doubled = line.is_empty() && kept.last().is_none_or(|last: &&str| last.is_empty());
        if !skipped && !doubled {
            kept.push(line);
        }
    }
    while kept.last().is_some_and(|last| last.is_empty()) {
        kept.pop();
    }
    let comment = comment.into_iter().filter(|line| !line.starts_with(OF_A_FILE));
    let mut text = String::new();
    let apart = (!kept.is_empty()).then_some("");
    for line in std::iter::once("").chain(kept).chain(apart).chain(comment) {
        text.push_str(line);
        text.push('\n');
    }
    text
}

/// The command that wrote the tables which begin with this line.
fn command(line: &str) -> Option<&str> {
    let (_, command) = line.strip_prefix(BY)?.split_once(' ')?;
    command.split([',', ' ']).next()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONFIGURATION: &str = "\
# The machine.
[comparator] # R3
bound = 1.5e-3 # m
critical = 0.05

[model]
theta = [1.0, 2.0]   # five in truth
# sample_time = 0.02

[[cylinder]]
n = 2
theta = [3.0]
# The crooked one.
c2_gain = 1.0

[cylinder.sequential]
old = 1
nodes = [1.0]

# The end.
";

    const TABLES: &str = "\
# By tertius 9.9.9 calibrate, for a machine.
# From a.log
# Keys of [[cylinder]] belong in that cylinder's table, if the file has one.

# what it means
[comparator]
bound = 0.002

[[cylinder]]
n = 1
c2_gain = 1.5

[cylinder.sequential]
nodes = [7.0]

[[cylinder]]
n = 2
c2_gain = 2.5

[cylinder.sequential]
nodes = [8.0]
";

    #[test]
    fn values_change_and_all_else_stays() {
        let expected = "\
# The machine.
[comparator] # R3
bound = 0.002 # m
critical = 0.05

[model]
theta = [1.0, 2.0]   # five in truth
# sample_time = 0.02

[[cylinder]]
n = 2
theta = [3.0]
# The crooked one.
c2_gain = 2.5

[cylinder.sequential]
nodes = [8.0]

[[cylinder]]
n = 1
c2_gain = 1.5

[cylinder.sequential]
nodes = [7.0]

# The end.

# By tertius 9.9.9 calibrate, for a machine.
# From a.log
";
        let once = put(CONFIGURATION, TABLES, &[]).expect("both are TOML");
        assert_eq!(once, expected);
        let newer = TABLES.replace("a.log", "b.log").replace("9.9.9", "10.0.0");
        let twice = put(&once, &newer, &[]).expect("both are TOML");
        assert_eq!(twice, expected.replace("a.log", "b.log").replace("9.9.9", "10.0.0"));
    }

    #[test]
    fn tables_that_a_new_calibration_does_not_give_are_removed() {
        let process = "[cylinder.process]\nsample_time = 0.02\n\n[cylinder.process.spool]\na = 1\n";
        let old = CONFIGURATION.replace("# The end.", &format!("{process}\n# The end."));
        let text = put(&old, TABLES, &[]).expect("both are TOML");
        assert_eq!(text, put(CONFIGURATION, TABLES, &[]).expect("both are TOML"));
        assert_eq!(without(&old, 2, "process").expect("it is TOML"), CONFIGURATION);
        let supply = "[process]\nlevel = 30.0\n\n[process.supply]\nreference = 230.0\n\n";
        let with = |supply: &str| CONFIGURATION.replace("[model]", &format!("{supply}[model]"));
        let (old, kept) = (with(supply), with("[process]\nlevel = 30.0\n\n"));
        assert_eq!(without_supply(&old).expect("it is TOML"), kept);
        let calibrated = put(&old, TABLES, &[]).expect("both are TOML");
        assert_eq!(calibrated, put(&kept, TABLES, &[]).expect("both are TOML"));
        let newer = format!("{TABLES}\n[process.supply]\nreference = 220.0\n");
        let calibrated = put(&old, &newer, &[]).expect("both are TOML");
        assert!(
            calibrated.contains("level = 30.0\n\n[process.supply]\nreference = 220.0\n"),
            "{calibrated}"
        );
        let tuned = put(&old, "[fde]\nhigh = 0.002\n", &[]).expect("both are TOML");
        assert!(tuned.contains("reference = 230.0"), "what it does not learn stays");
        assert_eq!(without(&old, 1, "process").expect("it is TOML"), old);
    }

    #[test]
    fn what_would_outlive_its_model_is_removed() {
        let model =
            "# By tertius 1 identify, for it.\n\n[model]\ntheta = [5.0]\nsample_time = 0.02\n";
        let text = put(CONFIGURATION, model, &["theta"]).expect("both are TOML");
        assert!(
            text.contains("theta = [5.0]   # five in truth\nsample_time = 0.02\n# sample_time")
        );
        assert!(!text.contains("[3.0]") && text.contains("c2_gain = 1.0"), "{text}");
        let other = put(&text, TABLES, &[]).expect("both are TOML");
        assert!(other.contains("# By tertius 1 identify, for it.\n\n# By tertius 9.9.9 calibrate"));
    }

    #[test]
    fn a_profile_of_another_line_does_not_stay() {
        let line = "[[cylinder]]\nn = 2\nc2_gain = 3.5\nc2_offset = 0.1\n";
        let text = put(CONFIGURATION, line, &[]).expect("both are TOML");
        assert!(text.contains("c2_gain = 3.5") && !text.contains("sequential"), "{text}");
        let model = "[[cylinder]]\nn = 2\ntheta = [5.0]\n";
        assert!(put(CONFIGURATION, model, &[]).expect("both are TOML").contains("nodes = [1.0]"));
    }

    #[test]
    fn a_detector_that_was_left_out_judges_again_where_a_threshold_of_it_is_learnt() {
        let off = "[fde]\nenabled = false\nhigh = 0.006\n\n[comparator]\nenabled = false\n";
        let tuned = put(off, "[fde]\nhigh = 0.002\n", &[]).expect("both are TOML");
        assert!(
            tuned.starts_with(
                "[fde]\nenabled = true\nhigh = 0.002\n\n[comparator]\nenabled = false\n"
            ),
            "{tuned}"
        );
        let calibrated = put(off, "[comparator]\nbound = 0.002\n", &[]).expect("both are TOML");
        assert!(calibrated.contains("[fde]\nenabled = false\n"), "{calibrated}");
        assert!(
            calibrated.contains("[comparator]\nenabled = true\nbound = 0.002\n"),
            "{calibrated}"
        );
    }

    #[test]
    fn tables_in_other_forms_are_found() {
        let text = "comparator.bound = 1.0\nfde = { low = 1.0, high = 2.0 } # both\n";
        let tables = "[comparator]\nbound = 3.0\n[fde]\nhigh = 4.0\n";
        let put = put(text, tables, &[]).expect("both are TOML");
        let value: toml::Table = put.parse().expect("it is TOML");
        assert_eq!(value["comparator"]["bound"].as_float(), Some(3.0), "{put}");
        assert_eq!(value["fde"]["high"].as_float(), Some(4.0), "{put}");
        assert_eq!(value["fde"]["low"].as_float(), Some(1.0), "{put}");
    }
}
