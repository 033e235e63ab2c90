"""dbc/e-type.dbc against the layout that it must have, by cantools.

The layout stands here a second time, as a table to be read beside the specification; the excerpt of
a recording is decoded by cantools and by plain bit arithmetic on this table. Prints how many frames
it compared; ends with an AssertionError at the first difference.
"""

import sys
from fractions import Fraction
from pathlib import Path

import can
import cantools

TOP = Path(__file__).resolve().parents[2]
SIGNED, UNSIGNED = True, False

# name: start bit, length, sign, factor, offset, unit
POSITION = (16, UNSIGNED, Fraction(3, 27648), Fraction(-3, 2), "m")
TRANSDUCER = {
    "Position": (0, *POSITION),
    "Velocity": (16, 16, SIGNED, Fraction(1, 10000), 0, "m/s"),
    "Status": (32, 8, UNSIGNED, 1, 0, None),
    "Counter": (40, 8, UNSIGNED, 1, 0, None),
}
VALVE = {
    "ControlSpeed": (0, 16, SIGNED, Fraction(1, 10000), 0, "m/s"),
    "SpoolPosition": (16, 16, SIGNED, Fraction(1, 100), 0, "%"),
    "PressureBottom": (32, 16, UNSIGNED, Fraction(1, 100), 0, "bar"),
    "PressureRod": (48, 16, UNSIGNED, Fraction(1, 100), 0, "bar"),
}


def three(names, factor, unit):
    return {n: (16 * i, 16, SIGNED, factor, 0, unit) for i, n in enumerate(names)}


def plain(start, length):
    return (start, length, UNSIGNED, 1, 0, None)


E2E = {"Crc": plain(0, 16), "Counter": plain(16, 8)}
STATES = {
    f"Cyl{n}_{c}_State": plain(24 + 4 * (n - 1) + 2 * (c == "C2"), 2)
    for n in range(1, 7)
    for c in ("C1", "C2")
}

# name: identifier, length in bytes, signals
LAYOUT = {
    "Sync": (0x080, 1, {"Counter": plain(0, 8)}),
    **{f"Cyl{n}_C1": (0x180 + n, 6, TRANSDUCER) for n in range(1, 7)},
    **{f"Cyl{n}_C2": (0x190 + n, 6, TRANSDUCER) for n in range(1, 7)},
    **{f"Cyl{n}_Valve": (0x1A0 + n, 8, VALVE) for n in range(1, 7)},
    "Mru_Attitude": (0x1B1, 6, three(("Roll", "Pitch", "Yaw"), Fraction(1, 10000), "rad")),
    "Mru_Translation": (0x2B1, 6, three(("Surge", "Sway", "Heave"), Fraction(1, 1000), "m")),
    "Plc_State": (
        0x1C1,
        4,
        {
            "PlatformState": plain(0, 8),
            "SupplyPressure": (8, 16, UNSIGNED, Fraction(1, 100), 0, "bar"),
            "Counter": plain(24, 8),
        },
    ),
    "Fd_Status": (
        0x1D1,
        8,
        {**E2E, **STATES, "Level": plain(48, 3), "Mode": plain(51, 3)}
        | {"ActiveWarnings": plain(54, 6), "WithoutC2": plain(60, 3)},
    ),
    "Fd_Warning": (
        0x2D1,
        8,
        {
            **E2E,
            "Cylinder": plain(24, 3),
            "Detector": plain(27, 3),
            "Fault": plain(30, 3),
            "Suspect": plain(33, 2),
            "Level": plain(35, 3),
            "Raised": plain(38, 1),
            "FaultTable": plain(39, 1),
            "Residual": (40, 16, SIGNED, Fraction(1, 100000), 0, "m"),
            "Threshold": (56, 8, UNSIGNED, Fraction(5, 100000), 0, "m"),
        },
    ),
    "Fd_Estimate": (
        0x3D1,
        8,
        {
            **E2E,
            "Cylinder": plain(24, 3),
            "Valid": plain(27, 1),
            "Position": (32, *POSITION),
            "Sigma": (48, 16, UNSIGNED, Fraction(1, 1000000), 0, "m"),
        },
    ),
}

LEVELS = ["none", "yellow", "orange", "red", "black"]
CHOICES = {
    ("Plc_State", "PlatformState"): ["safe", "settled", "neutral", "engaged"],
    **{("Fd_Status", s): ["unknown", "healthy", "suspect", "faulty"] for s in STATES},
    ("Fd_Status", "Level"): LEVELS,
    ("Fd_Status", "Mode"): ["starting", "monitoring", "gated", "degraded", "stopping"],
    ("Fd_Warning", "Detector"): [
        None, "fde1", "fde2", "fde3", "plausibility", "sequential", "process",
    ],
    ("Fd_Warning", "Fault"): [
        "unclassified", "abrupt", "noise", "incipient", "out_of_range", "broken_wire", "frozen",
        "stale",
    ],
    ("Fd_Warning", "Suspect"): ["undecided", "c1", "c2", "process"],
    ("Fd_Warning", "Level"): LEVELS,
    ("Fd_Warning", "Raised"): ["cleared", "raised"],
    ("Fd_Warning", "FaultTable"): ["first", "second"],
    ("Fd_Estimate", "Valid"): ["invalid", "valid"],
}


def check_layout(database):
    messages = {m.name: m for m in database.messages}
    assert messages.keys() == LAYOUT.keys(), messages.keys() ^ LAYOUT.keys()
    for name, (identifier, length, signals) in LAYOUT.items():
        message = messages[name]
        assert (message.frame_id, message.length) == (identifier, length), message
        assert not message.is_extended_frame and not message.is_fd, message
        assert message.comment and message.senders, f"{name} has no comment or no sender"
        found = {s.name: s for s in message.signals}
        assert found.keys() == signals.keys(), (name, found.keys() ^ signals.keys())
        used = set()
        for signal, (start, bits, signed, factor, offset, unit) in signals.items():
            s = found[signal]
            place = (s.byte_order, s.start, s.length, s.is_signed, s.unit or None)
            assert place == ("little_endian", start, bits, signed, unit), (name, signal, place)
            # The double nearest to the exact factor, not a rounded decimal.
            assert (s.scale, s.offset) == (float(factor), float(offset)), (name, signal, s.scale)
            span = set(range(start, start + bits))
            assert not used & span and max(span) < 8 * length, (name, signal)
            used |= span
            # The bounds are decimals: 1 and 27648 must be in, and what is beside them out.
            if signal == "Position":
                inside = [r for r in range(1 << bits) if s.minimum <= s.scale * r - 1.5 <= s.maximum]
                assert (inside[0], inside[-1], len(inside)) == (1, 27648, 27648), (name, signal)
            names = CHOICES.get((name, signal))
            if names:
                choices = {k: str(v) for k, v in s.choices.items()}
                assert choices == {k: v for k, v in enumerate(names) if v}, (name, signal, choices)


def by_hand(signals, data):
    whole = int.from_bytes(data, "little")
    values = {}
    for name, (start, bits, signed, factor, offset, _) in signals.items():
        raw = whole >> start & (1 << bits) - 1
        raw -= (raw >> bits - 1 & signed) << bits
        values[name] = float(raw * Fraction(factor) + Fraction(offset))
    return values


def compare(database, identifier, data):
    message = database.get_message_by_frame_id(identifier)
    by_cantools = message.decode(data, decode_choices=False)
    expected = by_hand(LAYOUT[message.name][2], data)
    assert by_cantools.keys() == expected.keys()
    for name, value in expected.items():
        # A count times a rounded factor: a few units in the last place of the largest, 655.35.
        assert abs(by_cantools[name] - value) < 5e-13, (message.name, name, value, by_cantools)
    return message.name


def main():
    database = cantools.database.load_file(TOP / "dbc/e-type.dbc", strict=True)
    check_layout(database)
    with can.LogReader(TOP / "tests/oracle/e-type-excerpt.log") as log:
        names = [compare(database, frame.arbitration_id, bytes(frame.data)) for frame in log]
    received = {n for n in LAYOUT if not n.startswith("Fd_")}
    assert sorted(names) == sorted(2 * list(received)), "two cycles hold every message twice"
    # The gateway's own are in no recording: bytes in which all fields differ.
    for name in LAYOUT.keys() - received:
        for data in (bytes.fromhex("0123456789ABCDEF"), bytes.fromhex("F0E1D2C3B4A59687")):
            names.append(compare(database, LAYOUT[name][0], data))
    print(len(names))


if __name__ == "__main__":
    sys.exit(main())
