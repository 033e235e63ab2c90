"""Tails by scipy.stats and lines by NumPy.

Each line of standard input is a JSON object with either `excesses`, answered by

  shape, scale  scipy.stats.genpareto.fit with the location 0, polished to the last digits
  likelihood    its log-likelihood, and `exponential` that of scipy.stats.expon
  mean          the scale of scipy.stats.expon.fit with the location 0
  beyond        for `share`: the excess that this share of genpareto and of expon is beyond

or `points` ([C2, C1]), answered by `line`: a and b of numpy.linalg.lstsq.
"""

import json
import sys

import numpy
from scipy import optimize, stats


def polished(function, start, args=(), disp=0):
    return optimize.fmin(
        function, start, args=args, disp=0, xtol=1e-12, ftol=1e-14, maxiter=10000, maxfun=10000
    )


def tail(excesses, share):
    scale = float(numpy.mean(excesses))
    unit = numpy.array(excesses) / scale
    # From several places: the simplex of `fit` can end beside the maximum.
    fits = [
        stats.genpareto.fit(unit, shape, floc=0, scale=1.0, optimizer=polished)
        for shape in (-0.2, 0.1, 0.5)
    ]
    shape, _, size = min(fits, key=lambda fit: stats.genpareto.nnlf(fit, unit))
    _, mean = stats.expon.fit(excesses, floc=0)
    return {
        "shape": float(shape),
        "scale": float(size * scale),
        "likelihood": float(numpy.sum(stats.genpareto.logpdf(excesses, shape, 0, size * scale))),
        "exponential": float(numpy.sum(stats.expon.logpdf(excesses, 0, mean))),
        "mean": float(mean),
        "beyond": [
            float(stats.genpareto.isf(share, shape, 0, size * scale)),
            float(stats.expon.isf(share, 0, mean)),
        ],
    }


def line(points):
    c2, c1 = numpy.array(points).T
    regressors = numpy.column_stack([c2, numpy.ones_like(c2)])
    return {"line": numpy.linalg.lstsq(regressors, c1, rcond=None)[0].tolist()}


for text in sys.stdin:
    case = json.loads(text)
    if "points" in case:
        answer = line(case["points"])
    else:
        answer = tail(case["excesses"], case["share"])
    print(json.dumps(answer))
