"""Reads captures in pcapng by draft-ietf-opsawg-pcapng, with packets of LINKTYPE_CAN_SOCKETCAN.

    pcapng.py CAPTURE

prints JSON, a list of its frames: [time in ns, interface, identifier, extended, remote, error, CAN FD, bit rate switch,
error state, announced length, data in hexadecimal]. Whatever is not as the draft and linux/can.h say is an error.
"""

import json
import struct
import sys


def blocks(capture):
    at = 0
    while at < len(capture):
        kind, length = struct.unpack_from("<II", capture, at)
        assert length >= 12 and length % 4 == 0, f"length {length} at {at}"
        (again,) = struct.unpack_from("<I", capture, at + length - 4)
        assert again == length, f"{again} is not {length} at {at}"
        yield kind, capture[at + 8 : at + length - 4]
        at += length
    assert at == len(capture)


def options(body):
    while body:
        code, length = struct.unpack_from("<HH", body)
        if code == 0:
            assert length == 0 and len(body) == 4
            return
        yield code, body[4 : 4 + length]
        body = body[4 + (length + 3) // 4 * 4 :]


def frame(packet):
    word, length, flags, _, _ = struct.unpack_from(">IBBBB", packet)
    fd = bool(flags & 4)
    assert len(packet) == (72 if fd else 16), f"{len(packet)} bytes"
    remote, error = bool(word >> 30 & 1), bool(word >> 29 & 1)
    data = b"" if remote else packet[8 : 8 + length]
    assert packet[8 + len(data) :].strip(b"\0") == b""
    switch, state = (bool(flags & 1), bool(flags & 2)) if fd else (False, False)
    return [word & 0x1FFFFFFF, bool(word >> 31), remote, error, fd, switch, state, length, data.hex()]


def read(capture):
    interfaces = []
    for n, (kind, body) in enumerate(blocks(capture)):
        assert (n == 0) == (kind == 0x0A0D0D0A), "one section, at the beginning"
        if n == 0:
            assert struct.unpack_from("<IHHq", body) == (0x1A2B3C4D, 1, 0, -1)
            dict(options(body[16:]))
        elif kind == 1:
            link, _, snap = struct.unpack_from("<HHI", body)
            assert (link, snap) == (227, 0)
            told = dict(options(body[8:]))
            assert told[9] == b"\x09", "nanoseconds"
            interfaces.append(told[2].decode("ascii"))
        else:
            assert kind == 6, f"block of type {kind}"
            interface, high, low, length, whole = struct.unpack_from("<IIIII", body)
            assert length == whole
            yield [high << 32 | low, interfaces[interface], *frame(body[20 : 20 + length])]


with open(sys.argv[1], "rb") as file:
    json.dump(list(read(file.read())), sys.stdout)
