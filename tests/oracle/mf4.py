"""Bus logging in MDF 4 by asammdf and python-can.

    mf4.py write LOG MF4 COMPRESSION
    mf4.py made MF4
    mf4.py read MF4…

`write` writes the candump log LOG by python-can, compressed by nothing (0), zlib (1) or transposition and zlib (2). `made`
writes frames of every kind. `read` prints JSON, for each file a list of its frames as `logged.row` has them.
"""

import sys

import can
from logged import row, show

START = 1_700_000_000.25


def write(log, mf4, compression):
    with can.MF4Writer(mf4, compression_level=int(compression)) as writer:
        for frame in can.CanutilsLogReader(log):
            frame.channel = 1
            writer.on_message_received(frame)


def made(mf4):
    frames = [
        {"arbitration_id": 0x181, "is_extended_id": False, "data": [0xE0, 0x2D]},
        {"arbitration_id": 0x18FEF100, "is_extended_id": True, "data": [1], "channel": 2},
        {"arbitration_id": 0x100, "is_extended_id": False, "is_remote_frame": True, "dlc": 3},
        {"arbitration_id": 0x181, "is_extended_id": False, "is_fd": True, "data": range(12), "bitrate_switch": True},
        {"arbitration_id": 0x181, "is_extended_id": False, "is_fd": True, "data": [9], "error_state_indicator": True},
        {"is_error_frame": True},
        {"arbitration_id": 0x1FFFFFFF, "is_remote_frame": True, "dlc": 8, "channel": 2},
        {"arbitration_id": 0x7FF, "is_extended_id": False, "data": range(8), "is_rx": False},
        {"arbitration_id": 0x7FE, "is_extended_id": False, "is_fd": True, "data": range(64)},
    ]
    with can.MF4Writer(mf4) as writer:
        for n, frame in enumerate(frames):
            writer.on_message_received(can.Message(**{"timestamp": START + 0.5 * n, "channel": 1, **frame}))


def read(mf4):
    return (row(message, message.channel) for message in can.MF4Reader(mf4))


if sys.argv[1] == "write":
    write(*sys.argv[2:])
elif sys.argv[1] == "made":
    made(sys.argv[2])
else:
    show(read, sys.argv[2:])
