"""Reads EDS and DCF files with canopen, for comparison.

  eds.py FILE…

prints, for each file, the line "file PATH" and then what it has, or "refused REASON". A line for each
variable has, with tabs between them: its address, the type of its object, its own data type and access,
whether it may be mapped into a PDO, its default, its value (of a DCF), its limits, and its name; "-" stands
for what is not there. Data types that the device's PDOs may be filled with are lines "dummy TYPE". Lines
"pdo NAME IDENTIFIER OBJECT@BIT+BITS…" are the PDOs that are on, on node 5.

Where canopen keeps something in another form than the standard means it, it is converted here:
- A default of a signed type that is written as the type's bits (0xFF as an INTEGER8) is a negative number.
- An empty text is none, and a number in which the node-ID was not replaced is "$NODEID+" and its rest.
- Variables of CompactSubObj that canopen makes only when they are asked for are asked for. Their lines
  begin with "compact", because canopen neither names them nor maps them into PDOs as the file says.
"""

import io
import logging
import re
import sys

import canopen
from canopen.objectdictionary import ODArray, ODVariable, datatypes
from canopen.objectdictionary import eds as reader

SIGNED = {0x02: 8, 0x03: 16, 0x04: 32, 0x10: 24, 0x12: 40, 0x13: 48, 0x14: 56, 0x15: 64}
UNSIGNED = {0x05: 8, 0x06: 16, 0x07: 32, 0x16: 24, 0x18: 40, 0x19: 48, 0x1A: 56, 0x1B: 64}
NAMES = {0x01: "BOOLEAN", 0x08: "REAL32", 0x09: "VISIBLE_STRING", 0x0A: "OCTET_STRING",
         0x0B: "UNICODE_STRING", 0x0C: "TIME_OF_DAY", 0x0D: "TIME_DIFFERENCE", 0x0F: "DOMAIN",
         0x11: "REAL64"}


def type_name(number):
    if number in SIGNED:
        return f"INTEGER{SIGNED[number]}"
    if number in UNSIGNED:
        return f"UNSIGNED{UNSIGNED[number]}"
    return NAMES.get(number, f"type 0x{number:04X}")


def number_text(variable, number):
    bits = SIGNED.get(variable.data_type)
    if bits and 2 ** (bits - 1) <= number < 2**bits:
        number -= 2**bits
    return str(number)


def text(variable, value, raw, node_id):
    if raw and "$NODEID" in raw.upper():
        if value is not None:
            return f"$NODEID+{value - node_id}"
        rest = raw.replace(" ", "").upper().replace("$NODEID", "").strip("+")
        return f"$NODEID+{int(rest or '0', 0)}"
    if isinstance(value, bytes):
        return value.hex() or "-"
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, int):
        return number_text(variable, value)
    return value or "-"


def line(variable, kind, sub_index, node_id):
    kept = vars(variable)
    limits = [text(variable, kept.get(key), None, node_id) for key in ("min", "max")]
    # Reals have limits, too, and canopen reads them as whole numbers.
    if variable.data_type in datatypes.FLOAT_TYPES:
        limits = [limit if limit == "-" else repr(float(limit)) for limit in limits]
    return "\t".join([
        f"0x{variable.index:04X}:{sub_index:02X}", kind, type_name(variable.data_type),
        variable.access_type, "PDO" if variable.pdo_mappable else "-",
        text(variable, variable.default, kept.get("default_raw"), node_id),
        text(variable, variable.value, kept.get("value_raw"), node_id), *limits, variable.name])


def numbers(path_text, key):
    """The numbers of that key by index: what canopen reads and does not keep."""
    parser = reader.RawConfigParser(inline_comment_prefixes=(";",))
    parser.optionxform = str
    parser.read_string(path_text)
    objects = [section for section in parser.sections() if re.fullmatch("[0-9A-Fa-f]{4}", section)]
    return {int(section, 16): int(parser.get(section, key), 0)
            for section in objects if parser.has_option(section, key)}


def describe(path_text):
    dictionary = reader.import_eds(io.StringIO(path_text), None)
    node_id = dictionary.node_id
    compact = numbers(path_text, "CompactSubObj")
    codes = numbers(path_text, "ObjectType")
    lines = []
    for index in dictionary:
        entry = dictionary.indices[index]
        if index < 0x1000:
            lines.append(f"dummy\t{type_name(entry.data_type)}")
        elif isinstance(entry, ODVariable):
            kind = "DOMAIN" if codes.get(index) == reader.DOMAIN else "VAR"
            lines.append(line(entry, kind, 0, node_id))
        else:
            kind = "ARRAY" if isinstance(entry, ODArray) else "RECORD"
            made = range(0, compact[index] + 1) if index in compact else []
            prefix = "compact\t" if index in compact else ""
            for sub_index in sorted({*entry.subindices, *made}):
                variable = entry.subindices.get(sub_index) or entry[sub_index]
                lines.append(prefix + line(variable, kind, sub_index, node_id))
    return lines


def pdos(path_text):
    """The PDOs of node 5 that are on and that canopen can read."""
    try:
        node = canopen.RemoteNode(5, reader.import_eds(io.StringIO(path_text), 5))
    except KeyError:  # A PDO without its mapping.
        return []
    canopen.Network().add_node(node)
    lines = []
    for name, maps in (("TPDO", node.tpdo), ("RPDO", node.rpdo)):
        for number in maps:
            pdo = maps[number]
            try:
                pdo.read(from_od=True)
            except (KeyError, TypeError):
                continue
            if pdo.enabled and pdo.map:
                places = [f"0x{it.index:04X}:{it.subindex:02X}@{it.offset}+{it.length}"
                          for it in pdo.map if it.index >= 0x1000]
                lines.append("\t".join(["pdo", f"{name}{number}", f"0x{pdo.cob_id:X}", *places]))
    return lines


def decoded(path):
    with open(path, "rb") as file:
        content = file.read()
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("cp1252")


def main():
    logging.disable(logging.CRITICAL)
    for path in sys.argv[1:]:
        print(f"file\t{path}")
        try:
            lines = describe(decoded(path)) + pdos(decoded(path))
        except Exception as error:
            lines = [f"refused\t{type(error).__name__}: {error}".replace("\n", " ")]
        for one in lines:
            print(one)


if __name__ == "__main__":
    main()
