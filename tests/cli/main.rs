//! The commands as people run them: their outputs, files and messages.

mod buses;
mod canopen;
mod canopen_story;
mod canopen_timers;
mod check_command;
mod cli_document;
#[cfg(feature = "parquet")]
mod columns;
mod convert;
mod coverage;
mod demo;
mod doctor;
mod dwell_history;
mod eds_command;
mod fleet;
mod fleet_run;
mod formats;
mod gateway_frames;
mod golden;
mod incidents;
mod init;
mod inject_cli;
mod inject_oracle;
mod machines;
mod manual;
mod output_files;
mod outputs_document;
mod overrides;
mod package;
mod replay_bad_input;
mod replay_identity;
mod report;
mod residuals;
mod schema;
mod simulate;
mod state;
