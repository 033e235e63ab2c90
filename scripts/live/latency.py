"""From a frame to the warning that it causes, beside a bare C echo in the same boot: by the kernel's
stamps, in alternating blocks."""

import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import bus
import machine
from gateway import Gateway, configuration

INTERFACE = "late0"
WARNING = 0x2D1
# Cylinder 6's C1 is out of range in every so many cycles, a tenth of a second apart from the next.
EVERY = 10
# The last frame of a cycle comes so long after the others, s.
APART = 0.003
SAMPLES = 56  # a block
BLOCKS = 6
CLEAR = "[alarm]\nclear = 0.04\n"
MOST = 1.5


class Traffic:
    """The machine. The last frame of a cycle comes a while after the others, when whoever listens
    has read those: what is measured is one frame and what follows from it."""

    def __init__(self):
        self.cycles = machine.cycles(250.0, 330.0)
        self.raw = bus.sender(INTERFACE)
        self.listener = bus.Listener(INTERFACE, only=[machine.LAST, WARNING])

    def play(self, samples, settle=2.0):
        """Latencies in µs, `samples` of them after `settle` seconds; None where no answer came."""
        self.listener.read()
        frames, asked, number = [], [], 0
        start = time.monotonic()
        while len(asked) < samples or number % EVERY != 0:
            bad = number * machine.CYCLE >= settle and number % EVERY == 0
            self.send(self.cycles[number % len(self.cycles)], bad)
            number += 1
            time.sleep(max(0.0, start + number * machine.CYCLE - time.monotonic()))
            heard = self.listener.read()
            if bad:
                asked.append(next(f.at for f in heard if f.identifier == machine.LAST))
            frames += heard
        answers = [f.at for f in frames if f.identifier == WARNING and is_raised(f)]
        return [latency(at, answers) for at in asked]

    def send(self, cycle, bad):
        for identifier, data in cycle:
            if identifier == 0x186 and bad:
                data = b"\0\0" + data[2:]
            if identifier == machine.LAST:
                time.sleep(APART)
            self.raw.send(bus.pack(identifier, data))


def is_raised(frame):
    """Raised of Fd_Warning; the echo sets it, too."""
    return bool(frame.data[4] >> 6 & 1)


def latency(asked, answers):
    soonest = asked + round(EVERY * machine.CYCLE * 1e9)
    first = next((at for at in answers if at > asked), soonest)
    return (first - asked) / 1e3 if first < soonest else None


def of_gateway(binary, folder, traffic):
    gateway = Gateway(binary, folder, configuration(INTERFACE, CLEAR))
    gateway.start_and_wait()
    found = traffic.play(SAMPLES)
    if gateway.stop() != 0:
        raise SystemExit("the gateway failed")
    return found


def of_echo(program, mode, traffic):
    words = [INTERFACE, f"{machine.LAST:X}", f"{WARNING:X}", mode]
    echo = subprocess.Popen([str(program), *words])
    time.sleep(0.3)
    found = traffic.play(SAMPLES)
    if echo.poll() is not None:
        raise SystemExit("the echo ended")
    echo.kill()
    echo.wait()
    return found


def percentile(values, share):
    return sorted(values)[min(len(values) - 1, int(share * len(values)))]


def measure(binary, program):
    bus.add_vcan(INTERFACE)
    traffic = Traffic()
    results = {"gateway": [], "echo": [], "echo of one frame": []}
    with tempfile.TemporaryDirectory(dir="/dev/shm") as folder:
        for _ in range(BLOCKS):
            results["gateway"].append(of_gateway(binary, Path(folder), traffic))
            results["echo"].append(of_echo(program, "all", traffic))
            results["echo of one frame"].append(of_echo(program, "only", traffic))
    print(f"latency, µs, {BLOCKS} blocks of {SAMPLES} samples in turn")
    print(f"  {'':20}{'samples':>8}{'missing':>8}{'median':>9}{'99 %':>9}   medians of the blocks")
    medians = {}
    for name, blocks in results.items():
        values = [value for block in blocks for value in block if value is not None]
        missing = sum(value is None for block in blocks for value in block)
        medians[name] = statistics.median(values)
        of_blocks = (statistics.median(v for v in block if v is not None) for block in blocks)
        print(f"  {name:20}{len(values):8}{missing:8}{medians[name]:9.1f}"
              f"{percentile(values, 0.99):9.1f}   {' '.join(f'{m:.0f}' for m in of_blocks)}")
    ratio = medians["gateway"] / medians["echo"]
    strict = medians["gateway"] / medians["echo of one frame"]
    good = ratio <= MOST and all(None not in block for block in results["gateway"])
    print(f"  the gateway's median is {ratio:.2f} of the echo's ({strict:.2f} of that which gets "
          f"only the one frame); wanted: {MOST} at the most: {'reached' if good else 'NOT reached'}")
    return good
