"""What befalls the gateway in the soak: deeds that take a while, as generators that give the
seconds to wait until they go on, and write what they did into a diary."""

import multiprocessing
import os
import subprocess
import time
from collections import Counter
from random import Random

import bus
import hostile
import machine
from attacks import attacks
from gateway import PORT

# Seconds of the interface taking frames again, at a rate at which those that wait burst out.
RELEASE = 1.0
TBF = ["tbf", "rate"]


class Disturber:
    def __init__(self, stage, random):
        self.stage, self.random = stage, random
        # (what, begin, end) in ns since 1970.
        self.diary = []
        self.deck = []
        self.deeds = [
            self.link_down, self.deleted, self.jam, self.silence, self.bus_off, self.flood_foreign,
            self.flood_own, self.kill, self.reload, self.refuse,
        ]

    def run(self):
        """For ever, every deed once in a random order, and so on."""
        while True:
            # Sometimes the next thing comes before the last one has passed.
            yield self.random.uniform(0.05, 0.5) if self.random.random() < 0.25 \
                else self.random.uniform(3.0, 7.0)
            if not self.deck:
                self.deck = self.random.sample(self.deeds, len(self.deeds))
            deed = self.deck.pop()
            begin = time.time_ns()
            what = yield from deed()
            self.diary.append((what or deed.__name__.replace("_", " "), begin, time.time_ns()))

    def for_a_while(self, least, most):
        yield self.random.uniform(least, most)

    def link_down(self):
        bus.ip("link", "set", "down", self.stage.near)
        yield from self.for_a_while(0.2, 3.0)
        bus.ip("link", "set", "up", self.stage.near)

    def deleted(self):
        bus.ip("link", "delete", self.stage.near)
        yield from self.for_a_while(0.1, 2.5)
        self.stage.create()

    def jam(self):
        """The gateway's frames do not get out; those of the machine get in."""
        near = self.stage.near
        bus.tc("add", near, *TBF, "8bit", "burst", "32", "limit", "100000")
        yield from self.for_a_while(0.5, 5.0)
        self.stage.note("release")
        bus.tc("change", near, *TBF, "1mbit", "burst", "1kb", "limit", "100000")
        yield RELEASE
        bus.tc("del", near)

    def silence(self):
        self.stage.machine.pause()
        yield from self.for_a_while(0.3, 5.0)
        self.stage.machine.go_on()

    def bus_off(self):
        """A controller that is bus-off hears nothing."""
        self.stage.machine.pause()
        yield 0.1
        self.stage.send_error("bus-off", bus.BUS_OFF)
        yield from self.for_a_while(0.1, 2.0)
        self.stage.send_error("restarted", bus.RESTARTED)
        yield self.random.choice([0.0, 0.3])
        self.stage.machine.go_on()

    def flood_foreign(self):
        yield from self.flood([f"{self.random.randrange(0x300, 0x380):X}"])

    def flood_own(self):
        """Somebody else has the gateway's identifiers."""
        yield from self.flood([self.random.choice(["1D1", "2D1", "3D1"])])

    def flood(self, identifiers):
        frames = str(self.random.randrange(1000, 8000))
        for identifier in identifiers:
            command = ["cangen", self.stage.far, "-g", "0", "-i", "-n", frames, "-I", identifier]
            flood = subprocess.Popen([*command, "-L", "8"])
            while flood.poll() is None:
                yield 0.05

    def kill(self):
        self.stage.kill()
        yield from self.for_a_while(0.0, 2.0)
        self.stage.start()
        # As a service manager does, nothing is asked of it before it says that it is ready.
        for _ in range(200):
            if self.stage.is_ready():
                break
            yield 0.05

    def reload(self):
        self.stage.reload()
        yield 1.0

    def refuse(self):
        self.stage.refuse()
        yield 1.0
        self.stage.mend()


class Attacks:
    """Attacks on the bus, one after the other, each kind once before any comes again."""

    def __init__(self, stage, random):
        self.stage, self.random, self.deck = stage, random, []

    def run(self):
        while True:
            yield self.random.uniform(3.0, 7.0)
            if not self.deck:
                number = len(list(attacks(Random(0))))
                self.deck = self.random.sample(range(number), number)
            kind = self.deck.pop()
            while True:
                seed = self.random.randrange(1 << 30)
                places = machine.attack_of(kind, seed).places
                self.stage.attacked = {place // 2 + 1 for place in places}
                if len(places) > 2 or self.stage.faulty not in self.stage.attacked:
                    break
            self.stage.machine.attack(kind, seed)
            yield self.random.uniform(3.0, 9.0)
            self.stage.machine.relent()
            # It takes as long to be over.
            yield 2.0
            self.stage.attacked = set()


class Crowd:
    """Readers of the page who behave badly, for a while: another computer, as far as one processor allows."""

    def __init__(self, stage, random):
        self.stage, self.random = stage, random
        # (what, begin, end) in ns since 1970, and the connections of each kind of them.
        self.diary, self.did = [], Counter()

    def run(self):
        hostile.fill(self.stage.store)
        while True:
            yield self.random.uniform(5.0, 25.0)
            hostile.keep(self.stage.recordings)
            here, there = multiprocessing.Pipe()
            process = multiprocessing.get_context("fork").Process(target=self.behave, args=(there,), daemon=True)
            begin = time.time_ns()
            process.start()
            yield self.random.uniform(4.0, 12.0)
            here.send("go")
            while not here.poll():
                yield 0.1
            self.did.update(here.recv())
            process.join()
            self.diary.append(("readers", begin, time.time_ns()))

    @staticmethod
    def behave(orders):
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
        hostile.Readers(PORT, orders)


class Faults:
    """Steps of a random transducer, one after the other."""

    STEP = 0.003  # m

    def __init__(self, stage, random):
        self.stage, self.random = stage, random

    def run(self):
        while True:
            yield self.random.uniform(3.0, 8.0)
            place = self.random.randrange(1, 7), self.random.choice(["c1", "c2"])
            if len(self.stage.attacked) == 1 and place[0] in self.stage.attacked:
                continue
            self.stage.faulty = place[0]
            self.stage.machine.fault(*place, self.random.choice([self.STEP, -self.STEP]))
            yield self.random.uniform(2.0, 5.0)
            self.stage.machine.mend(*place)
            self.stage.faulty = None
