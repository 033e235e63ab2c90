"""One recording on one thread and on several: times in turn, and the instructions of each thread under callgrind.

Run by scripts/bench-threads; see there. Instructions tell what two cores can give at most: as many times the speed as all
of one thread's are to those of the busiest of several, or to half of theirs. What handing over costs in caches is not
among them.
"""

import re
import statistics
import subprocess
import sys
import time
from pathlib import Path

TOP = Path(__file__).resolve().parents[2]
CONFIG = TOP / "tests/recordings/e-type.toml"
TABLES = TOP / "tests/recordings/e-type-sequential.toml"
# Of the recording under callgrind, s; the difference between the two excludes the start.
LONG, SHORT = 120, 12
FORMATS = ["log", "log.zst", "log.gz", "blf", "asc"]


def recorded(program, folder, name, seconds):
    """A simulated machine's recording in all formats, by the ending of its name."""
    logs = {ending: folder / f"{name}.{ending}" for ending in FORMATS}
    if not logs["log"].exists():
        call = [program, "simulate", "--config", TABLES, "--duration", str(seconds), "--seed", "7"]
        subprocess.run([*call, "--output", logs["log"]], check=True, stderr=subprocess.DEVNULL)
    for ending, log in logs.items():
        if not log.exists():
            subprocess.run([program, "convert", logs["log"], log], check=True, capture_output=True)
    return logs


def call(program, log, config, threads, residuals):
    table = ["--residuals", "/dev/null"] if residuals else []
    return [program, "replay", log, "--config", config, "--threads", str(threads), *table]


def counted(program, folder, *what):
    """Instructions of each thread."""
    out = folder / "callgrind.out"
    for old in folder.glob("callgrind.out*"):
        old.unlink()
    valgrind = ["valgrind", "--tool=callgrind", "--separate-threads=yes", f"--callgrind-out-file={out}"]
    subprocess.run([*valgrind, *map(str, call(program, *what))], check=True, capture_output=True)
    threads = sorted(folder.glob("callgrind.out-*"))
    totals = [re.findall(r"^(?:totals|summary): (\d+)", path.read_text(), re.M) for path in threads]
    return [max(map(int, total)) for total in totals if total]


def instructions(program, folder, logs, what):
    """Instructions a frame on one thread, and of each with --threads 2; the recording has `frames` more than the shorter one."""
    (long, short), (ending, *rest) = logs, what
    costs = []
    for threads in (1, 2):
        more, less = (counted(program, folder, log[ending], rest[0], threads, rest[1]) for log in (long, short))
        costs.append([a - b for a, b in zip(more, less)])
    frames = sum(1 for _ in long["log"].open()) - sum(1 for _ in short["log"].open())
    return [[cost / frames for cost in threads] for threads in costs]


def timed(program, logs, what, rounds):
    """Medians of the wall time on one thread and with --threads 2, s."""
    ending, config, residuals = what
    times = {1: [], 2: []}
    for _ in range(rounds):
        for threads, taken in times.items():
            began = time.perf_counter()
            command = call(program, logs[ending], config, threads, residuals)
            subprocess.run(command, check=True, capture_output=True)
            taken.append(time.perf_counter() - began)
    return [statistics.median(taken) for taken in times.values()]


def main(program, folder, minutes, rounds):
    folder = Path(folder)
    counting = [recorded(program, folder, f"{seconds}-s", seconds) for seconds in (LONG, SHORT)]
    timing = recorded(program, folder, f"{minutes}-min", 60 * int(minutes)) if int(rounds) else None
    print("| recording | a frame on one thread | judging, reading, writing | at most |", "one, s | two, s | |" if timing else "")
    for config, residuals in ((CONFIG, False), (TABLES, False), (CONFIG, True)):
        for ending in FORMATS:
            what = (ending, config, residuals)
            (one,), two = instructions(program, folder, counting, what)
            # Order of the threads: judging begins, then comes who writes, then who reads.
            if residuals:
                two = [two[0], two[2], two[1]]
            name = ending + (", sequential tables" if config == TABLES else "") + (", `--residuals`" if residuals else "")
            row = f"| {name} | {one:.0f} | {', '.join(f'{it:.0f}' for it in two)} | {one / max(*two, sum(two) / 2):.2f} |"
            if timing:
                alone, both = timed(program, timing, what, int(rounds))
                row += f" {alone:.3f} | {both:.3f} | {alone / both:.2f} |"
            print(row, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
