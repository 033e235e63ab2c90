"""Lets things befall the gateway for a while and writes down what was on the bus; judge.py says
whether that was right. Run by scripts/soak, see there.

The gateway is at one end of a vxcan pair and the machine at the other, so that what stops the
gateway's frames does not stop the machine's, and what is heard at the machine's end is what others
hear.
"""

import argparse
import heapq
import json
import random
import signal
import time
from pathlib import Path

import bus
import hostile
import machine
from gateway import Gateway, configuration

# Of the healthy recording: neutral, and engaged from 130 s to 470 s.
FROM, TO = 120.0, 300.0
TURN = 0.02  # s
# Frames by which it is known that the machine speaks; no attack takes both away.
MARKS = {machine.SYNC, machine.LAST}


class Stage:
    near, far = "soak0", "soak1"

    def __init__(self, binary, folder):
        self.notes = []
        self.listener = None
        self.frames, self.syncs = [], []
        self.attacked, self.faulty = set(), None
        self.sizes, self.sized = [], 0.0
        self.store, self.recordings = folder / "kept.events", folder / "recordings"
        self.create()
        self.gateway = Gateway(binary, folder, self.configuration(1.0))
        self.deaths, self.refusals, self.reloads = [], 0, 0
        self.start()
        self.machine = machine.Machine(self.far, machine.cycles(FROM, TO))

    def configuration(self, clear):
        own = f'[http]\ntoken = "{hostile.TOKEN}"\n[store]\nfile = "{self.store}"\n'
        own += f'[recorder]\nfolder = "{self.recordings}"\nbefore = 2.0\nafter = 1.0\n'
        return configuration(self.near, f"{own}[alarm]\nclear = {clear}\n")

    def create(self):
        bus.ip("link", "add", "dev", self.near, "type", "vxcan", "peer", "name", self.far)
        if self.listener:
            self.collect()
            self.listener.close()
            self.listener.open()
        else:
            without = [i for i in machine.USED + machine.UNUSED if i not in MARKS]
            self.listener = bus.Listener(self.far, without=without, buffer=64 << 20)
        bus.ip("link", "set", "up", self.far)
        bus.ip("link", "set", "up", self.near)

    def collect(self):
        """Keeps what is the gateway's, and when the machine spoke."""
        for frame in self.listener.read():
            if not frame.local:
                self.frames.append((frame.at, frame.identifier, frame.data.hex()))
            elif frame.identifier in MARKS:
                self.syncs.append(frame.at)

    def measure(self):
        """Keeps the memory and the threads of the gateway, once a second."""
        if time.monotonic() < self.sized or not self.gateway.process:
            return
        self.sized = time.monotonic() + 1.0
        try:
            lines = Path(f"/proc/{self.gateway.process.pid}/status").read_text().splitlines()
        except OSError:
            return
        told = dict(line.split(":", 1) for line in lines)
        if "VmRSS" in told:
            self.sizes.append((time.time_ns(), int(told["VmRSS"].split()[0]), int(told["Threads"])))

    def note(self, what, at=None):
        self.notes.append((what, at or time.time_ns()))

    def send_error(self, what, error):
        with bus.sender(self.far) as raw:
            self.note(what)
            raw.send(bus.pack(bus.ERROR_FLAG | error, bytes(8)))

    def start(self):
        self.note("start")
        self.begun = self.gateway.said(" starting ")
        self.gateway.start()

    def kill(self):
        self.look_for_death()
        self.note("kill")
        self.gateway.kill()
        self.gateway.process = None

    def is_ready(self):
        return self.gateway.said(" starting ") > self.begun

    def look_for_death(self):
        """It only ever ends by being killed."""
        process = self.gateway.process
        if process and process.poll() is not None:
            self.deaths.append((time.time_ns(), process.returncode))
            self.start()

    def reload(self):
        self.reloads += 1
        self.gateway.configure(self.current())
        self.gateway.process.send_signal(signal.SIGHUP)

    def refuse(self):
        """A bad one, until :meth:`mend`: a gateway that starts meanwhile would rightly refuse it."""
        self.refusals += 1
        self.gateway.configure(self.current().replace("cylinders = 6", "cylinders = 66"))
        self.gateway.process.send_signal(signal.SIGHUP)

    def mend(self):
        self.gateway.configure(self.current())

    def current(self):
        return self.configuration(1.0 + 0.1 * (self.reloads % 2))


def play(stage, seconds, seed):
    """Everything that is to happen, in turn."""
    from disturb import Attacks, Crowd, Disturber, Faults

    disturber = Disturber(stage, random.Random(seed))
    faults = Faults(stage, random.Random(seed + 1))
    attacks = Attacks(stage, random.Random(seed + 2))
    crowd = Crowd(stage, random.Random(seed + 3))
    start = time.monotonic()
    # The first things happen to a gateway that has judged.
    queue = [(start + 4.0, 0, disturber.run()), (start + 2.0, 1, faults.run()),
             (start + 3.0, 2, attacks.run()), (start + 1.0, 3, crowd.run())]
    end = start + seconds
    while time.monotonic() < end:
        while queue[0][0] <= time.monotonic():
            _, number, deed = heapq.heappop(queue)
            pause = next(deed)
            heapq.heappush(queue, (time.monotonic() + pause, number, deed))
        stage.collect()
        stage.look_for_death()
        stage.measure()
        time.sleep(max(0.0, min(TURN, queue[0][0] - time.monotonic())))
    # What has begun is brought to its end, so that it is in the diary.
    (deed,) = (deed for _, number, deed in queue if number == 0)
    done = len(disturber.diary)
    deed_end = time.monotonic() + 20
    while len(disturber.diary) == done and deed.gi_yieldfrom is not None \
            and time.monotonic() < deed_end:
        time.sleep(next(deed))
    return disturber.diary, crowd


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, required=True)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--binary", type=Path, required=True)
    parser.add_argument("--folder", type=Path, required=True)
    options = parser.parse_args()
    stage = Stage(options.binary, options.folder)
    disturbances, crowd = play(stage, options.seconds, options.seed)
    time.sleep(3.0)
    stage.collect()
    stage.look_for_death()
    sent, diary = stage.machine.stop()
    asked = time.time_ns()
    code = stage.gateway.stop()
    time.sleep(0.5)
    stage.collect()
    (options.folder / "run.json").write_text(json.dumps({
        "seconds": options.seconds, "seed": options.seed, "frames": stage.frames,
        "syncs": stage.syncs, "notes": stage.notes, "disturbances": disturbances, "machine": diary, "sent": sent,
        "deaths": stage.deaths, "stopped": asked, "code": code, "refusals": stage.refusals,
        "reloads": stage.reloads, "unheard": stage.listener.lost, "sizes": stage.sizes,
        "readers": crowd.diary, "connections": crowd.did,
    }))


if __name__ == "__main__":
    main()
