"""What a gateway says over Modbus TCP, as a master reads it that knows the documented map and no more.

    modbus.py PORT MAP CYLINDERS

MAP is docs/modbus.csv. Each block of a hundred addresses, up to that of the last cylinder, is read in one request, as
input and as holding registers, which have to be the same. Then everything that would change something is tried, which
has to change nothing. The answer is JSON: the values by their names, not-a-number as null, and the exception codes of
what is not there and of what was tried.
"""

import csv
import json
import math
import sys
from collections import defaultdict

from pymodbus.client import ModbusTcpClient

port, cylinders = int(sys.argv[1]), int(sys.argv[3])
client = ModbusTcpClient("127.0.0.1", port=port, timeout=20, retries=0)
assert client.connect()
types = {name: client.DATATYPE[of] for name, of in (("u16", "UINT16"), ("u32", "UINT32"), ("f32", "FLOAT32"))}

rows = defaultdict(list)
with open(sys.argv[2], newline="") as file:
    for row in csv.DictReader(file):
        rows[int(row["address"]) // 100].append(row)


def length(block):
    """Registers from the first of a block to its last, between which there is no gap."""
    last = rows[block][-1]
    return int(last["address"]) + types[last["type"]].value[1] - 100 * block


def read(address, count):
    one = client.read_input_registers(address, count=count)
    other = client.read_holding_registers(address, count=count)
    assert not one.isError() and not other.isError(), (address, one, other)
    # The clock of the test stands, so that nothing ages between the two.
    assert one.registers == other.registers, (address, one, other)
    return one.registers


def values():
    known = {}
    for block in range(cylinders + 1):
        registers = read(100 * block, length(block))
        for row in rows[block]:
            first = int(row["address"]) - 100 * block
            kind = types[row["type"]]
            value = client.convert_from_registers(registers[first : first + kind.value[1]], kind)
            missing = isinstance(value, float) and math.isnan(value)
            known[row["name"]] = None if missing else value
    return known


before = values()
beyond = [
    client.read_input_registers(length(0), count=1),
    client.read_input_registers(0, count=length(0) + 1),
    client.read_input_registers(100 * (cylinders + 1), count=1),
    client.read_holding_registers(65_535, count=1),
]
attempts = [
    client.write_register(0, 1),
    client.write_registers(100, [1, 2]),
    client.write_coil(0, True),
    client.write_coils(0, [True, False]),
    client.mask_write_register(address=0, and_mask=0xFF, or_mask=0),
    client.readwrite_registers(read_address=0, read_count=1, write_address=0, values=[1]),
    client.read_coils(0, count=1),
    client.read_discrete_inputs(0, count=1),
]
assert all(it.isError() for it in beyond + attempts), (beyond, attempts)
assert values() == before
client.close()
codes = [[it.exception_code for it in them] for them in (beyond, attempts)]
json.dump({"values": before, "beyond": codes[0], "attempts": codes[1]}, sys.stdout)
