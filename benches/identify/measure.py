"""The time and the peak memory of `tertius identify` on a million cycles, and on a quarter of them.

One cylinder of the default machine, moved by Table 4-1's model in the real form of frames: C1, the
valve with its pressures, the platform's state; candump -l lines.
"""

import argparse
import math
import os
import pathlib
import struct
import sys
import tempfile
import time

THETA = (-0.0101, -0.1231, -1.6891e-5, -10.7104, -0.0023)
GAMMA = (0.0926, 6.5427)
PERIOD = 16384
MOST_SECONDS = 2.0
MOST_GROWTH = 1.1


def one_period():
    """Payloads of one period of a command that repeats."""
    l, v, p, cycles = 0.0, 0.0, 0.0, []
    waves = ((11, 1.0), (37, 0.6), (97, 0.4), (311, 0.2), (1201, 0.1))
    for k in range(3 * PERIOD):
        u = 0.1 * sum(a * math.sin(2 * math.pi * n * k / PERIOD) for n, a in waves)
        u = round(u * 1e4) / 1e4
        if k >= 2 * PERIOD:
            count = round((l + 1.5) * 27648 / 3)
            c1 = struct.pack("<HhBB", count, round(v * 1e4), 0, k & 255).hex().upper()
            pressure = round((p + 300.0) * 100)
            valve = struct.pack("<hhHH", round(u * 1e4), 0, pressure, 20000).hex().upper()
            cycles.append((c1, valve))
        l, v, p = (
            l + 0.02 * v,
            THETA[0] * l + (1 + THETA[1]) * v + THETA[2] * p + GAMMA[0] * u,
            THETA[3] * v + (1 + THETA[4]) * p + GAMMA[1] * u,
        )
    return cycles


def record(path, cycles):
    period = one_period()
    with open(path, "w", encoding="ascii") as log:
        for k in range(cycles):
            c1, valve = period[k % PERIOD]
            micros = 1_700_000_000_000_000 + 20_000 * k
            stamps = [micros + 100 * i for i in range(4)]
            at = [f"({stamp // 1000000}.{stamp % 1000000:06})" for stamp in stamps]
            log.write(
                f"{at[0]} can0 080#{k & 255:02X}\n{at[1]} can0 181#{c1}\n"
                f"{at[2]} can0 1C1#03000000\n{at[3]} can0 1A1#{valve}\n"
            )


def configure(path, top):
    text = (top / "config/e-type.toml").read_text(encoding="utf-8")
    text = text.replace("cylinders = 6 ", "cylinders = 1 ").replace("../dbc", str(top / "dbc"))
    text = "\n".join(line for line in text.splitlines() if not line.startswith("c2"))
    path.write_text(text, encoding="utf-8")


def run(binary, log, config):
    """Seconds, those of them that a processor worked, and peak memory, MB."""
    start = time.perf_counter()
    null = os.open(os.devnull, os.O_WRONLY)
    pid = os.posix_spawn(
        binary,
        [binary, "identify", str(log), "--config", str(config)],
        os.environ,
        file_actions=[(os.POSIX_SPAWN_DUP2, null, 1)],
    )
    _, status, usage = os.wait4(pid, 0)
    if status != 0:
        sys.exit(f"tertius identify failed ({status})")
    seconds = time.perf_counter() - start
    return seconds, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    top = pathlib.Path(__file__).resolve().parents[2]
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        config = folder / "machine.toml"
        configure(config, top)
        found = {}
        for cycles in (250_000, 1_000_000):
            log = folder / f"{cycles}.log"
            record(log, cycles)
            rounds = [run(arguments.binary, log, config) for _ in range(arguments.rounds)]
            seconds, worked = (min(values) for values in list(zip(*rounds))[:2])
            memory = max(memory for _, _, memory in rounds)
            found[cycles] = (seconds, memory)
            size = log.stat().st_size / 1e6
            print(
                f"{cycles} cycles ({size:.0f} MB): {seconds:.2f} s, {worked:.2f} s of them worked, "
                f"{memory:.1f} MB"
            )
    growth = found[1_000_000][1] / found[250_000][1]
    if found[1_000_000][0] > MOST_SECONDS or growth > MOST_GROWTH:
        sys.exit(f"asked for: {MOST_SECONDS} s, and memory that grows by less than {MOST_GROWTH}")


main()
