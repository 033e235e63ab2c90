"""A fleet that is there already, one recording after the other, on two Dask workers, and on two of which one is killed.

    PYTHONPATH=fleet fleet_week.py PROGRAM FLEET.toml

The results are put beside FLEET.toml, in `serial`, `undisturbed` and `dask`, which are made anew. What these runs leave has
to be the same, byte for byte, but for how long it took. By scripts/bench-fleet-week.
"""

import io
import json
import os
import shutil
import signal
import sys
import time
from pathlib import Path

from fleet import left
from tertius_fleet.engine import Progress, beside, in_turn, planned, workers
from tertius_fleet.report import write


def two(jobs, folder, program, kills):
    """Does the jobs on two workers; if it `kills`, one of them when half of the jobs are done. Returns how long it took,
    s, and what the killed one was at."""
    killed, done = [], [0]
    began = time.monotonic()
    with workers(2) as client:

        def kill(job):
            done[0] += 1
            busy = {address: keys for address, keys in client.processing().items() if keys}
            if kills and not killed and done[0] >= len(jobs) // 2 and busy:
                address = sorted(busy)[0]
                worker = client.run(os.getpid, workers=[address])[address]
                killed.extend(str(key) for key in busy[address])
                time.sleep(1)  # It is then in the middle of a recording.
                os.kill(worker, signal.SIGKILL)

        failures = beside(jobs, folder, program, Progress(jobs, io.StringIO()), client, kill)
    assert failures == {}, failures
    assert bool(killed) == kills, "no worker was killed"
    return time.monotonic() - began, killed


def alike(one, folder):
    """Compares what is left in the folder with `one`; returns the number of files."""
    other = left(folder)
    differ = [name for name in one.keys() | other.keys() if one.get(name) != other.get(name)]
    assert not differ, differ
    return len(one)


def main(program, fleet):
    folder = Path(fleet).resolve().parent
    jobs = planned(program, fleet, quick=True)
    for name in ("serial", "undisturbed", "dask"):
        shutil.rmtree(folder / name, ignore_errors=True)

    began, progress = time.monotonic(), Progress(jobs, io.StringIO())
    failures = in_turn(jobs, folder / "serial", program, progress)
    assert failures == {}, failures
    serial = time.monotonic() - began
    hours = progress.recorded / 3600
    print(
        f"{len(jobs)} recordings, {hours:.1f} machine-hours, one after the other: {serial:.1f} s, "
        f"{progress.processor:.1f} s of processor time: {progress.processor / progress.recorded * 8766:.2f} core-hours "
        "a machine-year",
        flush=True,
    )

    one = left(folder / "serial")
    took, _ = two(jobs, folder / "undisturbed", program, kills=False)
    print(f"Two workers: {took:.1f} s, {serial / took:.2f} times as fast", flush=True)
    alike(one, folder / "undisturbed")
    took, killed = two(jobs, folder / "dask", program, kills=True)
    print(f"One of them killed at {killed}: {took:.1f} s, {serial / took:.2f} times as fast", flush=True)

    files = alike(one, folder / "dask")
    done = [name for name in one if name.endswith(".done")]
    assert len(done) == len(jobs), (len(done), len(jobs))
    print(f"{files} files alike, {len(done)} recordings done, each once")
    incidents = {}
    for path in sorted((folder / "dask/folded").glob("*/*.done")):
        machine, it = path.parent.name, json.loads(path.read_text())
        incidents[machine] = incidents.get(machine, 0) + it["incidents"]
    print("Incidents:", ", ".join(f"{machine} {count}" for machine, count in incidents.items()))
    print(f"The page is {write(folder / 'dask', None)}")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
