"""A small fleet on Dask, of whose workers one is killed in the middle, against the same fleet one after the other.

    PYTHONPATH=fleet fleet.py PROGRAM

Three machines with three recordings each, cut in the middle of incidents. What the two runs leave has to be the same,
byte for byte, but for how long it took. By scripts/fleet.
"""

import hashlib
import io
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import duckdb

from tertius_fleet import step
from tertius_fleet.engine import Progress, beside, in_turn, planned, workers
from tertius_fleet.report import write

CONFIG = Path("tests/recordings/e-type-sequential.toml").resolve()
SECONDS, PARTS = 60, 3


def recordings(program, folder, machine):
    """The parts of a machine's recording, cut within a fault."""
    fault = f"step,cylinder={machine + 1},sensor=c{machine % 2 + 1},at=18,until=22,size=0.01"
    other = f"freeze,cylinder={machine + 3},sensor=c1,at=38,until=42"
    call = [program, "simulate", "--config", CONFIG, "--duration", str(SECONDS), "--seed", str(machine)]
    if machine == 0:
        call += ["--states", "0:engaged,4:safe,45:engaged"]
    text = subprocess.run([*call, "--fault", fault, "--fault", other], capture_output=True, check=True).stdout
    lines = text.splitlines(keepends=True)
    cuts = [len(lines) * part // PARTS for part in range(PARTS + 1)]
    folder.mkdir(parents=True)
    for part in range(PARTS):
        (folder / f"{part}.log").write_bytes(b"".join(lines[cuts[part] : cuts[part + 1]]))


def left(folder):
    """Checksums of what a run left; those of `.done` say how long it took, and are only counted."""
    files = {}
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        if path.is_file() and "/." not in name:
            files[name] = "" if path.suffix == ".done" else hashlib.sha256(path.read_bytes()).hexdigest()
    return files


class Death(BaseException):
    """What nobody catches."""


def dying(jobs, folder, program, whole):
    """Does the jobs of a machine, each of which dies once before each file that it puts in its place."""
    true = step.settle
    for job in jobs:
        for survived in range(4):
            left_to_do = [survived]

            def settle(source, target):
                if left_to_do[0] == 0:
                    raise Death
                left_to_do[0] -= 1
                true(source, target)

            step.settle = settle
            try:
                step.step(job, folder / "dying", program)
            except Death:
                pass
            else:
                raise AssertionError(f"{job['recording']} put fewer files in place than {survived + 1}")
            finally:
                step.settle = true
        step.step(job, folder / "dying", program)
    died = left(folder / "dying")
    differ = [name for name in died if died[name] != whole.get(name)]
    assert died and not differ, differ


def main(program):
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        entries = []
        for machine in range(3):
            recordings(program, folder / f"m{machine}", machine)
            history = 'history = "m0.dwells"\n' if machine == 0 else ""
            entries.append(
                f'[[machine]]\nname = "M {machine}"\nconfig = "{CONFIG}"\nrecordings = ["m{machine}"]\n{history}'
            )
        (folder / "fleet.toml").write_text("\n".join(entries))
        jobs = planned(program, folder / "fleet.toml")
        assert [job["index"] for job in jobs] == [1, 2, 3] * 3, jobs

        began = time.monotonic()
        failures = in_turn(jobs, folder / "serial", program, Progress(jobs, io.StringIO()))
        assert failures == {}, failures
        serial = time.monotonic() - began

        began, killed = time.monotonic(), []
        with workers(2) as client:

            def kill(job):
                # While the others are at it: the second job that is done.
                busy = {address: keys for address, keys in client.processing().items() if keys}
                if not killed and job["index"] == 2 and busy:
                    address = sorted(busy)[0]
                    worker = client.run(os.getpid, workers=[address])[address]
                    os.kill(worker, signal.SIGKILL)
                    killed.append(busy[address])

            failures = beside(jobs, folder / "dask", program, Progress(jobs), client, kill)
        assert failures == {}, failures
        assert killed, "no worker was killed"
        dask = time.monotonic() - began

        one, other = left(folder / "serial"), left(folder / "dask")
        differ = [name for name in one.keys() | other.keys() if one.get(name) != other.get(name)]
        assert not differ, differ
        tables = [name for name in one if name.startswith("columns/")]
        assert len(tables) == 8 * 9, tables
        assert sum(name.endswith(".jsonl") for name in one) == 9, one
        count = f"select count(*) from '{folder}/serial/columns/dwells/*/*/*.parquet'"
        stops = duckdb.connect().execute(count).fetchone()[0]
        assert stops == 6 and "folded/M 0/000003.dwells" in one, (stops, sorted(one))

        dying(jobs[:3], folder, program, one)

        # What the program leaves by itself, which either of the two goes on from.
        run = [program, "fleet", "run", folder / "fleet.toml", "--jobs", "2", "--output", folder / "own"]
        subprocess.run(run, check=True, capture_output=True)
        assert left(folder / "own") == one
        assert in_turn(jobs, folder / "own", program, Progress(jobs, io.StringIO())) == {}
        run[-1] = folder / "dask"
        subprocess.run(run, check=True, capture_output=True)
        assert left(folder / "own") == one and left(folder / "dask") == other

        # Once more there is nothing to do, and what is in the way is refused.
        again = time.monotonic()
        assert in_turn(jobs, folder / "dask", program, Progress(jobs, io.StringIO())) == {}
        again = time.monotonic() - again
        assert left(folder / "dask") == other
        changed = [{**job, "configuration": "00000000"} for job in jobs]
        refused = in_turn(changed, folder / "dask", program, Progress(jobs, io.StringIO()))
        assert len(refused) == 3 and all("begin the machine anew" in why for why in refused.values()), refused
        page = write(folder / "dask", None).read_text()
        assert all(f"M {machine}" in page for machine in range(3)), page
        print(
            f"{len(one)} files alike, of 3 machines with 3 recordings; one of 2 workers was killed at {killed[0]}. "
            f"One after the other {serial:.1f} s, on Dask {dask:.1f} s, once more {again:.2f} s"
        )


if __name__ == "__main__":
    main(sys.argv[1])
