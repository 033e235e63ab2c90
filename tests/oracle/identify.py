"""(4-7) and (4-8) by NumPy's lstsq, from the signals as they are: JSON in, JSON out."""

import json
import sys

import numpy as np


def averaged(x, window):
    return np.convolve(x, np.ones(window) / window, "valid")


def regression(x, y):
    coefficients, _, rank, _ = np.linalg.lstsq(x, y, rcond=None)
    assert rank == x.shape[1]
    residual = y - x @ coefficients
    variance = residual @ residual / (len(y) - x.shape[1])
    inverse = np.linalg.pinv(x)
    return {
        "coefficients": coefficients.tolist(),
        "errors": np.sqrt(variance * np.sum(inverse**2, axis=1)).tolist(),
        "residual_norm": float(np.linalg.norm(residual)),
        "condition": float(np.linalg.cond(x / np.linalg.norm(x, axis=0))),
        "rows": len(y),
    }


def main():
    task = json.load(sys.stdin)
    cycle, l, v, p, u = np.array(task["signals"]).T
    half = task["window"] // 2
    regressors, targets = [], []
    for part in np.split(np.arange(len(cycle)), np.where(np.diff(cycle) != 1)[0] + 1):
        inner = part[half : len(part) - half]
        vs, ps = averaged(v[part], task["window"]), averaged(p[part], task["window"])
        x = np.column_stack([l[inner], vs, ps, u[inner], np.ones(len(inner))])
        regressors.append(x[:-1])
        targets.append(np.column_stack([np.diff(vs), np.diff(ps)]))
    x, y = np.vstack(regressors), np.vstack(targets)
    last = [4] if task["constant"] else []
    of_p = [2] if task["pressure"] else []
    answer = {"velocity": regression(x[:, [0, 1, *of_p, 3, *last]], y[:, 0])}
    if task["pressure"]:
        answer["pressure"] = regression(x[:, [1, 2, 3, *last]], y[:, 1])
    json.dump(answer, sys.stdout)


main()
