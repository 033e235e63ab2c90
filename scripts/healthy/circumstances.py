"""Machines that are commissioned as an engineer does it, then meet what their lesson did not have and is no fault; run by
scripts/sweep-healthy circumstances, see there."""

import json
import os
import random
import re
import subprocess
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from machine import at_most

CONFIG = Path("config/e-type-simulated.toml")
PLANT = Path("config/e-type-hydraulic-plant.toml")
GRADES = {"fine": 1, "coarse": 4}
ALWAYS = "time = [0.0, 1e9]"


@dataclass
class Circumstance:
    """What differs from the machine that was commissioned."""

    name: str
    # Numbers of the plant, by table and key: a value, or a function of the present one.
    numbers: dict = field(default_factory=dict)
    # Tables that it adds to the plant's.
    tables: str = ""
    sea: str = "1.5,7"
    # Faults by the text of `--fault`; a row with one counts what is said of a machine that is not healthy.
    fault: str = ""


def times(factor):
    return lambda value: value * factor


def disturbed(what):
    return f"[disturbance]\n{what}\n"


# Four times Coulomb's.
STICK_SLIP = {("friction", "stiction"): 8.8e3, ("friction", "stribeck_speed"): 0.004}
WARM = "".join(f"[{side}.warming]\namplitudes = {[sign * 4e-4 * (-1) ** leg for leg in range(6)]}\nperiod = 3600.0\n"
               for side, sign in (("c1", 1), ("c2", -1)))
SEAS = ["0.6,6", "1,6.5", "1.5,7", "2,8", "2.5,8", "3,9"]
CIRCUMSTANCES = [
    *(Circumstance(f"sea of {sea.replace(',', ' m and ')} s", sea=sea) for sea in SEAS),
    Circumstance("stick-slip of the seals, sea of 0.3 m", numbers=STICK_SLIP, sea="0.3,6"),
    Circumstance("the same, 1.5 m", numbers=STICK_SLIP),
    Circumstance("the same, friction × 1.5", numbers=STICK_SLIP | {("friction", "coulomb"): times(1.5),
                 ("friction", "viscous"): times(1.5)}),
    Circumstance("loads change by up to 30 % within a second, every minute",
                 tables=disturbed(f"load_steps = {{ {ALWAYS}, part = 0.3, every = 60.0, within = 1.0 }}")),
    Circumstance("dead band wanders by ±40 % in an hour",
                 numbers={("thermal", "overlap"): 0.4, ("thermal", "period"): 3600.0}),
    Circumstance("swell of 20 s, 0.5 m", sea="0.5,20"),
    *(Circumstance(f"C1 and C2 sampled together, {ms:g} ms of jitter",
                   tables=disturbed(f"sampling = {{ {ALWAYS}, shared_jitter = {ms / 1000} }}")) for ms in (0.5, 1.0)),
    Circumstance("C2 sampled 0.5 ms beside C1", tables=disturbed(f"sampling = {{ {ALWAYS}, skew = 0.0005 }}")),
    *(Circumstance(f"spikes of {share:g} % of four counts on both",
                   tables=disturbed(f"spikes = {{ {ALWAYS}, share = [{share / 100}, {share / 100}], counts = 4.0 }}"))
      for share in (0.5, 1.0, 2.0)),
    *(Circumstance(f"spikes of {share:g} % of forty counts on both",
                   tables=disturbed(f"spikes = {{ {ALWAYS}, share = [{share / 100}, {share / 100}], counts = 40.0 }}"))
      for share in (0.5, 2.0)),
    Circumstance("transducers warm by ±0.4 mm in an hour", tables=WARM),
    Circumstance("several at once", sea="2,8", numbers=STICK_SLIP | {("thermal", "overlap"): 0.2,
                 ("friction", "stiction"): times(2.0)},
                 tables=disturbed(f"load_steps = {{ {ALWAYS}, part = 0.2, every = 60.0, within = 1.0 }}\n"
                 f"spikes = {{ {ALWAYS}, share = [0.005, 0.005], counts = 4.0 }}\n"
                 "pump = { time = [900.0, 930.0], part = 0.3 }")),
    *(Circumstance(f"a valve sticks within {band:g} %", fault=f"sticking,cylinder=3,at=300,band={band / 100}")
      for band in (0.5, 1.0)),
    Circumstance("a valve leaks 5 mm/s", fault="valve_leakage,cylinder=3,at=300,speed=0.005"),
    Circumstance("friction × 3", fault="friction,cylinder=3,at=300,factor=3"),
    *(Circumstance(f"supply −{part} %", fault=f"supply_loss,cylinder=3,at=300,part={part / 100}") for part in (10, 20)),
]


def drawn(seed, coarse):
    """The plant of a machine of this seed, as text: valves, loads, friction and calibration of its own."""
    chance, text = random.Random(seed), PLANT.read_text()
    around = lambda part: lambda value: value * chance.uniform(1 - part, 1 + part)
    for table, key, change in [
        ("spread", "extend", around(0.08)),
        ("spread", "retract", around(0.05)),
        ("spread", "load", around(0.15)),
        ("friction", "viscous", around(0.2)),
        ("friction", "coulomb", around(0.2)),
        ("valve", "lag", around(0.3)),
        ("valve", "overlap", around(0.3)),
        ("c1", "offset", around(0.5)),
        ("c2", "offset", around(0.5)),
        ("c2", "gain", around(0.5)),
        ("transducer", "counts", times(1 / coarse)),
    ]:
        text = changed(text, table, key, change)
    return text


def changed(text, table, key, change):
    """`text` with the numbers of a key changed; the key is added where it is absent and the change is a number."""
    head = re.search(rf"(?m)^\[{re.escape(table)}\].*\n", text)
    assert head, table
    end = re.compile(r"(?m)^\[").search(text, head.end())
    body = text[head.end() : end.start() if end else len(text)]
    line = re.search(rf"(?m)^{key} = ([^#\n]*)", body)
    if not line:
        assert not callable(change), f"{table}.{key}"
        return text[: head.end()] + f"{key} = {change}\n" + text[head.end() :]
    value = re.sub(r"-?\d+\.?\d*(?:e-?\d+)?", lambda it: repr(float(change(float(it[0]))
                   if callable(change) else change)), line[1])
    at = head.end() + line.start(1)
    return text[:at] + value + text[at + len(line[1]) :]


def befallen(text, it):
    """The plant's text in a circumstance."""
    for (table, key), change in it.numbers.items():
        text = changed(text, table, key, change)
    return f"{text}\n{it.tables}"


class Commissioned:
    """A machine drawn by a seed, which `tertius commission` taught."""

    def __init__(self, folder, binary, seed, grade, lesson, lesson_sea):
        self.folder, self.binary, self.seed = folder / f"{grade}-{seed}", binary, seed
        self.folder.mkdir(parents=True, exist_ok=True)
        self.text = drawn(seed, GRADES[grade])
        plant = self.folder / "plant.toml"
        plant.write_text(self.text)
        log, self.config = self.folder / "lesson.log", self.folder / "machine.toml"
        template = self.folder / "template.toml"
        template.write_text(CONFIG.read_text().replace('"../dbc/', f'"{Path("dbc").resolve()}/'))
        if not self.config.exists():
            self.call("simulate", "--config", CONFIG, "--plant", plant, "--seed", seed, "--sea", lesson_sea,
                      "--duration", lesson, "--output", log, "--force")
            # A cylinder that is refused keeps its present tables, and is watched as well.
            self.call("commission", log, "--config", template, "--output", self.config, "--accept-refused", "--force")
            log.unlink()

    def call(self, *arguments):
        done = subprocess.run([self.binary, *map(str, arguments)], capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{' '.join(map(str, arguments))}\n{done.stdout[-2000:]}\n{done.stderr}")

    def play(self, number, it, seconds, lost):
        """The lines of JSON that a replay prints of an hour in a circumstance, those that judge. After ten minutes each
        cylinder may have `lost` a transducer, of which nothing is counted then."""
        plant = self.folder / f"plant-{number}.toml"
        plant.write_text(befallen(self.text, it))
        simulate = [self.binary, "simulate", "--config", CONFIG, "--plant", plant, "--sea", it.sea,
                    "--seed", str(self.seed * 1000 + number), "--duration", str(seconds)]
        if it.fault:
            simulate += ["--fault", it.fault]
        gone = {n: f"c{1 + n % 2}" for n in range(1, 7)} if lost else {}
        for n, sensor in gone.items():
            simulate += ["--fault", f"loss,cylinder={n},sensor={sensor},at={600 + 2 * n},probability=1"]
        replay = [self.binary, "replay", "-", "--config", self.config, "--format", "jsonl"]
        machine = subprocess.Popen(simulate, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        monitor = subprocess.Popen(replay, stdin=machine.stdout, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        machine.stdout.close()
        said = [json.loads(line) for line in monitor.stdout]
        said = [it for it in said if "suspect" not in it or it["suspect"] != gone.get(it["cylinder"])]
        error = machine.stderr.read().decode()
        if machine.wait():
            raise SystemExit(f"{simulate}: {error}")
        monitor.wait()
        return said


def summary(said):
    """Warnings by detector, incidents by what they are called, and notices."""
    raised = Counter(it["detector"] for it in said if it["type"] == "warning" and it["state"] == "raised")
    last = {it["incident"]: it for it in said if it["type"] == "incident"}
    incidents = Counter((it["suspect"], it["fault"]) for it in last.values())
    notices = Counter(it["notice"] for it in said if it["type"] == "notice")
    return raised, incidents, notices


def circumstances(options, folder):
    kept = Path(options.keep) if options.keep else folder
    machines = [(grade, seed) for grade in options.grades for seed in options.machines]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        make = lambda it: Commissioned(kept, options.binary, it[1], it[0], options.teach, options.taught_sea)
        made = list(pool.map(make, machines))
        print("| circumstance | transducers | hours | FDE1, FDE2 | FDE3 | sequential | process | others | "
              "warnings an hour, at most (95 %) | incidents | notices |\n" + "| --- " * 11 + "|")
        for number, it in enumerate(CIRCUMSTANCES):
            if options.only and not re.search(options.only, it.name):
                continue
            played = list(pool.map(lambda one: one.play(number, it, round(3600 * options.hours), options.lost), made))
            for grade in options.grades:
                raised, incidents, notices = Counter(), Counter(), Counter()
                hours = 0.0
                for (of, _), said in zip(machines, played):
                    if of == grade:
                        hours += options.hours
                        for total, more in zip((raised, incidents, notices), summary(said)):
                            total.update(more)
                known = ["fde1", "fde2", "fde3", "sequential", "process"]
                others = sum(raised.values()) - sum(raised[one] for one in known)
                of = ", ".join(f"{count} {' '.join(key)}" for key, count in incidents.most_common(5))
                told = ", ".join(f"{count} {key}" for key, count in notices.items())
                count = sum(raised.values())
                print(f"| {it.name} | {grade} | {hours:g} | {raised['fde1'] + raised['fde2']} | {raised['fde3']} | "
                      f"{raised['sequential']} | {raised['process']} | {others} | {at_most(count) / hours:.3g} | "
                      f"{of} | {told} |", flush=True)
