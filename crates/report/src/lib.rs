//! Results for people and scripts.
//!
//! - [`story`]: incidents and notices in words, which every output for people takes from here.
//! - `report`, with the feature `plots`: text, lines of JSON, tables of CSV, and pages of HTML with figures. With
//!   `parquet`: tables in Parquet files.

#[cfg(feature = "plots")]
pub mod report;
pub mod story;
