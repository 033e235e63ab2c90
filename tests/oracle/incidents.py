"""The peaks of incidents, taken a second time from the table of residuals.

    incidents.py CSV THRESHOLD BOUND CRITICAL SAMPLE_TIME < lines of JSON of the same replay

Each incident as it was told last is compared with the rows of its cylinder from its begin to its end: R1 and R2
where they were judged (in a monitored state, and not until a second after a gap of more than five cycles, or two
cycles after a shorter one), R3, and C1 - C2 as measured where it went beyond CRITICAL, m, which makes it black; but
not where a reading is no measurement (no signal, out of range). A peak within its limit (THRESHOLD of R1 and R2,
BOUND of R3, m) may be smaller than that of the rows, since it counts only while a warning stands. The answer is
JSON: the number of incidents and of peaks that were compared, and what differs.
"""

import json
import sys

import numpy

COLUMNS = {"r1": 8, "r2": 9, "r3": 10}
GAP, SETTLE, RECOVERY = 5, 50, 2


def judged(values, gated):
    """Where an observer's residual counts."""
    counts = ~numpy.isnan(values) & (gated == 0)
    missing, wait = GAP + 1, 0
    for i, value in enumerate(values):
        if numpy.isnan(value):
            missing += 1
            continue
        if missing > 0:
            wait = max(wait, SETTLE if missing > GAP else RECOVERY)
        missing = 0
        if wait > 0:
            counts[i] = False
            wait -= 1
    return counts


def main():
    threshold, bound, critical, sample_time = map(float, sys.argv[2:6])
    limits = {"r1": threshold, "r2": threshold, "r3": bound, "c1_c2": critical}
    rows = numpy.genfromtxt(sys.argv[1], delimiter=",", skip_header=1)
    used = {}
    for cylinder in numpy.unique(rows[:, 1]):
        of = rows[:, 1] == cylinder
        for name in ("r1", "r2"):
            used[cylinder, name] = judged(rows[of, COLUMNS[name]], rows[of, 11])
        used[cylinder, "r3"] = ~numpy.isnan(rows[of, COLUMNS["r3"]])
    newest = {}
    for line in sys.stdin:
        record = json.loads(line)
        if record["type"] == "incident":
            newest[record["incident"]] = record
    compared, differences = 0, []
    for number, incident in newest.items():
        end = incident["end"] if incident["end"] is not None else numpy.inf
        # A cycle is named by its opening, and judged later in it.
        t = rows[:, 0]
        cylinder = rows[:, 1] == incident["cylinder"]
        during = (t > incident["begin"] - sample_time) & (t < end)
        own, within = rows[cylinder & during], during[cylinder]
        expected = {}
        for name, column in COLUMNS.items():
            values = own[used[incident["cylinder"], name][within], column]
            if len(values):
                expected[name] = values[numpy.argmax(numpy.abs(values))]
        apart = own[:, 2] - own[:, 3]
        apart = apart[~numpy.isnan(apart)]
        is_measured = incident["fault"] not in ("broken_wire", "out_of_range", "stale")
        if is_measured and len(apart) and numpy.max(numpy.abs(apart)) > critical:
            expected["c1_c2"] = apart[numpy.argmax(numpy.abs(apart))]
        told = incident["peaks"]
        for name in sorted(set(expected) | set(told)):
            compared += 1
            here, there = told.get(name), expected.get(name)
            if here is None or there is None:
                alike = False
            elif max(abs(here), abs(there)) > limits[name]:
                alike = abs(here - there) <= 1e-12
            else:
                alike = abs(here) <= abs(there) + 1e-12
            if not alike:
                differences.append([number, name, here, there])
        if is_measured and (incident["level"] == "black") != ("c1_c2" in expected):
            differences.append([number, "level", incident["level"], expected.get("c1_c2")])
    print(json.dumps({"incidents": len(newest), "compared": compared, "differences": differences}))


main()
