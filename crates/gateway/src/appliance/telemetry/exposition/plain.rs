//! The telemetry for clients that do not know OpenMetrics.

use std::fmt::Write as _;

/// Content type of [`plain`], for HTTP.
pub const PLAIN_CONTENT_TYPE: &str = "text/plain; version=0.0.4; charset=utf-8";

/// `text` of OpenMetrics in the older format of Prometheus, for clients that do not accept OpenMetrics: there is no
/// type *info*, counters are described by the name of their samples, and there are no units.
pub fn plain(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    let mut help = "";
    for line in text.lines() {
        let mut words = line.splitn(4, ' ');
        match [(); 4].map(|()| words.next().unwrap_or_default()) {
            ["#", "EOF" | "UNIT", ..] => {}
            // The type comes after it, and says how the family is called.
            ["#", "HELP", _, text] => help = text,
            ["#", "TYPE", name, kind] => {
                let (suffix, kind) = match kind {
                    "counter" => ("_total", kind),
                    "info" => ("_info", "gauge"),
                    _ => ("", kind),
                };
                _ = write!(plain, "# HELP {name}{suffix} {help}\n# TYPE {name}{suffix} {kind}\n");
            }
            _ => _ = writeln!(plain, "{line}"),
        }
    }
    plain
}
