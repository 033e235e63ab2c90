"""An EDS or DCF as Python's `canopen` reads it.

    canopen_sheet.py SHEET NODE

The answer is JSON: the node number and bit rate of a DCF (null in an EDS), the PDOs as
[COB-ID, [[name, bits], ...]], and every variable by "index:sub" as
[name, data type, access, default, whether it can be mapped].
"""

import json
import sys

import canopen
from canopen.objectdictionary import ODVariable

dictionary = canopen.import_od(sys.argv[1], int(sys.argv[2]))
variables = {}
for entry in dictionary.values():
    for it in [entry] if isinstance(entry, ODVariable) else list(entry.values()):
        name = it.name if isinstance(entry, ODVariable) else f"{entry.name}.{it.name}"
        key = f"{it.index:04X}:{it.subindex}"
        variables[key] = [name, it.data_type, it.access_type, it.default, it.pdo_mappable]

pdos = []
for number in range(dictionary.device_information.nr_of_TXPDO):
    mapping = dictionary[0x1A00 + number]
    parts = []
    for sub in range(1, mapping[0].default + 1):
        mapped = mapping[sub].default
        variable = dictionary[mapped >> 16][mapped >> 8 & 0xFF]
        assert variable.pdo_mappable and len(variable) == mapped & 0xFF, (number, sub)
        parts.append([variable.name, len(variable)])
    pdos.append([dictionary[0x1800 + number][1].default, parts])
json.dump([dictionary.node_id, dictionary.bitrate, pdos, variables], sys.stdout)
