//! Tables of the last transducers.

use super::{percent, rate, seconds, suspects};
use crate::report::sheet::{Section, Sheet};
use tertius_lab::evaluate::WITHIN;
use tertius_lab::evaluate::last::{LastFigures, LastResult};

/// What was found of the last transducers, and the false alarms.
pub fn sections(result: &LastResult) -> [Section; 2] {
    let mut header = ["transducers", "other one", "controller", "fault", "faults"].to_vec();
    let within = WITHIN.map(|seconds| format!("{seconds} s"));
    header.extend(within.iter().map(String::as_str));
    header.extend(["median", "named", "wrong (median, maximum)", "longer than found"]);
    let mut sheet = Sheet::new(&header);
    for figures in &result.faults {
        let LastFigures { grade, outage, in_loop, label, faults, found, delay, .. } = figures;
        let LastFigures { named, wrong: [median, most], outlasted, .. } = figures;
        let mut cells = vec![(*grade).to_owned(), (*outage).to_owned()];
        cells.push(if *in_loop { "reads it" } else { "does not" }.to_owned());
        cells.extend([label.clone(), faults.to_string()]);
        cells.extend(found.iter().map(|found| percent(&found.found)));
        cells.extend([
            seconds(delay.median),
            suspects(named),
            format!("{median:.2} s, {most:.2} s"),
            outlasted.count.to_string(),
        ]);
        sheet.add_row(cells);
    }
    let faults = sheet.about(
        "faults of a cylinder's last transducer: within how long it is named; faults of which a warning names it, stays \
         undecided, names the process or the other transducer; how long the estimate is valid and off by more than 3 σ, \
         and for how many faults longer than it takes to name the transducer",
    );
    let header =
        ["transducers", "other one", "hours", "last one named", "a year at most", "anything else"];
    let mut sheet = Sheet::new(&header);
    for hours in &result.hours {
        sheet.add_row([
            hours.grade.to_owned(),
            hours.outage.to_owned(),
            format!("{:.1}", hours.hours),
            hours.named.events.to_string(),
            rate(hours.named.at_most),
            hours.otherwise.events.to_string(),
        ]);
    }
    let hours = sheet.about(
        "false alarms of a cylinder with one transducer left, hours of one cylinder: warnings that name that \
         transducer, and those that name no transducer that it has or had",
    );
    [faults, hours]
}
