"""Measures `tertius replay` beside `wc -l` and python-can with cantools, in turn, some rounds.

Run by scripts/bench-replay; see there. Only the standard library is imported here: a process that
is started begins with the peak memory of the one that starts it.
"""

import argparse
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

TOP = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent
SOURCE = TOP / "tests/recordings/e-type-healthy.log.zst"
CONFIG = TOP / "tests/recordings/e-type.toml"
DBC = TOP / "dbc/e-type.dbc"
SOURCE_FRAMES = 660_000

# What is asked for.
LEAST_FRAMES = 5_000_000
LEAST_RATE = 10e6  # frames/s
LEAST_RATIO = 50  # to python-can with cantools
MOST_MEMORY = 64  # MiB
LARGER = 4  # times as long, for the memory


def arguments():
    parser = argparse.ArgumentParser(prog="scripts/bench-replay")
    parser.add_argument("folder", nargs="?", help="keeps the recordings there for the next time")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--repetitions", type=int, default=8, help=f"of {SOURCE_FRAMES} frames")
    parser.add_argument("--reference-frames", type=int, default=1_000_000)
    parser.add_argument("--binary", type=Path, default=TOP / "target/release/tertius")
    return parser.parse_args()


def run(command, output):
    """Runs a command to its end: wall and CPU seconds, peak memory in MiB, of the whole process."""
    with open(output, "wb") as file:
        start = time.perf_counter()
        child = os.posix_spawnp(
            command[0], command, os.environ, file_actions=[(os.POSIX_SPAWN_DUP2, file.fileno(), 1)]
        )
        _, status, usage = os.wait4(child, 0)
        wall = time.perf_counter() - start
    if status != 0:
        sys.exit(f"{' '.join(command)} failed: {os.waitstatus_to_exitcode(status)}")
    cpu = usage.ru_utime + usage.ru_stime
    return {"wall": wall, "cpu": cpu, "memory": usage.ru_maxrss / 1024}


def make(folder, repetitions):
    """The recordings, by their kind; those that are there already are taken as they are."""
    names = {kind: folder / f"{repetitions}.log{kind}" for kind in ("", ".gz", ".zst")}
    names["larger"] = folder / f"{LARGER * repetitions}.log"
    for count, paths in (
        (repetitions, [names[""], names[".gz"], names[".zst"]]),
        (LARGER * repetitions, [names["larger"]]),
    ):
        if not all(path.exists() for path in paths):
            print(f"making {', '.join(path.name for path in paths)}", file=sys.stderr)
            # Under another name until they are whole.
            parts = [path.with_name(f"part-{path.name}") for path in paths]
            command = [sys.executable, HERE / "recording.py", SOURCE, count, *parts]
            subprocess.run(list(map(str, command)), check=True)
            for part, path in zip(parts, paths):
                part.rename(path)
    return names


class Replay:
    """`tertius replay` with everything on except --residuals."""

    def __init__(self, binary, folder):
        self.binary, self.folder = binary, folder

    def of(self, log, frames):
        output, warnings = self.folder / "replay.jsonl", self.folder / "warnings.log"
        command = [self.binary, "replay", log, "--config", CONFIG, "--format", "jsonl", "--threads", "1"]
        figures = run([*map(str, command), "--warnings", str(warnings), "--force"], output)
        self.check(json.loads(output.read_text().splitlines()[-1]), frames)
        return figures | {"frames": frames}

    @staticmethod
    def check(summary, frames):
        """That the recording is what it should be: whole, without a seam that shows."""
        wrong = [key for key in ("bad_lines", "missing_cycles", "incomplete_cycles", "time_jumps")
                 if summary[key] != 0]
        jumps = [cylinder["counter_jumps"] for cylinder in summary["cylinders"]]
        if summary["frames"] != frames or wrong or any(map(any, jumps)):
            sys.exit(f"the replay is not of the recording that was made: {summary}")
        if any(summary["warnings"].values()):
            sys.exit(f"the healthy recording raised warnings: {summary['warnings']}")


def reference(log, most, folder):
    output = folder / "reference.json"
    run([sys.executable, *map(str, (HERE / "reference.py", log, DBC, most))], output)
    return json.loads(output.read_text())


def measure(options, folder):
    logs, frames = make(folder, options.repetitions), options.repetitions * SOURCE_FRAMES
    replay = Replay(options.binary, folder)
    count = ["wc", "-l"]
    rounds = []
    for number in range(options.rounds + 1):
        print(f"round {number} of {options.rounds}", file=sys.stderr)
        figures = {
            "replay": replay.of(logs[""], frames),
            "wc -l": run([*count, str(logs[""])], folder / "wc") | {"frames": frames},
            "python": reference(logs[""], options.reference_frames, folder),
            "replay .gz": replay.of(logs[".gz"], frames),
            "replay .zst": replay.of(logs[".zst"], frames),
        }
        # The first round brings the files into memory and is not counted.
        if number > 0:
            rounds.append(figures)
    larger = replay.of(logs["larger"], LARGER * frames)
    return rounds, larger


def rate(figures, clock):
    return figures["frames"] / figures[clock]


def spread(values, form):
    low, middle, high = min(values), statistics.median(values), max(values)
    return f"{middle:{form}} ({low:{form}} to {high:{form}})"


def report(rounds, larger):
    names = {"python": "python-can and cantools"}
    print("M frames/s, median (least to most):")
    print(f"  {'':24} {'by CPU time':24} by wall time")
    for key in rounds[0]:
        by_cpu, by_wall = (
            spread([rate(figures[key], clock) / 1e6 for figures in rounds], ".3g")
            for clock in ("cpu", "wall")
        )
        print(f"  {names.get(key, key):24} {by_cpu:24} {by_wall}")

    def ratios(one, other):
        return [rate(f[one], "cpu") / rate(f[other], "cpu") for f in rounds]

    print("ratios of the same round, by CPU time:")
    print(f"  replay / python-can and cantools: {spread(ratios('replay', 'python'), '.0f')}")
    print(f"  replay / wc -l: {spread(ratios('replay', 'wc -l'), '.4f')}")
    print("peak memory, MiB:")
    for key in ("replay", "replay .gz", "replay .zst"):
        print(f"  {key:24} {max(figures[key]['memory'] for figures in rounds):.1f}")
    print(f"  {f'replay, {LARGER} × as long':24} {larger['memory']:.1f}")
    own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"  (less than {own:.1f}, that of this script, cannot be seen)")


def judge(rounds, larger):
    """Whether what is asked for is reached."""
    speed = statistics.median(rate(f["replay"], "cpu") for f in rounds)
    ratio = statistics.median(rate(f["replay"], "cpu") / rate(f["python"], "cpu") for f in rounds)
    figures = [f[key] for f in rounds for key in f if key.startswith("replay")]
    memory = max(f["memory"] for f in [*figures, larger])
    fast = speed >= LEAST_RATE or ratio >= LEAST_RATIO
    print(f"asked for: {LEAST_RATE / 1e6:.0f} M frames/s or {LEAST_RATIO} × python-can and "
          f"cantools, memory below {MOST_MEMORY} MiB: "
          f"{'reached' if fast and memory < MOST_MEMORY else 'NOT reached'}")
    return fast and memory < MOST_MEMORY


def main():
    options = arguments()
    frames = options.repetitions * SOURCE_FRAMES
    print(f"{frames / 1e6:.2f} M frames, {options.rounds} rounds; python-can and cantools on the "
          f"first {options.reference_frames / 1e6:.2f} M")
    if frames < LEAST_FRAMES:
        print(f"fewer than the {LEAST_FRAMES / 1e6:.0f} M frames that are asked for")
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(options.folder or temporary)
        folder.mkdir(parents=True, exist_ok=True)
        rounds, larger = measure(options, folder)
    report(rounds, larger)
    sys.exit(0 if judge(rounds, larger) else 1)


if __name__ == "__main__":
    main()
