"""Machines that Tertius was not made on: their DBC, configuration and recordings, by cantools and NumPy.

    machines.py truth FOLDER
        writes truth.dbc, truth.toml and truth-plant.toml, by which `tertius simulate` records what its
        machine does to the tenth of a micrometre
    machines.py MACHINE FOLDER SEED LEARNT SECONDS [TRUTH.log]
        writes MACHINE.dbc, MACHINE.toml, healthy.log, faulty.log and faults.csv

The first LEARNT seconds have no fault, and are only in healthy.log. Faults are put into lengths before
these are rounded to counts, or into frames; several on either transducer of each cylinder, in turn and
with healthy time between them. faults.csv has cylinder, sensor, kind, begin, end and size; times are
seconds since the first frame of faulty.log.

A machine is one of
    rig7    one cylinder at 7 ms, by a plant of its own; neither Sync, counters nor speeds on the bus
    loop7   the same with speeds, its controller reading C1 with its faults
    rig24   one cylinder of the simulator at 20 ms; signed 24-bit Motorola readings of a micrometre
    paged   six cylinders on CAN FD with extended identifiers; C1 in the second page of a message, C2 in
            the six pages of another
"""

import csv
import math
import sys
from pathlib import Path

import can
import cantools
import numpy as np
from cantools.database.can import Database, Message, Signal
from cantools.database.conversion import BaseConversion

START = 1_700_000_000.0
# Before the first fault, and before each that follows it, the machine is healthy for so long, s.
LEAD, BETWEEN = 8.0, (5.0, 7.0)
# A fault lasts so long, s.
LASTING = (1.5, 4.5)


def signal(name, start, bits, scale=1, offset=0, unit=None, page=None, signed=False, **more):
    """A signal; `page` is the value of Page at which it is there."""
    conversion = BaseConversion.factory(scale, offset, is_float=more.pop("is_float", False))
    if page is not None:
        more |= {"multiplexer_ids": [page], "multiplexer_signal": "Page"}
    return Signal(name, start, bits, is_signed=signed, conversion=conversion, unit=unit, **more)


def motorola(name, start, bits, **more):
    """The same in Motorola order; `start` is where its most significant bit is, from the front."""
    place = 8 * (start // 8) + 7 - start % 8
    return signal(name, place, bits, byte_order="big_endian", **more)


# ---------------------------------------------------------------- the simulator's machine, in full


def write_truth(folder):
    messages = [Message(0x80, "Sync", 1, [signal("Counter", 0, 8)])]
    metres = {"scale": 1e-7, "unit": "m", "signed": True}
    for n in range(1, 7):
        for place, side in [(0x180, "C1"), (0x190, "C2")]:
            signals = [
                signal("Position", 0, 32, **metres),
                signal("Velocity", 32, 32, scale=1e-7, unit="m/s", signed=True),
            ]
            messages.append(Message(place + n, f"Cyl{n}_{side}", 8, signals))
        signals = [
            signal("ControlSpeed", 0, 32, scale=1e-7, unit="m/s", signed=True),
            signal("PressureBottom", 32, 16, scale=0.01, unit="bar"),
            signal("PressureRod", 48, 16, scale=0.01, unit="bar"),
        ]
        messages.append(Message(0x1A0 + n, f"Cyl{n}_Valve", 8, signals))
    write_dbc(messages, folder / "truth.dbc")
    (folder / "truth.toml").write_text(
        configuration("Truth", 6, 0.02, [-1.5, 1.5], "truth.dbc")
        + '[signals]\nsync = "Sync"\n[signals.cylinder]\n'
        + "".join(
            f'{side.lower()} = "Cyl{{n}}_{side}.Position"\n'
            f'{side.lower()}_velocity = "Cyl{{n}}_{side}.Velocity"\n'
            for side in ("C1", "C2")
        )
        + 'control_speed = "Cyl{n}_Valve.ControlSpeed"\n'
        + 'pressure_bottom = "Cyl{n}_Valve.PressureBottom"\n'
        + 'pressure_rod = "Cyl{n}_Valve.PressureRod"\n'
    )
    plant = Path("config/e-type-plant.toml").read_text()
    for old, new in [
        ("counts = 27648.0 ", "counts = 3.0e7 "),
        ("fluctuation_probability = 5.0e-4 ", "fluctuation_probability = 0.0 "),
    ]:
        assert plant.count(old) == 1, old
        plant = plant.replace(old, new)
    (folder / "truth-plant.toml").write_text(plant)


def read_truth(folder, log):
    """Lengths and speeds by C1 and C2, commands and pressures, each an array of cycles by cylinders."""
    database = cantools.database.load_file(folder / "truth.dbc")
    columns = {}
    for frame in can.CanutilsLogReader(log):
        columns.setdefault(frame.arbitration_id, []).append(bytes(frame.data))
    raw = lambda place: np.stack(
        [np.frombuffer(b"".join(columns[place + n]), "<i4").reshape(-1, 2) for n in range(1, 7)], 1
    )
    # NumPy reads the frames at once; cantools reads one of each to see that it is the same.
    for place, columns_of, name in [(0x180, 0, "Position"), (0x190, 1, "Velocity")]:
        for n in range(1, 7):
            message = database.get_message_by_frame_id(place + n)
            told = message.decode(columns[place + n][7])[name]
            assert abs(told - 1e-7 * raw(place)[7, n - 1, columns_of]) < 1e-12
    c1, c2 = raw(0x180) * 1e-7, raw(0x190) * 1e-7
    valves = [np.frombuffer(b"".join(columns[0x1A0 + n]), "<i4, <u2, <u2") for n in range(1, 7)]
    u, bottom, rod = [
        np.stack([valve[field] * scale for valve in valves], 1)
        for field, scale in [("f0", 1e-7), ("f1", 0.01), ("f2", 0.01)]
    ]
    lengths, speeds = [np.stack([c1[..., i], c2[..., i]], -1) for i in (0, 1)]
    return {"lengths": lengths, "speeds": speeds, "u": u, "bottom": bottom, "rod": rod}


# ---------------------------------------------------------------- faults


class Fault:
    """On C1 (side 0) or C2 (1) of a cylinder, from 0; `size` in m, m/s, or 1 where there is none."""

    def __init__(self, cylinder, side, kind, begin, end, size):
        self.cylinder, self.side, self.kind = cylinder, side, kind
        self.begin, self.end, self.size = begin, end, size
        self.restart()

    def restart(self):
        """Before the recording is gone through once more."""
        self.rng, self.held = np.random.default_rng(int(self.begin * 1e6)), None

    def there(self, t):
        return self.begin <= t < self.end

    def reading(self, t, length, speed):
        """What the transducer reads instead."""
        if self.kind == "step":
            length += self.size
        elif self.kind == "drift":
            length += self.size * (t - self.begin)
        elif self.kind == "noise":
            length += self.size * self.rng.integers(-1, 2)
        elif self.kind == "incipient":
            length += self.size * (1 - 2.0 ** (self.begin - t))
        elif self.kind in ("freeze", "blind"):
            # A blind one holds its length, and its speed is right.
            self.held = self.held or (length, speed)
            return self.held if self.kind == "freeze" else (self.held[0], speed)
        return length, speed


# In the loop a lost C1 makes a controller stop, which is nothing to be tried here.
MOVING = ["step", "drift", "noise", "freeze", "incipient", "blind"]
LOST = ["stale", "loss", "out_of_range", "broken_wire"]


def size(kind, rng):
    low, high = {
        "step": (0.5e-3, 60e-3),
        "drift": (0.2e-3, 20e-3),
        "noise": (0.5e-3, 5e-3),
        "incipient": (5e-3, 70e-3),
    }.get(kind, (1.0, 1.0))
    sign = rng.choice([-1.0, 1.0]) if high < 1.0 else 1.0
    return sign * float(np.exp(rng.uniform(np.log(low), np.log(high))))


def plan(cylinders, seed, begin, end, kinds):
    """Faults of every kind on both transducers of each cylinder, in random order, one after another."""
    faults = []
    for cylinder in range(cylinders):
        rng = np.random.default_rng([seed, cylinder])
        t, bag = begin + LEAD, []
        while True:
            bag = bag or list(rng.permutation([(kind, side) for kind in kinds for side in (0, 1)]))
            kind, side = bag.pop()
            t += rng.uniform(*BETWEEN)
            last = t + rng.uniform(*LASTING)
            if last + 3.0 > end:
                break
            faults.append(Fault(cylinder, int(side), str(kind), t, last, size(kind, rng)))
            t = last
    return faults


# ---------------------------------------------------------------- a rig of its own, at 7 ms


def rig(seed, seconds, ts, faults):
    """One cylinder in a position loop: second-order valve, square-root flow, compressible oil, friction.

    The controller reads C1 as `faults` make it."""
    rng = np.random.default_rng([seed, 70])
    area, mass, load, supply = 2.0e-3, 800.0, 1500.0, 160.0
    rise, leak, full = 2.2e4, 2.0, 0.8
    steps, cycles = 14, int(seconds / ts)
    dt = ts / steps
    frequencies = np.array([0.06, 0.13, 0.29, 0.47])
    sizes, phases = np.array([0.16, 0.1, 0.05, 0.02]), rng.uniform(0, 2 * np.pi, 4)
    times = np.arange(cycles) * ts
    angle = 2 * np.pi * np.outer(times, frequencies) + phases
    reference, speed = np.sin(angle) @ sizes, np.cos(angle) @ (sizes * 2 * np.pi * frequencies)
    reference = reference + 0.55
    l, v, p, x, xd, u = float(reference[0]), float(speed[0]), load / area * 1e-5, 0.0, 0.0, 0.0
    noise = rng.normal(0.0, 1.5e-5, (cycles, 2))
    speed_noise = rng.normal(0.0, 1e-3, (cycles, 2))
    lengths, speeds, commands = np.empty((cycles, 1, 2)), np.empty((cycles, 1, 2)), np.empty((cycles, 1))
    for k in range(cycles):
        t = times[k]
        lengths[k, 0] = [l + noise[k, 0], 0.998 * (l + 1e-4 * v) + 0.0021 + 3e-4 * l * l + noise[k, 1]]
        speeds[k, 0] = v + speed_noise[k]
        seen = lengths[k, 0, 0]
        for fault in faults:
            if fault.side == 0 and fault.there(t):
                seen, _ = fault.reading(t, seen, speeds[k, 0, 0])
        command = min(max(speed[k] + 4.0 * (reference[k] - seen), -0.6), 0.6)
        # From this cycle to the next the valve has the command of the cycle before.
        commands[k, 0], u = command, command
        for _ in range(steps):
            xd += dt * (190.0**2 * (u / full - x) - 2 * 0.8 * 190.0 * xd)
            x += dt * xd
            drop = max(supply - p if x > 0 else supply + p, 0.0) / supply
            flow = full * x * drop**0.5
            p += dt * (rise * (flow - v) - leak * p)
            friction = 4.0e3 * v + 150.0 * math.tanh(v / 5e-3)
            if not 0.02 < l < 1.18:
                # The cylinder's end: a stiff spring that damps.
                friction += 2e7 * (l - min(max(l, 0.02), 1.18)) + 1e5 * v
            v += dt * (area * 1e5 * p - load - friction) / mass
            l += dt * v
    return {"lengths": lengths, "speeds": speeds, "u": commands}


# ---------------------------------------------------------------- how each machine speaks


class Rig:
    """One cylinder on three messages; `speeds` are left out where they are not sent."""

    cylinders, fast = 1, ()

    def __init__(self, name, speeds):
        self.name, self.speeds = name, speeds
        self.ts, self.stroke = 0.007, [0.0, 1.2]

    def messages(self):
        v = {"scale": 1e-4, "unit": "m/s", "signed": True}
        c1 = [signal("Length", 3, 20, scale=2e-6, unit="m", minimum=0, maximum=1.2)]
        c2 = [motorola("Length", 0, 32, unit="m", minimum=0, maximum=1.2, is_float=True)]
        if self.speeds:
            c1.append(signal("Speed", 32, 16, **v))
            c2.append(signal("Speed", 32, 16, **v))
        drive = [signal("Wanted", 0, 16, **v)]
        rows = [(0x101, "One", 8, c1), (0x102, "Two", 8, c2), (0x0F0, "Drive", 2, drive)]
        return [Message(*row) for row in rows]

    def signals(self):
        text = '[signals.cylinder]\ncontrol_speed = "Drive.Wanted"\n'
        text += 'c1 = "One.Length"\nc2 = "Two.Length"\n'
        return text + ('c1_velocity = "One.Speed"\nc2_velocity = "Two.Speed"\n' if self.speeds else "")

    def cycle(self, k, truth, readings):
        """The frames of cycle `k`: s after its beginning, message, values, whose readings it has."""
        for side, name in [(0, "One"), (1, "Two")]:
            length, speed, _ = readings[0][side]
            values = {"Length": max(length, 0.0)} | ({"Speed": speed} if self.speeds else {})
            yield 2e-4 + 3e-4 * side, name, values, [(0, side)]
        yield 2.5e-3, "Drive", {"Wanted": truth["u"][k, 0]}, []

    # What is beyond the range by far; a broken wire says no more here.
    wild = {"out_of_range": 1.31, "broken_wire": 2.0}


class Rig24:
    """Readings of a micrometre in 24 bits, which pass raw 32767 while the rod moves."""

    cylinders, ts, stroke, name, fast = 1, 0.02, [-1.5, 1.5], "rig24", ()
    wild = {"out_of_range": 1.7, "broken_wire": None}

    def __init__(self, truth, at):
        # In cycle `at` C1 reads raw 32767, to the micrometre; C2 does 50 cycles later.
        raw = lambda k, side: int(round(truth["lengths"][k, 0, side] * 1e6))
        self.offsets = [raw(at + 50 * side, side) - 32767 for side in (0, 1)]

    def messages(self):
        result = []
        for side, name in [(0, "EncoderA"), (1, "EncoderB")]:
            offset = self.offsets[side] * 1e-6
            signals = [
                motorola("Length", 4, 24, scale=1e-6, offset=offset, unit="m", signed=True),
                motorola("Speed", 28, 16, scale=1e-4, unit="m/s", signed=True),
                motorola("Failed", 44, 1),
                motorola("Alive", 48, 4),
            ]
            result.append(Message(0x311 + side, name, 7, signals))
        valve = [
            motorola("Speed", 0, 16, scale=1e-4, unit="m/s", signed=True),
            motorola("Bottom", 16, 16, scale=0.01, unit="bar"),
            motorola("Rod", 32, 16, scale=0.01, unit="bar"),
        ]
        return result + [Message(0x320, "Valve", 6, valve)]

    def signals(self):
        text = "[signals.cylinder]\n"
        for side, name in [("c1", "EncoderA"), ("c2", "EncoderB")]:
            text += f'{side} = "{name}.Length"\n{side}_velocity = "{name}.Speed"\n'
            text += f'{side}_status = "{name}.Failed"\n{side}_counter = "{name}.Alive"\n'
        text += 'control_speed = "Valve.Speed"\n'
        return text + 'pressure_bottom = "Valve.Bottom"\npressure_rod = "Valve.Rod"\n'

    def cycle(self, k, truth, readings):
        for side, name in [(0, "EncoderA"), (1, "EncoderB")]:
            length, speed, failed = readings[0][side]
            values = {"Length": length, "Speed": speed, "Failed": int(failed), "Alive": k % 16}
            yield 6e-4 + 5e-4 * side, name, values, [(0, side)]
        values = {"Speed": truth["u"][k, 0], "Bottom": truth["bottom"][k, 0], "Rod": truth["rod"][k, 0]}
        yield 7e-3, "Valve", values, []


class Paged:
    """Six cylinders in three messages and Sync. The page of Base that comes first is of no use."""

    cylinders, ts, stroke, name = 6, 0.02, [-1.5, 1.5], "paged"
    # CAN FD, whatever their length.
    fast = ("Base", "Legs", "Valves")
    wild = {"out_of_range": 1.6, "broken_wire": -1.5 + 32767 * 3 / 27648}

    def messages(self):
        metres = {"scale": 3 / 27648, "offset": -1.5, "unit": "m"}
        metres |= {"minimum": -1.5 + 3 / 27648, "maximum": 1.5}
        speed = {"scale": 1e-4, "unit": "m/s", "signed": True}
        page = signal("Page", 0, 8, is_multiplexer=True)
        base, legs, valves = [page], [page], []
        for n in range(1, 7):
            base.append(signal(f"Oil{n}", 8 * n, 8, unit="degC", page=0))
            base.append(signal(f"Length{n}", 32 * n - 16, 16, page=3, **metres))
            base.append(signal(f"Speed{n}", 32 * n, 16, page=3, **speed))
            base.append(signal(f"Alive{n}", 200 + 8 * n, 8, page=3))
            legs.append(signal(f"Alive{n}", 8, 8, page=n - 1))
            legs.append(signal(f"Length{n}", 16, 16, page=n - 1, **metres))
            legs.append(signal(f"Speed{n}", 32, 16, page=n - 1, **speed))
            legs.append(signal(f"Failed{n}", 48, 2, page=n - 1))
            for i, name in enumerate(["Wanted", "Bottom", "Rod"]):
                how = speed if i == 0 else {"scale": 0.01, "unit": "bar"}
                valves.append(signal(f"{name}{n}", 48 * (n - 1) + 16 * i, 16, **how))
        wide = {"is_extended_frame": True, "is_fd": True, "protocol": None}
        return [
            Message(0x18FF0080, "Beat", 1, [signal("Count", 0, 8)], is_extended_frame=True),
            Message(0x18FF4100, "Base", 32, base, **wide),
            Message(0x18FF4200, "Legs", 8, legs, **wide),
            Message(0x18FF4300, "Valves", 48, valves, **wide),
        ]

    def signals(self):
        text = '[signals]\nsync = "Beat"\n[signals.cylinder]\n'
        for side, name in [("c1", "Base"), ("c2", "Legs")]:
            text += f'{side} = "{name}.Length{{n}}"\n{side}_velocity = "{name}.Speed{{n}}"\n'
            text += f'{side}_counter = "{name}.Alive{{n}}"\n'
        text += 'c2_status = "Legs.Failed{n}"\ncontrol_speed = "Valves.Wanted{n}"\n'
        return text + 'pressure_bottom = "Valves.Bottom{n}"\npressure_rod = "Valves.Rod{n}"\n'

    def cycle(self, k, truth, readings):
        yield 0.0, "Beat", {"Count": k % 256}, []
        yield 3e-4, "Base", {"Page": 0} | {f"Oil{n}": 40 + n for n in range(1, 7)}, []
        values = {"Page": 3}
        for n in range(1, 7):
            values[f"Alive{n}"] = (k + 40 * n) % 256
            values[f"Length{n}"], values[f"Speed{n}"], _ = readings[n - 1][0]
        yield 6e-4, "Base", values, [(n, 0) for n in range(6)]
        for n in range(1, 7):
            length, speed, failed = readings[n - 1][1]
            values = {"Page": n - 1, f"Alive{n}": k % 256, f"Length{n}": length}
            values |= {f"Speed{n}": speed, f"Failed{n}": 2 * int(failed)}
            yield 1e-3 + 2.5e-4 * n, "Legs", values, [(n - 1, 1)]
        values = {}
        for n in range(1, 7):
            for name, key in [("Wanted", "u"), ("Bottom", "bottom"), ("Rod", "rod")]:
                values[f"{name}{n}"] = float(truth[key][k, n - 1])
        yield 8e-3, "Valves", values, []


def configuration(name, cylinders, ts, stroke, dbc):
    return (
        f'[machine]\nname = "{name}"\ncylinders = {cylinders}\nsample_time = {ts}\nstroke = {stroke}\n'
        f'[bus]\ninterface = "can0"\ndbc = "{dbc}"\n'
    )


def write_dbc(messages, path):
    path.write_text(Database(messages).as_dbc_string(), newline="")


# ---------------------------------------------------------------- recordings


class Recorder:
    """Two candump files of the same machine; the second has the faults, from cycle `first` on."""

    def __init__(self, machine, database, folder, first):
        self.machine, self.first = machine, first
        self.known = {message.name: message for message in database.messages}
        self.healthy = (folder / "healthy.log").open("w")
        self.faulty = (folder / "faulty.log").open("w")
        self.last = {}

    def line(self, at, message, data):
        identifier = f"{message.frame_id:0{8 if message.is_extended_frame else 3}X}"
        mark = "##1" if message.name in self.machine.fast else "#"
        return f"({at:.6f}) can0 {identifier}{mark}{data.hex().upper()}\n"

    def cycle(self, k, at, truth, faults, jitter):
        """Cycle `k`, which begins at `at`, with the `faults` that are there."""
        lengths, speeds = truth["lengths"][k].tolist(), truth["speeds"][k].tolist()
        # Of each cylinder's transducers: length, speed, and whether it says that it has failed.
        healthy = [[(*one, False) for one in zip(*both)] for both in zip(lengths, speeds)]
        readings = [list(both) for both in healthy]
        hit = {}
        for fault in faults:
            hit[fault.cylinder, fault.side] = fault
            length, speed, failed = readings[fault.cylinder][fault.side]
            length, speed = fault.reading(k * self.machine.ts, length, speed)
            if fault.kind in LOST[2:]:
                wild = self.machine.wild[fault.kind]
                length, failed = (length, True) if wild is None else (wild, failed)
            readings[fault.cylinder][fault.side] = (length, speed, failed)
        faulty = list(self.machine.cycle(k, truth, readings)) if hit else None
        for i, (after, name, values, of) in enumerate(self.machine.cycle(k, truth, healthy)):
            message = self.known[name]
            stamp = at + after + jitter[i]
            # Strict refuses what is out of the range of the DBC, which a fault may well be.
            data = message.encode(values, strict=False)
            line = self.line(stamp, message, data)
            self.healthy.write(line)
            if k < self.first:
                continue
            mine = [hit[place] for place in of if place in hit]
            key = (name, *of[:1])
            if mine:
                if any(fault.kind == "loss" for fault in mine):
                    continue
                data = message.encode(faulty[i][2], strict=False)
                if any(fault.kind == "stale" for fault in mine):
                    data = self.last[key]
                line = self.line(stamp, message, data)
            self.last[key] = data
            self.faulty.write(line)


def write(name, folder, seed, learnt, seconds, log):
    loop = name == "loop7"
    kinds = MOVING if loop else MOVING + LOST
    if name in ("rig7", "loop7"):
        machine = Rig(name, speeds=loop)
        faults = plan(1, seed, learnt, seconds, kinds)
        truth = rig(seed, seconds, machine.ts, faults if loop else [])
    else:
        truth = read_truth(folder, log)
        if name == "rig24":
            # A cylinder of six, by turns.
            truth = {key: value[:, [seed % 6]] for key, value in truth.items()}
            machine = Rig24(truth, int((learnt + 5.0) / 0.02))
        else:
            machine = Paged()
        faults = plan(machine.cylinders, seed, learnt, seconds, kinds)
        if name == "paged":
            # C1 of six is in one frame, which nobody loses for one of them alone.
            faults = [f for f in faults if f.side == 1 or f.kind not in ("stale", "loss")]
    write_dbc(machine.messages(), folder / f"{name}.dbc")
    text = configuration(f"{name}, {seed}", machine.cylinders, machine.ts, machine.stroke, f"{name}.dbc")
    (folder / f"{name}.toml").write_text(text + machine.signals())
    database = cantools.database.load_file(folder / f"{name}.dbc")
    recorder = Recorder(machine, database, folder, int(learnt / machine.ts))
    cycles = min(len(truth["u"]), int(seconds / machine.ts))
    jitter = np.random.default_rng([seed, 9]).uniform(-5e-5, 5e-5, (cycles, 16)) + 1e-4
    jitter = np.round(jitter, 6).tolist()
    for fault in faults:
        fault.restart()
    ahead = sorted(faults, key=lambda fault: fault.begin)
    for k in range(cycles):
        t = k * machine.ts
        there = [fault for fault in ahead if fault.there(t)]
        recorder.cycle(k, START + t, truth, there, jitter[k])
    first = recorder.first * machine.ts
    with (folder / "faults.csv").open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["cylinder", "sensor", "kind", "begin", "end", "size"])
        for fault in faults:
            times = [f"{time - first:.6f}" for time in (fault.begin, fault.end)]
            rows.writerow([fault.cylinder + 1, f"c{fault.side + 1}", fault.kind, *times, fault.size])


def main():
    what, folder, *rest = sys.argv[1:]
    folder = Path(folder)
    if what == "truth":
        write_truth(folder)
    else:
        seed, learnt, seconds, *log = rest
        write(what, folder, int(seed), float(learnt), float(seconds), *(log or [None]))


main()
