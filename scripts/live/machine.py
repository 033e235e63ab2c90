"""The machine on the bus: a recording of a healthy one, played in real time cycle by cycle, with
faults of its transducers and attacks on its bus where they are asked for. A process of its own."""

import io
import multiprocessing
import os
import random
import time
from pathlib import Path

import bus
from attacks import CYCLE, Attack, Frame, attacks

TOP = Path(__file__).resolve().parents[2]
RECORDING = TOP / "tests/recordings/e-type-healthy.log.zst"
# A cycle that this computer cannot begin in time is lost, not late: what it would have said was of
# another moment. One that takes longer than it should is noted.
LATE, LONG = 0.004, 0.008  # s
# Between two frames of a cycle in a recording, and what a frame that is forged may be early without waiting for it, s.
APART, AT_ONCE = 1.3e-4, 1e-3

SYNC, LAST = 0x080, 0x1A6
# What the configuration listens to, and the rest of the recording.
USED = [SYNC, 0x1C1, *(base + n for base in (0x180, 0x190, 0x1A0) for n in range(1, 7))]
UNUSED = [0x1B1, 0x2B1]

# Cyl{n}_C1 and Cyl{n}_C2; Position is raw in bytes 0 and 1.
BASE = {"c1": 0x180, "c2": 0x190}
COUNTS_PER_METRE = 27648 / 3


def cycles(start, end):
    """The cycles of the recording from `start` to `end` seconds: lists of (identifier, data)."""
    import zstandard

    found, first, cycle = [], round(start / CYCLE), -1
    with open(RECORDING, "rb") as file:
        reader = zstandard.ZstdDecompressor().stream_reader(file)
        for line in io.TextIOWrapper(reader, encoding="ascii"):
            identifier, data = line.split()[2].split("#")
            identifier = int(identifier, 16)
            cycle += identifier == SYNC
            if cycle >= round(end / CYCLE):
                break
            if cycle >= first:
                if identifier == SYNC:
                    found.append([])
                found[-1].append((identifier, bytes.fromhex(data)))
    return found


def shifted(data, counts):
    """The data of a transducer's frame with its position so many counts away."""
    raw = int.from_bytes(data[:2], "little") + counts
    return min(max(raw, 1), 27648).to_bytes(2, "little") + data[2:]


def attack_of(kind, seed):
    """The attack of that index among all kinds, as `seed` draws it."""
    return list(attacks(random.Random(seed)))[kind]


class Machine:
    """Plays `cycles` on `interface` until it is stopped, over and over with `rest` seconds of
    silence in between."""

    def __init__(self, interface, cycles, rest=3.0, real_time=True):
        self._here, there = multiprocessing.Pipe()
        played = _Played(interface, cycles, rest, real_time, there)
        context = multiprocessing.get_context("fork")
        self._process = context.Process(target=played.run, daemon=True)
        self._process.start()

    def pause(self):
        self._here.send(("pause",))

    def go_on(self):
        self._here.send(("go on",))

    def fault(self, cylinder, transducer, metres):
        """A step of the transducer's reading, until :meth:`mend`."""
        self._here.send(("fault", cylinder, transducer, round(metres * COUNTS_PER_METRE)))

    def mend(self, cylinder, transducer):
        self._here.send(("mend", cylinder, transducer))

    def attack(self, kind, seed):
        """An attack on the bus, until :meth:`relent`."""
        self._here.send(("attack", kind, seed))

    def relent(self):
        self._here.send(("relent",))

    def stop(self):
        """Ends it: how many frames of USED were taken by the interface, and its diary, a list of
        (what, begin, end) with times in ns since 1970."""
        self._here.send(("stop",))
        answer = self._here.recv()
        self._process.join()
        return answer


class _Attacked:
    """What an attack makes of the cycles after that of `number`. A cycle is prepared while the one before it is sent, since
    a frame may be forged that comes before its own; `prepared` is the first that is not."""

    def __init__(self, kind, seed, number):
        self.attack: Attack = attack_of(kind, seed)
        self.what = f"attack {kind} {seed}"
        self.first = self.prepared = number + 1
        self.pending = []
        self.begun, self.is_over = None, False

    def prepare(self, number, frames):
        self.prepared = number + 1
        for frame in frames:
            self.pending.extend(self.attack.act(frame, number + 1 - self.first))

    def due(self, number):
        """What is sent in this cycle, in order."""
        end = (number + 1) * CYCLE
        due = [frame for frame in self.pending if number * CYCLE <= frame.at < end]
        self.pending = [frame for frame in self.pending if frame.at >= end]
        return sorted(due, key=lambda frame: frame.at)


class _Played:
    def __init__(self, interface, cycles, rest, real_time, orders):
        self.interface, self.orders, self.real_time = interface, orders, real_time
        self.cycles = [[(i, bus.pack(i, data), data) for i, data in cycle] for cycle in cycles]
        self.used = set(USED)
        self.rest = round(rest / CYCLE)
        self.faults, self.begun = {}, {}
        self.attacked = None
        self.paused = self.stopped = False
        self.sent, self.diary, self.raw = 0, [], None

    def run(self):
        if self.real_time:
            # It is another computer's work: what this one has to do must not delay it.
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))
        start, last = time.monotonic(), -1
        while not self.stopped:
            elapsed = time.monotonic() - start
            number = int(elapsed / CYCLE)
            if number == last or elapsed - number * CYCLE > LATE:
                time.sleep(max(0.0, start + (number + 1) * CYCLE - time.monotonic()))
                continue
            now = time.time_ns()
            if last >= 0 and number > last + 1 and self.raw:
                self.diary.append(("stall", now - round((number - last - 1) * CYCLE * 1e9), now))
            self.obey(now, number)
            at = number % (len(self.cycles) + self.rest)
            slept = self.send_attacked(number, start, now) if self.attacked else 0.0
            if at < len(self.cycles):
                if not self.paused:
                    if not self.attacked:
                        self.send(self.cycles[at])
                    if time.time_ns() - now > (LONG + slept) * 1e9 and self.raw:
                        self.diary.append(("stall", now, time.time_ns()))
            elif last < number - at + len(self.cycles):
                rest = len(self.cycles) + self.rest - at
                self.diary.append(("wrap", now, now + round(rest * CYCLE * 1e9)))
            last = number
        for place in list(self.begun):
            self.mend(*place, time.time_ns())
        self.end_attack(time.time_ns())
        self.orders.send((self.sent, self.diary))

    def obey(self, now, number):
        while self.orders.poll():
            order, *words = self.orders.recv()
            if order == "pause":
                self.paused = True
            elif order == "go on":
                self.paused = False
            elif order == "fault":
                cylinder, transducer, counts = words
                self.faults[BASE[transducer] + cylinder] = counts
                self.begun[cylinder, transducer] = now
            elif order == "mend":
                self.mend(*words, now)
            elif order == "attack":
                self.begin_attack(*words, number)
            elif order == "relent":
                self.attacked.is_over = True
            else:
                self.stopped = True
        if self.attacked and self.attacked.is_over and number >= self.attacked.prepared:
            self.end_attack(now)

    def mend(self, cylinder, transducer, now):
        del self.faults[BASE[transducer] + cylinder]
        begun = self.begun.pop((cylinder, transducer))
        self.diary.append((f"fault {cylinder} {transducer}", begun, now))

    def frames(self, number):
        """Those of the machine in that cycle, with its faults."""
        at = number % (len(self.cycles) + self.rest)
        for i, (identifier, _, data) in enumerate(self.cycles[at] if at < len(self.cycles) else []):
            if identifier in self.faults:
                data = shifted(data, self.faults[identifier])
            yield Frame(number * CYCLE + i * APART, identifier, data)

    def begin_attack(self, kind, seed, number):
        self.attacked = it = _Attacked(kind, seed, number)
        # This cycle is sent as it is.
        it.pending = list(self.frames(number))
        for before in range(max(0, number + 1 - round(it.attack.past / CYCLE)), number + 1):
            for frame in self.frames(before):
                it.attack.act(frame, before + 1 - it.first)

    def send_attacked(self, number, start, now):
        """Sends a cycle that is attacked; seconds in which it waited for the time of a forged frame."""
        it, slept = self.attacked, 0.0
        if number > it.first - 1 and it.begun is None:
            it.begun = now
        if not it.is_over:
            # After a stall the cycles in between are lost.
            for following in range(max(it.prepared, number), number + 2):
                it.prepare(following, self.frames(following))
        due = it.due(number)
        if self.paused:
            return slept
        for frame in due:
            ahead = start + frame.at - time.monotonic()
            if ahead > AT_ONCE and frame.at - number * CYCLE > LATE:
                time.sleep(ahead)
                slept += ahead
            self.send([(frame.id, bus.pack(frame.id, frame.data), None)])
        return slept

    def end_attack(self, now):
        if self.attacked:
            self.diary.append((self.attacked.what, self.attacked.begun or now, now))
        self.attacked = None

    def send(self, cycle):
        try:
            self.raw = self.raw or bus.sender(self.interface)
            for identifier, packed, data in cycle:
                if identifier in self.faults and data is not None:
                    packed = bus.pack(identifier, shifted(data, self.faults[identifier]))
                self.raw.send(packed)
                self.sent += identifier in self.used
        except OSError as error:
            if error.errno not in bus.AWAY:
                raise
            if self.raw:
                self.raw.close()
            self.raw = None
