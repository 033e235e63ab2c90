//! The recordings of the flight recorder, to be taken away.

use super::connections::Connection;
use super::sending::{body, no_place, no_thread};
use super::shared::{Shared, json};
use axum::Extension;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::http::header::{CACHE_CONTROL, CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use std::fs;
use std::io::{self, Write};
use std::path::{Path as FilePath, PathBuf};
use std::sync::Arc;

/// Most recordings that are listed, the newest.
const MOST_LISTED: usize = 200;

/// A recording, as listed.
#[derive(Debug, Serialize)]
struct Recording {
    /// Name of its folder, which begins with the time: `20261123T021600Z-cylinder-3-incident-7`.
    name: String,
    bytes: u64,
}

/// The recordings, and where they are.
#[derive(Debug, Serialize)]
struct List {
    /// `null`: nothing is recorded.
    folder: Option<PathBuf>,
    /// The newest first.
    recordings: Vec<Recording>,
}

pub(super) async fn list(State(shared): State<Shared>) -> Response {
    let folder = shared.desk.plan().recordings;
    let listed = tokio::task::spawn_blocking(move || {
        let mut names = folder.as_deref().map_or_else(Vec::new, names);
        names.sort_unstable_by(|a, b| b.cmp(a));
        names.truncate(MOST_LISTED);
        let recording = |name: String| {
            let bytes = folder.as_deref().map_or(0, |folder| size(&folder.join(&name)));
            Recording { name, bytes }
        };
        List { recordings: names.into_iter().map(recording).collect(), folder: folder.clone() }
    });
    match listed.await {
        Ok(list) => json(&list),
        Err(_) => StatusCode::INTERNAL_SERVER_ERROR.into_response(),
    }
}

/// Names of the finished recordings in `folder`; none if it cannot be read.
fn names(folder: &FilePath) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().filter_map(Result::ok);
    let finished = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
    let names = finished.filter_map(|entry| entry.file_name().into_string().ok());
    names.filter(|name| is_name(name)).collect()
}

/// Whether `name` is that of a recording, which names nothing outside of the folder: a time, and words.
fn is_name(name: &str) -> bool {
    name.len() <= 100
        && name.starts_with(|c: char| c.is_ascii_digit())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-')
}

fn size(recording: &FilePath) -> u64 {
    let files = fs::read_dir(recording).into_iter().flatten().filter_map(Result::ok);
    files.filter_map(|file| file.metadata().ok()).map(|metadata| metadata.len()).sum()
}

/// `GET /api/recordings/NAME.tar`: the folder as an archive, which `tertius replay NAME` replays once it is unpacked.
pub(super) async fn archive(
    State(shared): State<Shared>,
    Extension(connection): Extension<Arc<Connection>>,
    Path(file): Path<String>,
) -> Response {
    let absent = || (StatusCode::NOT_FOUND, "there is no such recording\n").into_response();
    let Some(name) = file.strip_suffix(".tar").filter(|name| is_name(name)) else {
        return absent();
    };
    let Some(path) = shared.desk.plan().recordings.map(|folder| folder.join(name)) else {
        return absent();
    };
    if !path.is_dir() {
        return absent();
    }
    let place = match shared.places.recordings.place(&connection) {
        Ok(place) => place,
        Err(refusal) => return no_place(refusal),
    };
    let own = name.to_owned();
    let body = match body(&connection, place, move |out| pack(out, &own, &path)) {
        Ok(body) => body,
        Err(error) => return no_thread(&error),
    };
    let headers = [
        (CONTENT_TYPE, "application/x-tar".to_owned()),
        (CACHE_CONTROL, "no-store".to_owned()),
        (CONTENT_DISPOSITION, format!("attachment; filename=\"{name}.tar\"")),
    ];
    (headers, body).into_response()
}

fn pack(out: impl Write, name: &str, path: &FilePath) -> io::Result<()> {
    let mut archive = tar::Builder::new(out);
    archive.follow_symlinks(false);
    archive.append_dir_all(name, path)?;
    archive.into_inner()?.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_in_the_folder() {
        assert!(is_name("20261123T021600Z-cylinder-3-incident-7"));
        assert!(is_name("20261123T021600Z-on-demand-2"));
        for name in ["", ".", "..", "-rf", "../1", "1/2", "1\\2", "1.tmp", "1 2", "\u{661}"] {
            assert!(!is_name(name), "{name:?}");
        }
        assert!(!is_name(&"1".repeat(101)));
    }
}
