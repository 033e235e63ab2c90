//! What the tests of the package share with each other, with a benchmark and with an example: machines,
//! recordings, runs of the program, and the oracles in Python that its numbers are compared with.
//!
//! A helper of one test binary stays beside it, in `tests/`.

// Nobody makes them by chance, and nobody outside of this workspace sees them.
#![allow(clippy::new_without_default, clippy::should_implement_trait)]

pub mod bench;
pub mod broker;
pub mod candump;
pub mod certificates;
pub mod detection;
pub mod machine;
pub mod oracle;
pub mod page;
pub mod process;
pub mod support;
pub mod visits;

use std::path::Path;
use std::sync::LazyLock;

/// The top of the repository.
///
/// # Panics
/// Never: this crate lies two folders below it.
pub fn top() -> &'static Path {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).expect("this crate is two folders below it")
}

/// The path of the program under test.
///
/// # Panics
/// Outside of an integration test that Cargo runs: only Cargo knows where it has put the program.
pub fn program() -> &'static str {
    static PROGRAM: LazyLock<String> = LazyLock::new(|| {
        std::env::var("CARGO_BIN_EXE_tertius").expect("`cargo test` says where the program is")
    });
    &PROGRAM
}
