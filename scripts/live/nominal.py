"""The machine's nominal traffic for a while: processor time and memory of the gateway, and of a
candump beside it."""

import subprocess
import tempfile
import time
from pathlib import Path

import bus
import machine
from gateway import Gateway, configuration

INTERFACE = "calm0"
SAMPLE = 10.0  # s
# The first minute is for what is made once.
WARM_UP = 60.0
MOST_GROWTH = 256  # KiB
TIME = ["/usr/bin/time", "-v", "-o"]


def resident(pid):
    """KiB."""
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1])
    raise SystemExit(f"/proc/{pid}/status has no VmRSS")


def timed(path):
    """What /usr/bin/time wrote: CPU seconds, wall seconds, largest memory in KiB."""
    lines = dict(line.strip().rsplit(": ", 1) for line in path.read_text().splitlines()
                 if ": " in line)
    cpu = float(lines["User time (seconds)"]) + float(lines["System time (seconds)"])
    wall = 0.0
    for part in lines["Elapsed (wall clock) time (h:mm:ss or m:ss)"].split(":"):
        wall = wall * 60 + float(part)
    return cpu, wall, int(lines["Maximum resident set size (kbytes)"])


def measure(binary, seconds):
    bus.add_vcan(INTERFACE)
    with tempfile.TemporaryDirectory(dir="/dev/shm") as folder:
        folder = Path(folder)
        gateway = Gateway(binary, folder, configuration(INTERFACE), [*TIME, str(folder / "gateway")])
        gateway.start_and_wait()
        pid = gateway.pid()
        dump = subprocess.Popen([*TIME, str(folder / "candump"), "candump", "-L", INTERFACE],
                                stdout=subprocess.DEVNULL)
        play = machine.Machine(INTERFACE, machine.cycles(100.0, 520.0))
        samples, start = [], time.monotonic()
        while (now := time.monotonic() - start) < seconds:
            samples.append((now, resident(pid)))
            time.sleep(SAMPLE)
        samples.append((time.monotonic() - start, resident(pid)))
        counts = gateway.counts()
        sent, diary = play.stop()
        # Whoever is timed, not who times it.
        subprocess.run(["kill", str(pid)], check=True)
        if gateway.process.wait() != 0:
            raise SystemExit("the gateway failed")
        child = Path(f"/proc/{dump.pid}/task/{dump.pid}/children").read_text().split()[0]
        subprocess.run(["kill", child], check=True)
        dump.wait()
        cpu, wall, most = timed(folder / "gateway")
        dump_cpu, dump_wall, dump_most = timed(folder / "candump")
    warm = [memory for at, memory in samples if at >= min(WARM_UP, seconds / 2)]
    growth = warm[-1] - warm[0]
    flat = max(warm) - warm[0] <= MOST_GROWTH
    stalls = sum(end - begin for what, begin, end in diary if what == "stall") / 1e9
    print(f"nominal load: {wall:.0f} s, {sent} frames of the machine in {counts['cycles']} cycles, "
          f"{counts['cycles_incomplete']} incomplete, {counts['cycles_missing']} missing; the "
          f"player itself was late for {stalls:.2f} s")
    print(f"  gateway: {cpu:.1f} s of CPU, {100 * cpu / wall:.2f} %; memory {most} KiB at the most")
    print(f"  candump -L beside it: {dump_cpu:.1f} s, {100 * dump_cpu / dump_wall:.2f} %, "
          f"{dump_most} KiB; the gateway takes {cpu / dump_cpu:.2f} of its CPU time")
    print(f"  VmRSS every {SAMPLE:.0f} s, KiB: {' '.join(str(memory) for _, memory in samples)}")
    print(f"  after the first minute it grew by {growth} KiB, {max(warm) - warm[0]} at the most: "
          f"{'flat' if flat else 'NOT flat'}")
    return flat
