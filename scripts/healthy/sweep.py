"""Healthy machines on which something befalls that is no fault; run by scripts/sweep-healthy, see there."""

import argparse
import tempfile
from itertools import product
from pathlib import Path

from circumstances import circumstances
from machine import Taught, at_most

GRADES = {"fine": 1, "coarse": 4}
FROM = 600.0
# How C2 is sampled beside C1: always so much later, and by chance, s.
SAMPLINGS = [
    ("as taught", 0.0, 0.0),
    ("0.2 ms by chance", 0.0, 2e-4),
    ("0.5 ms by chance", 0.0, 5e-4),
    ("1 ms by chance", 0.0, 1e-3),
    ("0.2 ms later", 2e-4, 0.0),
    ("0.5 ms later", 5e-4, 0.0),
    ("0.2 ms sooner", -2e-4, 0.0),
    ("0.5 ms sooner", -5e-4, 0.0),
    ("0.5 ms sooner, 0.5 ms by chance", -5e-4, 5e-4),
]


def row(*cells):
    print("| " + " | ".join(str(cell) for cell in cells) + " |", flush=True)


def head(*cells):
    row(*cells)
    row(*["---"] * len(cells))


def rate(count, hours):
    """Warnings an hour, and how many there are at most with 95 %."""
    return f"{count / hours:.3g}", f"{at_most(count) / hours:.3g}"


def run(taught, options, befalls="", through=None):
    """What is said in the hours of a cell: warnings by detector, notices, and all of it."""
    heard = []
    for seed in range(options.seeds):
        seconds = 3600.0 * options.hours / options.seeds
        heard.append(taught.play(1000 + seed, seconds, befalls, through))
    return heard


def raised(heard, *detectors):
    return sum(warning["detector"] in detectors for one in heard for warning in one.raised)


def spikes_of(share, counts):
    return f"spikes = {{ time = [0.0, 1e9], share = {share}, counts = {counts:.1f} }}"


def spikes(options, teach):
    head("taught", "transducers", "h", "spikes", "on", "counts", "hours", "sequential", "an hour", "at most",
         "FDE1", "FDE2", "FDE3")
    total = {}
    for how, grade in product(options.taught, options.grades):
        taught = teach(grade, spikes_of([0.01, 0.01], 4.0) if how == "spiky" else "")
        for share, on, counts in product(options.share, options.on, options.counts):
            shares = [share / 100 * (on in ("both", side)) for side in ("c1", "c2")]
            heard = run(taught, options, spikes_of(shares, counts))
            count = raised(heard, "sequential")
            fde = [raised(heard, f"fde{n}") for n in (1, 2, 3)]
            row(how, grade, f"{taught.level:.2f}", f"{share:g} %", on, f"{counts:g}", options.hours, count,
                *rate(count, options.hours), *fde)
            of = total.setdefault((how, grade), [0, 0.0])
            of[0], of[1] = of[0] + count, of[1] + options.hours
    for (how, grade), (count, hours) in total.items():
        print(f"{how}, {grade}: {count} sequential in {hours:g} h, {' an hour, at most '.join(rate(count, hours))}")


def sampling(options, teach):
    head("transducers", "h", "from then on", "hours", "sequential", "at most an hour", "blame",
         "told after, s", "FDE1", "FDE2", "FDE3")
    for grade in options.grades:
        taught = teach(grade, "")
        for name, skew, jitter in SAMPLINGS:
            befalls = f"sampling = {{ time = [{FROM}, 1e9], skew = {skew}, jitter = {jitter} }}"
            heard = run(taught, options, befalls)
            told = [time for one in heard for time in one.timing[:1]]
            after = ", ".join(f"{time - FROM:.1f}" for time in told) or "never"
            alarms = [w for one in heard for w in one.all if w["detector"] == "sequential"]
            # Whoever was ever blamed, in whatever word on an alarm.
            blamed = len({(w["cylinder"], w["onset"]) for w in alarms if w["suspect"] in ("c1", "c2")})
            count = raised(heard, "sequential")
            row(grade, f"{taught.level:.2f}", name, options.hours, count, rate(count, options.hours)[1],
                blamed, after, *(raised(heard, f"fde{n}") for n in (1, 2, 3)))


def late(options, teach):
    head("transducers", "h", "late", "hours", "late frames", "sequential", "FDE1", "FDE2", "FDE3",
         "plausibility", "FDE beside the punctual")
    for grade in options.grades:
        taught = teach(grade, "")
        punctual = run(taught, options)
        for share in (0.0, 0.001, 0.006):
            heard = run(taught, options, through=share) if share else punctual
            # Those that no punctual machine has said within a second.
            new = [new_ones(one.raised, other.raised) for one, other in zip(heard, punctual)]
            row(grade, f"{taught.level:.2f}", f"{share:.1%}", options.hours, sum(one.late for one in heard),
                *(raised(heard, name) for name in ("sequential", "fde1", "fde2", "fde3", "plausibility")),
                sum(map(len, new)))


def new_ones(warnings, known):
    same = lambda a, b: a["cylinder"] == b["cylinder"] and abs(float(a["t"]) - float(b["t"])) < 1.0
    fde = [w for w in warnings if w["detector"].startswith("fde")]
    return [w for w in fde if not any(same(w, other) for other in known)]


def main():
    parser = argparse.ArgumentParser(prog="scripts/sweep-healthy")
    listed = lambda of: lambda text: [of(part) for part in text.split(",")]
    parser.add_argument("what", choices=["spikes", "sampling", "late", "circumstances"])
    parser.add_argument("--share", type=listed(float), default=[0.1, 0.5, 1.0, 2.0, 3.0])
    parser.add_argument("--counts", type=listed(float), default=[2.0, 4.0, 10.0, 40.0])
    parser.add_argument("--on", type=listed(str), default=["both", "c1", "c2"])
    parser.add_argument("--taught", type=listed(str), default=["clean", "spiky"])
    parser.add_argument("--grades", type=listed(str), default=list(GRADES))
    parser.add_argument("--hours", type=float, default=1.0)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--level", type=float)
    parser.add_argument("--teach", type=float, default=1200.0)
    parser.add_argument("--machines", type=listed(int), default=[1, 2])
    parser.add_argument("--taught-sea", default="1.5,7")
    parser.add_argument("--only", default="")
    parser.add_argument("--keep", default="")
    parser.add_argument("--lost", action="store_true")
    parser.add_argument("--binary", type=Path, required=True)
    options = parser.parse_args()
    options.binary = options.binary.resolve()
    with tempfile.TemporaryDirectory(prefix="tertius-healthy.") as folder:
        def teach(grade, befalls):
            return Taught(Path(folder), options.binary, GRADES[grade], befalls, options.teach, options.level)

        if options.what == "circumstances":
            circumstances(options, Path(folder))
            return
        {"spikes": spikes, "sampling": sampling, "late": late}[options.what](options, teach)


main()
