//! The files of the page, which are in the program.

use axum::extract::Path;
use axum::http::header::{ACCEPT_ENCODING, CACHE_CONTROL, CONTENT_ENCODING, CONTENT_TYPE, VARY};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;
use std::sync::LazyLock;

const HTML: &str = "text/html; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const PICTURE: &str = "image/svg+xml";
const TEXT: &str = "text/plain; charset=utf-8";

/// Names, types and contents; the first one is the page itself.
const FILES: [(&str, &str, &str); 14] = [
    ("index.html", HTML, include_str!("page/index.html")),
    ("page.css", STYLE, include_str!("page/page.css")),
    ("page.js", SCRIPT, include_str!("page/page.js")),
    ("overview.js", SCRIPT, include_str!("page/overview.js")),
    ("trends.js", SCRIPT, include_str!("page/trends.js")),
    ("alarms.js", SCRIPT, include_str!("page/alarms.js")),
    ("incidents.js", SCRIPT, include_str!("page/incidents.js")),
    ("maintenance.js", SCRIPT, include_str!("page/maintenance.js")),
    ("recordings.js", SCRIPT, include_str!("page/recordings.js")),
    ("words.js", SCRIPT, include_str!("page/words.js")),
    ("icon.svg", PICTURE, include_str!("page/icon.svg")),
    // uPlot 1.6.32 (MIT), as it is published.
    ("uplot.js", SCRIPT, include_str!("page/uplot/uPlot.iife.min.js")),
    ("uplot.css", STYLE, include_str!("page/uplot/uPlot.min.css")),
    ("licence-uplot.txt", TEXT, include_str!("page/uplot/LICENSE")),
];

struct Asset {
    name: &'static str,
    kind: &'static str,
    plain: &'static str,
    compressed: Vec<u8>,
}

static ASSETS: LazyLock<Vec<Asset>> = LazyLock::new(|| {
    let asset = |(name, kind, plain): (_, _, &'static str)| {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
        // Memory takes everything.
        let written = encoder.write_all(plain.as_bytes());
        let compressed = written.and_then(|()| encoder.finish()).unwrap_or_default();
        Asset { name, kind, plain, compressed }
    };
    FILES.into_iter().map(asset).collect()
});

pub(super) async fn index(headers: HeaderMap) -> Response {
    answer(&ASSETS[0], &headers)
}

pub(super) async fn asset(Path(name): Path<String>, headers: HeaderMap) -> Response {
    match ASSETS.iter().find(|asset| asset.name == name) {
        Some(asset) => answer(asset, &headers),
        None => (StatusCode::NOT_FOUND, "there is no such file\n").into_response(),
    }
}

/// What is told where a login would need a token.
pub(super) const NO_TOKEN: &str = "from another computer the page needs a login, and the configuration has no token: \
                                   `tertius token` makes one, whose digest belongs into [http]\n";

/// `text` as a page that no cache keeps.
pub(super) fn html(text: String) -> Response {
    ([(CONTENT_TYPE, HTML), (CACHE_CONTROL, "no-store")], text).into_response()
}

fn answer(asset: &'static Asset, headers: &HeaderMap) -> Response {
    let accepted = headers.get(ACCEPT_ENCODING).and_then(|value| value.to_str().ok());
    let compressed = !asset.compressed.is_empty()
        && accepted.is_some_and(|it| it.split(',').any(|it| it.trim().starts_with("gzip")));
    // Revalidated by being fetched again: an update of the program changes the files under the same names.
    let mut response =
        [(CONTENT_TYPE, asset.kind), (CACHE_CONTROL, "no-cache"), (VARY, "accept-encoding")]
            .into_response();
    if compressed {
        response.headers_mut().insert(CONTENT_ENCODING, HeaderValue::from_static("gzip"));
        *response.body_mut() = asset.compressed.as_slice().into();
    } else {
        *response.body_mut() = asset.plain.into();
    }
    response
}
