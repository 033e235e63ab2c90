//! Configurations: what is read, and what is refused in which words.

mod buses;
mod common;
mod design;
mod documents;
mod files;
mod keys;
mod names;
mod overrides;
mod properties;
mod reading;
mod schema;
mod second;
mod values;
