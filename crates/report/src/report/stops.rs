//! Readings on the mechanical stops and their trends, in numbers and words.

use serde::Serialize;
use tertius_config::MachineNames;
use tertius_core::sample::Transducer;
use tertius_core::sequential::{
    Blame, DriftLimits, DwellHistory, Forecast, Judgement, Trend, stops,
};
use tertius_core::text::Millimetres;

/// Histories of the cylinders that have one, and their common limits.
#[derive(Clone, Debug)]
pub struct Stops<'a> {
    pub stops: Vec<Stop<'a>>,
    pub limits: DriftLimits,
    /// How cylinders and transducers are called.
    pub names: &'a MachineNames,
}

/// Readings on the stop of one cylinder.
#[derive(Clone, Copy, Debug)]
pub struct Stop<'a> {
    /// Cylinder number, counted from 1.
    pub cylinder: u8,
    pub history: &'a DwellHistory,
    /// Judgement of the stops; `None` where too little was read.
    pub judgement: Option<Judgement>,
}

/// Columns of [`Stops::rows`], before those of the two limits.
const COLUMNS: [&str; 6] = ["cylinder", "transducer", "dwells", "within", "moved", "drift a month"];

const DAYS: f64 = 30.4375;

/// A transducer in the summary for scripts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrendLine {
    pub(super) cylinder: u8,
    /// Name of the cylinder, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) name: Option<String>,
    pub(super) transducer: &'static str,
    /// Name of the transducer, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) transducer_name: Option<String>,
    pub(super) dwells: usize,
    pub(super) months: f64,
    pub(super) moved_mm: f64,
    pub(super) mm_per_month: f64,
    pub(super) error_mm_per_month: f64,
    pub(super) months_until_maintenance: Option<Left>,
    pub(super) months_until_critical: Option<Left>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Left {
    pub(super) expected: f64,
    pub(super) earliest: f64,
    pub(super) latest: f64,
}

impl From<Forecast> for Left {
    fn from(Forecast { expected, earliest, latest }: Forecast) -> Self {
        Self { expected, earliest, latest }
    }
}

/// What a finding of an only transducer leaves open.
pub const OF_STOP: &str = "a stop that has worn by more than usual, or is dented, looks the same";

impl Stop<'_> {
    /// Transducers that were read, by their place.
    pub fn fitted(&self) -> impl Iterator<Item = usize> + use<> {
        let has_c2 = self.history.dwells().first().is_some_and(|it| it.readings.c2.is_some());
        0..1 + usize::from(has_c2)
    }

    /// Whether C1 is the only transducer, as far as was read.
    pub fn is_single(&self) -> bool {
        self.history.dwells().first().is_some_and(|it| it.readings.c2.is_none())
    }

    /// Trends of C1 and C2, where there are enough dwells.
    fn trends(&self) -> [Option<Trend>; 2] {
        [0, 1].map(|which| self.history.trend(which))
    }

    /// Forecast of when C1 (`which` 0) or C2 (1), which has that trend, will have moved by `limit`,
    /// m; `None` unless the stops name it.
    pub fn until(&self, which: usize, trend: &Trend, limit: f64) -> Option<Forecast> {
        self.judgement.filter(|judgement| judgement.names(which))?;
        trend.until(limit)
    }

    fn blame(&self) -> Blame {
        self.judgement.map_or(Blame::Neither, |judgement| judgement.blame)
    }
}

impl<'a> Stops<'a> {
    /// Judges `histories`, which have the numbers of their cylinders, of one machine.
    pub fn new(
        histories: Vec<(u8, &'a DwellHistory)>,
        limits: DriftLimits,
        names: &'a MachineNames,
    ) -> Self {
        let judged = stops::judge(histories.iter().map(|(_, history)| *history));
        let stop = |((cylinder, history), judgement)| Stop { cylinder, history, judgement };
        Self { stops: histories.into_iter().zip(judged).map(stop).collect(), limits, names }
    }

    /// Stops with readings.
    fn known(&self) -> impl Iterator<Item = &Stop<'a>> {
        self.stops.iter().filter(|stop| !stop.history.dwells().is_empty())
    }

    pub fn is_empty(&self) -> bool {
        self.known().next().is_none()
    }

    pub fn columns(&self) -> Vec<String> {
        let DriftLimits { maintenance, critical } = self.limits;
        let limits =
            [maintenance, critical].map(|limit| format!("until {}", Millimetres(limit).chosen()));
        COLUMNS.map(str::to_owned).into_iter().chain(limits).collect()
    }

    /// A row for each transducer that was read on its stop.
    pub fn rows(&self) -> Vec<Vec<String>> {
        let DriftLimits { maintenance, critical } = self.limits;
        let mut rows = Vec::new();
        for stop in self.known() {
            for (which, trend) in stop.fitted().map(|which| (which, stop.history.trend(which))) {
                let dwells = stop.history.dwells().len().to_string();
                let cylinder = self.names.short(stop.cylinder);
                let mut row = vec![cylinder, self.called(stop, which), dwells];
                row.extend(match trend {
                    Some(trend) => [
                        span(trend.months),
                        signed(trend.moved),
                        speed(&trend),
                        left(stop.until(which, &trend, maintenance)),
                        left(stop.until(which, &trend, critical)),
                    ],
                    None => ["–", "–", "–", "too few dwells", "–"].map(str::to_owned),
                });
                rows.push(row);
            }
        }
        rows
    }

    /// Verdict of the newest history, for people.
    pub fn verdict(&self) -> String {
        let drifts = |stop: &Stop<'_>| {
            let named = |which: &usize| stop.judgement.is_some_and(|it| it.names(*which));
            let named: Vec<String> =
                [0, 1].into_iter().filter(named).map(|which| self.called(stop, which)).collect();
            let whose = if stop.blame() == Blame::Undecided {
                "C1 or C2".to_owned()
            } else {
                named.join(" and ")
            };
            (!whose.is_empty())
                .then(|| format!("{whose} of {}", self.names.cylinder(stop.cylinder)))
        };
        let drifting: Vec<String> = self.known().filter_map(drifts).collect();
        let is_single =
            |stop: &Stop<'_>| stop.is_single() && stop.judgement.is_some_and(|it| it.names(0));
        let open = match self.known().any(is_single) {
            true => format!(" Where C1 is the only transducer, {OF_STOP}."),
            false => String::new(),
        };
        match (drifting.is_empty(), self.is_judged()) {
            (false, _) => format!("The stops show a drift: {}.{open}", drifting.join(", ")),
            (true, true) => "The stops show no drift.".to_owned(),
            (true, false) => "Too few readings on the stops to detect a drift.".to_owned(),
        }
    }

    fn called(&self, stop: &Stop<'_>, which: usize) -> String {
        self.names.transducer(stop.cylinder, Transducer::ALL[which])
    }

    /// Whether there are enough dwells to judge any cylinder.
    pub fn is_judged(&self) -> bool {
        self.known().any(|stop| stop.judgement.is_some())
    }

    /// Rows for scripts; a transducer with too few dwells is left out.
    pub fn lines(&self) -> Vec<TrendLine> {
        let DriftLimits { maintenance, critical } = self.limits;
        let line = |stop: &Stop<'_>, which: usize, trend: Trend| TrendLine {
            cylinder: stop.cylinder,
            name: self.names.of_cylinder(stop.cylinder).map(str::to_owned),
            transducer: Transducer::NAMES[which],
            transducer_name: self
                .names
                .of_transducer(stop.cylinder, Transducer::ALL[which])
                .map(str::to_owned),
            dwells: trend.dwells,
            months: trend.months,
            moved_mm: trend.moved * 1e3,
            mm_per_month: trend.per_month * 1e3,
            error_mm_per_month: trend.error * 1e3,
            months_until_maintenance: stop.until(which, &trend, maintenance).map(Left::from),
            months_until_critical: stop.until(which, &trend, critical).map(Left::from),
        };
        let mut lines = Vec::new();
        for stop in self.known() {
            let trends = stop.trends().into_iter().enumerate();
            lines.extend(trends.filter_map(|(which, trend)| Some(line(stop, which, trend?))));
        }
        lines
    }
}

/// A trend in a sentence; `limit` is the largest move of the reading, m, and `until` when it will
/// have happened.
pub fn sentence(trend: &Trend, limit: f64, until: Option<Forecast>) -> String {
    match until {
        Some(forecast) => {
            let in_time = if forecast.expected > 0.0 { "in " } else { "" };
            format!(
                "{} a month; {} {in_time}{}",
                speed(trend),
                Millimetres(limit).chosen(),
                left(until)
            )
        }
        None => format!("no drift seen ({} a month)", speed(trend)),
    }
}

fn speed(trend: &Trend) -> String {
    format!("{:+.3} ± {:.3} mm", unsigned_zero(trend.per_month, 1e6), trend.error * 1e3)
}

fn left(until: Option<Forecast>) -> String {
    match until {
        None => "no drift seen".to_owned(),
        Some(Forecast { expected, .. }) if expected <= 0.0 => "reached".to_owned(),
        Some(Forecast { expected, earliest, latest }) => {
            let (unit, name) = unit(expected);
            format!(
                "{:.1} {name} ({:.1} to {:.1})",
                expected / unit,
                earliest / unit,
                latest / unit
            )
        }
    }
}

fn span(months: f64) -> String {
    let (unit, name) = unit(months);
    format!("{:.1} {name}", months / unit)
}

/// Unit for a time of `months`, in months.
fn unit(months: f64) -> (f64, &'static str) {
    [(12.0, "years"), (1.0, "months"), (1.0 / DAYS, "days")]
        .into_iter()
        .find(|(unit, _)| months >= 2.0 * unit)
        .unwrap_or((1.0 / (24.0 * DAYS), "hours"))
}

fn signed(metres: f64) -> String {
    format!("{:+.2} mm", unsigned_zero(metres, 1e5))
}

/// Metres as millimetres, rounded to parts of a metre; zero has no sign.
fn unsigned_zero(metres: f64, parts: f64) -> f64 {
    (metres * parts).round() / parts * 1e3 + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use tertius_core::sequential::{Dwell, StopReadings};
    use tertius_core::time::Timestamp;

    const LIMITS: DriftLimits = DriftLimits { maintenance: 5e-3, critical: 0.05 };

    /// A history with one dwell a day; C2 drifts by `drift` in a day, m.
    fn history(days: i64, drift: f64) -> DwellHistory {
        let mut history = DwellHistory::default();
        for day in 0..days {
            let at = Timestamp::from_nanos(day * 86_400_000_000_000);
            let scatter = 2e-5 * ((day * 5 % 3) as f64 - 1.0);
            let readings = [-1.4 + scatter, -1.39 + drift * day as f64];
            history.add(Dwell { at, readings: StopReadings::both(readings) });
        }
        history
    }

    #[test]
    fn a_drift_is_told_with_the_time_left() {
        let names = MachineNames::default();
        let (still, drifting) = (history(31, 0.0), history(31, -1e-4));
        let stops = Stops::new(vec![(2, &still), (3, &drifting)], LIMITS, &names);
        assert_eq!(stops.columns()[5..], ["drift a month", "until 5 mm", "until 50 mm"]);
        assert_eq!(stops.verdict(), "The stops show a drift: C2 of cylinder 3.");
        let rows = stops.rows();
        assert_eq!(rows.len(), 4);
        for row in &rows[..3] {
            assert_eq!(row[6..], ["no drift seen", "no drift seen"], "{row:?}");
        }
        let row = &rows[3];
        assert_eq!(row[..5], ["3", "C2", "31", "30.0 days", "-2.90 mm"], "{row:?}");
        assert!(row[5].starts_with("-3.044 ± 0.0"), "{row:?}");
        assert!(row[6].starts_with("21.0 days (20") && row[7].starts_with("15.5 months ("));
        let lines = stops.lines();
        assert_eq!(lines.len(), 4);
        let line = serde_json::to_value(&lines[3]).expect("numbers");
        assert_eq!((&line["cylinder"], &line["transducer"]), (&3.into(), &"c2".into()));
        let left = &line["months_until_maintenance"];
        let [earliest, expected, latest] =
            ["earliest", "expected", "latest"].map(|key| left[key].as_f64().expect("a number"));
        assert!(earliest < expected && expected < latest, "{left}");
        assert!((expected - 21.0 / 30.4375).abs() < 0.01, "{left}");
        let none = serde_json::to_value(&lines[0]).expect("numbers");
        assert!(none["months_until_maintenance"].is_null() && none["mm_per_month"].is_number());
    }

    /// A stop that wears looks the same, and the only transducer has nothing beside it.
    #[test]
    fn the_only_transducer_has_a_row_of_its_own_and_its_stop_is_not_forgotten() {
        let (names, still) = (MachineNames::default(), history(31, 0.0));
        let single = |drift: f64| {
            let mut history = DwellHistory::default();
            for day in 0..31 {
                let at = Timestamp::from_nanos(day * 86_400_000_000_000);
                let reading = -1.4 + drift * day as f64 + 2e-5 * ((day * 5 % 3) as f64 - 1.0);
                history.add(Dwell { at, readings: StopReadings::single(reading) });
            }
            history
        };
        let (sound, drifting) = (single(0.0), single(-1e-4));
        let stops = Stops::new(vec![(1, &still), (2, &sound), (3, &drifting)], LIMITS, &names);
        let rows = stops.rows();
        let whose: Vec<String> = rows.iter().map(|row| row[..2].join(" ")).collect();
        assert_eq!(whose, ["1 C1", "1 C2", "2 C1", "3 C1"]);
        assert_eq!(rows[2][6..], ["no drift seen", "no drift seen"]);
        assert!(rows[3][6].contains(" to "), "{:?}", rows[3]);
        assert_eq!(
            stops.verdict(),
            "The stops show a drift: C1 of cylinder 3. Where C1 is the only transducer, a stop that has worn by more than \
             usual, or is dented, looks the same."
        );
        assert_eq!(stops.lines().len(), 4);
    }

    #[test]
    fn of_few_dwells_nothing_is_claimed() {
        let (none, few) = (DwellHistory::default(), history(2, 1e-3));
        let names = MachineNames::default();
        let stops = Stops::new(vec![(1, &none)], LIMITS, &names);
        assert!(stops.is_empty());
        let stops = Stops::new(vec![(1, &none), (2, &few)], LIMITS, &names);
        assert_eq!(stops.lines(), []);
        assert_eq!(stops.rows()[0][..], ["2", "C1", "2", "–", "–", "–", "too few dwells", "–"]);
        assert_eq!(stops.rows().len(), 2);
        assert!(stops.verdict().contains("Too few readings on the stops"));
    }
}
