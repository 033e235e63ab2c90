"""The gateway's frames as another receiver reads them.

    gateway.py DBC LOG

LOG is what `tertius replay --warnings` wrote. Every line is read by python-can, decoded strictly by
cantools and checked by its AUTOSAR E2E profile 5 with the identifier as data ID. The answer is JSON:
a list of [time in µs, identifier, interface, whether E2E holds, {signal: value}]; values are raw.
"""

import json
import sys

import can
import cantools
from cantools.autosar.end_to_end import check_profile5_crc

dbc = cantools.database.load_file(sys.argv[1], strict=True)
frames = []
for frame in can.CanutilsLogReader(sys.argv[2]):
    assert not (frame.is_extended_id or frame.is_fd or frame.is_remote_frame), frame
    assert not frame.is_error_frame, frame
    message = dbc.get_message_by_frame_id(frame.arbitration_id)
    data = bytes(frame.data)
    assert len(data) == message.length, frame
    signals = message.decode(data, decode_choices=False, scaling=False)
    whole = check_profile5_crc(data, frame.arbitration_id)
    time = round(frame.timestamp * 1e6)
    frames.append([time, frame.arbitration_id, frame.channel, whole, signals])
json.dump(frames, sys.stdout)
