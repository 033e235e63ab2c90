"""The table of residuals of a replay, computed a second time by other means.

    residuals.py DBC LOG CSV < configuration as JSON

LOG is a recording in the form of candump -l, CSV what `tertius replay --residuals` made of it. Bits
are found with cantools' reading of the DBC, the gain L is from SciPy's solve_discrete_are, and the
rules are those of the description:

- A cycle has a place, a Ts after that of the last one. It opens with Sync, unless that comes within three
  quarters of Ts after the last place. When it was lost, a reading 19/20 of Ts after the last place stands in
  for it; where no Sync is configured, the first reading half of Ts after it opens a cycle. A Sync moves the
  place to where it is if it is early, and by a sixteenth of the way if it is late; so does a reading, whose
  cycle opens at its place. A Sync more than Ts/20 early, and a reading in place of Sync, give way to a Sync
  that comes later within half of Ts, and no more than Ts/20 before the place. A cycle closes 0.8 Ts after it
  opens.
- A counter says of which cycle a frame is: the last one's and as many counts as cycles have passed. What
  is up to five cycles old is late, the same count is repeated, one of the next cycle is held for it, and
  another count is believed with the second frame in a row that goes on with it. What is refused for five
  cycles running is taken by its time.
- Without a counter a frame that follows a lost one waits until the cycle closes; one that comes meanwhile
  is better unless it is further from the usual phase (median of 64) by more than 1 ms and 4.4 deviations. As
  many wait in turn as were lost.
  Half of Ts after the usual phase the same payload is a repetition, another one is held.
- A cylinder is evaluated when everything of it has come, or when the cycle closes.
- A cycle that does not open is evaluated without readings, until the observers have stopped.
- A reading is used unless its sender repeats itself, its code or status says broken wire, it is
  beyond codes or stroke, or it has been exactly constant for `frozen` seconds under a command that
  moved since the cycle before in a monitored state. It stays frozen until it changes. The other
  transducer, good when last judged, has to have moved meanwhile by half of frozen_speed times `frozen`
  or by the comparator's bound if that is less: in three steps one way, the newest of no more than twice
  the two before it together. Unless it has, that takes five times as long, of which the command moved
  `frozen` seconds either way, and the other one has read nothing else.
- (5-4): x(k+1) = A x(k) + B u(k) + L (y(k) - C x(k)); the residual is y - C x before this step. It
  starts with the first reading as [length, speed or 0, 0]. Without a reading the model alone goes on,
  for at most max_gap seconds; then it starts anew. The last command is held.
- FDE1 and FDE2 judge when the platform's state is a monitored one (not older than a second), the
  observer has followed 1 s of readings and a command has come within `stale` seconds.

The answer is JSON: rows, the largest difference of each column, the first row that has something
where the other has nothing, times of restarts, and counts that tell how much was tried.
"""

import json
import math
import sys

import cantools
import numpy
from scipy.linalg import solve_discrete_are

COLUMNS = "t,cylinder,c1,c2,c2_corrected,u,estimate1,estimate2,r1,r2,r3,gated".split(",")
DEFAULTS = {
    "plausibility": {
        "stale": 0.1, "broken_wire_codes": [32767], "status_mask": ~0, "valid_raw": None,
        "frozen": 0.1, "frozen_speed": 0.02, "state_stale": 1.0,
    },
    "model": {
        "theta": [-0.0101, -0.1231, -1.6891e-5, -10.7104, -0.0023], "gamma": [0.0926, 6.5427],
    },
    "observer": {"q": [5e-9, 2e-4, 1e4], "r": [1e-8, 5.0], "settle": 1.0},
}


def read_log(path):
    """Times in ns, identifiers and payloads."""
    times, ids, data = [], [], []
    with open(path, "rb") as log:
        for line in log:
            stamp, _, frame = line.split(b" ")
            whole, fraction = stamp[1:-1].split(b".")
            times.append(int(whole) * 10**9 + int(fraction.ljust(9, b"0")))
            identifier, payload = frame.strip().split(b"#")
            ids.append(int(identifier, 16))
            data.append(bytes.fromhex(payload.decode()))
    return times, ids, data


class Signals:
    """Raw and physical values of MESSAGE.SIGNAL in every frame of its message."""

    def __init__(self, dbc, ids, data):
        self.dbc = cantools.database.load_file(dbc)
        self.ids = numpy.array(ids)
        self.data = data
        self.padded = {}

    def find(self, name):
        message, signal = name.split(".")
        message = self.dbc.get_message_by_name(message)
        return message, message.get_signal_by_name(signal)

    def of(self, name):
        message, signal = self.find(name)
        little, big = self.words(message.frame_id)
        length = numpy.uint64(signal.length)
        if signal.byte_order == "little_endian":
            raw = little >> numpy.uint64(signal.start)
        else:
            # The DBC names the highest bit; bits count from the lowest of each byte.
            first = signal.start // 8 * 8 + 7 - signal.start % 8
            raw = big >> numpy.uint64(64 - first - signal.length)
        raw = (raw & ((numpy.uint64(1) << length) - numpy.uint64(1))).astype(numpy.int64)
        if signal.is_signed:
            raw -= (raw >> (signal.length - 1)) << signal.length
        physical = raw * float(signal.scale) + float(signal.offset)
        self.check(message, signal, physical)
        return raw.tolist(), physical.tolist()

    def words(self, identifier):
        if identifier not in self.padded:
            frames = numpy.nonzero(self.ids == identifier)[0]
            joined = b"".join(self.data[i].ljust(8, b"\0") for i in frames)
            self.padded[identifier] = (
                numpy.frombuffer(joined, "<u8"), numpy.frombuffer(joined, ">u8").astype("u8"),
            )
        return self.padded[identifier]

    def check(self, message, signal, physical):
        """Every hundredth value against cantools' own decoding."""
        frames = numpy.nonzero(self.ids == message.frame_id)[0]
        for row in range(0, len(frames), 100):
            theirs = message.decode(self.data[frames[row]], decode_choices=False)[signal.name]
            assert math.isclose(theirs, physical[row], rel_tol=1e-14, abs_tol=1e-15), signal


class Observer:
    def __init__(self, config, n, velocity):
        model = {**config["model"], **config["cylinders"].get(n, {})}
        t, g, ts = model["theta"], model["gamma"], config["machine"]["sample_time"]
        self.a = numpy.array([[1, ts, 0], [t[0], 1 + t[1], t[2]], [0, t[3], 1 + t[4]]])
        self.b = numpy.array([0, g[0], g[1]])
        outputs = 2 if velocity else 1
        c = numpy.eye(3)[:outputs]
        weights = config["observer"]
        q, r = numpy.diag(weights["q"]), numpy.diag(weights["r"][:outputs])
        p = solve_discrete_are(self.a.T, c.T, q, r)
        self.l = self.a @ p @ c.T @ numpy.linalg.inv(c @ p @ c.T + r)
        self.velocity = velocity
        self.settle = round(weights["settle"] / ts)
        self.max_gap = round(config["machine"]["max_gap"] / ts)
        self.x = None
        self.started = False
        self.u = 0.0
        # Cycles until a loss has decayed to a part of its first effect, and until the present one has.
        error, shown, self.recovery = self.l[:, 0], 0.1 * abs(self.l[0, 0]), 0
        while self.recovery < self.settle and abs(error[0]) >= shown and error[0] != 0.0:
            error, self.recovery = (self.a - self.l @ c) @ error, self.recovery + 1
        self.recovering = self.broken = 0

    def step(self, reading, u):
        """C x, the innovation and whether it may be judged; and whether it began anew."""
        self.u = self.u if u is None else u
        recovering = self.recovering
        lost = reading is None or u is None
        self.recovering = self.recovery if lost else max(self.recovering - 1, 0)
        if reading is None:
            if self.x is not None:
                self.coasted += 1
                gone = self.coasted > self.max_gap
                self.x = None if gone else self.a @ self.x + self.b * self.u
            return None, False
        anew = self.x is None and self.started
        if self.x is None:
            speed = reading["velocity"] if self.velocity else 0.0
            self.x = numpy.array([reading["position"], speed, 0.0])
            self.followed, self.started = 0, True
        self.broken = self.broken + 1 if recovering > 0 else 0
        settled = self.followed >= self.settle and self.broken <= self.max_gap
        self.followed += 1
        self.coasted = 0
        estimate = float(self.x[0])
        residual = reading["position"] - estimate
        innovation = [residual, reading["velocity"] - self.x[1]] if self.velocity else [residual]
        self.x = self.a @ self.x + self.b * self.u + self.l @ innovation
        return (estimate, residual, settled), anew


class Transducer:
    """The checks of one transducer."""

    def __init__(self, config, signal):
        plausibility, stroke = config["plausibility"], config["machine"]["stroke"]
        self.limits = plausibility
        half_count = abs(signal.scale) / 2
        low, high = stroke
        self.codes = plausibility["valid_raw"]
        if self.codes is None:
            low, high = max(low, signal.minimum), min(high, signal.maximum)
        self.lengths = low - half_count, high + half_count
        self.frozen = round(plausibility["frozen"] / config["machine"]["sample_time"])
        way = 0.5 * plausibility["frozen_speed"] * plausibility["frozen"]
        self.travel = min(way, config.get("comparator", {}).get("bound", 1.5e-3))
        self.last = None
        self.sound, self.steps, self.goes_on, self.passed = False, [], False, None
        self.hold(None)

    def hold(self, beside):
        self.beside, self.constant, self.pushed = beside, 0, {1: 0, -1: 0}
        self.witnessed = self.stirred = False

    def pass_by(self, reading):
        """What its steps are, before anybody judges it."""
        if reading is None:
            self.steps, self.passed, self.goes_on = [], None, False
            return
        before, self.passed = self.passed, reading["position"]
        step = 0.0 if before is None else self.passed - before
        self.goes_on = False
        if step == 0.0:
            return
        self.steps = self.steps[-2:] + [step]
        one_way = len({step > 0 for step in self.steps}) == 1
        if len(self.steps) == 3 and one_way:
            self.goes_on = abs(step) <= 2 * abs(sum(self.steps[:2]))

    def good(self, reading, moving, other):
        self.sound = self.judged(reading, moving, other)
        return self.sound

    def judged(self, reading, moving, other):
        if reading is None:
            return False
        same = reading["position"] == self.last
        self.last = reading["position"]
        if not (same and (moving or self.is_frozen())):
            self.hold(other and other[0])
        else:
            self.constant += 1
            if moving:
                self.pushed[moving] += 1
            if self.beside is not None and other is not None:
                travel = abs(other[0] - self.beside)
                self.stirred |= travel > 0
                self.witnessed |= other[1] and travel >= self.travel
        return not (self.is_broken(reading) or self.is_outside(reading) or self.is_frozen())

    def is_broken(self, reading):
        limits = self.limits
        by_status = reading.get("status", 0) & limits["status_mask"]
        return by_status or reading["code"] in limits["broken_wire_codes"]

    def is_outside(self, reading):
        low, high = self.codes or (-math.inf, math.inf)
        inside = self.lengths[0] <= reading["position"] <= self.lengths[1]
        return not (inside and low <= reading["code"] <= high)

    def is_frozen(self):
        if self.witnessed:
            return self.constant >= self.frozen
        either_way = min(self.pushed.values()) >= self.frozen
        return not self.stirred and either_way and self.constant >= 5 * self.frozen


class Cylinder:
    def __init__(self, config, n, signals, gate, tried):
        self.n, self.gate, self.tried = n, gate, tried
        named = config["signals"]["cylinder"]
        self.transducers, self.observers = [], []
        for which in ("c1", "c2"):
            _, signal = signals.find(named[which].replace("{n}", str(n)))
            self.transducers.append(Transducer(config, signal))
            self.observers.append(Observer(config, n, which + "_velocity" in named))
        own = config["cylinders"].get(n, {})
        self.gain, self.offset = own.get("c2_gain", 1.0), own.get("c2_offset", 0.0)
        ts = config["machine"]["sample_time"]
        self.stale = round(config["plausibility"]["stale"] / ts)
        self.speed = config["plausibility"]["frozen_speed"]
        self.moving = 0
        self.without_command = 0

    def row(self, at, opened, live, readings, u, restarts):
        monitored = self.gate.is_open(at)
        estimates, residuals, judged, used = [None] * 2, [None] * 3, False, []
        positions = [reading and reading["position"] for reading in readings]
        for transducer, reading in zip(self.transducers, readings):
            transducer.pass_by(reading)
        for i, reading in enumerate(readings):
            beside = self.transducers[1 - i]
            known = beside.sound and positions[1 - i] is not None
            other = (positions[1 - i], beside.goes_on) if known else None
            good = self.transducers[i].good(reading, self.moving if monitored else 0, other)
            self.tried["refused"] += reading is not None and not good
            self.tried["frozen"] += self.transducers[i].is_frozen()
            used.append(reading["position"] if good else None)
            result, anew = self.observers[i].step(reading if good else None, u)
            if anew:
                restarts.append([at, self.n, f"fde{i + 1}"])
            if result is not None:
                estimates[i], residuals[i], settled = result
                judged |= settled
        if u is not None:
            self.moving = (1 if u > 0 else -1) if abs(u) > self.speed else 0
            self.without_command = 0
        else:
            self.without_command += live
        judged = judged and monitored and self.without_command < self.stale
        corrected = None if positions[1] is None else self.gain * positions[1] + self.offset
        if None not in used:
            residuals[2] = used[0] - corrected
        return [opened, self.n, *positions, corrected, u, *estimates, *residuals, int(not judged)]


class Gate:
    def __init__(self, config, signals):
        states = config["machine"].get("monitored_states")
        self.monitored = None
        if states is not None:
            choices = signals.find(config["signals"]["state"])[1].choices
            self.monitored = {number for number, name in choices.items() if str(name) in states}
        self.timeout = round(config["plausibility"]["state_stale"] * 1e9)
        self.state, self.since = None, 0

    def is_open(self, at):
        if self.monitored is None:
            return True
        return self.state in self.monitored and at - self.since <= self.timeout


TAKEN, REPLACES, SETTLES, WAITS, HELD, TWICE, LATE = range(7)


class Slot:
    """The arrivals of one message."""

    def __init__(self, ts, bits):
        self.ts, self.bits = ts, bits
        self.last = self.misfit = None
        self.believed, self.fitting = True, 0
        self.filled, self.payload, self.phases = None, None, []
        self.kept = None
        self.starved, self.starved_in = 0, None

    def off(self, cycle, count):
        """Cycles beside the newest, "same", "jumped", or None if the counter says nothing."""
        if self.bits is None or count is None or self.last is None:
            return None
        if count == self.last[1]:
            return "same"
        if not self.believed:
            return None
        half = 1 << (self.bits - 1)
        off = (count - self.last[1] - (cycle - self.last[0]) + half) % (2 * half) - half
        return off if -5 <= off <= 1 else "jumped"

    def rejects(self, cycle, count, empty, behind):
        before = self.misfit or self.last
        counts, cycles = (count - before[1]) % (1 << self.bits), cycle - before[0]
        if (cycles, counts) == (0, 0):
            return True
        if cycles == 0 and self.misfit and not behind and counts == 1:
            self.believed, self.fitting, self.misfit = False, 0, None
            return not empty
        assert cycles == 0 or counts % cycles or counts == cycles, "another step is not tried here"
        same = cycles > 0 and counts == cycles
        if empty and same and self.misfit and not behind:
            return False
        if empty or not behind:
            self.misfit = cycle, count
        return True

    def usual(self):
        if len(self.phases) < 8:
            return None
        newest = sorted(self.phases[-64:])
        middle = newest[len(newest) // 2]
        scatter = sorted(abs(phase - middle) for phase in newest)[len(newest) // 2]
        return middle * 1000, max(1000, int(4.4 * scatter)) * 1000

    def starves(self, cycle):
        if not self.starved or self.starved_in != cycle:
            self.starved, self.starved_in = self.starved + 1, cycle
        if self.starved >= 5:
            self.believed, self.fitting, self.misfit = False, 0, None
        return self.starved >= 5

    def take(self, frame, cycle, opened, believed=False):
        at, payload, count, _ = frame
        self.filled, self.starved = cycle, 0
        if count is not None:
            if not self.believed and self.last:
                fits = (count - self.last[1]) % (1 << self.bits) == max(cycle - self.last[0], 1)
                self.fitting = self.fitting + 1 if fits else 0
                self.believed = self.fitting >= 16
            self.misfit, self.last = None, (cycle, count)
        if not believed:
            self.payload = payload
            phase = at - opened
            self.phases.append(abs(phase) // 1000 * (1 if phase >= 0 else -1))
        return TAKEN

    def judge(self, frame, cycle, opened, is_open):
        at, payload, count, _ = frame
        phase, half = at - opened, self.ts // 2
        lacks = self.filled != cycle
        empty = lacks and is_open
        off = self.off(cycle, count)
        if off is not None:
            if off == "same" or (off == 0 and not lacks):
                return TWICE
            if off == 0 and empty:
                return self.take(frame, cycle, opened, believed=True)
            if off == 1 and phase >= half:
                return HELD
            behind = off != "jumped" and off < 0
            if off != 0 and not self.rejects(cycle, count, empty, behind):
                return self.take(frame, cycle, opened)
            if not (lacks and self.starves(cycle)):
                return LATE
        usual, tolerance = self.usual() or (0, 0)
        copied, for_next = payload == self.payload, phase >= usual + half
        if not lacks:
            self.fitting = self.fitting if copied else 0
            return HELD if for_next and not copied else TWICE
        if not is_open:
            return HELD if self.starves(cycle) else LATE
        if self.kept and self.kept[1] == cycle:
            first = abs(self.kept[0][0] - opened - usual)
            if abs(phase - usual) <= first + tolerance:
                if self.kept[3] + 1 < cycle - self.filled - 1:
                    return WAITS
                self.kept = None
                self.take(frame, cycle, opened)
                return REPLACES
            return HELD if for_next and not copied else SETTLES
        if self.usual() and self.filled is not None and 2 <= cycle - self.filled <= 6:
            return WAITS
        return self.take(frame, cycle, opened)

    def keep(self, fate, frame, cycle):
        sure = fate == HELD and self.filled == cycle or self.off(cycle, frame[2]) == 1
        whose = cycle + (fate == HELD)
        before = self.kept[3] + 1 if self.kept and self.kept[1] == whose else 0
        self.kept = frame, whose, sure, before

    def settle(self, cycle, opened, is_open):
        if self.kept and self.filled != cycle and self.kept[1] == cycle and (self.kept[2] or not is_open):
            frame, self.kept = self.kept[0], None
            starved = self.starved
            self.take(frame, cycle, opened)
            self.starved = starved
            return frame
        return None

    def may_open(self, frame, cycle, opened):
        off = self.off(cycle, frame[2])
        if off is not None:
            return off in (1, "jumped")
        usual = (self.usual() or (0, 0))[0]
        copied = self.filled == cycle and frame[1] == self.payload
        least = self.ts // 2 // 2 * 3 if copied else self.ts // 2
        opens = self.filled != cycle or frame[0] - opened >= usual + least
        self.kept = None if opens else self.kept
        return opens


class Machine:
    def __init__(self, config, signals, first):
        self.first = first
        self.ts = round(config["machine"]["sample_time"] * 1e9)
        self.deadline = round(0.8 * self.ts)
        self.gap = round(config["machine"]["max_gap"] / config["machine"]["sample_time"])
        self.gate = Gate(config, signals)
        self.tried = dict.fromkeys(["frozen", "refused", "late", "twice", "missing"], 0)
        count = config["machine"]["cylinders"]
        self.cylinders = [
            Cylinder(config, n, signals, self.gate, self.tried) for n in range(1, count + 1)
        ]
        self.rows, self.restarts = [], []
        self.opened, self.is_open, self.provisional = None, False, False
        self.place, self.early = None, self.ts // 20
        self.live, self.silent = False, 0
        self.inputs, self.pending = {}, set()
        self.number, self.followed = 0, 0
        self.wire(config["signals"], signals)

    def wire(self, named, signals):
        self.sync, self.state, self.places = None, None, {}
        if "sync" in named:
            self.sync = signals.dbc.get_message_by_name(named["sync"]).frame_id
        if "state" in named:
            self.state = signals.find(named["state"])[0].frame_id
            self.states = signals.of(named["state"])[0]
        self.fields = [set() for _ in self.cylinders]
        for key, name in named["cylinder"].items():
            if key.startswith("pressure"):
                continue
            for index in range(len(self.cylinders)):
                full = name.replace("{n}", str(index + 1))
                place = index, key, *signals.of(full)
                self.places.setdefault(signals.find(full)[0].frame_id, []).append(place)
                self.fields[index].add(key)
        self.counters = {
            identifier: raw for identifier, places in self.places.items()
            for _, key, raw, _ in places if key.endswith("_counter")
        }
        self.slots = {
            identifier: Slot(self.ts, 8 if identifier in self.counters else None)
            for identifier in self.places
        }
        self.readings = {
            identifier for identifier, places in self.places.items()
            if any(key != "control_speed" for _, key, _, _ in places)
        }

    def take(self, at, identifier, row, payload):
        if identifier == self.sync:
            self.pass_time(at)
            since = None if self.opened is None else at - self.opened
            beside = None if self.place is None else at - self.place
            if self.provisional and abs(since) < self.ts // 2 and beside >= -self.early:
                # It only confirms the cycle, which begins with it.
                self.opened, self.provisional = at, False
                self.follow(beside)
            elif beside is not None and beside < self.ts - self.ts // 4:
                self.tried["twice"] += 1
            else:
                self.open(at, by_reading=False)
        elif identifier == self.state:
            self.pass_time(at)
            self.gate.state, self.gate.since = self.states[row], at
        elif identifier in self.places:
            self.pass_time(at)
            count = self.counters.get(identifier)
            frame = at, payload, None if count is None else int(count[row]), row
            self.take_of_cylinders(identifier, frame)

    def take_of_cylinders(self, identifier, frame):
        self.live = True
        slot = self.slots[identifier]
        if identifier in self.readings and self.opens(frame, slot):
            self.open(frame[0], by_reading=True)
        fate = LATE
        if self.opened is not None:
            fate = slot.judge(frame, self.number, self.opened, self.is_open)
        if fate in (TAKEN, REPLACES):
            self.fill(identifier, frame, frame[0])
        if fate in (HELD, SETTLES):
            self.settle(identifier, frame[0], is_open=False)
        self.tried["late"] += fate in (WAITS, HELD) and bool(slot.kept) and slot.kept[1] == self.number
        if fate in (WAITS, HELD):
            slot.keep(fate, frame, self.number)
        self.tried["late"] += fate in (LATE, REPLACES, SETTLES)
        self.tried["twice"] += fate == TWICE

    def settle(self, identifier, at, is_open):
        frame = self.slots[identifier].settle(self.number, self.opened, is_open)
        if frame is not None:
            self.fill(identifier, frame, at)

    def fill(self, identifier, frame, at):
        row = frame[3]
        done = set()
        for index, key, raw, physical in self.places[identifier]:
            self.inputs[index][key] = raw[row], physical[row]
            done.add(index)
        for index in sorted(done & self.pending):
            if self.inputs[index].keys() == self.fields[index]:
                self.evaluate(index, at)

    def opens(self, frame, slot):
        if self.opened is None:
            return True
        since = frame[0] - self.place
        if self.sync is None:
            could = not self.is_open and since >= self.ts // 2
        else:
            could = since >= self.ts - self.early and (slot.filled == self.number or not self.is_open)
        return could and slot.may_open(frame, self.number, self.opened)

    def pass_time(self, now):
        while self.opened is not None:
            due = self.opened + self.deadline + (0 if self.is_open else self.ts)
            if due >= now:
                return
            if not self.is_open:
                self.miss(due)
                continue
            self.close(due)
            held = [
                slot.kept[0][0] for identifier, slot in self.slots.items()
                if identifier in self.readings and slot.kept and slot.kept[2]
                and slot.kept[1] == self.number + 1
            ]
            if held and self.sync is None:
                self.open(min(held), by_reading=True, now=due)

    def open(self, at, by_reading, now=None):
        now = at if now is None else now
        if self.is_open:
            self.close(now)
        if self.place is not None:
            early = self.ts // 2 if self.sync is None else self.ts // 4
            for _ in range(max((at - self.place + early) // self.ts, 1) - 1):
                self.miss(now)
        beside = None if self.place is None else at - self.place - self.ts
        self.provisional = self.sync is not None and (
            by_reading or beside is not None and -self.farthest() <= beside < -self.early
        )
        if beside is None or abs(beside) > self.farthest():
            self.place, self.followed = at, 0
        else:
            self.place += self.ts
            self.follow(beside)
        self.opened = self.place if by_reading else at
        self.is_open, self.silent = True, 0
        self.number += 1
        self.inputs = {index: {} for index in range(len(self.cylinders))}
        self.pending = set(self.inputs)
        for identifier, slot in self.slots.items():
            self.settle(identifier, now, is_open=True)
            if slot.kept and slot.kept[1] != self.number:
                slot.kept = None
                self.tried["late"] += 1

    def farthest(self):
        return self.ts // 2 if self.sync is None else self.ts - self.ts // 4

    def follow(self, beside):
        self.followed = min(self.followed + 1, 16)
        slowness = self.followed
        if self.sync is not None:
            slowness = 16 if self.provisional else 1 if beside < 0 else slowness
        self.place += abs(beside) // slowness * (1 if beside >= 0 else -1)

    def close(self, at):
        for identifier in self.slots:
            self.settle(identifier, at, is_open=False)
        for index in sorted(self.pending):
            self.evaluate(index, at)
        self.is_open = self.live = False

    def miss(self, at):
        self.opened += self.ts
        self.place += self.ts
        self.number += 1
        self.is_open = False
        self.silent += 1
        self.tried["missing"] += 1
        if self.live or self.silent <= self.gap + 1:
            for index in range(len(self.cylinders)):
                self.inputs[index] = {}
                self.evaluate(index, at)
        self.live = False

    def evaluate(self, index, at):
        self.pending.discard(index)
        inputs = self.inputs[index]
        readings = []
        for which in ("c1", "c2"):
            if which not in inputs:
                readings.append(None)
                continue
            reading = {"code": inputs[which][0], "position": inputs[which][1]}
            for part in ("velocity", "status", "counter"):
                if f"{which}_{part}" in inputs:
                    reading[part] = inputs[f"{which}_{part}"][part == "velocity"]
            readings.append(reading)
        u = inputs["control_speed"][1] if "control_speed" in inputs else None
        opened = (self.opened - self.first) / 1e9
        row = self.cylinders[index].row(at, opened, self.live, readings, u, self.restarts)
        self.rows.append(row)
        self.inputs[index] = {}

    def finish(self):
        if self.is_open:
            self.close(self.opened + self.deadline)


def shortest(text):
    """Whether the digits are those of the shortest decimal that reads back the same."""

    def digits(number):
        return number.lower().split("e")[0].replace(".", "").lstrip("-").strip("0")

    return digits(text) == digits(repr(float(text)))


def compare(rows, path):
    with open(path, encoding="ascii") as file:
        header, *lines = file.read().splitlines()
    assert header.split(",") == COLUMNS, header
    theirs = [line.split(",") for line in lines]
    answer = {"rows": [len(rows), len(theirs)], "worst": {}, "first_odd": None}
    longer = sum(not shortest(text) for row in theirs[:20000] for text in row if text)
    answer["longer_than_shortest"] = longer
    for index, (ours, row) in enumerate(zip(rows, theirs)):
        if [value is None for value in ours] != [text == "" for text in row]:
            answer["first_odd"] = f"row {index + 1}: {ours} against {row}"
            break
    ours = numpy.array(rows[: len(theirs)], dtype=float)
    theirs = numpy.array([[float(text or "nan") for text in row] for row in theirs[: len(rows)]])
    for column, name in enumerate(COLUMNS):
        difference = numpy.abs(ours[:, column] - theirs[:, column])
        some = numpy.flatnonzero(~numpy.isnan(difference))
        answer["worst"][name] = float(difference[some].max()) if len(some) else None
    return answer


def main():
    dbc, log, csv = sys.argv[1:]
    config = json.load(sys.stdin)
    for table, defaults in DEFAULTS.items():
        config[table] = {**defaults, **config.get(table, {})}
    config["machine"].setdefault("max_gap", 0.1)
    config["cylinders"] = {own["n"]: own for own in config.get("cylinder", [])}
    times, ids, data = read_log(log)
    machine = Machine(config, Signals(dbc, ids, data), times[0])
    rows = {}
    for at, identifier, payload in zip(times, ids, data):
        row = rows.get(identifier, 0)
        rows[identifier] = row + 1
        machine.take(at, identifier, row, payload)
    machine.finish()
    answer = compare(machine.rows, csv)
    answer["restarts"] = [
        [(at - times[0]) / 1e9, n, detector] for at, n, detector in machine.restarts
    ]
    answer["gated"] = sum(row[-1] for row in machine.rows)
    json.dump({**answer, **machine.tried}, sys.stdout)


main()
