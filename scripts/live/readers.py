"""The gateway with its unit's limits, with readers who behave badly; run by scripts/readers, see there."""

import argparse
import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections import Counter
from pathlib import Path

import hostile
from gateway import TOP, limits

GROUPS = Path("/sys/fs/cgroup")
PORT = 9497
PAGE = f"http://127.0.0.1:{PORT}"
CYCLES = 100  # that it has to judge afterwards
PATIENCE = 30.0  # s


class Group:
    """A control group of `memory` bytes, until it is left. OSError where none can be made."""

    def __init__(self, memory):
        listed = GROUPS / "cgroup.controllers"
        new = listed.exists() and "memory" in listed.read_text().split()
        self.what = f"in a control group of version {2 if new else 1}, with what the kernel gives back"
        self.path = (GROUPS if new else GROUPS / "memory") / f"tertius-readers-{os.getpid()}"
        self.limit, self.peak, self.events = ("memory.max", "memory.peak", "memory.events") if new else \
            ("memory.limit_in_bytes", "memory.max_usage_in_bytes", "memory.oom_control")
        if new:
            (GROUPS / "cgroup.subtree_control").write_text("+memory")
        self.path.mkdir()
        try:
            (self.path / self.limit).write_text(str(memory))
        except OSError:
            self.path.rmdir()
            raise

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.path.rmdir()

    def command(self, command):
        return ["sh", "-c", f'echo $$ > {self.path}/cgroup.procs && exec "$@"', "sh", *command]

    def most(self, _process):
        return int((self.path / self.peak).read_text())

    def killed(self):
        """How many processes the kernel has ended for their memory."""
        lines = dict(line.split() for line in (self.path / self.events).read_text().splitlines())
        return int(lines["oom_kill"])


class Bound:
    """Where no control group can be made: the process may have no more than `memory` bytes that it can write to and that
    are its own, and the stacks of its `tasks`. A program that asks for more gets none and ends. What the kernel keeps for
    its sockets is not among them."""

    STACK = 2 << 20  # of a thread in Rust; the kernel gives it memory page by page

    def __init__(self, memory, tasks):
        self.bytes = memory + tasks * self.STACK
        self.what = f"without a control group: RLIMIT_DATA of {self.bytes >> 20} MiB with the stacks, without the kernel's sockets"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def command(self, command):
        return ["prlimit", f"--data={self.bytes}", "--", *command]

    def most(self, process):
        """The most that it had of its own in memory while it was looked at."""
        try:
            lines = Path(f"/proc/{process.pid}/status").read_text().splitlines()
        except OSError:
            return 0
        return next((int(line.split()[1]) << 10 for line in lines if line.startswith("RssAnon:")), 0)

    def killed(self):
        return 0


def bounded(memory, tasks):
    """What bounds the gateway's memory here."""
    try:
        return Group(memory)
    except OSError as error:
        print(f"readers: no control group can be made here ({error})", flush=True)
        return Bound(memory, tasks)


def configuration(folder):
    """With everything that has a thread of its own."""
    text = (TOP / "tests/recordings/e-type-sequential.toml").read_text()
    text = text.replace('"can0"', '"virtual"').replace('"../../dbc/e-type.dbc"', f'"{TOP / "dbc/e-type.dbc"}"')
    own = f'[http]\nlisten = "127.0.0.1:{PORT}"\ntoken = "{hostile.TOKEN}"\n[store]\nfile = "kept.events"\n'
    # A broker whose name is looked for by a thread.
    own += f'[modbus]\nlisten = "127.0.0.1:{PORT + 1}"\n[mqtt]\nbroker = "broker.invalid:1883"\n'
    text = text.replace("[sequential]\n", f'[sequential]\nhistory = "{folder / "kept.dwells"}"\n')
    return f'{own}[recorder]\nfolder = "{folder / "recordings"}"\n{text}'


def ask(path):
    """The answer to `path`; nothing where there is none."""
    try:
        with urllib.request.urlopen(PAGE + path, timeout=5) as answer:
            return answer.read().decode()
    except OSError:
        return None


def cycles():
    lines = (ask("/metrics") or "").splitlines()
    return next((int(line.split()[1]) for line in lines if line.startswith("tertius_cycles_total ")), None)


def wait_for(what, process, done):
    end = time.monotonic() + PATIENCE
    while not done():
        if process.poll() is not None:
            raise SystemExit(f"readers: the gateway has ended ({process.returncode}) before {what}")
        if time.monotonic() > end:
            raise SystemExit(f"readers: {what} took more than {PATIENCE:.0f} s")
        time.sleep(0.05)


def threads(process):
    """The names of its threads."""
    found = []
    for task in Path(f"/proc/{process.pid}/task").iterdir():
        try:
            found.append((task / "comm").read_text().strip())
        except OSError:
            pass  # It has ended.
    return found


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--binary", required=True)
    parser.add_argument("--seconds", type=float, required=True)
    options = parser.parse_args()
    memory, tasks = limits()
    with tempfile.TemporaryDirectory() as folder, bounded(memory, tasks) as group:
        folder = Path(folder)
        (folder / "machine.toml").write_text(configuration(folder))
        hostile.keep(folder / "recordings")
        log = TOP / "tests/recordings/e-type-healthy.log.zst"
        command = group.command([options.binary, "run", "--config", folder / "machine.toml", "--play", log])
        with open(folder / "run.log", "w") as out:
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=out, stderr=out)
        try:
            wait_for("its first cycles", process, lambda: (cycles() or 0) > CYCLES)
            here, there = multiprocessing.Pipe()
            hostile.fill(folder / "kept.events")
            readers = multiprocessing.Process(target=hostile.Readers, args=(PORT, there), daemon=True)
            readers.start()
            end, most, found = time.monotonic() + options.seconds, [], 0
            answered = refused = 0
            while time.monotonic() < end:
                found = max(found, group.most(process))
                most = max(most, threads(process), key=len) if process.poll() is None else most
                answered, refused = (answered + 1, refused) if ask("/api/alarms") else (answered, refused + 1)
            before = cycles()
            wait_for("more cycles", process, lambda: (cycles() or 0) > (before or 0) + CYCLES)
            here.send("go")
            did = here.recv()
            readers.join()
            health = ask("/health")
        finally:
            process.terminate()
            process.wait(30)
        found, killed = max(found, group.most(process)), group.killed()
    print(f"readers: {', '.join(f'{kind} {count}' for kind, count in did.items())} connections of {len(hostile.ADDRESSES)} addresses")
    print(f"  a reader of another address was answered {answered} times, and not {refused} times")
    print(f"  memory {found / 2**20:.1f} MiB of {memory >> 20} {group.what}; "
          f"{killed} processes ended for it; {len(most)} threads of {tasks}")
    print(f"  the threads: {', '.join(f'{count} {name}' for name, count in sorted(Counter(most).items()))}")
    good = killed == 0 and 0 < found <= memory and health is not None and len(most) <= tasks and answered > 0 and refused == 0
    print(f"  alive and judging afterwards: {'yes' if good else 'NO'}")
    sys.exit(0 if good else 1)


main()
