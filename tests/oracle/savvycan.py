"""Tables of SavvyCAN by the csv module of Python.

    savvycan.py write COLUMNS LOG TABLE

writes the candump log LOG of data frames as SavvyCAN saves it, with COLUMNS `dir`, or without the direction, `old`.

    savvycan.py read TABLE…

prints JSON, for each table a list of its frames: [time in µs, identifier, extended, bus, data in hexadecimal].
"""

import csv
import json
import re
import sys

PAYLOAD = [f"D{n}" for n in range(1, 9)]
COLUMNS = {
    "dir": ["Time Stamp", "ID", "Extended", "Dir", "Bus", "LEN", *PAYLOAD],
    "old": ["Time Stamp", "ID", "Extended", "Bus", "LEN", *PAYLOAD],
}
FRAME = re.compile(r"\((\d+)\.(\d{6})\) \S+ ([0-9A-F]+)#([0-9A-F]*)")


def write(columns, log, table):
    with open(log, encoding="ascii") as lines, open(table, "w", newline="", encoding="ascii") as out:
        # Every row ends with a comma, and the names of the columns do not.
        out.write(",".join(COLUMNS[columns]) + "\n")
        rows = csv.writer(out, lineterminator=",\n")
        for line in lines:
            seconds, micros, identifier, data = FRAME.match(line).groups()
            data = bytes.fromhex(data)
            row = [str(int(seconds + micros)), identifier.rjust(8, "0"), str(len(identifier) == 8).lower()]
            row += ["Rx"] if columns == "dir" else []
            row += [0, len(data), *(f"{byte:02X}" for byte in data.ljust(8, b"\0"))]
            rows.writerow(row)


def read(table):
    with open(table, newline="", encoding="utf-8-sig") as lines:
        # Cells beyond the named columns are listed under None.
        for row in csv.DictReader(lines):
            cells = [row[name] or "" for name in row if name is not None and re.fullmatch(r"D\d+", name)]
            cells += row.get(None) or []
            data = bytes(int(cell, 16) for cell in cells[: int(row["LEN"])])
            yield [
                int(row["Time Stamp"]),
                int(row["ID"], 16),
                row["Extended"].lower() in ("true", "1"),
                int(row["Bus"]),
                data.hex(),
            ]


if sys.argv[1] == "write":
    write(*sys.argv[2:])
else:
    json.dump([list(read(table)) for table in sys.argv[2:]], sys.stdout)
