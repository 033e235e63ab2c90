"""Counts the instructions of `tertius replay` under callgrind, a frame, and says where they go.

Run by scripts/bench-instructions; see there. What other work does to the machine does not touch these
numbers, so that a change of one in a hundred shows. They are not time: a division counts as one, and so
does a load that misses the cache.
"""

import argparse
import json
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

TOP = Path(__file__).resolve().parents[2]
SOURCE = TOP / "tests/recordings/e-type-healthy.log.zst"
CONFIG = TOP / "tests/recordings/e-type.toml"
SEQUENTIAL = TOP / "tests/recordings/e-type-sequential.toml"
UNCALIBRATED = TOP / "config/e-type.toml"
DBC = TOP / "dbc/e-type.dbc"
# Frames of the engaged stretch: all detectors judge from its first cycle to its last.
ENGAGED = slice(220_000, 440_000)
# What the shorter run has of a recording: start and end, which are in both, and hardly anything else.
SHORTER = 0.01

# Of a frame of the healthy recording, everything on but sequential tables.
MOST = 660
# Of a cycle with sequential tables to one without.
MOST_RATIO = 1.5

# What a file of src/ is counted as; the first that fits.
ROOMS = [
    ("candump lines", r"(formats?|buffer|recording|statistics|input)[/.]"),
    ("decode", r"decode/|monitor/(intake|subscriptions)"),
    ("plausibility", r"sample/plausibility|monitor/implausible"),
    ("sample", r"sample/"),
    ("observe (FDE1, FDE2)", r"observe/"),
    ("compare (FDE3)", r"compare/"),
    ("verdict", r"verdict/"),
    ("sequential", r"sequential/"),
    ("estimate", r"estimate/"),
    ("alarm", r"alarm/"),
    ("monitor, of a cylinder", r"monitor/cylinder"),
    ("monitor", r"monitor/"),
    ("report", r"report/|cli/"),
]
# Helpers of a line or two, counted where they are used.
HELPERS = re.compile(r"src/(time|frame)\.rs")


class Profile:
    """What callgrind counted in one run."""

    def __init__(self, binary, log, config, folder):
        out, output = folder / "callgrind.out", folder / "replay.jsonl"
        sent = folder / "warnings.log"
        for file in (out, sent):
            file.unlink(missing_ok=True)
        command = ["valgrind", "--tool=callgrind", "--dump-instr=yes", f"--callgrind-out-file={out}"]
        command += [binary, "replay", log, "--config", config, "--format", "jsonl", "--threads", "1"]
        command += ["--warnings", sent]
        with open(output, "wb") as file:
            done = subprocess.run(list(map(str, command)), stdout=file, stderr=subprocess.PIPE, text=True)
        lines = output.read_text().splitlines()
        summary = json.loads(lines[-1]) if lines else {}
        # In a beginning nothing may have been judged yet, which is a failure of its own.
        if done.returncode != 0 and summary.get("judged", True):
            sys.exit(f"{' '.join(map(str, command))} failed:\n{done.stderr}")
        self.own, self.foreign = read(out, binary)
        self.frames = summary["frames"]
        self.samples = sum(cylinder["samples"] for cylinder in summary["cylinders"])

    def less(self, other):
        """Without what `other` counted, of fewer frames of the same recording."""
        self.own.subtract(other.own)
        self.foreign.subtract(other.foreign)
        self.frames -= other.frames
        self.samples -= other.samples
        return self

    def total(self):
        return self.own.total() + self.foreign.total()

    def a_frame(self):
        return self.total() / self.frames


def read(path, binary):
    """Instructions of the program by address, and of libraries by function."""
    binary = str(binary.resolve())
    own, foreign = Counter(), Counter()
    names, addresses = {}, {}
    where = obj = None
    called = False
    for line in path.open():
        if match := re.match(r"c?(ob|fn)=\((\d+)\)(?: (.*))?$", line):
            kind, number, name = match.groups()
            if name is not None:
                names[kind, number] = name
            if line.startswith("ob="):
                obj = names[kind, number]
            elif line.startswith("fn="):
                where = names[kind, number]
        elif line.startswith("calls="):
            # What follows is the cost of what is called, which is told there.
            called = True
        elif line.startswith(("0x", "+", "-", "*")):
            at, _, cost, *_ = line.split() + ["0"]
            if at.startswith("0x"):
                addresses["now"] = int(at, 16)
            elif at != "*":
                addresses["now"] += int(at, 0)
            if not called:
                if obj == binary:
                    own[addresses["now"]] += int(cost)
                else:
                    foreign[where] += int(cost)
            called = False
    return own, foreign


def rooms(binary, profile):
    """Instructions by room: by the innermost function of src/ that is inlined at an address."""
    addresses = [at for at, cost in profile.own.items() if cost]
    asked = subprocess.run(
        ["addr2line", "--inlines", "--addresses", "--exe", str(binary)],
        input="".join(f"{at:#x}\n" for at in addresses), text=True, capture_output=True, check=True,
    ).stdout
    found, at = {}, None
    for line in asked.splitlines():
        if line.startswith("0x"):
            at = int(line, 16)
        elif at not in found and "/.cargo/" not in line and "/rustc/" not in line:
            if (match := re.search(r"/src/(\S+\.rs)", line)) and not HELPERS.search(line):
                found[at] = match.group(1)
    counted = Counter()
    for at in addresses:
        name = found.get(at, "")
        room = next((room for room, files in ROOMS if re.match(files, name)), "other")
        counted[room] += profile.own[at]
    counted["libraries (memcpy, libm)"] += profile.foreign.total()
    return counted


def lines_of(folder):
    """The recording, plain."""
    path = folder / "healthy.log"
    with open(path, "wb") as file:
        subprocess.run(["zstd", "--decompress", "--stdout", "--quiet", SOURCE], stdout=file, check=True)
    return path.read_bytes().splitlines(keepends=True)


def recordings(lines, folder, name):
    """The recording and its beginning."""
    paths = [folder / f"{name}.log", folder / f"{name}-beginning.log"]
    for path, count in zip(paths, (len(lines), int(SHORTER * len(lines)))):
        path.write_bytes(b"".join(lines[:count]))
    return paths


def with_estimates(folder):
    """The configuration with estimates that are sent."""
    text = CONFIG.read_text().replace('dbc = "../../dbc/e-type.dbc"', f'dbc = "{DBC}"')
    path = folder / "estimates.toml"
    path.write_text(text + "\n[estimate]\nsend = true\n\n[gateway]\nbus_share = 0.15\n")
    return path


def measure(binary, folder):
    lines = lines_of(folder)
    whole = recordings(lines, folder, "whole")
    engaged = recordings(lines[ENGAGED], folder, "engaged")

    def profile(logs, config):
        longer, shorter = (Profile(binary, log, config, folder) for log in logs)
        return longer.less(shorter)

    return {
        "whole": profile(whole, CONFIG),
        "whole, uncalibrated: warnings stand": profile(whole, UNCALIBRATED),
        "whole, with estimates sent": profile(whole, with_estimates(folder)),
        "whole, with sequential tables": profile(whole, SEQUENTIAL),
        "engaged": profile(engaged, CONFIG),
        "engaged, with sequential tables": profile(engaged, SEQUENTIAL),
    }


def report(binary, profiles):
    print(f"{'instructions':38} a frame   a cylinder and cycle")
    for name, profile in profiles.items():
        print(f"  {name:36} {profile.a_frame():7.1f} {profile.total() / profile.samples:12.1f}")
    shown = ["whole", "engaged, with sequential tables"]
    print(f"\n{'a frame, by room':38} " + "   ".join(shown))
    tables = [rooms(binary, profiles[name]) for name in shown]
    names = sorted(set().union(*tables), key=lambda room: -tables[0][room])
    for room in names:
        columns = [table[room] / profiles[name].frames for table, name in zip(tables, shown)]
        print(f"  {room:36} " + " ".join(f"{column:7.1f}" for column in columns))


def judge(profiles):
    """Whether what is asked for is reached."""
    cost = profiles["whole"].a_frame()
    reached = [cost <= MOST]
    print(f"\na frame: {cost:.0f}, at most {MOST}: {word(reached[-1])}")
    for name in ("whole", "engaged"):
        ratio = profiles[f"{name}, with sequential tables"].a_frame() / profiles[name].a_frame()
        reached.append(ratio <= MOST_RATIO)
        print(f"a cycle with sequential tables to one without, {name}: {ratio:.2f}, at most "
              f"{MOST_RATIO}: {word(reached[-1])}")
    return all(reached)


def word(is_reached):
    return "reached" if is_reached else "NOT reached"


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench-instructions")
    parser.add_argument("--binary", type=Path, default=TOP / "target/release/tertius")
    options = parser.parse_args()
    for program in ("valgrind", "addr2line", "zstd"):
        if shutil.which(program) is None:
            sys.exit(f"{program} is not installed; Debian has it in the package "
                     f"{'binutils' if program == 'addr2line' else program}")
    with tempfile.TemporaryDirectory() as temporary:
        profiles = measure(options.binary, Path(temporary))
    report(options.binary, profiles)
    sys.exit(0 if judge(profiles) else 1)


if __name__ == "__main__":
    main()
