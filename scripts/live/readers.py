"""The gateway in a control group of its unit's limits, with readers who behave badly; run by scripts/readers, see there."""

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
    """A control group of `memory` bytes, until it is left."""

    def __init__(self, memory):
        new = "memory" in (GROUPS / "cgroup.controllers").read_text() if (GROUPS / "cgroup.controllers").exists() else False
        self.version = 2 if new else 1
        self.path = (GROUPS if new else GROUPS / "memory") / f"tertius-readers-{os.getpid()}"
        names = {1: ("memory.limit_in_bytes", "memory.max_usage_in_bytes", "memory.oom_control"),
                 2: ("memory.max", "memory.peak", "memory.events")}
        self.limit, self.peak, self.events = names[self.version]
        if new:
            (GROUPS / "cgroup.subtree_control").write_text("+memory")
        self.path.mkdir()
        (self.path / self.limit).write_text(str(memory))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.path.rmdir()

    def most(self):
        return int((self.path / self.peak).read_text())

    def killed(self):
        """How many processes the kernel has ended for their memory."""
        lines = dict(line.split() for line in (self.path / self.events).read_text().splitlines())
        return int(lines["oom_kill"])


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
    with tempfile.TemporaryDirectory() as folder, Group(memory) as group:
        folder = Path(folder)
        (folder / "machine.toml").write_text(configuration(folder))
        hostile.keep(folder / "recordings")
        log = TOP / "tests/recordings/e-type-healthy.log.zst"
        joined = f'echo $$ > {group.path}/cgroup.procs && exec "$@"'
        command = ["sh", "-c", joined, "sh", options.binary, "run", "--config", folder / "machine.toml", "--play", log]
        with open(folder / "run.log", "w") as out:
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=out, stderr=out)
        try:
            wait_for("its first cycles", process, lambda: (cycles() or 0) > CYCLES)
            here, there = multiprocessing.Pipe()
            hostile.fill(folder / "kept.events")
            readers = multiprocessing.Process(target=hostile.Readers, args=(PORT, there), daemon=True)
            readers.start()
            end, most = time.monotonic() + options.seconds, []
            answered = refused = 0
            while time.monotonic() < end:
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
        found, killed = group.most(), group.killed()
    print(f"readers: {', '.join(f'{kind} {count}' for kind, count in did.items())} connections of {len(hostile.ADDRESSES)} addresses")
    print(f"  a reader of another address was answered {answered} times, and not {refused} times")
    print(f"  memory {found / 2**20:.1f} MiB of {memory >> 20}, with what the kernel gives back (version {group.version}); "
          f"{killed} processes ended for it; {len(most)} threads of {tasks}")
    print(f"  the threads: {', '.join(f'{count} {name}' for name, count in sorted(Counter(most).items()))}")
    good = killed == 0 and health is not None and len(most) <= tasks and answered > 0 and refused == 0
    print(f"  alive and judging afterwards: {'yes' if good else 'NO'}")
    sys.exit(0 if good else 1)


main()
