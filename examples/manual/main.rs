//! Writes the man pages and the completions of the program below a folder, as a package has them below `/usr`.
//!
//!     cargo run --locked --example manual -- FOLDER
//!
//! An example and not a command: whoever runs the program needs neither the code nor its dependencies.

mod commands;
mod configuration;
mod roff;

use std::error::Error;
use std::path::Path;
use std::{env, fs};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = env::args_os().nth(1).ok_or("no folder; usage: manual FOLDER")?;
    let mut documents = commands::pages()?;
    documents.extend(commands::completions());
    documents.push(configuration::page());
    for document in &documents {
        let path = Path::new(&folder).join(&document.path);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent)?;
        }
        fs::write(&path, &document.text).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    println!("{} files below {}", documents.len(), Path::new(&folder).display());
    Ok(())
}
