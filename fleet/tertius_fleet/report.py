"""One page over all machines, from the tables of `replay --parquet`, by DuckDB."""

import html
import math
import os
from datetime import datetime, timezone
from pathlib import Path

import duckdb

from .step import Refused

#: A drift is told that is so many standard errors from none: of a thousand cylinders chance moves none so far.
SURE = 4.0

#: A number of incidents that chance brings more seldom is told.
UNLIKELY = 0.01

#: What is said of such a number.
MORE = "more than chance allows"

#: Hours of a mean year.
YEAR = 8766.0

QUERIES = {
    # The newest report of each incident: what became of it.
    "stories": """
        select *, row_number() over (partition by machine, begin, incident order by timestamp desc, t desc) as age
        from incidents qualify age = 1""",
    "machines": """
        select s.machine, count(*) as recordings, min(s.begin) as since, sum(s.duration) / 3600 as hours,
            max(s.false_alarms_per_year) as budget, list(distinct s.configuration) as configurations,
            count(*) filter (not s.judged) as unjudged,
            sum(s.bad_lines) as bad_lines, sum(s.missing_cycles) as missing, sum(s.time_jumps) as jumps
        from summaries s group by all order by machine""",
    # What plausibility alone has found is a fact and no matter of chance.
    "found": """
        select machine, count(*) as incidents, count(*) filter (detectors <> 'plausibility') as by_chance
        from stories group by all""",
    "months": """
        select machine, strftime(begin, '%Y-%m') as month, count(*) as incidents,
            count(*) filter (level in ('red', 'black')) as severe
        from stories group by all order by machine, month""",
    "worst": """
        select machine, begin, cylinder, name, level, suspect, summary, "end" is null as stands from stories
        order by list_position(['black', 'red', 'orange', 'yellow', 'none'], level), begin desc limit 50""",
    "suspects": """
        select machine, cylinder, max_by(name, begin) as name, suspect, max_by(suspect_name, begin) as suspect_name,
            count(*) as incidents, max(begin) as newest from stories
        where suspect in ('c1', 'c2') group by all having count(*) > 1 order by incidents desc limit 30""",
    "trends": """
        select machine, cylinder, name, transducer, transducer_name, dwells, months, moved_mm, mm_per_month, error_mm_per_month,
            maintenance_months, critical_months
        from trends qualify row_number() over (partition by machine, cylinder, transducer order by begin desc) = 1""",
    # The difference of the two transducers, day by day, tells a drift also where no stop is read.
    "differences": """
        with days as (
            select machine, cylinder, max(name) as name, day, sum(r3_mean * r3_count) / sum(r3_count) * 1000 as mean_mm
            from minutes where r3_count > 0 group by all)
        select machine, cylinder, max_by(name, day) as name, count(*) as days, regr_slope(mean_mm, date_diff('day', date '2000-01-01', day)) * 30.4375
            as mm_per_month, arg_min(mean_mm, day) as first_mm, arg_max(mean_mm, day) as last_mm,
            sqrt((1 - coalesce(regr_r2(mean_mm, date_diff('day', date '2000-01-01', day)), 1)) * regr_syy(mean_mm,
            date_diff('day', date '2000-01-01', day)) / nullif(count(*) - 2, 0) / nullif(regr_sxx(mean_mm,
            date_diff('day', date '2000-01-01', day)), 0)) * 30.4375 as error
        from days group by all having count(*) > 6""",
    "unjudged": """
        select machine, sum(samples) as samples, sum(gated) as gated,
            sum(samples * 2 - coalesce(unjudged_r1, samples) - coalesce(unjudged_r2, samples)) as judged,
            sum(judged_seconds) as sequential, sum(not_monitored_seconds) as not_monitored,
            sum(no_reading_seconds) as no_reading, sum(not_calibrated_seconds) as not_calibrated,
            sum(no_baseline_seconds) as no_baseline, sum(implausible_c1 + implausible_c2) as implausible
        from cylinders group by all order by machine""",
    # How long a bus was silent is known where it is heard again.
    "unheard": """
        with told as (
            select *, lead(notice) over one as next, epoch_us(lead(timestamp) over one) as until from notices
            where notice in ('silence', 'heard_again', 'gap', 'time_jump', 'interruption')
            window one as (partition by machine, bus, notice in ('silence', 'heard_again') order by timestamp, t))
        select machine, notice, bus, count(*) as times, max(timestamp) as newest,
            sum(case notice when 'gap' then seconds
                when 'silence' then case next when 'heard_again' then (until - epoch_us(timestamp)) / 1e6 end end) as seconds,
            count(*) filter (notice = 'silence' and next is distinct from 'heard_again') as open
        from told where notice <> 'heard_again' group by all order by machine, notice, bus""",
    "reasons": """
        select machine, reasons, count(*) as recordings, min(begin) as first from summaries where not judged
        group by all order by recordings desc limit 50""",
}

#: Columns that tables of older programs do not have.
NEWER = {
    "incidents": ("name", "suspect_name"),
    "minutes": ("name",),
    "trends": ("name", "transducer_name"),
}

STYLE = """
:root { color-scheme: light dark; } body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 76rem;
padding: 0 1rem; } h2 { margin-top: 2.2rem; } table { border-collapse: collapse; display: block; overflow-x: auto; }
th, td { padding: .25rem .55rem; text-align: right; border-bottom: 1px solid color-mix(in srgb, currentColor 20%,
transparent); white-space: nowrap; } th { vertical-align: bottom; white-space: normal; } th:first-child, td:first-child, .text {
text-align: left; } .text { min-width: 19rem; white-space: normal; } p { max-width: 50rem; }
"""


def tables(results):
    """A connection with a view of each table, and of each query."""
    folder = results / "columns"
    if not folder.is_dir():
        raise Refused(f"{folder}: there is no such folder; expected the tables of `tertius-fleet run --output {results}`")
    base = duckdb.connect()
    base.execute("set TimeZone = 'UTC'")
    for table in ("warnings", "incidents", "notices", "minutes", "cylinders", "trends", "summaries"):
        if not any(folder.glob(f"{table}/machine=*/day=*/*.parquet")):
            raise Refused(f"{folder / table}: there are no Parquet files; was the fleet replayed with --parquet?")
        files = str(folder / table / "*" / "*" / "*.parquet").replace("'", "''")
        read = (
            f"read_parquet('{files}', hive_partitioning = true, "
            "hive_types = {'machine': varchar, 'day': date}, union_by_name = true)"
        )
        columns = base.execute(f"describe select * from {read}").fetchall()
        # Microseconds are enough here, and more functions know them.
        times = [column[0] for column in columns if column[1].startswith("TIMESTAMP")]
        micros = ", ".join(f'make_timestamp(epoch_ns("{name}") // 1000) as "{name}"' for name in times)
        known = {column[0] for column in columns}
        missing = "".join(f", null::varchar as {name}" for name in NEWER.get(table, ()) if name not in known)
        base.execute(f"create view {table} as select * replace ({micros}){missing} from {read}")
    base.execute(f"create table stories as {QUERIES['stories']}")
    return base


def rows(base, name):
    found = base.execute(QUERIES[name])
    names = [column[0] for column in found.description]
    return [dict(zip(names, row)) for row in found.fetchall()]


def table(heads, lines, texts=()):
    """A table in HTML; columns in `texts` are words."""
    kind = ["class=text" if index in texts else "" for index in range(len(heads))]
    cell = lambda tag, index, value: f"<{tag} {kind[index]}>{html.escape(str(value))}</{tag}>"
    out = ["<table><thead><tr>", *(cell("th", index, head) for index, head in enumerate(heads)), "</tr></thead><tbody>"]
    for line in lines:
        out += ["<tr>", *(cell("td", index, value) for index, value in enumerate(line)), "</tr>"]
    return "".join([*out, "</tbody></table>"])


def called(number, name):
    """What has a number, with its name if it has one."""
    return f"{number} {name}" if name else number


def moment(at):
    return at.strftime("%Y-%m-%d %H:%M")


def share(part, whole):
    return "–" if not whole or part is None else f"{100 * part / whole:.1f} %"


def chance(count, expected):
    """Probability of so many events or more, where so many are expected: the tail of Poisson's distribution."""
    if expected <= 0:
        return 0.0 if count else 1.0
    below = (math.exp(k * math.log(expected) - expected - math.lgamma(k + 1)) for k in range(count))
    return max(0.0, 1.0 - math.fsum(below))


def verdict(machine, incidents):
    """What the number of incidents says of the machine's budget of false alarms."""
    expected = machine["hours"] / YEAR * machine["budget"]
    if incidents == 0:
        return "none of residuals" if expected >= 3 else "none of residuals, in too short a time to confirm the budget"
    if chance(incidents, expected) < UNLIKELY:
        return f"{MORE}: faults, or false alarms above the budget"
    return "as many as the budget allows"


def overview(base):
    """The machines: how long, what was found, and whether that is more than chance allows."""
    counts = {row["machine"]: row for row in rows(base, "machines")}
    found = {row["machine"]: row for row in rows(base, "found")}
    lines = []
    for name, it in counts.items():
        of_it = found.get(name, {"incidents": 0, "by_chance": 0})
        a_year = of_it["by_chance"] / it["hours"] * YEAR if it["hours"] else 0.0
        lines.append(
            [name, verdict(it, of_it["by_chance"]), of_it["incidents"], of_it["by_chance"], f"{a_year:.1f}",
             f"{it['budget']:g}", it["recordings"], f"{it['hours']:.2f}", f"{it['since']:%Y-%m-%d}",
             ", ".join(sorted(it["configurations"]))]
        )
    # What somebody has to look at comes first.
    lines.sort(key=lambda line: not line[1].startswith(MORE))
    heads = ["machine", "against the budget", "incidents", "of residuals", "of residuals, a year", "budget, a year",
             "recordings", "hours", "since (UTC)", "configuration"]
    return table(heads, lines, (1,))


def drifts(base):
    """Transducers that drift: by the stops, and by the difference of the two day by day."""
    stops = [
        [it["machine"], called(it["cylinder"], it["name"]), called(it["transducer"].upper(), it["transducer_name"]), it["dwells"], f"{it['months']:.1f}", f"{it['moved_mm']:+.2f}",
         f"{it['mm_per_month']:+.3f} ± {it['error_mm_per_month']:.3f}",
         "–" if it["maintenance_months"] is None else f"{it['maintenance_months']:.1f}"]
        for it in rows(base, "trends")
        if it["maintenance_months"] is not None or abs(it["mm_per_month"]) > SURE * it["error_mm_per_month"]
    ]
    days = [
        [it["machine"], called(it["cylinder"], it["name"]), it["days"], f"{it['first_mm']:+.3f}", f"{it['last_mm']:+.3f}",
         f"{it['mm_per_month']:+.3f} ± {it['error']:.3f}"]
        for it in rows(base, "differences")
        if it["error"] is not None and abs(it["mm_per_month"]) > SURE * it["error"]
    ]
    by_stops = table(["machine", "cylinder", "transducer", "dwells", "months", "moved, mm", "mm a month", "months to maintenance"], stops)
    by_days = table(["machine", "cylinder", "days", "first day, mm", "last day, mm", "mm a month"], days)
    none = "<p>None is further than four standard errors from standing still.</p>"
    return (
        "<h3>By the mechanical stops</h3>" + (by_stops if stops else none)
        + "<h3>By C1 − C2, day by day</h3><p>This does not tell which of the two it is.</p>" + (by_days if days else none)
    )


def unjudged(base):
    """What was not judged, and why."""
    lines = []
    for it in rows(base, "unjudged"):
        parts = [it[name] for name in ("sequential", "not_monitored", "no_reading", "not_calibrated", "no_baseline")]
        whole = sum(part or 0 for part in parts)
        lines.append(
            [it["machine"], share(it["judged"], 2 * it["samples"]), share(it["gated"], it["samples"]),
             *(share(part, whole) for part in parts), it["implausible"]]
        )
    heads = ["machine", "observers judged", "neither did", "sequential judged", "not monitored", "no reading",
             "not calibrated", "no baseline", "implausible readings"]
    reasons = [[it["machine"], it["recordings"], moment(it["first"]), it["reasons"]] for it in rows(base, "reasons")]
    text = table(heads, lines)
    if reasons:
        text += "<h3>Recordings of which nothing was judged</h3>" + table(["machine", "recordings", "first (UTC)", "why"], reasons, (3,))
    return text


def unheard(base):
    """What the buses did not bring: gaps, clocks that were set, buses that were lost or silent."""
    words = {
        "gap": "no cycle for longer than machine.max_gap",
        "time_jump": "the clock was set",
        "interruption": "the {bus}bus was lost",
        "silence": "the {bus}bus was silent while another was heard",
    }
    lines = [
        [it["machine"], words[it["notice"]].format(bus=it["bus"] + " " if it["bus"] else ""), it["times"],
         "–" if it["seconds"] is None else f"{it['seconds']:.1f}", it["open"] or "–", moment(it["newest"])]
        for it in rows(base, "unheard")
    ]
    heads = ["machine", "what", "times", "seconds in all", "not heard again", "newest (UTC)"]
    return table(heads, lines, (1,)) if lines else "<p>No gap was longer than <code>machine.max_gap</code>, and no bus was lost or silent.</p>"


def page(base):
    months = [[it["machine"], it["month"], it["incidents"], it["severe"]] for it in rows(base, "months")]
    worst = [
        [it["machine"], moment(it["begin"]), called(it["cylinder"], it["name"]), it["level"], it["summary"] + (" (stands)" if it["stands"] else "")]
        for it in rows(base, "worst")
    ]
    again = [
        [it["machine"], called(it["cylinder"], it["name"]), called(it["suspect"].upper(), it["suspect_name"]), it["incidents"],
         moment(it["newest"])]
        for it in rows(base, "suspects")
    ]
    nothing = "<p>None.</p>"
    parts = [
        ("Machines", "Nobody tells this page which incidents were true, so that the rate of those of residuals, which chance "
         "can bring, is at least that of false alarms. The budget is <code>sequential.false_alarms_per_year</code> of the "
         "configuration. Machines with more incidents than chance allows come first.", overview(base)),
        ("Transducers that drift", "", drifts(base)),
        ("Transducers that are suspected again and again", "", table(["machine", "cylinder", "transducer", "incidents", "newest (UTC)"], again) if again else nothing),
        ("Incidents by machine and month", "Each counts in the month of its begin.", table(["machine", "month", "incidents", "red or black"], months) if months else nothing),
        ("The worst incidents", "At most 50.", table(["machine", "begin (UTC)", "cylinder", "level", "what"], worst, (4,)) if worst else nothing),
        ("What was not heard", "Gaps and clocks that were set; buses that were lost, or were silent while another bus of the "
         "machine was heard. What they carry was unknown meanwhile, and no transducer is to blame.", unheard(base)),
        ("What was not judged, and why", "Shares of the samples of all cylinders, and of the sequential detectors' time. "
         "Unknown is not healthy.", unjudged(base)),
    ]
    now = datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M UTC")
    body = "".join(f"<h2>{title}</h2>" + (f"<p>{words}</p>" if words else "") + text for title, words, text in parts)
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        '<meta name="generator" content="tertius-fleet report"><title>Fleet</title>'
        f"<style>{STYLE}</style></head><body><h1>Fleet</h1><p>Made {now}.</p>{body}</body></html>\n"
    )


def write(results, output=None):
    """Writes the page over the `results` of a run, and returns its path. A page of somebody else is not written over."""
    target = Path(output) if output else results / "fleet.html"
    if target.exists() and target.stat().st_size and "tertius-fleet report" not in target.read_text(errors="replace")[:2000]:
        raise Refused(f"{target}: it exists, and this command did not write it; name another file with --output")
    text = page(tables(results))
    beside = target.with_name(f".{target.name}.part")
    beside.write_text(text)
    os.replace(beside, target)
    return target
