"""The page of a fleet over a year that is made here: what drifts, what is more than chance, and what is not.

    PYTHONPATH=fleet fleet_page.py PROGRAM

A replay of seconds gives the columns; DuckDB makes months of them whose figures are known. By scripts/fleet.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

import duckdb

from tertius_fleet.report import chance, write

CONFIG = "tests/recordings/e-type-sequential.toml"
LOG = "tests/recordings/e-type-faults.log.zst"

#: How the configuration calls a cylinder and its C2.
NAMES = ("two<", "LT-2B")

#: Of machine B, cylinder 2, C1 − C2 moves by so much a day, mm.
DRIFT = 0.1

#: Each table of the year, from the table `real` of the same name.
YEAR = {
    # A day of 24 hours each: 40 of them, in two months.
    "summaries": """
        select * replace (begin + to_days(d::int) as begin, 86400e0 as duration, 1e0 as false_alarms_per_year,
            not (machine = 'B' and d = 7) as judged,
            case when machine = 'B' and d = 7 then 'the platform was never engaged' end as reasons)""",
    "minutes": f"""
        select * replace (minute + to_days(d::int) as minute,
            r3_mean + case when machine = 'B' and cylinder = 2 then d * {DRIFT} / 1000 else 0 end
                + (hash(d * 7 + cylinder) % 100 / 100.0 - 0.5) * 1e-5 as r3_mean)""",
    "cylinders": "select * replace (begin + to_days(d::int) as begin)",
    # One incident on A; on B one on every other day, four of them of plausibility alone.
    "incidents": f"""
        select * exclude (news, high, later) replace (begin + to_days(d::int) as begin,
            timestamp + to_days(d::int) + to_seconds(later) as timestamp, news as state, high as level,
            case when news = 'closed' then timestamp end as "end",
            case when d < 8 then 'plausibility' else 'fde3' end as detectors, 'c2' as suspect, 2 as cylinder, '{NAMES[0]}' as name,
            '{NAMES[1]}' as suspect_name)""",
    "warnings": "select *",
    # B's second bus is silent for 90 s on the third and the thirtieth day, and on the last one to the end; no other is. A's
    # only bus is lost once.
    "notices": """
        select d, machine, timestamp + to_days(d::int) + to_seconds(later) as timestamp, later::double as t,
            case machine when 'A' then 'interruption' else now end as notice, null::double as seconds,
            case machine when 'B' then 'second' end as bus""",
    # Without names, as in tables of older programs. C1 of B's cylinder 3 drifts from the thirtieth day on, as far as the stops know; its C2 does not.
    "trends": """
        select d, machine, begin + to_days(d::int) as begin, 3 as cylinder, transducer, 20 as dwells, 1.3e0 as months, 0.6e0 as moved_mm,
            case transducer when 'c1' then 0.45e0 else 0.01e0 end as mm_per_month, 0.02e0 as error_mm_per_month,
            case when transducer = 'c1' and d >= 30 then 9.8e0 end as maintenance_months, null::double as critical_months""",
}


def of_the_year(real, folder):
    """Writes the tables of machines A and B below `folder`."""
    base = duckdb.connect()
    base.execute("set TimeZone = 'UTC'")
    for table, query in YEAR.items():
        source = f"read_parquet('{real}/{table}/*/*/*.parquet', hive_partitioning = false)"
        names = [row[0] for row in base.execute(f"describe select * from {source}").fetchall()]
        times = [name for name in names if name in ("begin", "timestamp", "minute", "onset", "end", "peak_at")]
        plain = ", ".join(f'make_timestamp(epoch_ns("{name}") // 1000) as "{name}"' for name in times)
        only = "where true"
        if table == "incidents":
            only = "where (machine = 'A' and d = 20) or (machine = 'B' and d % 2 = 0)"
        reports = ""
        if table == "incidents":
            reports = ", (values ('opened', 'yellow', 0), ('closed', 'red', 5)) as reports(news, high, later)"
        if table == "notices":
            reports = ", (values ('silence', 0), ('heard_again', 90)) as reports(now, later)"
            source, times, plain = "(select make_timestamp(1700000000000000) as timestamp)", ["timestamp"], "timestamp as timestamp"
            only = """where (machine = 'A' and d = 11 and later = 0)
                or (machine = 'B' and (d in (3, 30) or (d = 39 and later = 0)))"""
        if table == "trends":
            source = "(select make_timestamp(1700000000000000) as begin, unnest(['c1', 'c2']) as transducer)"
            times, plain, only = ["begin"], "begin as begin", "where machine = 'B'"
        first = "qualify row_number() over () = 1" if table == "incidents" else ""
        base.execute(
            f"create or replace table made as {query} from (select * replace ({plain}) from {source} {first}), "
            f"range(40) as days(d), (values ('A'), ('B')) as machines(machine) {reports} {only}"
        )
        at = next(name for name in (*times, "d") if name in ("begin", "minute", "timestamp"))
        # Recordings have nanoseconds.
        nanos = ", ".join(f'"{name}"::timestamp_ns as "{name}"' for name in times)
        base.execute(
            f"copy (select * exclude (d, day) replace ({nanos}), \"{at}\"::date as day from "
            f"(select *, 0 as day from made)) to '{folder}/columns/{table}' (format parquet, partition_by (machine, day))"
        )


def main(program):
    assert abs(chance(3, 1.0) - 0.0803014) < 1e-6 and chance(0, 1.0) == 1.0 and chance(1, 0.0) == 0.0
    with tempfile.TemporaryDirectory() as folder:
        real = Path(folder) / "real"
        config = Path(folder) / "named.toml"
        names = f'name = "{NAMES[0]}"\nc2_name = "{NAMES[1]}"\n'
        text = Path(CONFIG).read_text().replace("../../dbc", str(Path("dbc").absolute()))
        config.write_text(text.replace("[[cylinder]]\nn = 2\n", f"[[cylinder]]\nn = 2\n{names}"))
        call = [program, "replay", LOG, "--config", config, "--format", "jsonl", "--parquet", real]
        subprocess.run(call, check=True, capture_output=True)
        (Path(folder) / "columns").mkdir()
        of_the_year(real, folder)
        page = write(Path(folder)).read_text()
        text = re.sub(r"\s+", " ", re.sub("<[^>]+>", " ", page.split("</style>")[1].replace("</tr>", "\n")))
        parts = dict(zip(re.findall("<h2>(.*?)</h2>", page), page.split("<h2>")[1:]))

        drifts = re.sub("<[^>]+>", " ", parts["Transducers that drift"])
        found = re.findall(r"\b([AB])\s+(\d) two&lt;\s+40\s+\S+\s+\S+\s+([+-]\S+) ±", drifts)
        assert [(machine, cylinder) for machine, cylinder, _ in found] == [("B", "2")], drifts
        assert abs(float(found[0][2]) - DRIFT * 30.4375) < 0.02, found

        stops = re.findall(r"\b([AB])\s+(\d)\s+(C\d)\s+20\s+1\.3\s+\+0\.60\s+\+0\.450 ± 0\.020\s+9\.8", drifts)
        assert stops == [("B", "3", "C1")], drifts

        # 20 on B, of which 4 are of plausibility; 960 hours expect a tenth of a false alarm. One of them is no proof.
        assert re.search(r" A as many as the budget allows 1 1 9\.1 1 40 960\.00 ", text), text[:900]
        assert re.search(r" B more than chance allows: [^0-9]+ 20 16 146\.1 1 40 960\.00 .* A as many", text), text[:900]
        # The newest report is what counts: all of them were red, and are over.
        months = re.findall(r"\b([AB]) (20\d\d-\d\d) (\d+) (\d+) ", text)
        of_b = [(int(count), int(red)) for machine, _, count, red in months if machine == "B"]
        assert sum(count for count, _ in of_b) == 20 and all(count == red for count, red in of_b), months
        assert len(of_b) == 2 and "stands" not in text, months
        assert re.search(r"B 2 two&lt; C2 LT-2B 20 ", text), "who is suspected again and again"
        assert re.search(r"B 20\d\d-\d\d-\d\d \d\d:\d\d 2 two&lt; red ", text), "the worst"
        assert "B 1 2023-11-21 22:13 the platform was never engaged" in text, text[-900:]
        unheard = re.sub(r"\s+", " ", re.sub("<[^>]+>", " ", parts["What was not heard"]))
        assert "B the second bus was silent while another was heard 3 180.0 1 2023-12-23 22:13" in unheard, unheard
        assert "A the bus was lost 1 – – 2023-11-25 22:13" in unheard, unheard
        assert len(re.findall("bus was", unheard)) == 2 and "gap" not in unheard, unheard
    print("the page of a made year has its drift, its budget, its months, its silence and its reasons")


if __name__ == "__main__":
    main(sys.argv[1])
