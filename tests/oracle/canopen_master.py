"""A CANopen master by Python's `canopen`, which speaks to the gateway as a node.

    canopen_master.py CHANNEL EDS NODE

CHANNEL is a SocketCAN interface on which a machine plays and the gateway starts. Everything is done
and compared here; the answer is JSON on standard output, with what was seen. `ready` on standard
error says that the master listens.
"""

import json
import math
import sys
import threading
import time

import canopen
from canopen.sdo.exceptions import SdoAbortedError, SdoCommunicationError

channel, sheet, number = sys.argv[1], sys.argv[2], int(sys.argv[3])
# A box without a moment to spare takes its time.
PATIENCE = 60.0

seen = []
arrived = threading.Condition()


def take(cob_id, data, timestamp):
    with arrived:
        seen.append((cob_id, bytes(data), time.monotonic()))
        arrived.notify_all()


def wait_for(what, condition):
    """Waits until `condition`, of the frames seen so far, is true, and returns what it returned."""
    end = time.monotonic() + PATIENCE
    with arrived:
        while True:
            found = condition()
            if found:
                return found
            left = end - time.monotonic()
            assert left > 0, f"{what} did not come; last were {seen[-5:]}"
            arrived.wait(left)


def of(cob_id, since=0):
    return [(data, at) for id_, data, at in seen[since:] if id_ == cob_id]


network = canopen.Network()
node = network.add_node(number, sheet)
node.sdo.RESPONSE_TIMEOUT = PATIENCE
for cob_id in [0x080, 0x180, 0x280, 0x380, 0x700]:
    network.subscribe(cob_id + number, take)
# The machine's frames would fill the receive buffer while this process waits for the processor.
own = [0x080, 0x180, 0x280, 0x380, 0x580, 0x700]
filters = [{"can_id": base + number, "can_mask": 0x7FF, "extended": False} for base in own]
network.connect(interface="socketcan", channel=channel, can_filters=filters)
print("ready", file=sys.stderr, flush=True)

# Boot-up, then the heartbeat of a node that started by itself.
wait_for("the boot-up", lambda: of(0x700 + number))
assert of(0x700 + number)[0][0] == b"\0", of(0x700 + number)
wait_for("a heartbeat", lambda: [data for data, _ in of(0x700 + number) if data == b"\5"])

# Every object of the data sheet, by its own type; what is constant has its default.
constants = live = segmented = 0
values = {}
for entry in node.object_dictionary.values():
    is_variable = isinstance(entry, canopen.objectdictionary.ODVariable)
    print(f"object {entry.index:04X}", file=sys.stderr, flush=True)
    for variable in [entry] if is_variable else list(entry.values()):
        address = f"{variable.index:04X}:{variable.subindex}"
        try:
            raw = node.sdo.upload(variable.index, variable.subindex)
        except SdoAbortedError as error:
            # An error that has not happened yet.
            assert (variable.index, error.code) == (0x1003, 0x08000024), (address, error)
            continue
        segmented += len(raw) > 4
        value = variable.decode_raw(raw)
        values[address] = None if isinstance(value, float) and math.isnan(value) else value
        if variable.data_type not in canopen.objectdictionary.DATA_TYPES:
            assert len(raw) * 8 == len(variable), (address, raw, len(variable))
        if variable.access_type == "const":
            expected = variable.default
            if isinstance(expected, float):
                # The sheet has as many digits as tell one binary32 from another.
                assert math.isclose(value, expected, rel_tol=1e-7), (address, value, expected)
            else:
                assert value == expected, (address, value, expected)
            constants += 1
        else:
            live += 1

print("the objects", file=sys.stderr, flush=True)

# What is not there, and what cannot be written.
refused = []
for write, index, sub in [
    (False, 0x3000, 0),
    (False, 0x1018, 9),
    (True, 0x2101, 1),
    (True, 0x1000, 0),
]:
    try:
        if write:
            node.sdo.download(index, sub, b"\1\0\0\0"[: 4 if index == 0x1000 else 1])
        else:
            node.sdo.upload(index, sub)
        refused.append(None)
    except SdoAbortedError as error:
        refused.append(error.code)

# Emergency messages of the fault that is played, from its raise to its clearing.
wait_for("an error reset", lambda: [error for error in node.emcy.log if error.code == 0])
emergencies = [[error.code, error.register, error.data.hex()] for error in list(node.emcy.log)]
warnings = [data[3:].hex() for data, _ in of(0x280 + number)]
history = node.sdo[0x1003][0].raw
newest = node.sdo[0x1003][1].raw & 0xFFFF
node.sdo[0x1003][0].raw = 0
history_after = node.sdo[0x1003][0].raw

print("the emergencies", file=sys.stderr, flush=True)

# Another heartbeat time.
node.sdo[0x1017].raw = 200
start = len(seen)
wait_for("ten heartbeats", lambda: len(of(0x700 + number, start)) > 10)
times = [at for _, at in of(0x700 + number, start)]
period = (times[-1] - times[0]) / (len(times) - 1)

print("the heartbeats", file=sys.stderr, flush=True)


def state_of(heartbeat):
    """Waits for a heartbeat with this state that comes after now."""
    start = len(seen)
    wait_for(f"state {heartbeat}", lambda: [1 for data, _ in of(0x700 + number, start) if data[0] == heartbeat])
    return len(seen)


def statuses_between(start, end):
    return sum(1 for id_, _, _ in seen[start:end] if id_ == 0x180 + number)


# Every NMT command.
silent = {}
for command, heartbeat in [("PRE-OPERATIONAL", 127), ("STOPPED", 4)]:
    node.nmt.state = command
    start = state_of(heartbeat)
    # Two heartbeats more, in which no PDO comes.
    wait_for("heartbeats", lambda: len(of(0x700 + number, start)) > 2)
    silent[command] = statuses_between(start, len(seen))
    print("silent", command, file=sys.stderr, flush=True)
    if command == "STOPPED":
        node.sdo.RESPONSE_TIMEOUT = 1.0
        node.sdo.MAX_RETRIES = 1
        try:
            node.sdo.upload(0x1000, 0)
            raise AssertionError("a node that is stopped has no SDO")
        except SdoCommunicationError:
            node.sdo.RESPONSE_TIMEOUT = PATIENCE
    else:
        assert node.sdo[0x1000].raw == 0
start = len(seen)
node.nmt.state = "OPERATIONAL"
state_of(5)
wait_for("a status", lambda: of(0x180 + number, start))
print("operational", file=sys.stderr, flush=True)
boots = 0
for command in ["RESET COMMUNICATION", "RESET"]:
    start = len(seen)
    node.nmt.state = command
    wait_for("the boot-up", lambda: [1 for data, _ in of(0x700 + number, start) if data == b"\0"])
    boots += 1
    print("boot-up after", command, file=sys.stderr, flush=True)
heartbeat_after = node.sdo[0x1017].raw
print("done", file=sys.stderr, flush=True)
json.dump(
    {
        "constants": constants,
        "live": live,
        "segmented": segmented,
        "values": values,
        "refused": refused,
        "emergencies": emergencies,
        "warnings": warnings,
        "history": [history, newest, history_after],
        "period": period,
        "silent": silent,
        "boots": boots,
        "heartbeat_after": heartbeat_after,
    },
    sys.stdout,
    default=repr,
)
sys.stdout.flush()

# The loss of the node: its heartbeat does not come any more. The caller kills it now.
end = len(seen)
while True:
    before = len(of(0x700 + number))
    time.sleep(3.5)
    if len(of(0x700 + number)) == before:
        break
print("lost", file=sys.stderr, flush=True)
network.disconnect()
