//! Two files of one machine teach the same whichever was recorded first.

use crate::yard::{Yard, moved, tertius};
use toml::{Table, Value};

/// Seconds of the files, of a calm and of a rough sea, and of the pause between them.
const LENGTHS: [i64; 2] = [140, 187];
const PAUSE: i64 = 30;

/// Part by which numbers may differ: sums are added up in another order.
const ROUNDING: f64 = 1e-6;

impl Yard {
    /// What both files teach: the tables, and what the commands said of them.
    fn taught(&self, name: &str, logs: [&str; 2]) -> Table {
        self.0.write(name, self.read("config.toml"));
        let config = self.path(name);
        for command in ["calibrate", "tune"] {
            let [one, other] = logs;
            tertius(&[command, one, other, "--config", &config, "--into", &config]).ok();
        }
        self.read(name).parse().expect("TOML")
    }
}

/// Keys whose numbers differ by more than rounding.
fn apart(key: &str, one: &Value, other: &Value) -> Vec<String> {
    match (one, other) {
        (Value::Table(one), Value::Table(other)) => {
            assert!(one.keys().eq(other.keys()), "{key}: {one} {other}");
            one.iter().flat_map(|(k, it)| apart(&format!("{key}.{k}"), it, &other[k])).collect()
        }
        (Value::Array(one), Value::Array(other)) => {
            assert_eq!(one.len(), other.len(), "{key}");
            let both = one.iter().zip(other).enumerate();
            both.flat_map(|(k, (one, other))| apart(&format!("{key}[{k}]"), one, other)).collect()
        }
        (Value::Float(one), Value::Float(other)) => {
            let same = (one - other).abs() <= ROUNDING * one.abs().max(other.abs()).max(1e-9);
            (!same).then(|| format!("{key}: {one} {other}")).into_iter().collect()
        }
        _ => (one != other).then(|| format!("{key}: {one} {other}")).into_iter().collect(),
    }
}

#[test]
fn what_two_files_teach_does_not_depend_on_which_was_recorded_first() {
    let yard = Yard::new();
    let seas = [["1.2,6.5", "5"], ["2.5,8", "6"]];
    let record = |which: usize| {
        let name = format!("sea-{which}.log");
        yard.simulate(&name, seas[which], LENGTHS[which], &[]);
        name
    };
    let files = [record(0), record(1)];
    let later = |which: usize| {
        let text = moved(&yard.read(&files[which]), LENGTHS[1 - which] + PAUSE);
        yard.0.write(&format!("later-{which}.log"), text)
    };
    let first = files.each_ref().map(|name| yard.path(name));
    let second = [later(0), later(1)];
    let calm_first = yard.taught("calm-first.toml", [&first[0], &second[1]]);
    let rough_first = yard.taught("rough-first.toml", [&first[1], &second[0]]);
    assert!(calm_first["cylinder"].as_array().is_some_and(|it| it.len() == 6));
    let apart = apart("", &Value::Table(calm_first), &Value::Table(rough_first));
    assert!(apart.is_empty(), "{} keys:\n{}", apart.len(), apart.join("\n"));
}
