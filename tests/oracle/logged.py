"""Frames as the readers of python-can give them, for the tests of each format."""

import json
import sys


def row(message, channel):
    """One frame: [time in µs, identifier, extended, remote, error, CAN FD, bit rate switch, error state, channel, data in
    hexadecimal]."""
    return [
        round(message.timestamp * 1e6),
        message.arbitration_id,
        message.is_extended_id,
        message.is_remote_frame,
        message.is_error_frame,
        message.is_fd,
        message.bitrate_switch,
        message.error_state_indicator,
        channel,
        bytes(message.data).hex(),
    ]


def show(read, files):
    """Prints JSON: for each of `files` the list of its frames by `read`."""
    json.dump([list(read(file)) for file in files], sys.stdout)
