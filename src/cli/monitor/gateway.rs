//! A running gateway, over the HTTP of its page.

use super::news::{News, NewsSource, WatchedMachine, told};
use super::picture::MINUTES;
use super::stream::EventLines;
use super::trust::{self, Trust};
use crate::cli::Failure;
use axum::body::Body;
use axum::http::header::{ACCEPT, AUTHORIZATION, HOST};
use axum::http::{HeaderValue, Request, Response, StatusCode, Uri};
use hyper::body::{Body as _, Incoming};
use hyper::client::conn::http1;
use hyper_util::rt::TokioIo;
use std::future::poll_fn;
use std::path::Path;
use std::pin::Pin;
use std::time::{Duration, Instant};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tokio::runtime::Runtime;
use tokio::time::timeout;

/// Port of a gateway's page where none is given.
const PORT: u16 = 9481;

/// Time limit of an answer, and of an event of the stream.
const PATIENCE: Duration = Duration::from_secs(3);

/// Pause before a gateway that was lost is asked again.
const PAUSE: Duration = Duration::from_secs(1);

/// Time after which the gateway is asked again what it monitors: a reload may have changed it.
const MACHINE_PERIOD: Duration = Duration::from_secs(15);

/// Most bytes of an answer: the trend of five minutes has a tenth of it.
const LARGEST_ANSWER: usize = 1_000_000;

/// Most bytes of a refusal that are read, and of its line that are shown.
const LARGEST_REFUSAL: usize = 2000;
const SHOWN_REFUSAL: usize = 120;

/// A gateway at an address.
pub struct GatewaySource {
    host: String,
    port: u16,
    /// Host and port as the request names them.
    authority: String,
    /// Whom it has to prove that it is the gateway; `None` over http.
    trust: Option<Trust>,
    /// The header that bears the token.
    token: Option<HeaderValue>,
}

impl GatewaySource {
    /// The gateway at `url`. Over https it is trusted by the certificates in `authorities`, else by those that this
    /// computer trusts, and gets the `token`.
    ///
    /// # Errors
    /// It is no address of a page, or `authorities` are no certificates.
    pub fn new(
        url: &str,
        authorities: Option<&Path>,
        token: Option<HeaderValue>,
    ) -> Result<Self, Failure> {
        let wrong = |why: &str| {
            Failure::Wrong(format!(
                "{url:?} is no address of a gateway's page: {why}; expected something like http://127.0.0.1:{PORT}"
            ))
        };
        let uri: Uri = url.parse().map_err(|_| wrong("it is no URL"))?;
        let encrypted = match uri.scheme_str() {
            Some("http") if authorities.is_some() => {
                return Err(wrong(
                    "--ca is for https://, and over http nobody shows a certificate",
                ));
            }
            Some("http") => false,
            Some("https") => true,
            _ => return Err(wrong("it begins neither with http:// nor with https://")),
        };
        if !matches!(uri.path(), "" | "/") || uri.query().is_some() {
            return Err(wrong("nothing may follow the port"));
        }
        let authority = uri.authority().ok_or_else(|| wrong("there is no host"))?;
        if authority.as_str().contains('@') {
            return Err(wrong("there is no login"));
        }
        let host = authority.host().trim_start_matches('[').trim_end_matches(']').to_owned();
        let port = authority.port_u16().unwrap_or(PORT);
        let trust = encrypted.then(|| Trust::new(&host, authorities)).transpose()?;
        // Who listens to http would have the token.
        let token = token.filter(|_| encrypted);
        Ok(Self { port, authority: format!("{}:{port}", authority.host()), host, trust, token })
    }

    /// The answer to a request for `path`, as text.
    ///
    /// # Errors
    /// Why there is none.
    pub fn text(&self, path: &str) -> Result<String, String> {
        let answer = runtime()?.block_on(self.answer(path))?;
        Ok(String::from_utf8_lossy(&answer).into_owned())
    }

    /// Follows the gateway until it is lost, for the reason returned; `Ok` if nobody wants to be told any more.
    async fn follow(&self, send: &mut dyn FnMut(News) -> bool) -> Result<(), String> {
        let machine = self.machine().await?;
        let mut asked = Instant::now();
        let cylinders = machine.limits_m.len();
        if !send(News::Machine(machine)) {
            return Ok(());
        }
        for number in 1..=cylinders {
            let path = format!("/api/trend/{number}?seconds={MINUTES:.0}");
            let answer = self.answer(&path).await?;
            let news = News::trend(number, &answer).map_err(|error| unreadable(&path, &error))?;
            if !send(news) {
                return Ok(());
            }
        }
        let path = "/api/stream";
        let mut stream = self.ask(path, "text/event-stream").await?;
        let mut events = EventLines::default();
        while let Some(bytes) = piece(stream.body_mut()).await? {
            events.push(&bytes).map_err(|error| format!("{path}: {error}"))?;
            while let Some((name, data)) = events.next() {
                let news = News::event(&name, &data).map_err(|error| unreadable(path, &error))?;
                if news.is_some_and(|news| !send(news)) {
                    return Ok(());
                }
            }
            if asked.elapsed() > MACHINE_PERIOD {
                let now = self.machine().await?;
                if now.limits_m.len() != cylinders {
                    return Err("it monitors another machine now".to_owned());
                }
                asked = Instant::now();
                if !send(News::Machine(now)) {
                    return Ok(());
                }
            }
        }
        Err("it has ended the stream".to_owned())
    }

    async fn machine(&self) -> Result<WatchedMachine, String> {
        let path = "/api/machine";
        let answer = self.answer(path).await?;
        told(&answer).map_err(|error| unreadable(path, &error))
    }

    /// The whole answer to a request.
    async fn answer(&self, path: &str) -> Result<Vec<u8>, String> {
        let mut answer = self.ask(path, "application/json").await?;
        read(answer.body_mut(), LARGEST_ANSWER, path).await
    }

    /// The answer to a request, of which the body is not read yet.
    async fn ask(&self, path: &str, kind: &str) -> Result<Response<Incoming>, String> {
        let asked = timeout(PATIENCE, self.send(path, kind)).await;
        let mut answer = asked.map_err(|_| silent())??;
        let status = answer.status();
        if status == StatusCode::OK {
            return Ok(answer);
        }
        if status == StatusCode::UNAUTHORIZED {
            return Err(trust::unauthorized(self.token.is_some()));
        }
        let refusal = read(answer.body_mut(), LARGEST_REFUSAL, path).await.unwrap_or_default();
        let refusal = String::from_utf8_lossy(&refusal);
        let line: String =
            refusal.lines().next().unwrap_or_default().chars().take(SHOWN_REFUSAL).collect();
        Err(format!("{path}: {status}: {line}"))
    }

    async fn send(&self, path: &str, kind: &str) -> Result<Response<Incoming>, String> {
        let request = Request::get(path).header(HOST, &self.authority).header(ACCEPT, kind);
        let request = match &self.token {
            Some(token) => request.header(AUTHORIZATION, token),
            None => request,
        };
        let request = request.body(Body::empty()).map_err(|error| error.to_string())?;
        let address = (self.host.as_str(), self.port);
        let stream = TcpStream::connect(address).await.map_err(|error| error.to_string())?;
        match &self.trust {
            Some(trust) => send(trust.connect(stream).await?, request).await,
            None => send(stream, request).await,
        }
    }
}

impl NewsSource for GatewaySource {
    fn name(&self) -> String {
        let scheme = if self.trust.is_some() { "https" } else { "http" };
        format!("{scheme}://{}", self.authority)
    }

    fn watch(&mut self, send: &mut dyn FnMut(News) -> bool) {
        let runtime = match runtime() {
            Ok(runtime) => runtime,
            Err(reason) => {
                send(News::Lost(reason));
                return;
            }
        };
        while let Err(reason) = runtime.block_on(self.follow(send)) {
            if !send(News::Lost(reason)) {
                return;
            }
            std::thread::sleep(PAUSE);
        }
    }
}

fn runtime() -> Result<Runtime, String> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    runtime.map_err(|error| error.to_string())
}

/// The answer to `request`, of which the body is not read yet.
async fn send(
    stream: impl AsyncRead + AsyncWrite + Send + Unpin + 'static,
    request: Request<Body>,
) -> Result<Response<Incoming>, String> {
    let handshake = http1::handshake(TokioIo::new(stream)).await;
    let (mut sender, connection) = handshake.map_err(|error| error.to_string())?;
    // It ends with the answer.
    tokio::spawn(connection);
    sender.send_request(request).await.map_err(|error| error.to_string())
}

fn silent() -> String {
    format!("it did not answer within {} s", PATIENCE.as_secs())
}

fn unreadable(path: &str, error: &serde_json::Error) -> String {
    format!("the answer of {path} is not that of a gateway of this version: {error}")
}

/// The next piece of a body, within the time limit; `None` at its end.
async fn piece(body: &mut Incoming) -> Result<Option<Vec<u8>>, String> {
    loop {
        let next = poll_fn(|context| Pin::new(&mut *body).poll_frame(context));
        let frame = match timeout(PATIENCE, next).await.map_err(|_| silent())? {
            Some(frame) => frame.map_err(|error| error.to_string())?,
            None => return Ok(None),
        };
        // Trailers are of no interest.
        if let Ok(data) = frame.into_data() {
            return Ok(Some(data.into()));
        }
    }
}

/// A whole body of at most `most` bytes.
async fn read(body: &mut Incoming, most: usize, path: &str) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    while let Some(more) = piece(body).await? {
        bytes.extend_from_slice(&more);
        if bytes.len() > most {
            return Err(format!("the answer of {path} has more than {most} bytes"));
        }
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_address_of_a_page_is_taken() {
        let taken = |url: &str| {
            GatewaySource::new(url, None, None).map(|it| (it.name(), it.host, it.port)).ok()
        };
        let own = |name: &str, host: &str, port| Some((name.to_owned(), host.to_owned(), port));
        let named = "http://127.0.0.1:9481";
        assert_eq!(taken(named), own(named, "127.0.0.1", 9481));
        assert_eq!(taken("http://127.0.0.1/"), own(named, "127.0.0.1", 9481));
        assert_eq!(taken("http://[::1]:80"), own("http://[::1]:80", "::1", 80));
        for url in [
            "",
            "box",
            "box:9481",
            "ftp://box",
            "https://",
            "http://box/health",
            "http://me@box",
            "http://",
        ] {
            assert_eq!(taken(url), None, "{url}");
        }
    }
}
