"""A simulated machine whose detectors were taught, and what is said while it plays."""

import heapq
import json
import math
import random
import re
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

CONFIG = Path("config/e-type-simulated.toml")
PLANT = Path("config/e-type-plant.toml")
# The identifiers of candump lines that are not delayed: Sync.
PUNCTUAL = "080"
DELAYS = (0.019, 0.026)


@dataclass
class Heard:
    """Of a machine: its warnings, s of the notices of timing, and how many frames were late."""

    all: list = field(default_factory=list)
    timing: list = field(default_factory=list)
    late: int = 0

    @property
    def raised(self):
        return [warning for warning in self.all if warning["state"] == "raised"]


class Taught:
    """The machine with transducers of `coarse` times a count, calibrated while `befalls`."""

    def __init__(self, folder, binary, coarse, befalls, seconds, level):
        self.folder, self.binary, self.coarse = folder, binary, coarse
        self.config = folder / "taught.toml"
        log, tables = folder / "teaching.log", folder / "tables.toml"
        self.config.write_text(plain())
        plant = self.plant(befalls)
        self.call("simulate", "--config", CONFIG, "--plant", plant, "--seed", "77", "--duration", seconds,
                  "--output", log, "--force")
        self.call("calibrate", log, "--config", self.config, "--output", tables, "--force")
        cylinders = tables.read_text()
        cylinders = cylinders[cylinders.index("\n[[cylinder]]") :]
        log.unlink()
        # Each cylinder has its own, unless one is asked for; the lowest is told.
        own = [float(nats) for nats in re.findall(r"(?m)^level = ([0-9.]+)", cylinders)]
        self.level = min(own) if level is None else level
        self.config.write_text(plain(level) + cylinders)

    def call(self, *arguments):
        done = subprocess.run([self.binary, *map(str, arguments)], capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{' '.join(map(str, arguments))}\n{done.stderr}")

    def plant(self, befalls):
        """The plant's table, without the fluctuations of Figure 5-9."""
        text = PLANT.read_text()
        for old, new in [
            ("fluctuation_probability = 5.0e-4 ", "fluctuation_probability = 0.0 "),
            ("noise = 4.0e-5 ", "noise = 5.0e-5 "),
            ("counts = 27648.0 ", f"counts = {27648.0 / self.coarse} "),
        ]:
            assert text.count(old) == 1, old
            text = text.replace(old, new)
        path = self.folder / "plant.toml"
        path.write_text(text + (f"\n[disturbance]\n{befalls}\n" if befalls else ""))
        return path

    def play(self, seed, seconds, befalls="", late=None):
        """What is said of `seconds` of a machine, `late` of whose frames come late."""
        simulate = [self.binary, "simulate", "--config", CONFIG, "--plant", self.plant(befalls)]
        simulate += ["--seed", str(seed), "--duration", str(seconds)]
        replay = [self.binary, "replay", "-", "--config", self.config, "--format", "jsonl"]
        said = self.folder / "said.jsonl"
        heard = Heard()
        with said.open("w") as output:
            pipe = subprocess.PIPE
            machine = subprocess.Popen(simulate, stdout=pipe, stderr=subprocess.DEVNULL)
            through = pipe if late else machine.stdout
            monitor = subprocess.Popen(replay, stdin=through, stdout=output, stderr=subprocess.DEVNULL)
            if late:
                heard.late = delay(machine.stdout, monitor.stdin, late, random.Random(seed))
                monitor.stdin.close()
            machine.stdout.close()
            if machine.wait() or monitor.wait():
                raise SystemExit(f"{simulate} | {replay}: {machine.returncode}, {monitor.returncode}")
        for line in said.open():
            line = json.loads(line)
            if line["type"] == "warning":
                heard.all.append(line)
            elif line["type"] == "notice" and line["notice"] == "timing" and "skew" in line:
                heard.timing.append(float(line["t"]))
        return heard


def plain(level=None):
    """The configuration without anything that was taught."""
    text = CONFIG.read_text().replace('"../dbc/', f'"{Path("dbc").resolve()}/')
    text = text[: text.index("[[cylinder]]")]
    if level is not None:
        text = text.replace("[sequential]\n", f"[sequential]\nlevel = {level}\n")
    return text


def delay(frames, out, share, chance):
    """Passes candump lines, `share` of them 19 to 26 ms late; how many were."""
    waiting, count = [], 0
    for number, line in enumerate(frames):
        # (1234567890.123456) can0 181#…
        if waiting and waiting[0][0] <= line:
            at = line[: line.index(b")")]
            while waiting and waiting[0][0][: len(at)] <= at:
                out.write(heapq.heappop(waiting)[0])
        if chance.random() < share and line[line.rindex(b" ") + 1 :][:3] != PUNCTUAL.encode():
            end = line.index(b")")
            at = float(line[1:end]) + chance.uniform(*DELAYS)
            heapq.heappush(waiting, (b"(%.6f" % at + line[end:], number))
            count += 1
        else:
            out.write(line)
    while waiting:
        out.write(heapq.heappop(waiting)[0])
    return count


def at_most(count):
    """The expectation that `count` or fewer of a Poisson distribution have a chance of 5 % at."""
    low, high = 0.0, 10.0 * (count + 5)
    for _ in range(100):
        middle = 0.5 * (low + high)
        # In logarithms, so that no exponential is 0.
        terms = [k * math.log(middle) - math.lgamma(k + 1) - middle for k in range(count + 1)]
        most = max(terms)
        chance = most + math.log(sum(math.exp(term - most) for term in terms))
        low, high = (middle, high) if chance > math.log(0.05) else (low, middle)
    return high
