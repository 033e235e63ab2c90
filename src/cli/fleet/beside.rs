//! The machines of a fleet beside each other, the recordings of each in order.

use super::plan::{FleetPlan, MachinePlan, PlannedInput};
use super::step::Step;
use crate::cli::Failure;
use crate::cli::progress::Bar;
use crate::text::counted;
use std::env;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

/// How far the recordings of a machine are done.
#[derive(Debug, Default)]
struct Folded {
    done: usize,
    /// Recordings of these in which something was judged.
    judged: usize,
    incidents: u64,
    /// Duration of the recordings, s.
    duration: f64,
    /// Why the next one is not done.
    failure: Option<Failure>,
}

/// Replays the recordings of `fleet`, of so many machines at a time as there are `jobs`, below the folder `output`. What
/// is there already is not done again. Returns what there is to say of it, in the order of the fleet.
///
/// # Errors
/// The plan cannot be done here, or a machine stands still; the others are done nevertheless.
pub fn run(fleet: &FleetPlan, output: &Path, jobs: usize) -> (String, Result<(), Failure>) {
    let program = match prepare(fleet, output) {
        Ok(program) => program,
        Err(failure) => return (String::new(), Err(failure)),
    };
    let all = fleet.machines.iter().map(|machine| machine.inputs.len()).sum();
    let bar = Bar::counting(all);
    let folded = beside(&fleet.machines, jobs, |machine| fold(machine, output, &program, &bar));
    bar.finish();
    (told(fleet, &folded, output), verdict(fleet, folded))
}

/// The program; refuses what cannot be done, before anything is.
fn prepare(fleet: &FleetPlan, output: &Path) -> Result<PathBuf, Failure> {
    fs::create_dir_all(output).map_err(|error| Failure::creating(output, &error))?;
    let real = |path: &Path| fs::canonicalize(path).ok();
    let folder = real(output);
    for machine in &fleet.machines {
        for input in &machine.inputs {
            let path = match input {
                PlannedInput::File(recording) => &recording.path,
                PlannedInput::Url(url) => {
                    return Err(Failure::Wrong(format!(
                        "machine {:?}: {url} is somewhere else, and only files are read here; `tertius-fleet run` and \
                         fleet/fold fetch recordings",
                        machine.name
                    )));
                }
            };
            let is_below = |folder: PathBuf| real(path).is_some_and(|it| it.starts_with(folder));
            if folder.clone().is_some_and(is_below) {
                return Err(Failure::Wrong(format!(
                    "{} is below {}, where the results are put; name another folder",
                    path.display(),
                    output.display()
                )));
            }
        }
    }
    env::current_exe().map_err(|error| {
        Failure::Failed(format!("this program cannot tell where it is, to call itself: {error}"))
    })
}

/// Calls `act` for each of `machines`, for so many at a time as there are `jobs`; the results in the order of the
/// machines.
fn beside<M: Sync, R: Send + Default>(
    machines: &[M],
    jobs: usize,
    act: impl Fn(&M) -> R + Sync,
) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let results: Vec<Mutex<R>> = machines.iter().map(|_| Mutex::default()).collect();
    let work = || {
        while let Some((machine, result)) = {
            let index = next.fetch_add(1, Ordering::Relaxed);
            machines.get(index).zip(results.get(index))
        } {
            *result.lock().unwrap_or_else(PoisonError::into_inner) = act(machine);
        }
    };
    thread::scope(|scope| {
        for _ in 0..jobs.min(machines.len()) {
            scope.spawn(work);
        }
    });
    let whole = |it: Mutex<R>| it.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.into_iter().map(whole).collect()
}

/// Replays the recordings of `machine` until one fails.
fn fold(machine: &MachinePlan, output: &Path, program: &Path, bar: &Bar) -> Folded {
    let mut folded = Folded::default();
    for (index, input) in (1..).zip(&machine.inputs) {
        let PlannedInput::File(recording) = input else { break };
        match (Step { machine, index, recording }).run(output, program) {
            Ok(done) => {
                folded.done += 1;
                folded.judged += usize::from(done.judged);
                folded.incidents += done.incidents;
                folded.duration += done.duration;
                bar.count();
            }
            Err(failure) => {
                folded.failure = Some(failure);
                break;
            }
        }
    }
    folded
}

/// A line for each machine, and one for all.
fn told(fleet: &FleetPlan, folded: &[Folded], output: &Path) -> String {
    let mut text = String::new();
    let hours = |it: &Folded| it.duration / 3600.0;
    for (machine, it) in fleet.machines.iter().zip(folded) {
        let incidents = counted(it.incidents, "incident");
        let (name, all) = (&machine.name, machine.inputs.len());
        _ = write!(text, "{name}: {} of {all} done, {incidents} in {:.2} h", it.done, hours(it));
        let blank = it.done - it.judged;
        text += &if blank > 0 { format!("; nothing was judged in {blank}\n") } else { "\n".into() };
    }
    let done: usize = folded.iter().map(|it| it.done).sum();
    let all: usize = fleet.machines.iter().map(|machine| machine.inputs.len()).sum();
    let hours: f64 = folded.iter().map(hours).sum();
    _ = write!(
        text,
        "{done} of {} done: {hours:.2} machine-hours. ",
        counted(all as u64, "recording")
    );
    if cfg!(feature = "parquet") {
        _ = writeln!(text, "The tables are in {}", output.join("columns").display());
    } else {
        text += "There are no tables: this program was built without the feature parquet\n";
    }
    text
}

/// Whether all is done, and something was judged of each machine.
fn verdict(fleet: &FleetPlan, folded: Vec<Folded>) -> Result<(), Failure> {
    let mut reasons = Vec::new();
    for (machine, it) in fleet.machines.iter().zip(folded) {
        let name = &machine.name;
        match it.failure {
            Some(why) => reasons.push(format!("machine {name:?} stands still: {why}")),
            None if it.judged == 0 => {
                reasons
                    .push(format!("machine {name:?}: nothing was judged in any of its recordings"));
            }
            None => {}
        }
    }
    if reasons.is_empty() { Ok(()) } else { Err(Failure::Failed(reasons.join("\ntertius: "))) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Barrier;

    #[test]
    fn so_many_are_at_it_at_a_time_and_results_keep_their_order() {
        let machines: Vec<usize> = (0..20).collect();
        for jobs in [1, 3, 40] {
            let (now, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
            let act = |machine: &usize| {
                most.fetch_max(now.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                thread::yield_now();
                now.fetch_sub(1, Ordering::SeqCst);
                *machine
            };
            assert_eq!(beside(&machines, jobs, act), machines);
            assert!(most.into_inner() <= jobs);
        }
        // All three are needed to come past it.
        let barrier = Barrier::new(3);
        let act = |_: &usize| barrier.wait().is_leader();
        let leaders = beside(&[0; 3], 3, act);
        assert_eq!(leaders.iter().filter(|leads| **leads).count(), 1);
    }
}
