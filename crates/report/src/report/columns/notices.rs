//! Notices as rows: the fields of their lines of JSON, and what they say in words.

use super::column::{Cells, TableColumn, TableRow, seconds};
use super::events::{columns, word};
use crate::report::notice::NoticeFields;
use crate::story;
use tertius_config::MachineNames;
use tertius_core::monitor::Notice;
use tertius_core::time::{Span, Timestamp};

/// An event other than a warning: a gap, a bus that is silent or lost, an observer that starts anew.
#[derive(Debug)]
pub struct NoticeRow {
    /// Time since the first frame of all.
    since: Span,
    /// Name of its cylinder.
    name: Option<String>,
    fields: NoticeFields,
    summary: String,
}

impl NoticeRow {
    /// The row of `notice`, of recordings whose first frame has the time stamp `begin`.
    pub fn new(begin: Timestamp, notice: &Notice, names: &MachineNames) -> Self {
        let fields = NoticeFields::from(notice);
        let summary = story::notice_line(notice, names);
        let name = fields.cylinder.and_then(|number| names.of_cylinder(number)).map(str::to_owned);
        Self { since: fields.at.since(begin), name, fields, summary }
    }
}

impl TableRow for NoticeRow {
    const TABLE: &'static str = "notices";

    const COLUMNS: &'static [TableColumn<Self>] = columns! {
        "timestamp", "ns since 1970, UTC", Time, "when it was", |it| Some(it.at());
        "t", "s", Number, "the same since the first frame of all", |it| seconds(it.since);
        "notice", "", Text, "what it is, as in the lines of JSON", |it| word(it.fields.notice);
        "seconds", "s", Number, "length of a gap; by how much the clock was set", |it| seconds(it.fields.seconds?);
        "bus", "", Text, "of several: first, second, third, fourth", |it| word(it.fields.bus?);
        "message", "", Text, "whose frames cannot be relied on: its identifier", |it| it.fields.message.clone().map(Into::into);
        "cylinder", "", Count, "from 1", |it| it.fields.cylinder.map(Into::into);
        "name", "", Text, "name of the cylinder, if it has one", |it| it.name.clone().map(Into::into);
        "detector", "", Text, "whose observer starts anew", |it| word(it.fields.detector?);
        "reason", "", Text, "why: gap, diverged, time_jump, interruption", |it| word(it.fields.reason?);
        "skew", "s", Number, "mean time by which C2 is sampled sooner than C1", |it| it.fields.skew;
        "jitter", "s", Number, "standard deviation of its random part", |it| it.fields.jitter;
        "device", "", Text, "c1, c2, valve", |it| word(it.fields.device?);
        "node", "", Count, "CANopen node that said it", |it| it.fields.node.map(Into::into);
        "state", "", Text, "which state it is in now", |it| word(it.fields.state?);
        "status", "", Text, "bits of a status that have no meaning in the configuration", |it| it.fields.status.clone().map(Into::into);
        "code", "", Text, "error code of an emergency", |it| it.fields.emergency.as_ref().map(|it| it.code.clone().into());
        "words", "", Text, "the code in words", |it| word(it.fields.emergency.as_ref()?.words);
        "register", "", Text, "error register", |it| it.fields.emergency.as_ref().map(|it| it.register.clone().into());
        "field", "", Text, "the maker's own bytes", |it| it.fields.emergency.as_ref().map(|it| it.field.clone().into());
        "summary", "", Text, "in words", |it| Some(it.summary.clone().into());
    };

    fn at(&self) -> Timestamp {
        self.fields.at
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::columns::column;
    use crate::report::jsonl;
    use serde_json::{Map, Value};
    use tertius_core::alarm::Detector;
    use tertius_core::frame::{BusNumber, Id};
    use tertius_core::observe::observer::Restart;
    use tertius_core::sample::device::{DeviceNews, DeviceState};
    use tertius_core::sample::dispute::Doubt;
    use tertius_core::sample::emergency::Emergency;
    use tertius_core::sample::{DeviceRole, Transducer};
    use tertius_core::sequential::Apart;

    /// All kinds of notices, some half a second apart.
    fn notices(at: Timestamp) -> Vec<Notice> {
        let second = BusNumber::Second;
        let reason = Restart::Diverged;
        let apart = Apart { mean: 0.0021, spread: 0.0007, ..Apart::default() };
        let emergency = Emergency { code: 0x8110, register: 0x11, detail: [1, 2, 3, 4, 0xFF] };
        let id = Id::standard(0x181).expect("11 bits");
        let device = |role, news| Notice::Device { at, cylinder: 2, role, node: 21, news };
        vec![
            Notice::Gap { at, length: Span::from_nanos(1_234_567_891) },
            Notice::TimeJump { at, by: Span::from_nanos(-7_000_000_001) },
            Notice::Interruption { at, bus: None },
            Notice::Interruption { at, bus: Some(second) },
            Notice::Silence { at, bus: second, silent: true },
            Notice::Silence { at, bus: BusNumber::First, silent: false },
            Notice::Doubt { at, id, bus: second, doubt: Doubt::Contradiction, is_over: false },
            Notice::Doubt { at, id, bus: second, doubt: Doubt::TooShort, is_over: true },
            Notice::Restart { at, cylinder: 3, detector: Detector::Fde2, reason },
            Notice::Timing { at, apart: Some(apart) },
            Notice::Timing { at, apart: None },
            Notice::UnnamedStatus { at, cylinder: 1, transducer: Transducer::C2, bits: 1 << 63 },
            device(DeviceRole::C1, DeviceNews::State(DeviceState::Stopped)),
            device(DeviceRole::Valve, DeviceNews::Network(emergency)),
        ]
    }

    #[test]
    fn rows_have_what_the_lines_have_and_say_it_in_words() {
        let begin = Timestamp::from_nanos(1_700_000_000_000_000_001);
        let at = begin.after(Span::from_nanos(500_000_000));
        let names = r#"[{"name":"FwdPort"},{"name":"FwdStbd"},{}]"#;
        let names: MachineNames = serde_json::from_str(names).expect("names");
        for notice in notices(at) {
            let mut line = Vec::new();
            jsonl::notice(&mut line, begin, &notice, &names).expect("it is memory");
            let mut line: Map<String, Value> = serde_json::from_slice(&line).expect("JSON");
            line.remove("type");
            line.insert("timestamp".to_owned(), at.as_nanos().into());
            let row = NoticeRow::new(begin, &notice, &names);
            let mut cells = column::cells(&row);
            let words = cells.remove("summary").expect("words");
            assert!(words.as_str().is_some_and(|it| it.len() > 10), "{words}");
            assert_eq!(cells, line);
        }
    }
}
