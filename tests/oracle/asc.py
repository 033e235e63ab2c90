"""Vector logs in ASC by python-can, in UTC.

    asc.py write LOG ASC
    asc.py read ASC…

`write` writes the candump log LOG. `read` prints JSON, for each log a list of its frames: [time in µs, identifier,
extended, remote, error, CAN FD, bit rate switch, error state, channel, data in hexadecimal].
"""

import json
import os
import sys
import time

import can

os.environ["TZ"] = "UTC"
time.tzset()


def write(log, asc):
    with can.ASCWriter(asc) as writer:
        for frame in can.CanutilsLogReader(log):
            frame.channel = 0
            writer.on_message_received(frame)


def read(asc):
    for m in can.ASCReader(asc, relative_timestamp=False):
        yield [
            round(m.timestamp * 1e6),
            m.arbitration_id,
            m.is_extended_id,
            m.is_remote_frame,
            m.is_error_frame,
            m.is_fd,
            m.bitrate_switch,
            m.error_state_indicator,
            m.channel + 1,
            bytes(m.data).hex(),
        ]


if sys.argv[1] == "write":
    write(*sys.argv[2:])
else:
    json.dump([list(read(asc)) for asc in sys.argv[2:]], sys.stdout)
