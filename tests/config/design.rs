//! What a configuration makes of the monitor.

use tertius::config::{self, design};
use tertius::dbc::{Database, text};
use tertius::sequential::wild::Outliers;

/// A table that says which share of wild samples it was made with goes by it, others by that of before.
#[test]
fn a_detector_allows_for_as_many_wild_samples_as_its_table() {
    let path = tertius_testing::top().join("tests/recordings/e-type-sequential.toml");
    let mut loaded = config::load(&path).expect("it is sound");
    let database = Database::parse(&text::from_bytes(&loaded.dbc_text)).expect("it is sound");
    let tables = loaded.settings.cylinder.iter_mut().filter_map(|it| it.sequential.as_mut());
    tables.take(1).for_each(|table| table.outlier_share = 0.003);
    let design = design::judging(&loaded.settings, &database).expect("they fit");
    let outliers = |place: usize| design.cylinders[place].sequential.as_ref().map(|it| it.outliers);
    assert_eq!(outliers(0), Some(Outliers { share: 0.003 }));
    assert_eq!(outliers(1), Some(Outliers::UNSAID));
}
