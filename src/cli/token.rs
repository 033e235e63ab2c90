//! `tertius token`: a token for those who act on alarms.

use super::Failure;
use crate::appliance::http::TokenDigest;
use clap::Args;
use std::fs::File;
use std::io::Read;

/// Makes a random token for acts on the page (acknowledge, shelve), and the digest that the configuration keeps
/// of it.
#[derive(Args, Debug)]
#[command(after_help = "Example:
  tertius token")]
pub struct Token {}

impl Token {
    /// Runs the command.
    ///
    /// # Errors
    /// The system has no random numbers.
    pub fn run(self) -> Result<(), Failure> {
        let mut bytes = [0; TokenDigest::TOKEN_BYTES];
        let read = File::open("/dev/urandom").and_then(|mut file| file.read_exact(&mut bytes));
        read.map_err(|error| Failure::Failed(format!("/dev/urandom: {error}")))?;
        let token: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        println!("token, to be told to those who may act; it is kept nowhere:\n\n  {token}\n");
        println!("its digest, for the configuration of the gateway; then reload it:\n");
        println!("[http]\ntoken = \"{}\"", TokenDigest::of(&token));
        Ok(())
    }
}
