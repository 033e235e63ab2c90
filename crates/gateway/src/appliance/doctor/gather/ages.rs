//! How old program, configuration and gateway are.

use super::super::facts::Ages;
use super::super::kernel::running;
use super::computer::uptime;
use std::fs;
use std::path::{Path, PathBuf};
use tertius_core::time::Span;

/// The ages, of a configuration that is read from these `files`, and of the process of its gateway.
pub(super) fn of(files: &[PathBuf], gateway: Option<u32>) -> Ages {
    let age = |path: &Path| {
        let changed = fs::metadata(path).and_then(|it| it.modified()).ok()?;
        changed.elapsed().ok().map(|age| Span::from_seconds(age.as_secs_f64()))
    };
    let of_process = |name: &str| gateway.map(|process| format!("/proc/{process}/{name}"));
    let read = |path: String| fs::read_to_string(path).ok();
    let stat = of_process("stat").and_then(read);
    let program = of_process("exe").and_then(|path| fs::read_link(path).ok());
    Ages {
        program: std::env::current_exe().ok().and_then(|path| age(&path)),
        configuration: files.iter().filter_map(|path| age(path)).min(),
        gateway: stat.and_then(|stat| running(&stat, uptime()?)),
        is_replaced: program.is_some_and(|path| path.to_string_lossy().ends_with(" (deleted)")),
    }
}
