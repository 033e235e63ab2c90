"""Two transducers of a cylinder by Python's `canopen`, and a PLC with the cylinder's valve beside them.

    canopen_devices.py CHANNEL EDS STORY

CHANNEL is a SocketCAN interface. The transducers are nodes 1 (C1) and 17 (C2) with the sheet EDS; they send
their PDO at each SYNC, 50 times a second, and heartbeats and emergency messages as STORY has it:

    spoken  both have heartbeats of 100 ms. Node 1 says that its magnet is lost and later that it is back; the
            heartbeat of node 17 stops and begins again; node 1 goes to pre-operational and back.
    silent  neither has a heartbeat, and node 1 stops sending.

It ends by itself.
"""

import struct
import sys
import time

import canopen

channel, sheet, story = sys.argv[1:]
SAMPLE_TIME = 0.02

network = canopen.Network()
network.connect(interface="socketcan", channel=channel)
nodes = [canopen.LocalNode(node_id, sheet) for node_id in (1, 17)]
for node in nodes:
    network.add_node(node)
    node.tpdo.read(from_od=True)
    # Object 0x1017, which the slave reads when it leaves its initialisation.
    node.sdo[0x1017].raw = 100 if story == "spoken" else 0
    node.nmt.state = "INITIALISING"
    node.nmt.state = "PRE-OPERATIONAL"
    node.nmt.state = "OPERATIONAL"
c1, c2 = nodes


def transducer(node):
    """Sends the PDO of a rod at rest, 100 mm from the middle, if the node is operational."""
    if node.nmt.state != "OPERATIONAL":
        return
    pdo = node.tpdo[1]
    for variable in pdo:
        variable.raw = 100_000 if variable.index == 0x6020 else 0
    pdo.transmit()


begun = time.monotonic()
cycle = 0
silenced = False


def run(seconds):
    """Runs the machine for so long."""
    global cycle
    for _ in range(round(seconds / SAMPLE_TIME)):
        network.send_message(0x080, [])
        if not silenced:
            transducer(c1)
        transducer(c2)
        # Engaged, 200 bar.
        network.send_message(0x1C1, struct.pack("<BHB", 3, 20_000, cycle & 0xFF))
        # Control word, set point, pressure set point.
        network.send_message(0x521, struct.pack("<HhH", 7, 0, 0))
        cycle += 1
        left = begun + cycle * SAMPLE_TIME - time.monotonic()
        if left > 0:
            time.sleep(left)


if story == "spoken":
    run(3)
    c1.emcy.send(0x5000, 0x81, b"\x01\x00\x00\x00\x00")
    run(1)
    c1.emcy.reset()
    run(2)
    c2.nmt.stop_heartbeat()
    run(1)
    c2.nmt.start_heartbeat(100)
    run(2)
    c1.nmt.state = "PRE-OPERATIONAL"
    run(1)
    c1.nmt.state = "OPERATIONAL"
    run(2)
else:
    run(3)
    silenced = True
    run(1)
network.disconnect()
