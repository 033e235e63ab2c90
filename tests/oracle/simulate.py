"""Judges a simulated recording: python-can reads it, cantools decodes every frame of it, and a
linear model (4-1) identified by least squares (4-7), (4-8) on cylinder 3 follows all six.

    simulate.py DBC LOG

Prints: frames, messages that are not as the DBC has them, values out of range, time stamps that
step back; then for each cylinder the VAF of position and velocity; then the parameters.
"""

import sys
from pathlib import Path

import can
import cantools
import numpy as np

# By a machine's DBC: sample time, area ratio, what its messages are called, and their signals.
MACHINES = {
    "e-type.dbc": (
        0.02,
        0.5,
        "Cyl{}_",
        {
            "l": ("C1", "Position"),
            "v": ("C1", "Velocity"),
            "u": ("Valve", "ControlSpeed"),
            "bottom": ("Valve", "PressureBottom"),
            "rod": ("Valve", "PressureRod"),
        },
    ),
    "a-type.dbc": (
        0.025,
        0.61,
        "Leg{}_",
        {
            "l": ("EncA", "Length"),
            "v": ("EncA", "Rate"),
            "u": ("Demand", "Speed"),
            "bottom": ("Servo", "BottomPressure"),
            "rod": ("Servo", "RodPressure"),
        },
    ),
}
TS, RATIO, MESSAGES, SIGNALS = MACHINES[Path(sys.argv[1]).name]

database = cantools.database.load_file(sys.argv[1])
frames = wrong = outside = backwards = 0
last = 0.0
columns = {}
for frame in can.LogReader(sys.argv[2]):
    frames += 1
    backwards += frame.timestamp < last
    last = frame.timestamp
    message = database.get_message_by_frame_id(frame.arbitration_id)
    if len(frame.data) != message.length or frame.is_extended_id != message.is_extended_frame:
        wrong += 1
        continue
    values = message.decode(frame.data, decode_choices=False)
    for signal in message.signals:
        value = values[signal.name]
        columns.setdefault((message.name, signal.name), []).append(value)
        half = signal.scale / 2
        outside += not (signal.minimum - half <= value <= signal.maximum + half)
print(frames, wrong, outside, backwards)


def smooth(x, n=5):
    """The centred moving average of section 4-1."""
    return np.convolve(x, np.ones(n) / n, "same")


def column(name, cylinder):
    message, signal = SIGNALS[name]
    return np.array(columns[MESSAGES.format(cylinder) + message, signal])


class Cylinder:
    def __init__(self, n):
        self.l = column("l", n)
        self.v = column("v", n)
        self.u = column("u", n)
        self.p = column("bottom", n) - RATIO * column("rod", n)


def identify(c, part):
    l, v, p, u = c.l[part], smooth(c.v)[part], smooth(c.p)[part], c.u[part]
    fast = np.linalg.lstsq(np.c_[l, v, p, u][:-1], np.diff(v), rcond=None)[0]
    load = np.linalg.lstsq(np.c_[v, p, u][:-1], np.diff(p), rcond=None)[0]
    a = np.array([[1, TS, 0], [fast[0], 1 + fast[1], fast[2]], [0, load[0], 1 + load[1]]])
    return a, np.array([0, fast[3], load[2]])


def follow(a, b, c, part):
    x = np.array([c.l[part][0], c.v[part][0], c.p[part][0]])
    states = []
    for u in c.u[part]:
        states.append(x)
        x = a @ x + b * u
    return np.array(states)


def vaf(y, estimate):
    return 100 * (1 - np.var(y - estimate) / np.var(y))


cylinders = {n: Cylinder(n) for n in range(1, 7)}
half = len(cylinders[1].l) // 2
first, second = slice(50, half), slice(half, None)
a, b = identify(cylinders[3], first)
for n, c in cylinders.items():
    states = follow(a, b, c, second)
    print(n, vaf(c.l[second], states[:, 0]), vaf(c.v[second], states[:, 1]))
print(a[1, 0], a[1, 1] - 1, a[1, 2], a[2, 1], a[2, 2] - 1, b[1], b[2])
