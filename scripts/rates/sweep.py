"""The same faults on machines of several sample times; run by scripts/sweep-rates, see there."""

import argparse
import csv
import json
import math
import re
import statistics
import subprocess
import tempfile
from pathlib import Path

CONFIG = Path("config/e-type-simulated.toml")
PLANT = Path("config/e-type-plant.toml")
USUAL = 50.0
# (name, columns of the injector's table)
FAULTS = [
    *((f"step {size:g} mm", ("step", size * 1e-3)) for size in (0.3, 0.5, 1.0, 2.0)),
    *((f"drift {rate:g} mm/s", ("drift", rate * 1e-3)) for rate in (0.1, 0.3, 1.0)),
    *((f"noise {size:g} mm", ("noise", size * 1e-3)) for size in (0.4, 0.8, 2.0)),
]
# One cylinder after the other; not on the grid of any of the sample times.
FIRST, APART, LASTS = 60.0, 40.0, 25.0
LENGTH = 300
DETECTORS = ("sequential", "fde3")


class Machine:
    """The machine at so many cycles a second, with what was learnt of it at that rate."""

    def __init__(self, folder, binary, rate, seconds):
        self.binary, self.rate, self.folder = binary, rate, folder
        self.config, self.plant = folder / "machine.toml", folder / "plant.toml"
        self.plant.write_text(plant())
        self.config.write_text(plain(rate))
        teaching, tables = folder / "teaching.log", folder / "tables.toml"
        self.simulate(77, seconds, teaching)
        self.call("identify", teaching, "--config", self.config, "--output", tables, "--force")
        self.config.write_text(plain(rate) + "\n" + of(tables.read_text(), "model"))
        self.call("calibrate", teaching, "--config", self.config, "--output", tables, "--force")
        cylinders = of(tables.read_text(), "[cylinder]")
        self.config.write_text(self.config.read_text() + "\n" + cylinders)
        teaching.unlink()

    def call(self, *arguments):
        done = subprocess.run([self.binary, *map(str, arguments)], capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{' '.join(map(str, arguments))}\n{done.stderr}")
        return done.stdout

    def simulate(self, seed, seconds, log):
        self.call("simulate", "--config", self.config, "--plant", self.plant, "--seed", seed,
                  "--duration", seconds, "--output", log, "--force")

    def warnings(self, log):
        said = self.call("replay", log, "--config", self.config, "--format", "jsonl")
        lines = [json.loads(line) for line in said.splitlines()]
        return [line for line in lines if line["type"] == "warning"]

    def faulty(self, log, kind, size):
        """When the fault of each cylinder begins, s since the first frame, and a recording with them."""
        table, faulty = self.folder / "faults.csv", self.folder / "faulty.log"
        begins = {n: FIRST + APART * (n - 1) + 0.0137 * n for n in range(1, 7)}
        with table.open("w") as out:
            rows = csv.writer(out)
            rows.writerow(["cylinder", "sensor", "kind", "t0", "magnitude", "parameter", "t1"])
            for n, begin in begins.items():
                rows.writerow([n, "c1" if n % 2 else "c2", kind, begin, size, "", begin + LASTS])
        self.call("inject", log, "--config", self.config, "--faults", table, "--output", faulty, "--force")
        return begins, faulty


def of(text, table):
    """The tables of that name, with those below them."""
    parts = re.split(r"(?m)^(?=\[)", text)
    name = table.strip("[]")
    return "".join(part for part in parts if re.match(r"\[+" + name + r"[.\]]", part))


def plain(rate):
    text = CONFIG.read_text().replace('"../dbc/', f'"{Path("dbc").resolve()}/')
    text = text[: text.index("[[cylinder]]")]
    text = re.sub(r"(?ms)^\[model\]\n.*?(?=^\[)", "", text)
    ts = 1.0 / rate
    for key, seconds in [("sample_time", ts), ("stale", max(0.1, 5 * ts)), ("frozen", max(0.1, 5 * ts))]:
        text, count = re.subn(rf"(?m)^{key} = .*$", f"{key} = {seconds!r}", text)
        assert count == 1, key
    return re.sub(r"(?m)^bitrate = .*$", "bitrate = 1000000", text)


def plant():
    """Without the fluctuations of Figure 5-9, which are what the sequential detectors find."""
    text = PLANT.read_text()
    for old, new in [
        ("fluctuation_probability = 5.0e-4 ", "fluctuation_probability = 0.0 "),
        ("noise = 4.0e-5 ", "noise = 5.0e-5 "),
    ]:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


def found(warnings, begins):
    """Seconds until each detector says so, for each fault; nothing where it does not. And whose it is in
    the end: right, wrong, undecided."""
    delays, suspects = {name: [] for name in DETECTORS}, [0, 0, 0]
    for n, begin in begins.items():
        own = [w for w in warnings if w["cylinder"] == n and w["detector"] in DETECTORS]
        during = [w for w in own if 0.0 <= float(w["t"]) - begin < LASTS]
        for name in DETECTORS:
            times = [float(w["t"]) - begin for w in during
                     if w["detector"] == name and w["state"] == "raised"]
            delays[name].append(min(times, default=math.inf))
        said = [w["suspect"] for w in during if w["detector"] == "sequential"]
        blamed = next((who for who in reversed(said) if who in ("c1", "c2")), None)
        right = "c1" if n % 2 else "c2"
        suspects[2 if blamed is None else 0 if blamed == right else 1] += 1
    return delays, suspects


def measured(machine, seeds):
    """Median delays of each fault and detector, s, and the suspects; and false alarms."""
    delays = {name: {detector: [] for detector in DETECTORS} for name, _ in FAULTS}
    suspects, false = {name: [0, 0, 0] for name, _ in FAULTS}, 0
    for seed in range(seeds):
        log = machine.folder / "healthy.log"
        machine.simulate(1000 + seed, LENGTH, log)
        healthy = machine.warnings(log)
        false += sum(w["detector"] in DETECTORS and w["state"] == "raised" for w in healthy)
        for name, (kind, size) in FAULTS:
            begins, faulty = machine.faulty(log, kind, size)
            more, whose = found(machine.warnings(faulty), begins)
            for detector in DETECTORS:
                delays[name][detector] += more[detector]
            suspects[name] = [a + b for a, b in zip(suspects[name], whose)]
    return delays, suspects, false


def row(name, results, usual):
    """Of one fault: at each rate the median delays, s and samples, whether they are those of 50 Hz, to 20 %
    or the cycle that it takes to see anything, and the suspects."""
    cells = [name]
    for detector in DETECTORS:
        medians = {rate: statistics.median(result[0][name][detector]) for rate, result in results.items()}
        told = [(rate, median, medians[usual]) for rate, median in sorted(medians.items())]
        if all(math.isinf(median) for median in medians.values()):
            cells += ["–"] * (3 if detector == "sequential" else 2)
            continue
        cells.append(", ".join("–" if math.isinf(median) else f"{median:.3f}" for _, median, _ in told))
        if detector == "sequential":
            samples = (median * rate for rate, median, _ in told)
            cells.append(", ".join("–" if math.isinf(count) else f"{count:.0f}" for count in samples))
        holds = (abs(median - before) <= 0.2 * before + 1 / min(rate, usual) for rate, median, before in told)
        cells.append(", ".join("yes" if held else "no" for held in holds))
    cells.append(", ".join("/".join(map(str, results[rate][1][name])) for rate in sorted(results)))
    return cells


def main():
    parser = argparse.ArgumentParser(prog="scripts/sweep-rates")
    parser.add_argument("--rates", default="50,10,20,100")
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--teach", type=float, default=1800.0)
    parser.add_argument("--binary", type=Path, required=True)
    options = parser.parse_args()
    rates = [float(rate) for rate in options.rates.split(",")]
    results = {}
    for rate in rates:
        with tempfile.TemporaryDirectory(prefix="tertius-rates.") as folder:
            machine = Machine(Path(folder), options.binary, rate, options.teach)
            results[rate] = measured(machine, options.seeds)
    usual = USUAL if USUAL in rates else rates[0]
    head = ["fault", "sequential, s", "samples", "as at 50 Hz", "R3, s", "as at 50 Hz", "suspect"]
    print("| " + " | ".join(head) + " |\n|" + " --- |" * len(head))
    for name, _ in FAULTS:
        print("| " + " | ".join(row(name, results, usual)) + " |")
    for rate in sorted(rates):
        seconds = LENGTH * options.seeds
        print(f"{rate:g} Hz: {results[rate][2]} false alarms of sequential and R3 in {seconds} s")


main()
