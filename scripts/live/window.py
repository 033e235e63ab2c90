"""The latency of a warning while the page is looked at, by people or by hostile readers, or while the ship's systems flood
or hang; run by scripts/bench-window and scripts/bench-peers, see there."""

import argparse
import errno
import http.client
import multiprocessing
import os
import random
import socket
import sqlite3
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import hostile
from peers import BROKER, FLOODING, HANGING, KNOCKING, NOT_TAKING, Modbus, OpcUa, Peers

TOP = Path(__file__).resolve().parents[2]
PORT = 9493
WATCHERS, NOT_READING = 50, 10
WARNINGS = 50  # a block
MOST = 1.05
# The data path is ahead of everything else, as the service has it; what is compared differs in all but that.
ALONE = "[realtime]\npriority = 20\n[alarm]\nclear = 0.04\n"
PATHS = ["/", "/api/overview", "/api/events?limit=100", "/api/trend/1", "/health", "/metrics", "/nowhere"]
CASES = ["alone", "beside", "looked at"]
WAYS = {
    "people": "the page is looked at",
    "hostile": "readers of the page behave badly",
    "peers": "the ship's systems flood and hang",
}


def configuration(disk, real_time=True, peers=()):
    """That of the recordings; what is looked at keeps everything on `disk`, and what has peers serves and publishes."""
    text = (TOP / "tests/recordings/e-type-sequential.toml").read_text()
    text = text.replace('"../../dbc/e-type.dbc"', f'"{TOP / "dbc/e-type.dbc"}"')
    if disk is None:
        return f'{ALONE}[http]\nlisten = "off"\n{text}'
    ship = f'[mqtt]\nbroker = "127.0.0.1:{BROKER}"\n' if peers else ""
    for it in peers:
        ship += f'[{it.__name__.lower()}]\nlisten = "127.0.0.1:{it.port}"\n'
    return f"""{ship}{ALONE if real_time else ALONE.replace("20", "0")}
[http]
listen = "127.0.0.1:{PORT}"
token = "{hostile.TOKEN}"
[store]
file = "{disk}/kept.events"
[recorder]
folder = "{disk}/recordings"
before = 2.0
after = 1.0
{text}"""


class Crowd:
    """Watchers, some of whom do not read; a client that asks without end; someone who locks the database for 0.8 s
    of each second. A process of its own: it must not delay the player of the machine."""

    def __init__(self, of, *with_what):
        context = multiprocessing.get_context("fork")
        self._here, there = multiprocessing.Pipe()
        self._process = context.Process(target=of, args=(*with_what, there), daemon=True)
        self._process.start()

    def go(self):
        """Ends it: how much it did, by name."""
        self._here.send("go")
        counts = self._here.recv()
        self._process.join()
        return counts


class _Gathered:
    def __init__(self, store, orders):
        self.over = threading.Event()
        self.answers = self.refused = self.events = self.locked = 0
        work = [self.watch] * (WATCHERS - NOT_READING) + [self.stare] * NOT_READING + [self.hammer]
        self.threads = [threading.Thread(target=it, daemon=True) for it in work]
        self.threads.append(threading.Thread(target=self.lock, args=(store,), daemon=True))
        for thread in self.threads:
            thread.start()
        orders.recv()
        self.over.set()
        for thread in self.threads:
            thread.join(10)
        orders.send({name: getattr(self, name) for name in ("events", "answers", "refused", "locked")})

    @staticmethod
    def stream():
        # One address may have half of the places for watchers.
        own = (f"127.0.0.{random.randint(2, 9)}", 0)
        client = socket.create_connection(("127.0.0.1", PORT), timeout=1.0, source_address=own)
        client.sendall(b"GET /api/stream HTTP/1.1\r\nHost: localhost\r\nAccept: text/event-stream\r\n\r\n")
        return client

    def watch(self):
        while not self.over.is_set():
            try:
                with self.stream() as client:
                    while not self.over.is_set() and (read := client.recv(65536)):
                        self.events += read.count(b"data:")
            except OSError:
                self.over.wait(0.5)

    def stare(self):
        while not self.over.is_set():
            try:
                with self.stream() as client:
                    client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)
                    self.over.wait(5.0)
            except OSError:
                self.over.wait(0.5)

    def hammer(self):
        number = 0
        while not self.over.is_set():
            try:
                client = http.client.HTTPConnection("127.0.0.1", PORT, timeout=2.0)
                client.request("GET", PATHS[number % len(PATHS)])
                client.getresponse().read()
                client.close()
                self.answers += 1
            except OSError:
                self.refused += 1
            number += 1

    def lock(self, store):
        while not self.over.is_set():
            try:
                with sqlite3.connect(store, timeout=0.2, isolation_level=None) as database:
                    database.execute("BEGIN IMMEDIATE")
                    self.locked += 1
                    self.over.wait(0.8)
                    database.execute("ROLLBACK")
            except sqlite3.Error:
                pass
            self.over.wait(0.2)


def fill(disk):
    """Leaves nothing on `disk` but what is taken already."""
    for size in (65536, 4096, 1):
        try:
            # Unbuffered, so that what does not fit is told here.
            with open(disk / "filler", "ab", buffering=0) as file:
                while file.write(b"\0" * size) == size:
                    pass
        except OSError as error:
            if error.errno != errno.ENOSPC:
                raise


class Gateway:
    """benches/latency.rs: a gateway whose frames are made for it."""

    def __init__(self, binary, folder, name, text):
        config = folder / f"{name}.toml"
        config.write_text(text)
        self.out = folder / f"{name}.out"
        with open(self.out, "w") as out, open(folder / f"{name}.log", "w") as log:
            self.process = subprocess.Popen([binary, config, str(WARNINGS)], stdin=subprocess.DEVNULL, stdout=out, stderr=log)

    def latencies(self):
        """µs, once it has ended."""
        if self.process.wait(timeout=120) != 0:
            raise SystemExit("the gateway failed")
        return [float(line) for line in self.out.read_text().split()]


def crowd_of(way, peers, disk):
    """The clients of the gateway that keeps its files on `disk`."""
    if peers:
        return Crowd(Peers, peers)
    if way == "hostile":
        hostile.keep(disk / "recordings")
        hostile.fill(disk / "kept.events")
        return Crowd(hostile.Readers, PORT)
    fill(disk)
    return Crowd(_Gathered, disk / "kept.events")


def block(binary, folder, case, way, peers):
    """Latencies, what the crowd did, and the bytes left on the disk of the one that is looked at."""
    if case == "alone":
        return Gateway(binary, folder, "alone", configuration(None)).latencies(), None, None
    disk = folder / "disk"
    size = "size=64m" if way == "hostile" else "size=8m"
    subprocess.run(["mount", "-t", "tmpfs", "-o", size, "tmpfs", disk], check=True)
    try:
        looked_at = Gateway(binary, folder, "looked-at", configuration(disk, case == "looked at", peers))
        time.sleep(0.5)
        crowd = crowd_of(way, peers, disk)
        judged = looked_at if case == "looked at" else Gateway(binary, folder, "alone", configuration(None))
        found = judged.latencies()
        did = crowd.go()
        looked_at.process.terminate()
        looked_at.process.wait(30)
        return found, did, os.statvfs(disk).f_bavail
    finally:
        subprocess.run(["umount", "--lazy", disk], check=True)


def judge(blocks, crowds, full, way, peers):
    names = f"{len(blocks['alone'])} blocks of {WARNINGS} warnings in turn"
    print(f"latency, µs, while {WAYS[way]}, {names}")
    print(f"  {'':12}{'median':>9}{'90 %':>9}{'99 %':>9}   medians of the blocks")
    for case, found in blocks.items():
        values = sorted(value for block in found for value in block)
        shares = "".join(f"{values[int(share * len(values))]:9.1f}" for share in (0.5, 0.9, 0.99))
        print(f"  {case:12}{shares}   {' '.join(f'{statistics.median(block):.0f}' for block in found)}")
    total = {name: sum(it[name] for it in crowds) for name in crowds[0]}
    if peers:
        print(f"  of each protocol {FLOODING} clients flood, {NOT_TAKING} do not take answers, {HANGING} hang, {KNOCKING} "
              f"connect without end")
        for it in peers:
            print(f"  {it.name}: {total[it.name + ' connections']} connections, {total[it.name + ' answers']} answers")
        print(f"  MQTT: {total['brokers']} connections to a broker that is silent, deaf, flooding or good, "
              f"{total['messages']} messages taken")
    elif way == "hostile":
        print(f"  connections of {len(hostile.ADDRESSES)} addresses: {', '.join(f'{kind} {n}' for kind, n in total.items())}")
    else:
        print(f"  {WATCHERS} watchers, {NOT_READING} of them not reading: {total['events']} events read; "
              f"{total['answers']} requests answered, {total['refused']} refused; the database locked {total['locked']} "
              f"times; the disk full in {full} of {len(blocks['looked at'])} blocks")
    # Hostile readers may delay only a few warnings, which a median does not show.
    what, average = ("mean", statistics.fmean) if way == "hostile" else ("median", statistics.median)
    of = {case: [average(block) for block in found] for case, found in blocks.items()}
    ratios = {case: average([b / a for a, b in zip(of[case], of["looked at"])]) for case in ("alone", "beside")}
    good = max(ratios.values()) <= MOST and (way != "people" or full == len(blocks["looked at"]))
    print(f"  {'looked at' if way == 'people' else 'with them'}, the {what} of a block is {ratios['alone']:.3f} of that alone, and {ratios['beside']:.3f} of that "
          f"beside another one which is; wanted: {MOST} at the most: {'reached' if good else 'NOT reached'}")
    return good


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--binary", required=True)
    parser.add_argument("--blocks", type=int, required=True)
    parser.add_argument("--peers", action="append", default=[], choices=["modbus", "opcua"])
    parser.add_argument("--hostile", action="store_true")
    options = parser.parse_args()
    peers = [{"modbus": Modbus, "opcua": OpcUa}[name] for name in options.peers]
    way = "peers" if peers else "hostile" if options.hostile else "people"
    blocks, crowds, full = {case: [] for case in CASES}, [], 0
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "disk").mkdir()
        for _ in range(options.blocks):
            for case in CASES:
                found, did, left = block(options.binary, folder, case, way, peers)
                blocks[case].append(found)
                if case == "looked at":
                    crowds.append(did)
                    full += left == 0
    sys.exit(0 if judge(blocks, crowds, full, way, peers) else 1)


main()
