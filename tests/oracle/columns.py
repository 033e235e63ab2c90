"""What DuckDB, Polars and pandas read of `replay --parquet`, against its lines of JSON; by scripts/columns.

    columns.py PROGRAM CONFIG LOG…

A table in Markdown goes to standard output: rows and seconds of each reader. Exit code 1 if a value differs.
"""

import json
import math
import struct
import subprocess
import sys
import tempfile
import time
from decimal import Decimal
from pathlib import Path

import duckdb
import pandas
import polars

TABLES = ["warnings", "incidents", "notices", "dwells", "minutes", "cylinders", "trends", "summaries"]
TIMES = {"timestamp", "onset", "begin", "end", "peak_at", "minute"}


def by_duckdb(folder, table):
    """Rows as dictionaries, times as whole nanoseconds."""
    files = f"{folder}/{table}/*/*/*.parquet"
    relation = duckdb.sql(f"select * from read_parquet('{files}', hive_partitioning = true)")
    times = [name for name in relation.columns if name in TIMES]
    if times:
        replaced = ", ".join(f'epoch_ns("{name}") as "{name}"' for name in times)
        relation = duckdb.sql(f"select * replace ({replaced}) from relation")
    return [dict(zip(relation.columns, row)) for row in relation.fetchall()]


def by_polars(folder, table):
    frame = polars.read_parquet(f"{folder}/{table}/*/*/*.parquet", hive_partitioning=True)
    times = [name for name in frame.columns if name in TIMES]
    return frame.with_columns(polars.col(name).to_physical() for name in times).to_dicts()


def by_pandas(folder, table):
    frame = pandas.read_parquet(f"{folder}/{table}", dtype_backend="pyarrow")
    for name in frame.columns:
        if name in TIMES:
            frame[name] = frame[name].astype("int64[pyarrow]")
    nulls = frame.astype(object).where(frame.notna(), None)
    return nulls.to_dict("records")


def bits(value):
    """A value that is equal only where it is so to the bit."""
    if isinstance(value, float):
        return struct.pack("<d", value)
    return value


def nanos(digits):
    return int(Decimal(digits) * 1_000_000_000)


def expected(lines):
    """The rows of the tables that the lines of JSON have, with the columns that can be compared."""
    tables = {table: [] for table in TABLES}
    for line in lines:
        exact = json.loads(line, parse_float=lambda digits: digits)
        line = json.loads(line)
        kind = line.pop("type")
        if kind == "summary":
            inner = line.pop("cylinders")
            trends = line.pop("trends", [])
            warnings = line.pop("warnings")
            reasons = line.pop("reasons", None)
            row = {**line, **{f"warnings_{name}": count for name, count in warnings.items()}}
            tables["summaries"].append({**row, "reasons": "; ".join(reasons) if reasons else None})
            for row in inner:
                for pair in ("implausible", "counter_jumps"):
                    row[f"{pair}_c1"], row[f"{pair}_c2"] = row.pop(pair)
                sequential, process = row.pop("sequential", None), row.pop("process", None)
                if sequential:
                    row["judged_seconds"] = sequential["judged_seconds"]
                    row |= {f"{name}_seconds": it for name, it in sequential["unknown_seconds"].items()}
                row |= {f"process_{name}": it for name, it in (process or {}).items()}
                tables["cylinders"].append(row)
            for row in trends:
                for name in ("maintenance", "critical"):
                    left = row.pop(f"months_until_{name}") or {}
                    row[f"{name}_months"] = left.get("expected")
                    row[f"{name}_months_earliest"] = left.get("earliest")
                    row[f"{name}_months_latest"] = left.get("latest")
                tables["trends"].append(row)
        elif kind == "notice":
            tables["notices"].append({**line, "timestamp": nanos(exact["timestamp"])})
        elif kind in ("warning", "incident"):
            line["timestamp"] = nanos(exact["timestamp"])
            if kind == "incident":
                peaks, detectors = line.pop("peaks"), line.pop("detectors")
                names = list(dict.fromkeys(it["detector"] for it in detectors))
                line |= {f"peak_{name}": value for name, value in peaks.items()} | {"detectors": ",".join(names)}
            seconds = {name: exact[name] for name in ("onset", "begin", "end", "peak_at") if line.get(name) is not None}
            # Seconds since the first frame of all, as the lines have them, and the time stamp of that frame.
            first = nanos(exact["timestamp"]) - nanos(exact["t"])
            line |= {name: first + nanos(digits) for name, digits in seconds.items()}
            device = line.pop("device", None) or {}
            line |= {f"device_{name}": value for name, value in device.items()}
            tables[f"{kind}s"].append(line)
    return tables


def differences(rows, wanted, where):
    """Texts that say where rows are others than wanted."""
    if len(rows) != len(wanted):
        yield f"{where}: {len(rows)} rows instead of {len(wanted)}"
        return
    for index, (row, line) in enumerate(zip(rows, wanted)):
        for name, value in line.items():
            found = row.get(name, "no column")
            if found is not None and isinstance(found, float) and math.isnan(found):
                found = None
            # A whole number is written without a point where it is a double, too.
            if isinstance(found, float) and isinstance(value, int) and not isinstance(value, bool):
                value = float(value)
            if bits(found) != bits(value):
                yield f"{where}, row {index}, {name}: {found!r} instead of {value!r}"


def main(program, config, logs):
    found, compared = [], 0
    print("| recording | reader | rows | values compared | seconds |\n| --- | --- | --- | --- | --- |")
    for log in logs:
        with tempfile.TemporaryDirectory() as folder:
            call = [program, "replay", log, "--config", config, "--format", "jsonl", "--parquet", folder]
            ran = subprocess.run(call, capture_output=True, text=True)
            if ran.returncode not in (0, 1):
                sys.exit(ran.stderr)
            wanted = expected(ran.stdout.splitlines())
            for reader in (by_duckdb, by_polars, by_pandas):
                began, rows, values = time.monotonic(), 0, 0
                for table in TABLES:
                    got = reader(folder, table)
                    rows += len(got)
                    if table in ("dwells", "minutes"):
                        continue  # The lines do not have them.
                    values += sum(len(line) for line in wanted[table])
                    found += differences(got, wanted[table], f"{log}, {reader.__name__}, {table}")
                    for row in got:
                        if {"machine", "day"} - row.keys():
                            found.append(f"{log}, {reader.__name__}, {table}: no machine and day")
                name = reader.__name__.removeprefix("by_")
                print(f"| {Path(log).name} | {name} | {rows} | {values} | {time.monotonic() - began:.2f} |")
                compared += values
    print(f"\n{compared} values compared, {len(found)} differ")
    for text in found[:20]:
        print(text, file=sys.stderr)
    return 1 if found or not compared else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2], sys.argv[3:]))
