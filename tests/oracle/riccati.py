"""The discrete Riccati equation by SciPy, and by mpmath in as many digits as it takes, as a filter.

Each line of standard input is a JSON object: a (3x3), c (Mx3), q and r (diagonals), and gain (3xM),
the gain L under test. The answer to it holds

  scipy       P and L by solve_discrete_are, or null where SciPy gives up
  residual    how well SciPy's P meets the equation, relative to A P A' + Q (null likewise)
  exact       P and L to 16 digits: in 60 digits, checked there to 1e-40, and stabilising
  poles       NumPy's eigenvalues of A - L C with the gain under test, as [real, imaginary]
"""

import json
import sys

import mpmath
import numpy
from scipy.linalg import solve_discrete_are

mpmath.mp.dps = 60  # a double has 16


def gain(p, a, c, r):
    return numpy.linalg.solve(c @ p @ c.T + r, c @ p @ a.T).T


def by_scipy(a, c, q, r):
    try:
        p = solve_discrete_are(a.T, c.T, q, r)
    except numpy.linalg.LinAlgError:
        return None, None
    l = gain(p, a, c, r)
    prediction = a @ p @ a.T + q
    deviations = numpy.sqrt(numpy.abs(numpy.diag(prediction)))
    left = numpy.abs(prediction - l @ c @ p @ a.T - p) / numpy.outer(deviations, deviations)
    return {"p": p.tolist(), "l": l.tolist()}, float(left.max())


def exact(a, c, q, r):
    """Runs the filter's own recursion, two steps at a time and in 60 digits.

    The recursion is doubled as in Anderson and Moore, Optimal Filtering, section 6.7. How it was
    found does not matter: what meets the equation and stabilises is the one solution.
    """
    a, c, q, r = (mpmath.matrix(m.tolist()) for m in (a, c, q, r))
    one = mpmath.eye(3)
    f, g, p = a.T, c.T * r**-1 * c, q
    for _ in range(80):
        w = (one + g * p) ** -1
        step = f.T * p * w * f
        f, g, p = f * w * f, g + f * w * g * f.T, p + step
        if mpmath.norm(step, 1) <= mpmath.norm(p, 1) * mpmath.mpf(10) ** -50:
            break
    innovation = c * p * c.T + r
    l = a * p * c.T * innovation**-1
    left = a * p * a.T - l * innovation * l.T + q - p
    for i in range(3):
        for j in range(3):
            assert abs(left[i, j]) <= 1e-40 * mpmath.sqrt(p[i, i] * p[j, j]), left
    # Its powers vanish: every eigenvalue of A - L C is inside the unit circle.
    power = a - l * c
    for _ in range(24):
        power *= power
    assert mpmath.norm(power, 1) < 1e-3, power
    return {"p": plain(p), "l": plain(l)}


def plain(m):
    return [[float(m[i, j]) for j in range(m.cols)] for i in range(m.rows)]


for line in sys.stdin:
    case = json.loads(line)
    a, c, l = (numpy.array(case[key], dtype=float) for key in ("a", "c", "gain"))
    q, r = (numpy.diag(case[key]) for key in ("q", "r"))
    solution, residual = by_scipy(a, c, q, r)
    poles = numpy.linalg.eigvals(a - l @ c)
    answer = {
        "scipy": solution,
        "residual": residual,
        "exact": exact(a, c, q, r),
        "poles": [[pole.real, pole.imag] for pole in poles],
    }
    print(json.dumps(answer))
