"""CAN interfaces, and frames on them by the kernel's own time stamps. Standard library only."""

import errno
import os
import socket
import struct
import subprocess
from pathlib import Path

FRAME = struct.Struct("=IB3x8s")
FILTER = struct.Struct("=II")
STAMP = struct.Struct("=qq")

ERROR_FLAG = 0x20000000
# Error classes of linux/can/error.h.
BUS_OFF, RESTARTED = 0x040, 0x100

# What a filter of one 11-bit identifier looks at: no remote frames, no 29-bit ones.
_EXACT = 0xC00007FF
_INVERTED = 0x20000000

# Not in Python's socket module.
_SO_RCVBUFFORCE, _SO_TIMESTAMPNS, _SO_RXQ_OVFL = 33, 35, 40

# Errors of an interface that is away, or whose driver takes nothing just now.
AWAY = {errno.ENETDOWN, errno.ENODEV, errno.ENXIO, errno.ENOBUFS}


def pack(identifier, data):
    return FRAME.pack(identifier, len(data), bytes(data))


def run(*command):
    """Runs a command that must succeed."""
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(command)} failed: {done.stderr.strip()}")


def ip(*words):
    run("ip", *words)


def add_vcan(interface):
    ip("link", "add", "dev", interface, "type", "vcan")
    ip("link", "set", "up", interface)


def tc(verb, interface, *words):
    """`tc qdisc`; where User-mode Linux has not loaded tbf yet, loads it."""
    command = ["tc", "qdisc", verb, "dev", interface, "root", *words]
    if subprocess.run(command, capture_output=True).returncode != 0:
        module = Path(f"/usr/lib/uml/modules/{os.uname().release}/kernel/net/sched/sch_tbf.ko")
        if module.exists():
            subprocess.run(["busybox", "insmod", str(module)], capture_output=True)
        run(*command)


def sender(interface):
    """A socket that only sends."""
    raw = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    raw.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, b"")
    raw.bind((interface,))
    return raw


class Frame:
    """A frame as it was on the bus: `at` in ns since 1970, `local` if this machine's own sockets
    on the same interface sent it."""

    __slots__ = ("at", "identifier", "data", "local")

    def __init__(self, at, identifier, data, local):
        self.at, self.identifier, self.data, self.local = at, identifier, data, local


class Listener:
    """Keeps frames in its socket until they are asked for, so that it takes no part in what is
    measured. `only` or `without`: the 11-bit identifiers to hear or to leave out."""

    def __init__(self, interface, only=None, without=(), buffer=32 << 20):
        self.interface, self.only, self.without, self.buffer = interface, only, without, buffer
        self.lost = 0
        self.open()

    def open(self):
        """Anew, as after the interface was deleted; it may still be down."""
        raw = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        level = socket.SOL_CAN_RAW
        if self.only is None:
            filters = [(i | _INVERTED, _EXACT) for i in self.without] or [(0, 0)]
            raw.setsockopt(level, socket.CAN_RAW_JOIN_FILTERS, 1)
        else:
            filters = [(i, _EXACT) for i in self.only]
        packed = b"".join(FILTER.pack(*words) for words in filters)
        raw.setsockopt(level, socket.CAN_RAW_FILTER, packed)
        for option, value in ((_SO_RCVBUFFORCE, self.buffer), (_SO_TIMESTAMPNS, 1), (_SO_RXQ_OVFL, 1)):
            raw.setsockopt(socket.SOL_SOCKET, option, value)
        raw.bind((self.interface,))
        self.raw = raw
        self._overflow = 0

    def read(self):
        """What has come since the last time."""
        frames = []
        while True:
            try:
                packed, control, flags, _ = self.raw.recvmsg(FRAME.size, 128, socket.MSG_DONTWAIT)
            except OSError as error:
                if error.errno in AWAY:
                    # Told once; what came before is still to be read, and more may come.
                    continue
                if error.errno == errno.EAGAIN:
                    return frames
                raise
            identifier, length, data = FRAME.unpack(packed)
            at = 0
            for _, kind, value in control:
                if kind == _SO_TIMESTAMPNS:
                    seconds, nanoseconds = STAMP.unpack(value)
                    at = seconds * 1_000_000_000 + nanoseconds
                elif kind == _SO_RXQ_OVFL:
                    (overflow,) = struct.unpack("=I", value)
                    self.lost += overflow - self._overflow
                    self._overflow = overflow
            local = bool(flags & socket.MSG_DONTROUTE)
            frames.append(Frame(at, identifier, data[:length], local))

    def close(self):
        self.raw.close()
