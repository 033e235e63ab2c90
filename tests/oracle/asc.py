"""Vector logs in ASC by python-can, in UTC.

    asc.py write LOG ASC
    asc.py read ASC…

`write` writes the candump log LOG. `read` prints JSON, for each log a list of its frames as `logged.row` has them.
"""

import os
import sys
import time

import can
from logged import row, show

os.environ["TZ"] = "UTC"
time.tzset()


def write(log, asc):
    with can.ASCWriter(asc) as writer:
        for frame in can.CanutilsLogReader(log):
            frame.channel = 0
            writer.on_message_received(frame)


def read(asc):
    return (row(message, message.channel + 1) for message in can.ASCReader(asc, relative_timestamp=False))


if sys.argv[1] == "write":
    write(*sys.argv[2:])
else:
    show(read, sys.argv[2:])
