"""Attacks on the bus: what somebody who can send makes of a machine's frames. Of scripts/blind, which attacks a recording,
and of the soak, which attacks the live gateway."""

from typing import Callable, NamedTuple

# m of a count of a position.
COUNT = 3.0 / 27648
STATUS, SYNC, STATE = 0x1D1, 0x080, 0x1C1
C1 = [0x180 + n for n in range(1, 7)]
C2 = [0x190 + n for n in range(1, 7)]
VALVES = [0x1A0 + n for n in range(1, 7)]
CYCLE = 0.02  # s


class Frame:
    """A line of a candump log."""

    __slots__ = ("at", "id", "data")

    def __init__(self, at, id, data):
        self.at, self.id, self.data = at, id, bytes(data)

    @classmethod
    def read(cls, line):
        stamp, _, frame = line.split()[:3]
        id, data = frame.split("#", 1)
        return cls(float(stamp.strip("()")), int(id, 16), bytes.fromhex(data))

    def __str__(self):
        return f"({self.at:017.6f}) can0 {self.id:03X}#{self.data.hex().upper()}"

    def later(self, seconds):
        return Frame(self.at + seconds, self.id, self.data)

    def off(self, millimetres):
        """The same, of a reading that is off."""
        count = int.from_bytes(self.data[:2], "little") + round(millimetres * 1e-3 / COUNT)
        return Frame(self.at, self.id, max(0, min(count, 65535)).to_bytes(2, "little") + self.data[2:])

    def byte(self, at, value):
        data = bytearray(self.data)
        data[at] = value & 0xFF
        return Frame(self.at, self.id, data)

    def count(self, value):
        return self.byte(5, value)


def both(act, ids):
    """What `act` makes of the frames of `ids`; all others stay."""
    return lambda frame, k: act(frame, k) if frame.id in ids else [frame]


def held(ids):
    """Each frame with the reading that stood at the beginning, and a counter that goes on."""
    first = {}

    def act(frame, k):
        then = first.setdefault(frame.id, frame) if k > 0 else frame
        return [Frame(frame.at, frame.id, then.data[:5] + frame.data[5:])]

    return both(act, ids)


def replayed(ids, seconds):
    """Readings of so many seconds before, with counters that go on."""
    past = {}

    def act(frame, k):
        queue = past.setdefault(frame.id, [])
        queue.append(frame)
        old = queue[max(0, len(queue) - 1 - round(seconds / CYCLE))]
        return [Frame(frame.at, frame.id, old.data[:5] + frame.data[5:])]

    return both(act, ids)


def drifting(ids, rate):
    return both(lambda frame, k: [frame.off(rate * CYCLE * k)], ids)


def forged(id, data, period):
    """A frame of somebody else after every `period`-th one."""
    return lambda frame, k: [frame] + ([Frame(frame.at + 2e-5, id, data)] if frame.id == SYNC and k % period == 0 else [])


class TrueReadings(str):
    """Why the lamps may stay green: the readings are what the transducers say, so nothing is to be blamed on them."""


class Attack(NamedTuple):
    name: str
    # Transducers concerned, as places in Fd_Status.
    places: list
    # The frames that are on the bus instead of a frame in the k-th cycle of the attack; the cycles before it have k <= 0.
    act: Callable
    # Why the lamps may stay green, if they may.
    why: str | None

    @property
    def past(self):
        """Seconds before the attack of which `act` wants the frames, too."""
        return 10 if "ten seconds" in self.name else 0


def attacks(rng):
    """Every kind of them, once, on a cylinder that is drawn."""
    yield from (Attack(*it) for it in kinds(rng, rng.randrange(6)))


def kinds(rng, n):
    """The fields of every kind, on the cylinder of index `n`."""
    c1, c2, valve = C1[n], C2[n], VALVES[n]
    one, two, pair, everyone = [2 * n], [2 * n + 1], [2 * n, 2 * n + 1], list(range(12))
    far = rng.uniform(20, 40) * rng.choice([-1, 1])
    silence = lambda ids: both(lambda frame, k: [], ids)
    yield "all twelve frozen, the counters go on", everyone, held(C1 + C2), None
    yield "both of one cylinder frozen", pair, held([c1, c2]), None
    yield "C1 frozen", one, held([c1]), None
    yield "C1 stands off", one, both(lambda f, k: [f.off(far)], [c1]), None
    yield "a second C1, same count, 30 mm off, behind the true one", one, both(
        lambda f, k: [f, f.off(30).later(5e-5)], [c1]), None
    yield "the same before the true one", one, both(lambda f, k: [f.off(30).later(-5e-5), f], [c1]), None
    yield "the same 7 ms before", one, both(lambda f, k: [f.off(30).later(-7e-3), f], [c1]), None
    yield "the same 12 ms before", one, both(lambda f, k: [f.off(30).later(-12e-3), f], [c1]), None
    yield "a second C1 with length 8", one, both(
        lambda f, k: [f, Frame(f.at + 5e-5, f.id, f.off(30).data + b"\0\0")], [c1]), None
    yield "a second C1 with length 2", one, both(
        lambda f, k: [Frame(f.at - 5e-5, f.id, f.off(30).data[:2]), f], [c1]), TrueReadings(
        "the short frames are discarded and the true readings are used")
    yield "C1 broken, a second one says that it is not", one, both(
        lambda f, k: [f.byte(4, 3), f.later(5e-5)], [c1]), None
    yield "a second C1 now and then, one cycle in ten", one, both(
        lambda f, k: [f, f.off(30).later(5e-5)] if k % 10 == 0 else [f], [c1]), None
    yield "C1 of ten seconds before comes first", one, (lambda old: both(
        lambda f, k: [old(f, k)[0].later(-5e-5), f], [c1]))(replayed([c1], 10)), None
    yield "C1 of ten seconds before instead", one, replayed([c1], 10), None
    yield "all twelve of ten seconds before instead", everyone, replayed(C1 + C2, 10), None
    yield "the counter of C1 cut off", one, both(lambda f, k: [Frame(f.at, f.id, f.data[:5])], [c1]), None
    yield "the counter of C1 stands", one, both(lambda f, k: [f.count(7)], [c1]), None
    yield "the counter of C1 at random", one, both(lambda f, k: [f.count(rng.randrange(256))], [c1]), TrueReadings(
        "the readings are true; only a repeated frame would be harder to recognise")
    yield "the counter of C1 runs backwards", one, both(lambda f, k: [f.count(-f.data[5])], [c1]), TrueReadings(
        "the readings are true, and a counter that counts down identifies cycles as well")
    yield "C1 does not come", one, silence([c1]), None
    yield "C1 comes every second cycle", one, both(lambda f, k: [f] if k % 2 else [], [c1]), None
    yield "neither of one cylinder comes", pair, silence([c1, c2]), None
    yield "no transducer comes", everyone, silence(C1 + C2), None
    yield "C1 reports a broken wire", one, both(lambda f, k: [f.byte(4, 3)], [c1]), None
    yield "C1 beyond its range", one, both(lambda f, k: [f.off(3000)], [c1]), None
    yield "C1 carries C2's reading", one, (lambda seen: both(lambda f, k: (
        seen.update({f.id: f}), [f if f.id == c2 or c2 not in seen else Frame(f.at, f.id, seen[c2].data[:5] + f.data[5:])]
    )[1], [c1, c2]))({}), (
        "two transducers that read the same look healthy; C2 has no second vote until C1 reads its own rod again")
    yield "C1 and C2 exchanged", pair, (lambda other: both(
        lambda f, k: [Frame(f.at, other[f.id], f.data)], [c1, c2]))({c1: c2, c2: c1}), (
        "both still read the rod, and their calibrations differ by less than the limits")
    yield "C1 and C2 both 30 mm off", pair, both(lambda f, k: [f.off(30)], [c1, c2]), (
        "common mode: reported when it begins; then both observers follow, and the bus looks as if the rod were there")
    yield "C1 and C2 both 5 mm off", pair, both(lambda f, k: [f.off(5)], [c1, c2]), (
        "common mode: reported when it begins; then both observers follow, and the bus looks as if the rod were there")
    yield "C1 and C2 drift by 1 mm/s together", pair, drifting([c1, c2], 1), (
        "common mode: the observers follow, and the flow of oil does not resolve so slow a drift")
    yield "all twelve drift by 1 mm/s together", everyone, drifting(C1 + C2, 1), (
        "common mode of all cylinders: it looks like a slow heave of the deck")
    yield "C1 drifts by 1 mm/s", one, drifting([c1], 1), None
    yield "no command", everyone, silence(VALVES), None
    yield "the command of one cylinder is zero", pair, both(
        lambda f, k: [Frame(f.at, f.id, b"\0\0" + f.data[2:])], [valve]), None
    yield "the command of one cylinder reversed", pair, both(lambda f, k: [Frame(
        f.at, f.id, (-int.from_bytes(f.data[:2], "little", signed=True)).to_bytes(2, "little", signed=True) + f.data[2:]
    )], [valve]), None
    yield "the platform's state says that nothing is monitored", everyone, both(lambda f, k: [f.byte(0, 0)], [STATE]), None
    yield "the platform's state does not come", everyone, silence([STATE]), None
    yield "18 more Syncs in a cycle", everyone, both(
        lambda f, k: [f] + [f.later(1.05e-3 * i) for i in range(1, 19)], [SYNC]), TrueReadings(
        "the readings are true, and open the cycles")
    yield "no Sync", everyone, silence([SYNC]), TrueReadings("the readings are true, and open the cycles")
    yield "Sync 5 ms early", everyone, both(lambda f, k: [f.later(-5e-3)], [SYNC]), TrueReadings(
        "the readings are true; only the cycles begin earlier")
    yield "a forged Fd_Status, all healthy, 50 Hz", everyone, forged(STATUS, bytes.fromhex("5555555555555555"), 1), TrueReadings(
        "a recording contains the gateway's own frames, too; only the live gateway can tell (event, metric, alert)")
    yield "a flood of the highest priority", everyone, forged(0x001, b"\0" * 8, 1), TrueReadings(
        "the readings are true as long as they arrive; the load of the bus is a metric")
