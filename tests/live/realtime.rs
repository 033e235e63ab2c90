//! Real time: the data path has it where the kernel grants it, and nothing else has.

use std::fs;
use std::io::{BufRead, BufReader};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::time::{Duration, Instant};
use tertius::appliance::realtime::{Refused, be_ordinary, set_priority};
use tertius_testing::support::{Scratch, top};

const SCHED_OTHER: &str = "0";
const SCHED_FIFO: &str = "1";

/// The policy and the real-time priority of a thread, by its /proc/…/stat.
fn policy(stat: &str) -> (String, String) {
    let (_, fields) = stat.rsplit_once(')').expect("the name is in brackets");
    let fields: Vec<&str> = fields.split_whitespace().collect();
    // Fields 40 and 41 of proc_pid_stat(5); the third is the first behind the name.
    (fields[41 - 3].to_owned(), fields[40 - 3].to_owned())
}

fn own_policy() -> String {
    policy(&fs::read_to_string("/proc/thread-self/stat").expect("it is Linux")).0
}

/// Waits until the data path has the policy and priority `wanted`, and every other thread of those
/// names, and of any, is ordinary: a new one needs its moment to give up what it inherited.
fn wait_for_policies(child: u32, wanted: (&str, &str), names: &[&str]) {
    let started = Instant::now();
    loop {
        let tasks = fs::read_dir(format!("/proc/{child}/task")).expect("it runs");
        // One that ends meanwhile has no policy.
        let stats =
            tasks.filter_map(|task| fs::read_to_string(task.ok()?.path().join("stat")).ok());
        let stats: Vec<String> = stats.collect();
        let (data_path, others): (Vec<&String>, Vec<&String>) =
            stats.iter().partition(|stat| stat.starts_with(&format!("{child} ")));
        let found = policy(data_path[0]);
        assert_eq!((&*found.0, &*found.1), wanted);
        let there = |name: &&str| others.iter().any(|stat| stat.contains(&format!("({name})")));
        if names.iter().all(there) && others.iter().all(|stat| policy(stat).0 == SCHED_OTHER) {
            return;
        }
        assert!(started.elapsed() < Duration::from_secs(30), "{stats:#?}");
        std::thread::yield_now();
    }
}

/// A gateway that waits for an interface, once it said `words`; its log, and what it said.
fn start(mut command: Command, words: &str) -> (Running, BufReader<ChildStderr>, String) {
    let child = command.stderr(Stdio::piped()).spawn().expect("it starts");
    let mut child = Running(child);
    let mut said = String::new();
    let mut log = BufReader::new(child.0.stderr.take().expect("it is piped"));
    while !said.contains(words) {
        assert_ne!(log.read_line(&mut said).expect("UTF-8"), 0, "{words:?} is not in\n{said}");
    }
    (child, log, said)
}

/// A process that does not outlive the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        _ = self.0.kill();
        _ = self.0.wait();
    }
}

fn config(scratch: &Scratch) -> String {
    let realtime = "\n[realtime]\npriority = 7\nlock_memory = true\n\
                    [http]\nlisten = \"127.0.0.1:0\"\n";
    let path = scratch.config(&[("\"can0\"", "\"t-none\"")]);
    let text = fs::read_to_string(&path).expect("it was written");
    scratch.write("e-type.toml", text + realtime)
}

#[test]
fn the_data_path_alone_runs_in_real_time() {
    let scratch = Scratch::new();
    let mut command = Command::new(env!("CARGO_BIN_EXE_tertius"));
    let path = config(&scratch);
    command.args(["run", "--config", &path]).current_dir(top());
    let (child, mut log, mut said) = start(command, "no bus");
    let granted = said.contains("the data path runs in real time priority=7");
    let refused = said.contains("no real-time priority 7: ");
    assert!(granted != refused, "one or the other is said\n{said}");
    let locked = said.contains("memory is locked");
    assert!(locked != said.contains("memory is not locked: "), "one or the other\n{said}");

    let wanted = if granted { (SCHED_FIFO, "7") } else { (SCHED_OTHER, "0") };
    wait_for_policies(child.0.id(), wanted, &["http", "link"]);

    // Threads that the data path starts later have none of it either.
    let moved =
        fs::read_to_string(&path).expect("it was written").replace("127.0.0.1", "127.0.0.2");
    fs::write(&path, moved).expect("the folder is ours");
    Command::new("kill").args(["-s", "HUP", &child.0.id().to_string()]).status().expect("kill");
    while !said.contains("telemetry: http://127.0.0.2") {
        assert_ne!(log.read_line(&mut said).expect("UTF-8"), 0, "no reload in\n{said}");
    }
    wait_for_policies(child.0.id(), wanted, &["http", "link"]);

    let status = fs::read_to_string(format!("/proc/{}/status", child.0.id())).expect("it runs");
    let kilobytes = status.lines().find_map(|line| line.strip_prefix("VmLck:"));
    assert_eq!(kilobytes.is_some_and(|text| text.trim() != "0 kB"), locked, "{status}");
}

#[test]
fn without_the_rights_it_says_what_to_do_and_goes_on() {
    let scratch = Scratch::new();
    // Root has to give them up; others have none.
    let root =
        fs::metadata("/proc/self").is_ok_and(|own| std::os::unix::fs::MetadataExt::uid(&own) == 0);
    let mut words = vec!["prlimit", "--rtprio=0", "--memlock=65536"];
    if root {
        words.extend(["setpriv", "--bounding-set=-sys_nice,-ipc_lock"]);
    }
    let mut command = Command::new(words[0]);
    command.args(&words[1..]).arg(env!("CARGO_BIN_EXE_tertius"));
    command.args(["run", "--config", &config(&scratch)]).current_dir(top());
    let (_child, _log, said) = start(command, "no bus");
    for words in [
        "no real-time priority 7: Operation not permitted; as a service, install tertius-realtime",
        "`ulimit -r 7` or CAP_SYS_NICE; continuing without",
        "memory is not locked: ",
        "`ulimit -l unlimited` or CAP_IPC_LOCK; continuing without",
    ] {
        assert!(said.contains(words), "{words:?} is not in\n{said}");
    }
}

#[test]
fn a_thread_beside_the_data_path_can_give_up_what_it_inherited() {
    let data_path = || match set_priority(1) {
        Ok(()) => {
            assert_eq!(own_policy(), SCHED_FIFO);
            let beside = || {
                let inherited = own_policy();
                be_ordinary();
                (inherited, own_policy())
            };
            let found = std::thread::spawn(beside).join().expect("it does not panic");
            assert_eq!(found, (SCHED_FIFO.to_owned(), SCHED_OTHER.to_owned()));
            assert_eq!(own_policy(), SCHED_FIFO, "and the data path keeps it");
        }
        // Whoever may not have it inherits nothing.
        Err(refused) => {
            assert!(matches!(refused, Refused::Priority { priority: 1, .. }));
            be_ordinary();
            assert_eq!(own_policy(), SCHED_OTHER);
        }
    };
    std::thread::spawn(data_path).join().expect("it does not panic");
}
