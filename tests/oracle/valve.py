"""The relation of a valve by NumPy's lstsq, from the signals as they are: JSON in, JSON out."""

import json
import sys

import numpy as np

BLOCK = 10  # cycles


def main():
    task = json.load(sys.stdin)
    length, spool, load, supply = np.array(task["signals"]).T
    limit, between, ts = task["limit"], task["between"], task["sample_time"]
    w = np.linspace(-1.0, 1.0, task["pieces"] + 1)
    knots = limit * w * np.abs(w)
    x = spool[:-1] + between * np.diff(spool)
    load_mean = (load[:-1] + load[1:]) / 2
    supply_mean = (supply[:-1] + supply[1:]) / 2
    drop = supply_mean - np.where(x >= 0, load_mean, -load_mean)
    root = np.sqrt(np.maximum(drop, 0.0) / 210.0)
    hats = np.column_stack([np.interp(x, knots, unit) for unit in np.eye(len(knots))])
    terms = np.column_stack([hats * root[:, None], load_mean]) * ts
    count = len(x) // BLOCK
    sums = terms[: count * BLOCK].reshape(count, BLOCK, -1).sum(axis=1)
    ends = np.arange(0, count * BLOCK + 1, BLOCK)
    columns = np.column_stack([sums, np.diff(load[ends])])
    # A hat that nobody stands under has no value.
    used = np.abs(columns).max(axis=0) > 0
    found = np.full(columns.shape[1], np.nan)
    found[used], *_ = np.linalg.lstsq(columns[:, used], np.diff(length[ends]), rcond=None)
    answer = [None if np.isnan(value) else value for value in found]
    json.dump({"curve": answer[:-2], "leakage": answer[-2], "compression": answer[-1]}, sys.stdout)


main()
