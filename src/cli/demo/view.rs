//! The scene as lines of at most 80 columns.

use super::scene::{FRAMES, Row, Scene, TOLD};
use crate::text::Millimetres;
use console::{Color, style};

/// Number of cells of a bar up to the limit; one more shows that it is crossed.
const CELLS: usize = 5;

/// Lines of the scene; `limits` are those of R1, R2 and R3, m.
pub fn lines(scene: &Scene, limits: [f64; 3]) -> Vec<String> {
    let mut lines = vec![heading(scene), header(limits)];
    for (index, row) in scene.rows.iter().enumerate() {
        let states = scene.status.states.get(index).cloned().unwrap_or_default();
        lines.push(cylinder(index + 1, row, &states, limits));
    }
    lines.extend(now(scene));
    lines.push(dim("what the gateway warns of"));
    fill(&mut lines, scene.warnings.iter().map(|line| coloured(line)).collect(), TOLD);
    lines.push(dim("frames of the gateway on the bus"));
    lines.push(scene.last_status.clone());
    fill(&mut lines, scene.frames.iter().cloned().collect(), FRAMES);
    lines
}

fn heading(scene: &Scene) -> String {
    let status = &scene.status;
    let blank = |name: &str| if name.is_empty() { "–".to_owned() } else { name.to_owned() };
    let (platform, mode) = (blank(&scene.platform), blank(&status.mode));
    let level = level(&blank(&status.level), 6);
    let active = status.active;
    format!(
        "{:7.2} s  platform {platform:<7}  gateway {mode:<10}  level {level}  warnings {active}",
        scene.now
    )
}

fn header(limits: [f64; 3]) -> String {
    let mut text = "  n    C1 mm state      C2 mm state  ".to_owned();
    for (which, limit) in limits.into_iter().enumerate() {
        text += &format!(" R{} of {:.2}", which + 1, Millimetres(limit));
    }
    dim(&text)
}

fn cylinder(n: usize, row: &Row, states: &[String; 2], limits: [f64; 3]) -> String {
    let mut line = format!("{n:>3}");
    for (reading, state) in row.readings.iter().zip(states) {
        let reading = reading.map_or("–".to_owned(), |metres| format!("{:+.1}", metres * 1e3));
        line += &format!(" {reading:>8} {}", health(state));
    }
    for (which, limit) in limits.into_iter().enumerate() {
        line += &residual(row.residual(which), limit);
    }
    line
}

/// A residual in 14 columns.
fn residual(residual: Option<f64>, limit: f64) -> String {
    let Some(residual) = residual else { return format!(" {:>6} {:6}", "–", "") };
    let millimetres = residual * 1e3;
    let number = match millimetres.abs() {
        0.0..100.0 => format!("{millimetres:+.2}"),
        _ => format!("{millimetres:+.0}"),
    };
    let ratio = residual.abs() / limit;
    let filled = if ratio > 1.0 { CELLS + 1 } else { (ratio * CELLS as f64).round() as usize };
    let bar = format!("{}{}", "█".repeat(filled), "·".repeat(CELLS + 1 - filled));
    let colour = if ratio > 1.0 { Color::Red } else { Color::Green };
    format!(" {number:>6} {}", style(bar).fg(colour))
}

/// Two lines: the present fault, and what to watch.
fn now(scene: &Scene) -> [String; 2] {
    let programme = &scene.programme;
    match scene.act() {
        Some((index, true)) => {
            let act = &programme.acts[index];
            [style(format!("now: {}", act.title)).bold().to_string(), act.hint.to_owned()]
        }
        Some((index, false)) => {
            let left = (programme.window(index)[0] - scene.now).ceil();
            let state = match (index, &*scene.platform) {
                (0, "engaged") => "the platform is engaged, its observers settle",
                (0, _) => "the platform comes up; this is played faster",
                _ => "that is over, and its warnings clear",
            };
            [state.to_owned(), dim(&format!("in {left:.0} s: {}", programme.acts[index].title))]
        }
        None => ["that was all".to_owned(), String::new()],
    }
}

fn fill(lines: &mut Vec<String>, mut told: Vec<String>, count: usize) {
    told.resize(count, String::new());
    lines.append(&mut told);
}

/// A line that begins with its time and its level, in colour.
fn coloured(line: &str) -> String {
    let (time, rest) = line.split_at_checked(10).unwrap_or(("", line));
    let (name, rest) = rest.split_at_checked(6).unwrap_or(("", rest));
    format!("{time}{}{rest}", level(name.trim_end(), 6))
}

fn level(name: &str, width: usize) -> String {
    let text = style(format!("{name:<width$}"));
    match name {
        "none" | "clear" => text.green(),
        "yellow" => text.yellow(),
        "orange" => text.color256(208),
        "red" => text.red(),
        "black" => text.bold().reverse(),
        _ => text,
    }
    .to_string()
}

fn health(state: &str) -> String {
    let text = style(format!("{state:<7}"));
    match state {
        "healthy" => text.green(),
        "suspect" => text.yellow(),
        "faulty" => text.red().bold(),
        _ => text.dim(),
    }
    .to_string()
}

fn dim(text: &str) -> String {
    style(text).dim().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::demo::listener::Status;
    use crate::cli::demo::programme::tests::programme;
    use crate::monitor::Record;
    use crate::sample::Quality;
    use console::measure_text_width;

    /// The widest and the emptiest possible scene.
    #[test]
    fn it_fits_a_terminal_of_80_columns_and_24_lines() {
        let limits = [1e-3, 1e-3, 1.5e-3];
        let beginning = || Scene::new(programme(6), 6);
        let empty = lines(&beginning(), limits);
        let mut scene = Scene { now: 9999.99, platform: "settled".to_owned(), ..beginning() };
        for cylinder in 1..=6 {
            scene.record(&Record {
                cylinder,
                c1: Some(-2.0556),
                c2: Some(2.0556),
                qualities: [Quality::Good; 2],
                residuals: [Some(-3.5), Some(0.09999), Some(0.0)],
                judged: [true; 2],
                monitored: true,
                ..Record::default()
            });
        }
        scene.status = Status {
            states: vec![["healthy", "unknown"].map(str::to_owned); 6],
            level: "orange".to_owned(),
            mode: "monitoring".to_owned(),
            active: 63,
        };
        let full = lines(&scene, limits);
        for lines in [empty, full] {
            assert!(lines.len() <= 20, "and the introduction's four");
            for line in &lines {
                assert!(measure_text_width(line) <= 80, "{line}");
            }
            let rows = &lines[1..8];
            assert!(rows.iter().all(|row| measure_text_width(row) == measure_text_width(&rows[0])));
        }
    }

    #[test]
    fn a_bar_is_full_at_the_limit_and_fuller_beyond() {
        let cells = |value: f64| residual(Some(value), 1e-3).matches('█').count();
        assert_eq!([0.0, 0.0005, 0.001, -0.00101, 0.5].map(cells), [0, 3, 5, 6, 6]);
        assert_eq!(residual(None, 1e-3).matches('█').count(), 0);
    }
}
