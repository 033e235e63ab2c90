"""PEAK traces by python-can.

    trc.py write VERSION LOG TRACE

writes the candump log LOG as a trace of version 1.0 or 2.1.

    trc.py read TRACE…

prints JSON, for each trace a list of its frames: [time in µs, identifier, extended, remote, CAN FD,
bit rate switch, error state, bus, data in hexadecimal]. python-can leaves out error frames and messages
about the controller.
"""

import json
import sys

import can
from can.io.trc import TRCFileVersion


def write(version, log, trace):
    with can.TRCWriter(trace) as writer:
        writer.file_version = {"1.0": TRCFileVersion.V1_0, "2.1": TRCFileVersion.V2_1}[version]
        for frame in can.CanutilsLogReader(log):
            writer.on_message_received(frame)


def read(trace):
    for m in can.TRCReader(trace):
        yield [
            round(m.timestamp * 1e6),
            m.arbitration_id,
            m.is_extended_id,
            m.is_remote_frame,
            m.is_fd,
            m.bitrate_switch,
            m.error_state_indicator,
            m.channel,
            bytes(m.data).hex(),
        ]


if sys.argv[1] == "write":
    write(*sys.argv[2:])
else:
    json.dump([list(read(trace)) for trace in sys.argv[2:]], sys.stdout)
