"""Writes a candump log as a pcap in nanoseconds, as tcpdump captures an interface of CAN.

    pcap.py LOG PCAP
"""

import struct
import sys

log, pcap = sys.argv[1:]
with open(log, encoding="ascii") as lines, open(pcap, "wb") as out:
    out.write(struct.pack("<IHHiIII", 0xA1B23C4D, 2, 4, 0, 0, 262144, 227))
    for line in lines:
        stamp, _, frame = line.split()
        seconds, decimals = stamp.strip("()").split(".")
        identifier, data = frame.split("#")
        data = bytes.fromhex(data)
        number = int(identifier, 16) | (1 << 31 if len(identifier) == 8 else 0)
        # The kernel captures all 16 bytes of a struct can_frame.
        packet = struct.pack(">IBBBB", number, len(data), 0, 0, 0) + data.ljust(8, b"\0")
        out.write(struct.pack("<IIII", int(seconds), int(decimals.ljust(9, "0")), len(packet), len(packet)) + packet)
