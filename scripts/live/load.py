"""Many frames back to back, to the gateway and to candump with the same receive buffer, in turn."""

import signal
import subprocess
import tempfile
import time
from pathlib import Path

import bus
import machine
from gateway import Gateway, configuration, wait_for

INTERFACE = "load0"
FRAMES = 100_000
ROUNDS = 3
# One for each round.
IDENTIFIERS = ["181", "196", "1A3"]


def flood(identifier):
    """`cangen` does not stop before its frames were taken: exit code 0 is all of them."""
    bus.run("cangen", INTERFACE, "-g", "0", "-n", str(FRAMES), "-I", identifier, "-L", "6")


def traffic(identifier, stopped=None):
    """Nominal traffic, and the flood in the midst of it; how many frames that were. The process
    `stopped` does not run during the flood."""
    play = machine.Machine(INTERFACE, machine.cycles(250.0, 350.0))
    time.sleep(2.0)
    start = time.monotonic()
    if stopped:
        stopped.send_signal(signal.SIGSTOP)
    flood(identifier)
    if stopped:
        stopped.send_signal(signal.SIGCONT)
    seconds = time.monotonic() - start
    # The kernel tells of lost frames with the next one that it does not lose.
    time.sleep(3.0)
    sent, _ = play.stop()
    return sent + FRAMES, seconds


def settled(count):
    """What `count` says once it has not moved for 2 s."""
    last, since = count(), time.monotonic()
    while time.monotonic() - since < 2.0:
        time.sleep(0.2)
        if (now := count()) != last:
            last, since = now, time.monotonic()
    return last


def of_gateway(binary, folder, identifier, stop):
    gateway = Gateway(binary, folder, configuration(INTERFACE))
    gateway.start_and_wait()
    sent, seconds = traffic(identifier, gateway.process if stop else None)
    settled(lambda: gateway.counts()["frames_received"])
    counts, buffer = gateway.counts(), gateway.receive_buffer()
    if gateway.stop() != 0:
        raise SystemExit("the gateway failed")
    figures = {"sent": sent, "received": counts["frames_received"], "seconds": seconds,
               "lost": counts["frames_dropped"], "cycles": counts["cycles"]}
    return figures, buffer


def of_candump(folder, identifier, stop, buffer):
    wanted = ",".join(f"{i:X}:7FF" for i in machine.USED)
    path = folder / "candump.log"
    # The kernel doubles what it is asked for.
    command = ["candump", "-L", "-d", "-r", str(buffer // 2), f"{INTERFACE},{wanted}"]
    with open(path, "wb") as file:
        dump = subprocess.Popen(command, stdout=file, stdin=subprocess.DEVNULL)
        time.sleep(1.0)
        sent, seconds = traffic(identifier, dump if stop else None)
        settled(lambda: path.stat().st_size)
        dump.terminate()
        dump.wait()
    received = lost = 0
    with open(path, "r", errors="replace") as file:
        for line in file:
            received += "#" in line
            if "total drops" in line:
                lost = int(line.rsplit("total drops", 1)[1].strip(" )\n"))
    return {"sent": sent, "received": received, "seconds": seconds, "lost": lost, "cycles": None}


def measure(binary):
    """Prints a table; whether what is asked for holds."""
    bus.add_vcan(INTERFACE)
    rounds = []
    print(f"load: {FRAMES} frames by cangen -g 0 into nominal traffic")
    print(f"  {'':24}{'sent':>8}{'received':>10}{'lost':>8}{'uncounted':>11}{'flood, s':>10}")
    with tempfile.TemporaryDirectory(dir="/dev/shm") as folder:
        folder = Path(folder)
        for number in range(ROUNDS + 1):
            stop = number == ROUNDS
            identifier = IDENTIFIERS[number % len(IDENTIFIERS)]
            gateway, buffer = of_gateway(binary, folder, identifier, stop)
            candump = of_candump(folder, identifier, stop, buffer)
            for name, figures in (("gateway", gateway), ("candump", candump)):
                uncounted = figures["sent"] - figures["received"] - figures["lost"]
                label = f"{name}{', stopped meanwhile' if stop else f', {identifier}'}"
                print(f"  {label:24}{figures['sent']:8}{figures['received']:10}"
                      f"{figures['lost']:8}{uncounted:11}{figures['seconds']:10.1f}", flush=True)
            rounds.append((gateway, candump))
    print(f"  receive buffer of both: {buffer} bytes")
    exact = all(g["sent"] == g["received"] + g["lost"] for g, _ in rounds)
    no_more = all(g["lost"] <= c["lost"] for g, c in rounds[:ROUNDS])
    print(f"  the gateway counts exactly: {'yes' if exact else 'NO'}; "
          f"it loses no more than candump: {'yes' if no_more else 'NO'}")
    return exact and no_more
