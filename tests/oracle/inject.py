"""Judges a recording with injected faults against the one without, with python-can, cantools and
NumPy: sys.argv = DBC, healthy log, faulty log, table of faults.

Every frame must be there, in order, at its time. A signal with a fault must read, within half a
count, what it read before plus the fault of the thesis's formulas; every other bit is untouched.
Prints for each fault: frames, frames that changed, largest error in counts, and of noise and spikes
the counts of -1, 0 and +1.
"""

import csv
import sys

import can
import cantools
import numpy as np

dbc, healthy, faulty, table = sys.argv[1:]
database = cantools.database.load_file(dbc)
before, after = [list(can.CanutilsLogReader(log)) for log in (healthy, faulty)]
assert len(before) == len(after), (len(before), len(after))
for one, other in zip(before, after):
    same = (one.timestamp, one.arbitration_id, one.dlc, one.channel)
    assert same == (other.timestamp, other.arbitration_id, other.dlc, other.channel), (one, other)

times = np.array([message.timestamp for message in before]) - before[0].timestamp
ids = np.array([message.arbitration_id for message in before])
untouched = np.ones(len(before), bool)

for fault in csv.DictReader(open(table)):
    message = database.get_message_by_name(f"Cyl{fault['cylinder']}_{fault['sensor']}")
    signal = message.get_signal_by_name("Position")
    t0, size, parameter = (float(fault[key] or 0) for key in ("t0", "magnitude", "parameter"))
    t1 = float(fault["t1"]) if fault["t1"] else np.inf
    at = np.flatnonzero(ids == message.frame_id)
    untouched[at] = False
    pairs = [[message.decode(log[i].data) for i in at] for log in (before, after)]
    for one, other in zip(*pairs):
        assert {k: v for k, v in one.items() if k != "Position"} == {
            k: v for k, v in other.items() if k != "Position"
        }
    old, new = [np.array([values["Position"] for values in pair]) for pair in pairs]
    t = times[at]
    # Times are multiples of a microsecond and faults begin between them.
    there = (t >= t0) & (t < t1)
    assert np.array_equal(old[~there], new[~there]), fault
    t, old, new = t[there] - t0, old[there], new[there]
    kind = fault["kind"]
    parts = ""
    if kind in ("noise", "spike"):
        times_size = np.round((new - old) / size)
        expected = old + size * times_size
        allowed = (-1, 0, 1) if kind == "noise" else (0, 1)
        assert np.isin(times_size, allowed).all(), fault
        parts = " ".join(str(int((times_size == n).sum())) for n in (-1, 0, 1))
    else:
        expected = {
            "step": lambda: old + size,
            "incipient": lambda: old + size * (1 - (1 + parameter) ** -t),
            "drift": lambda: old + size * t,
            "scale": lambda: old + size * old,
            "stuck": lambda: np.full_like(old, pairs[0][np.flatnonzero(there)[0] - 1]["Position"]),
        }[kind]()
    error = np.abs(new - expected).max() / signal.scale
    print(kind, len(old), int((old != new).sum()), f"{error:.6f}", parts)

for i in np.flatnonzero(untouched):
    assert before[i].data == after[i].data, before[i]
