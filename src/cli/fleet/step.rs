//! One recording of one machine: the program itself, from the state before it to the state behind it.
//!
//! A step may be done any number of times: what it leaves takes its place by renaming, and its `.done` comes last.
//! `fleet/` does the same on a cluster, with files of the same names and content, and either goes on after the other.

use super::plan::MachinePlan;
use super::recordings::TimedRecording;
use crate::cli::Failure;
use serde::{Deserialize, Serialize};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read, Seek, SeekFrom};
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

/// Longest part of the program's words that is kept, its end, bytes.
const MOST_SAID: u64 = 2000;

/// Longest last line of a replay, bytes.
const MOST_SUMMARY: u64 = 1 << 20;

/// A recording of a machine, which is replayed.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    pub machine: &'a MachinePlan,
    /// Its place among the recordings of the machine, from 1.
    pub index: usize,
    pub recording: &'a TimedRecording,
}

/// What a result depends on, but for the program.
#[derive(Debug, Deserialize, PartialEq, Serialize)]
struct DoneOf {
    machine: String,
    index: usize,
    recording: String,
    configuration: String,
    bytes: u64,
    /// Time of the last change, ns since 1970.
    modified: i64,
}

/// A step that is done.
#[derive(Debug, Deserialize, Serialize)]
pub struct Done {
    of: DoneOf,
    exit: i32,
    said: String,
    attempts: u32,
    seconds: f64,
    /// Known only to `fleet/`.
    processor_seconds: Option<f64>,
    /// Of the recording, s.
    pub duration: f64,
    pub judged: bool,
    pub incidents: u64,
}

/// What of the last line of a replay is looked at.
#[derive(Deserialize)]
struct LastLine {
    r#type: String,
    frames: u64,
    duration: f64,
    judged: bool,
    incidents: u64,
}

impl Step<'_> {
    /// Does the step below the folder `output`, by the `program`, unless it is done.
    ///
    /// # Errors
    /// The call or the recording is wrong; the program failed; or what is there is of another recording.
    pub fn run(&self, output: &Path, program: &Path) -> Result<Done, Failure> {
        let folder = output.join("folded").join(&self.machine.name);
        fs::create_dir_all(&folder).map_err(|error| Failure::creating(&folder, &error))?;
        let of = self.identity().map_err(|error| self.failed(&error.to_string()))?;
        let mark = folder.join(format!("{}.done", name(self.index)));
        match known(&mark) {
            Ok(Some(done)) if done.of == of => Ok(done),
            Ok(None) => self.replay(output, &folder, program, of),
            Ok(Some(_)) => Err(self.anew(&mark, "it is of another recording or configuration")),
            Err(error) => Err(self.anew(&mark, &error.to_string())),
        }
    }

    fn identity(&self) -> io::Result<DoneOf> {
        let found = fs::metadata(&self.recording.path)?;
        Ok(DoneOf {
            machine: self.machine.name.clone(),
            index: self.index,
            recording: self.recording.path.display().to_string(),
            configuration: self.machine.configuration.clone(),
            bytes: found.len(),
            modified: found
                .mtime()
                .saturating_mul(1_000_000_000)
                .saturating_add(found.mtime_nsec()),
        })
    }

    /// Replays the recording in a folder of its own, and puts what that leaves in its place.
    fn replay(
        &self,
        output: &Path,
        folder: &Path,
        program: &Path,
        of: DoneOf,
    ) -> Result<Done, Failure> {
        let outside = |error: io::Error| self.failed(&error.to_string());
        let (name, before) = (name(self.index), name(self.index - 1));
        let prefix = format!(".{name}.");
        let scratch =
            tempfile::Builder::new().prefix(&prefix).tempdir_in(folder).map_err(outside)?;
        let own = |name: &str| scratch.path().join(name);
        let (state, lines) = (own("state"), own("lines"));
        let mut call = Command::new(program);
        let tables = cfg!(feature = "parquet");
        call.arg("replay").arg(&self.recording.path).args(self.machine.options(tables));
        copy(&folder.join(format!("{before}.state")), &state).map_err(outside)?;
        call.arg("--state").arg(&state);
        if let Some(history) = &self.machine.history {
            let newest = folder.join(format!("{before}.dwells"));
            let from = if self.index == 1 { history } else { &newest };
            copy(from, &own("dwells")).map_err(outside)?;
            call.arg("--history").arg(own("dwells"));
        }
        if tables {
            call.arg("--parquet").arg(output.join("columns"));
        }
        let seen = inode(&state);
        let began = Instant::now();
        let (exit, said) = called(call, &lines, &own("said")).map_err(outside)?;
        let seconds = began.elapsed().as_secs_f64();
        let summary = last_line(&lines).map_err(outside)?;
        // Where nothing was judged the exit code is 1, and the state was left all the same.
        let is_left = |it: &LastLine| exit == Some(0) || inode(&state) != seen || it.frames == 0;
        let summary = match (exit, summary) {
            (Some(0 | 1), Some(summary)) if is_left(&summary) => summary,
            (Some(code), _) => return Err(self.failed(&format!("exit code {code}: {said}"))),
            (None, _) => return Err(self.failed(&format!("the replay was killed: {said}"))),
        };
        let done = Done {
            of,
            exit: exit.unwrap_or_default(),
            said,
            attempts: 1,
            seconds,
            processor_seconds: None,
            duration: summary.duration,
            judged: summary.judged,
            incidents: summary.incidents,
        };
        let mut text = serde_json::to_string(&done).map_err(io::Error::other).map_err(outside)?;
        text.push('\n');
        fs::write(own("done"), text).map_err(outside)?;
        for (from, to) in
            [("lines", "jsonl"), ("dwells", "dwells"), ("state", "state"), ("done", "done")]
        {
            settle(&own(from), &folder.join(format!("{name}.{to}"))).map_err(outside)?;
        }
        sweep(folder, &before);
        Ok(done)
    }

    /// Why the recording is not done, for a person.
    fn failed(&self, why: &str) -> Failure {
        Failure::Failed(format!("{}: {why}", self.recording.path.display()))
    }

    fn anew(&self, mark: &Path, why: &str) -> Failure {
        let folder = mark.parent().unwrap_or(mark).display();
        self.failed(&format!(
            "{}: {why}; to begin the machine anew, delete {folder}",
            mark.display()
        ))
    }
}

/// Name of the files of the recording of `index`.
fn name(index: usize) -> String {
    format!("{index:06}")
}

/// What the file `mark` says of a step that is done; `None` where there is none.
fn known(mark: &Path) -> io::Result<Option<Done>> {
    match fs::read(mark) {
        Ok(text) => Ok(Some(serde_json::from_slice(&text)?)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

/// Runs `call`, with what it prints in the file `lines`; its exit code and the end of what it says.
fn called(mut call: Command, lines: &Path, said: &Path) -> io::Result<(Option<i32>, String)> {
    call.stdin(Stdio::null()).stdout(File::create(lines)?).stderr(File::create(said)?);
    let status = call.status()?;
    let said = String::from_utf8_lossy(&end(said, MOST_SAID)?).trim().to_owned();
    Ok((status.code(), said))
}

/// The summary, where the program came to its end.
fn last_line(lines: &Path) -> io::Result<Option<LastLine>> {
    let end = end(lines, MOST_SUMMARY)?;
    let last = end.trim_ascii_end().rsplit(|byte| *byte == b'\n').next().unwrap_or_default();
    let last: Option<LastLine> = serde_json::from_slice(last).ok();
    Ok(last.filter(|line| line.r#type == "summary"))
}

/// The last bytes of a file, at most `most`.
fn end(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut file = File::open(path)?;
    let length = file.seek(SeekFrom::End(0))?;
    file.seek(SeekFrom::Start(length.saturating_sub(most)))?;
    let mut end = Vec::new();
    file.take(most).read_to_end(&mut end)?;
    Ok(end)
}

fn inode(path: &Path) -> Option<u64> {
    fs::metadata(path).ok().map(|found| found.ino())
}

/// Copies the file `from`, where it exists.
fn copy(from: &Path, to: &Path) -> io::Result<()> {
    match fs::copy(from, to) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Puts the file `from` in its place, where it exists.
fn settle(from: &Path, to: &Path) -> io::Result<()> {
    match fs::rename(from, to) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Removes what nobody goes on from any more: the state `before`, and the folder of whoever died at it.
fn sweep(folder: &Path, before: &str) {
    let of = |end: &str| folder.join(format!("{before}.{end}"));
    // What cannot be removed harms nobody.
    _ = fs::remove_file(of("state"));
    _ = fs::remove_file(of("dwells"));
    let prefix = format!(".{before}.");
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        if entry.file_name().as_encoded_bytes().starts_with(prefix.as_bytes()) {
            _ = fs::remove_dir_all(entry.path());
        }
    }
}
