//! Keeps a proxy running: opens both interfaces, and opens them again after each loss.

use super::Proxy;
use super::side::{Change, Side};
use crate::bus::UnrestrictedPort;
use std::time::Duration;

/// Longest wait between two checks.
const PATIENCE: Duration = Duration::from_millis(100);

/// Pause between two attempts to send to an interface that accepts no frames.
const FULL_PAUSE: Duration = Duration::from_millis(2);

/// Everything outside of the data path that a proxy depends on. A side is 0 for the interface whose
/// frames get faults, 1 for the other.
pub trait Bench<P> {
    /// Time since any fixed point, never running back.
    fn now(&mut self) -> Duration;
    /// Whether to end; asked before each turn.
    fn is_over(&mut self) -> bool;
    /// Waits until one of `ports` has something to receive, at most for `longest`.
    fn wait(&mut self, ports: [Option<&P>; 2], longest: Duration);
    /// Notes that an interface is open.
    fn opened(&mut self, side: usize, port: &P);
    /// Notes that an interface is lost, or could not be opened. Called once for each new reason.
    fn lost(&mut self, side: usize, reason: &str);
}

/// Runs `proxy` from `sides[0]` to `sides[1]` and back until the bench ends it.
pub fn run<P: UnrestrictedPort>(
    proxy: &mut Proxy,
    sides: &mut [Side<P>; 2],
    bench: &mut impl Bench<P>,
) {
    while !bench.is_over() {
        let now = bench.now();
        for (index, side) in sides.iter_mut().enumerate() {
            let change = side.attend(now);
            log_change(bench, index, side, change);
        }
        turn(proxy, sides, bench, now);
        let [from, to] = &*sides;
        let due = [from, to].into_iter().filter_map(|side| side.idle(now)).min();
        let pause = if proxy.waiting() > 0 { FULL_PAUSE } else { PATIENCE };
        bench.wait([from.port(), to.port()], due.map_or(pause, |due| due.min(pause)));
    }
}

fn turn<P: UnrestrictedPort>(
    proxy: &mut Proxy,
    sides: &mut [Side<P>; 2],
    bench: &mut impl Bench<P>,
    now: Duration,
) {
    let sent = |proxy: &Proxy| [proxy.back().counts().sent, proxy.there().counts().sent];
    let before = sent(proxy);
    let [from, to] = &mut *sides;
    let outcomes = proxy.turn(from.port_mut(), to.port_mut());
    let after = sent(proxy);
    for (index, outcome) in outcomes.into_iter().enumerate() {
        let side = &mut sides[index];
        match outcome {
            Ok(received) => {
                if received > 0 || after[index] > before[index] {
                    side.works();
                }
            }
            Err(error) => {
                let change = side.lose(error.to_string(), now);
                log_change(bench, index, side, change);
            }
        }
    }
}

fn log_change<P: UnrestrictedPort>(
    bench: &mut impl Bench<P>,
    index: usize,
    side: &Side<P>,
    change: Option<Change>,
) {
    match change {
        Some(Change::Opened) => {
            if let Some(port) = side.port() {
                bench.opened(index, port);
            }
        }
        Some(Change::Lost(reason)) => bench.lost(index, &reason),
        None => {}
    }
}
