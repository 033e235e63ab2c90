"""The gateway's PDOs as Python's `canopen` reads them by the EDS, against cantools by the DBC.

    canopen_pdos.py EDS NODE DBC LOG

LOG is what `tertius replay --warnings` wrote. The parts that the EDS maps are put together as bits
and taken apart by the DBC's signals, raw; each signal must be what cantools makes of the frame. The
answer is JSON: how many frames of each identifier were compared.
"""

import json
import sys

import can
import canopen
import cantools

sheet, number, dbc, log = sys.argv[1], int(sys.argv[2]), sys.argv[3], sys.argv[4]
# Connected to nothing: the frames are in the log.
node = canopen.Network().add_node(number, sheet)
node.tpdo.read(from_od=True)
database = cantools.database.load_file(dbc, strict=True)
# An EDS says of a PDO that is not sent under which COB-ID it would be.
maps = {pdo.cob_id & 0x7FF: pdo for pdo in node.tpdo.values()}

compared = {}
for frame in can.CanutilsLogReader(log):
    pdo = maps[frame.arbitration_id]
    pdo.data = bytearray(frame.data)
    bits, at = 0, 0
    for part in pdo:
        value, length = part.raw, len(part.od)
        assert part.offset == at, (part.name, part.offset, at)
        bits |= (value & (1 << length) - 1) << at
        at += length
    assert at == 8 * len(frame.data), (pdo.name, at)
    message = database.get_message_by_frame_id(frame.arbitration_id)
    expected = message.decode(bytes(frame.data), decode_choices=False, scaling=False)
    for signal in message.signals:
        raw = bits >> signal.start & (1 << signal.length) - 1
        if signal.is_signed and raw >> signal.length - 1:
            raw -= 1 << signal.length
        assert raw == expected[signal.name], (frame, signal.name, raw, expected[signal.name])
    # A part that is a signal by itself has its name and its value.
    for part in pdo:
        if part.name.split(".")[-1] in expected:
            assert part.raw == expected[part.name.split(".")[-1]], (frame, part.name)
    name = f"{frame.arbitration_id:03X}"
    compared[name] = compared.get(name, 0) + 1
json.dump(compared, sys.stdout)
