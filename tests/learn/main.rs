//! What is learnt from recordings, by the library and by the commands, and what it is worth.

mod a_type;
mod calibration;
mod commission;
mod commissioning;
mod evaluate;
mod foreign_machines;
mod identify;
mod identify_census;
mod identify_command;
mod identify_support;
mod in_place;
mod last;
mod lasting_step;
mod learned_configuration;
mod learning_support;
mod nonlinear;
mod order;
mod partly;
mod rates;
mod report_learning;
mod single;
mod tuning;
mod update;
mod valve;
mod yard;
