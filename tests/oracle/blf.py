"""Vector logs in BLF by python-can.

    blf.py write LOG BLF SIZE LEVEL
    blf.py made BLF
    blf.py read BLF…

`write` writes the candump log LOG in containers of SIZE bytes, compressed at LEVEL, -1 for the usual one and 0 for not at
all. `made` writes a log of frames of every kind. `read` prints JSON, for each log a list of its frames as `logged.row` has them.
"""

import sys

import can
from logged import row, show

START = 1_700_000_000.25


def write(log, blf, size, level):
    with can.BLFWriter(blf, compression_level=int(level)) as writer:
        writer.max_container_size = int(size)
        for frame in can.CanutilsLogReader(log):
            frame.channel = 0
            writer.on_message_received(frame)


def made(blf):
    frames = [
        {"arbitration_id": 0x181, "is_extended_id": False, "data": [0xE0, 0x2D]},
        {"arbitration_id": 0x18FEF100, "is_extended_id": True, "data": [1], "channel": 1},
        {"arbitration_id": 0x100, "is_extended_id": False, "is_remote_frame": True, "dlc": 3},
        {"arbitration_id": 0x181, "is_extended_id": False, "is_fd": True, "data": range(12), "bitrate_switch": True},
        {"arbitration_id": 0x181, "is_extended_id": False, "is_fd": True, "data": [9], "error_state_indicator": True},
        {"is_error_frame": True},
        {"arbitration_id": 0x7FF, "is_extended_id": False, "data": range(8), "is_rx": False},
    ]
    with can.BLFWriter(blf) as writer:
        for n, frame in enumerate(frames):
            writer.on_message_received(can.Message(**{"timestamp": START + 0.5 * n, "channel": 0, **frame}))


def read(blf):
    return (row(message, message.channel + 1) for message in can.BLFReader(blf))


if sys.argv[1] == "write":
    write(*sys.argv[2:])
elif sys.argv[1] == "made":
    made(sys.argv[2])
else:
    show(read, sys.argv[2:])
