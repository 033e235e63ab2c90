//! What a source tells of the machine that it watches: the answers of the gateway's page, whoever gives them.

use crate::appliance::telemetry::feed::TrendRow;
use crate::appliance::telemetry::lamp::Lamp;
use crate::appliance::telemetry::trend::QUANTITIES;
use crate::config::{MachineNames, visible};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// Watches a machine.
pub trait NewsSource: Send {
    /// What is watched, for people: `can0`, `http://127.0.0.1:9481`.
    fn name(&self) -> String;

    /// Sends what is known, about twice a second, until `send` returns false, as no one listens any more.
    fn watch(&mut self, send: &mut dyn FnMut(News) -> bool);
}

/// What a source tells.
#[derive(Clone, Debug)]
pub enum News {
    /// What is monitored.
    Machine(WatchedMachine),
    /// How everything is now.
    Overview(WatchedOverview),
    /// The last minutes of the cylinder with this number, in the order of time.
    History(usize, Vec<Sizes>),
    /// The newest of the trends, of each cylinder in the order of time.
    Trends(Vec<Sizes>),
    /// Nothing is known any more, for this reason.
    Lost(String),
}

/// As `/api/machine` answers.
#[derive(Clone, Debug, Default, Deserialize)]
pub struct WatchedMachine {
    pub name: String,
    /// How its cylinders and transducers are called; a gateway leaves it out where they have no names.
    #[serde(default)]
    pub names: MachineNames,
    /// Of each cylinder, limits of R1, R2, R3 and of the measured difference, m; `None` where there is no such
    /// quantity.
    pub limits_m: Vec<Vec<Option<f64>>>,
}

/// As `/api/overview` answers.
#[derive(Clone, Debug, Default, Deserialize)]
pub struct WatchedOverview {
    /// The system's time there, s.
    pub time: f64,
    pub status: String,
    pub reason: String,
    pub mode: Option<String>,
    /// The platform's state, where it is told.
    #[serde(default)]
    pub platform: Option<String>,
    pub bus: String,
    pub controller: Option<String>,
    pub level: String,
    pub incidents: Vec<WatchedIncident>,
    pub seconds_since_frame: Option<f64>,
    pub cylinders: Vec<WatchedCylinder>,
}

#[derive(Clone, Debug, Default, Deserialize)]
pub struct WatchedIncident {
    pub number: u32,
    pub level: String,
    /// Time stamp of its first warning, s.
    pub begin: f64,
    pub summary: String,
}

#[derive(Clone, Debug, Default, Deserialize)]
pub struct WatchedCylinder {
    /// Counted from 1.
    pub number: usize,
    /// C1 and C2.
    pub transducers: [WatchedTransducer; 2],
    pub residuals_mm: [Option<f64>; 3],
    pub estimate_m: Option<f64>,
    pub sigma_mm: Option<f64>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct WatchedTransducer {
    pub lamp: Lamp,
    /// Words for the lamp, with the reason.
    pub words: String,
    pub drift_mm_per_month: Option<f64>,
    pub error_mm_per_month: Option<f64>,
    /// Months until maintenance is due: expected, earliest, latest.
    pub months_left: [Option<f64>; 3],
}

impl Default for WatchedTransducer {
    fn default() -> Self {
        let words = Lamp::Unknown.words().to_owned();
        let (drift_mm_per_month, error_mm_per_month) = (None, None);
        Self {
            lamp: Lamp::Unknown,
            words,
            drift_mm_per_month,
            error_mm_per_month,
            months_left: [None; 3],
        }
    }
}

/// The largest |R1|, |R2| and |R3| of a cylinder in one bin of the trend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizes {
    /// Cylinder number, counted from 1.
    pub cylinder: usize,
    /// Begin of the bin, s.
    pub time: f64,
    /// |R1|, |R2| and |R3|, m; `None` where they were not judged.
    pub residuals: [Option<f64>; 3],
}

/// As `/api/trend/CYLINDER` answers.
#[derive(Debug, Deserialize)]
struct TrendAnswer {
    time: Vec<f64>,
    quantities: Vec<TrendColumn>,
}

#[derive(Debug, Deserialize)]
struct TrendColumn {
    name: String,
    least: Vec<Option<f64>>,
    largest: Vec<Option<f64>>,
}

impl News {
    /// The event `name` of the stream with its `data`; `None` for one that is not known.
    ///
    /// # Errors
    /// The data are not what they should be.
    pub fn event(name: &str, data: &str) -> serde_json::Result<Option<Self>> {
        Ok(match name {
            "overview" => told::<Option<_>>(data.as_bytes())?.map(Self::Overview),
            "bins" => {
                let rows: Option<Vec<TrendRow>> = serde_json::from_str(data)?;
                let sizes = |(cylinder, time, values): TrendRow| sizes(cylinder, time, &values);
                rows.map(|rows| Self::Trends(rows.into_iter().map(sizes).collect()))
            }
            "machine" => Some(Self::Machine(told(data.as_bytes())?)),
            _ => None,
        })
    }

    /// The trend of `cylinder`, from the answer `data`.
    ///
    /// # Errors
    /// The data are not what they should be.
    pub fn trend(cylinder: usize, data: &[u8]) -> serde_json::Result<Self> {
        let answer: TrendAnswer = serde_json::from_slice(data)?;
        let bin = |(index, time): (usize, &f64)| {
            let value = |name: &str| {
                let column = answer.quantities.iter().find(|column| column.name == name);
                let ends = column.map(|it| [&it.least, &it.largest]);
                let at = |values: &Vec<Option<f64>>| values.get(index).copied().flatten();
                largest(ends.map_or([None; 2], |ends| ends.map(at)))
            };
            Sizes { cylinder, time: *time, residuals: RESIDUALS.map(value) }
        };
        Ok(Self::History(cylinder, answer.time.iter().enumerate().map(bin).collect()))
    }
}

/// What `data` tells in JSON, where no text acts on a terminal.
///
/// # Errors
/// The data are not what they should be.
pub fn told<T: DeserializeOwned>(data: &[u8]) -> serde_json::Result<T> {
    let mut value = serde_json::from_slice(data)?;
    escape(&mut value);
    serde_json::from_value(value)
}

fn escape(value: &mut Value) {
    match value {
        Value::String(text) => *text = visible(text).into_owned(),
        Value::Array(all) => all.iter_mut().for_each(escape),
        Value::Object(fields) => fields.values_mut().for_each(escape),
        Value::Null | Value::Bool(_) | Value::Number(_) => {}
    }
}

const RESIDUALS: [&str; 3] = ["r1", "r2", "r3"];

/// The bin whose least and largest values are in `values`, quantity by quantity.
fn sizes(cylinder: usize, time: f64, values: &[Option<f64>]) -> Sizes {
    let value = |name| {
        let place = QUANTITIES.iter().position(|quantity| *quantity == name)?;
        let end = |which: usize| values.get(2 * place + which).copied().flatten();
        largest([end(0), end(1)])
    };
    Sizes { cylinder, time, residuals: RESIDUALS.map(value) }
}

fn largest(ends: [Option<f64>; 2]) -> Option<f64> {
    ends.into_iter().flatten().map(f64::abs).reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stream_and_the_answer_of_the_trend_tell_the_same() {
        let bins =
            "[[2,5.0,[1.0,1.1,1.0,1.1,-0.003,0.001,null,null,0.0,0.002,null,null,null,null]]]";
        let Ok(Some(News::Trends(streamed))) = News::event("bins", bins) else { panic!("bins") };
        let answer = r#"{"time":[5.0],"quantities":[
            {"name":"c1","least":[1.0],"largest":[1.1]},{"name":"r1","least":[-0.003],"largest":[0.001]},
            {"name":"r2","least":[null],"largest":[null]},{"name":"r3","least":[0.0],"largest":[0.002]}]}"#;
        let Ok(News::History(2, answered)) = News::trend(2, answer.as_bytes()) else {
            panic!("trend")
        };
        let residuals = [Some(0.003), None, Some(0.002)];
        assert_eq!(streamed, [Sizes { cylinder: 2, time: 5.0, residuals }]);
        assert_eq!(streamed, answered);
        assert!(News::event("bins", "[[1]]").is_err());
        assert!(matches!(News::event("of a later version", "?"), Ok(None)));
    }

    #[test]
    fn a_lamp_of_a_later_version_is_unknown() {
        assert_eq!(serde_json::from_str::<Lamp>("\"good\"").ok(), Some(Lamp::Good));
        assert_eq!(serde_json::from_str::<Lamp>("\"splendid\"").ok(), Some(Lamp::Unknown));
    }
}
