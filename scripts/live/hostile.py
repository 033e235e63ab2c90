"""Readers of the gateway's page that behave badly, 64 at a time from eight addresses; of window.py, readers.py and the soak."""

import itertools
import socket
import sqlite3
import threading
from collections import Counter

# The SHA-256 of no known token.
TOKEN = "5e" * 32
RECORDING = "20261123T021600Z-on-demand"
DOWNLOADS = [f"/api/recordings/{RECORDING}.tar", "/api/export/events.csv", "/api/export/events.jsonl"]
LONG = ["/api/events?limit=500", "/metrics", "/api/trend/1", "/assets/uplot.js"]
ADDRESSES = [f"127.0.0.{n}" for n in range(2, 10)]
LEAST_ROOM = 1  # bytes of a receive buffer, which the kernel makes 2304


def keep(folder):
    """A recording of 24 MB to be downloaded, in `folder`."""
    recording = folder / RECORDING
    recording.mkdir(parents=True, exist_ok=True)
    (recording / "frames.log.zst").write_bytes(b"\7" * 24_000_000)


def fill(store):
    """Writes 6 MB of events into the database `store`, to be exported."""
    with sqlite3.connect(store, timeout=10.0) as database:
        rows = ((n, 1, "bus_lost", "lost " * 70) for n in range(17_000))
        database.executemany("INSERT INTO events (at_ns, run, kind, text) VALUES (?, ?, ?, ?)", rows)


def request(path, method="GET", more=""):
    return f"{method} {path} HTTP/1.1\r\nHost: localhost\r\n{more}\r\n".encode()


class Readers:
    """Eight of each kind: who downloads and does not read; who watches and does not read; who asks for long answers and
    does not read; who says nothing; who asks a byte at a time; who tries tokens; who connects without end; and who asks
    without end and reads."""

    KINDS = ("download", "watch", "ask_much", "idle", "drip", "guess", "knock", "hammer")

    def __init__(self, port, orders):
        self.over = threading.Event()
        self.port, self.did = port, Counter({kind: 0 for kind in self.KINDS})
        work = itertools.product(self.KINDS, enumerate(ADDRESSES))
        self.threads = [threading.Thread(target=self.run, args=(kind, *of), daemon=True) for kind, of in work]
        for thread in self.threads:
            thread.start()
        orders.recv()
        self.over.set()
        for thread in self.threads:
            thread.join(10)
        orders.send(dict(self.did))

    def run(self, kind, number, address):
        """A connection of that kind after the other, until it is over."""
        while not self.over.is_set():
            try:
                with socket.socket() as client:
                    client.settimeout(5.0)
                    if kind != "hammer":
                        client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, LEAST_ROOM)
                    client.bind((address, 0))
                    client.connect(("127.0.0.1", self.port))
                    self.did[kind] += 1
                    getattr(self, kind)(client, number)
            except OSError:
                self.over.wait(0.05)

    def unread(self, client, path):
        """Reads nothing until it is ended, or for five seconds."""
        client.sendall(request(path))
        self.over.wait(5.0)

    def download(self, client, number):
        self.unread(client, DOWNLOADS[number % len(DOWNLOADS)])

    def watch(self, client, _number):
        self.unread(client, "/api/stream")

    def ask_much(self, client, number):
        self.unread(client, LONG[number % len(LONG)])

    def idle(self, _client, _number):
        self.over.wait(5.0)

    def drip(self, client, _number):
        for byte in request("/api/alarms"):
            client.sendall(bytes([byte]))
            if self.over.wait(0.1):
                return

    def guess(self, client, number):
        more = f"Content-Type: application/json\r\nContent-Length: 0\r\nAuthorization: Bearer {number}\r\n"
        client.sendall(request("/api/record", "POST", more))
        client.recv(4096)

    def knock(self, _client, _number):
        """Connects, and nothing else."""

    def hammer(self, client, number):
        client.sendall(request(LONG[number % len(LONG)]))
        while client.recv(1 << 16):
            pass
