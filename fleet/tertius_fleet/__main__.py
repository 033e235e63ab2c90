"""The command: `tertius-fleet run FLEET.toml --output RESULTS`, `tertius-fleet report RESULTS`."""

import argparse
import os
import sys
from pathlib import Path

from .engine import Progress, beside, in_turn, planned, workers
from .step import Refused


def arguments():
    parser = argparse.ArgumentParser(prog="tertius-fleet", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    run = commands.add_parser("run", help="replays every recording of a fleet, and goes on where it was")
    run.add_argument("fleet", help="FLEET.toml")
    run.add_argument("--output", required=True, help="folder of the results; of workers elsewhere a shared one")
    run.add_argument("--workers", type=int, default=os.cpu_count(), help="processes here; 0: one after the other")
    run.add_argument("--scheduler", help="a Dask scheduler elsewhere: tcp://…, or its scheduler file")
    run.add_argument("--program", default="tertius", help="the program, as workers call it")
    run.add_argument("--thorough", action="store_true", help="looks for overlaps in whole recordings before the first replay")
    report = commands.add_parser("report", help="one page over all machines")
    report.add_argument("results", help="the folder of the results")
    report.add_argument("--output", help="the page [default: RESULTS/fleet.html]")
    return parser.parse_args()


def run(call):
    jobs = planned(call.program, call.fleet, quick=not call.thorough)
    output, progress = os.path.abspath(call.output), Progress(jobs)
    if call.workers == 0 and call.scheduler is None:
        failures = in_turn(jobs, output, call.program, progress)
    else:
        with workers(call.workers, call.scheduler) as client:
            failures = beside(jobs, output, call.program, progress, client)
    hours = progress.recorded / 3600
    print(
        f"{progress.done} of {len(jobs)} recordings are done: {hours:.2f} machine-hours with "
        f"{progress.processor:.1f} s of processor time. The tables are in {Path(output) / 'columns'}"
    )
    for machine, why in failures.items():
        print(f"machine {machine} stands still: {why}", file=sys.stderr)
    return 1 if failures else 0


def main():
    call = arguments()
    try:
        if call.command == "run":
            return run(call)
        from .report import write

        page = write(Path(call.results), call.output)
        print(f"The page is {page}")
        return 0
    except Refused as error:
        print(f"tertius-fleet: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
