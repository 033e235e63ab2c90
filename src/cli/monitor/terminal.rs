//! The terminal: drawn at most five times a second, and left as it was found.

use super::news::News;
use super::view::{self, Marks};
use super::viewer::{Viewer, Wish};
use crate::cli::Failure;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::flag;
use std::env;
use std::io::{self, IsTerminal};
use std::os::fd::AsFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError};
use std::time::{Duration, Instant};

/// Least time between two drawings: a slow line has to carry them.
const PERIOD: Duration = Duration::from_millis(200);

const INSTEAD: &str = "without a terminal, the same is told by `tertius run` in its log, by `curl \
                       http://127.0.0.1:9481/health`, and for a recording by `tertius replay LOG --config FILE`";

/// Refuses an output that cannot be drawn on.
///
/// # Errors
/// It is no terminal, or one that cannot move its cursor.
pub fn check() -> Result<(), Failure> {
    if !io::stdout().is_terminal() {
        return Err(Failure::Wrong(format!(
            "standard output is no terminal to draw on; {INSTEAD}"
        )));
    }
    match env::var("TERM").unwrap_or_default().as_str() {
        "" | "dumb" => Err(Failure::Wrong(format!(
            "this terminal cannot be drawn on (TERM is dumb or not set); set TERM to what it is (TERM=xterm, linux, \
             vt100), or {INSTEAD}"
        ))),
        _ => Ok(()),
    }
}

/// What this terminal shows, by the environment.
pub fn marks() -> Marks {
    let set = |name: &str| env::var(name).ok().filter(|value| !value.is_empty());
    let locale = ["LC_ALL", "LC_CTYPE", "LANG"].into_iter().find_map(set).unwrap_or_default();
    let locale = locale.to_lowercase();
    Marks {
        unicode: locale.contains("utf-8") || locale.contains("utf8"),
        colours: set("NO_COLOR").is_none(),
    }
}

/// Shows `viewer` what comes by `news`, until the person quits or the program is told to.
///
/// # Errors
/// The terminal fails, or nobody tells any news.
pub fn show(
    viewer: Viewer,
    news: Receiver<(Instant, News)>,
    start: Instant,
) -> Result<(), Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGHUP, SIGINT, SIGTERM] {
        flag::register(signal, Arc::clone(&stop))
            .map_err(|error| Failure::Failed(format!("signals cannot be caught: {error}")))?;
    }
    // A panic restores the terminal, too, before it says what has happened.
    let terminal = ratatui::try_init().map_err(|error| failed(&error))?;
    let ended = Show { viewer, news, start, stop, marks: marks() }.run(terminal);
    let restored = ratatui::try_restore();
    ended?;
    restored.map_err(|error| failed(&error))
}

fn failed(error: &io::Error) -> Failure {
    Failure::Failed(format!("the terminal: {error}"))
}

struct Show {
    viewer: Viewer,
    news: Receiver<(Instant, News)>,
    start: Instant,
    stop: Arc<AtomicBool>,
    marks: Marks,
}

/// What the last drawing showed of the time: whole seconds.
type Second = u64;

impl Show {
    fn run(mut self, mut terminal: DefaultTerminal) -> Result<(), Failure> {
        let mut due = Instant::now();
        let mut drawn: Option<Second> = None;
        while !self.stop.load(Ordering::Relaxed) && !has_hung_up() {
            let heard = self.listen()?;
            let now = self.start.elapsed();
            let is_new = heard || drawn != Some(now.as_secs());
            if is_new && Instant::now() >= due {
                let Self { viewer, marks, .. } = &self;
                let draw = |frame: &mut ratatui::Frame<'_>| {
                    view::draw(viewer, now, *marks, frame.area(), frame.buffer_mut());
                };
                terminal.draw(draw).map_err(|error| failed(&error))?;
                (due, drawn) = (Instant::now() + PERIOD, Some(now.as_secs()));
            } else if is_new {
                drawn = None;
            }
            let left = due.saturating_duration_since(Instant::now());
            let patience = if left.is_zero() { PERIOD } else { left };
            if event::poll(patience).map_err(|error| failed(&error))? {
                match self.key(&event::read().map_err(|error| failed(&error))?) {
                    Consequence::Quit => return Ok(()),
                    Consequence::Changed => drawn = None,
                    Consequence::Nothing => {}
                }
            }
        }
        Ok(())
    }

    /// Takes the news that have come; returns whether there were any.
    fn listen(&mut self) -> Result<bool, Failure> {
        let mut heard = false;
        loop {
            match self.news.try_recv() {
                Ok((at, news)) => {
                    self.viewer.take(news, at.saturating_duration_since(self.start));
                    heard = true;
                }
                Err(TryRecvError::Empty) => return Ok(heard),
                Err(TryRecvError::Disconnected) => {
                    let told =
                        "the thread that watches has ended, which is an error of this program";
                    return Err(Failure::Failed(told.to_owned()));
                }
            }
        }
    }

    fn key(&mut self, event: &Event) -> Consequence {
        let key = match event {
            Event::Key(key) if key.kind != KeyEventKind::Release => key,
            Event::Resize(..) => return Consequence::Changed,
            _ => return Consequence::Nothing,
        };
        match wish(key) {
            Some(Asked::Quit) => Consequence::Quit,
            Some(Asked::For(wish)) => {
                self.viewer.wish(wish, self.start.elapsed());
                Consequence::Changed
            }
            None => Consequence::Nothing,
        }
    }
}

/// Whether the terminal is gone, as after a line broke, whose SIGHUP reaches only its own session. Reading it then
/// gives nothing, at once and for ever.
fn has_hung_up() -> bool {
    let stdin = io::stdin();
    let mut input = [PollFd::new(stdin.as_fd(), PollFlags::empty())];
    let gone = PollFlags::POLLHUP | PollFlags::POLLERR | PollFlags::POLLNVAL;
    let told = poll(&mut input, PollTimeout::ZERO).is_ok_and(|count| count > 0);
    told && input[0].revents().is_some_and(|events| events.intersects(gone))
}

/// What an event has led to.
enum Consequence {
    Quit,
    Changed,
    Nothing,
}

/// What a key asks for.
#[derive(Debug, PartialEq, Eq)]
enum Asked {
    For(Wish),
    Quit,
}

fn wish(key: &KeyEvent) -> Option<Asked> {
    if key.modifiers.contains(KeyModifiers::CONTROL) {
        return matches!(key.code, KeyCode::Char('c' | 'd')).then_some(Asked::Quit);
    }
    Some(Asked::For(match key.code {
        KeyCode::Char('q') => return Some(Asked::Quit),
        KeyCode::Up | KeyCode::Char('k') => Wish::Up,
        KeyCode::Down | KeyCode::Char('j') => Wish::Down,
        KeyCode::Char('s') => Wish::Sort,
        KeyCode::Char(' ') => Wish::Freeze,
        KeyCode::Char('z') | KeyCode::Enter => Wish::Zoom,
        KeyCode::Char('?' | 'h') => Wish::Help,
        KeyCode::Esc => Wish::Back,
        _ => return None,
    }))
}
