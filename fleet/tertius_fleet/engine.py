"""All machines of a plan beside each other, the recordings of each in order."""

import json
import subprocess
import sys
import time
from collections import deque
from contextlib import contextmanager

from .step import Failed, Refused, step

#: How often a step is begun again whose worker died: more than that, and it is the step that kills them.
DEATHS = 3


def planned(program, fleet, quick=False):
    """The jobs of FLEET.toml, as `tertius fleet plan` lists them. Raises Refused with its words."""
    call = [program, "fleet", "plan", str(fleet), "--format", "jsonl", *(["--quick"] if quick else [])]
    ran = subprocess.run(call, capture_output=True, text=True)
    if ran.returncode != 0:
        raise Refused(ran.stderr.strip())
    return [json.loads(line) for line in ran.stdout.splitlines()]


def counted(count, noun):
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


class Progress:
    """Says after each job how far the fleet is."""

    def __init__(self, jobs, out=sys.stderr):
        self.all, self.done, self.out, self.began = len(jobs), 0, out, time.monotonic()
        self.processor, self.recorded = 0.0, 0.0

    def job(self, job, done):
        self.done += 1
        # `tertius fleet run` does not know it.
        self.processor += done["processor_seconds"] or 0.0
        self.recorded += done["duration"]
        gone = time.monotonic() - self.began
        left = gone / self.done * (self.all - self.done)
        note = "" if done["judged"] else "; nothing was judged"
        print(
            f"{self.done} of {self.all}: {job['machine']}, {job['index']} of {job['of']}: "
            f"{counted(done['incidents'], 'incident')} in {done['duration'] / 3600:.2f} h{note}; {left:.0f} s left",
            file=self.out,
        )


def chains(jobs):
    """The jobs of each machine, in order."""
    machines = {}
    for job in jobs:
        machines.setdefault(job["machine"], deque()).append(job)
    return machines


def in_turn(jobs, output, program, progress):
    """Does the jobs one after the other, in this process. Returns what failed, by machine."""
    failures = {}
    for job in jobs:
        if job["machine"] in failures:
            continue
        try:
            progress.job(job, step(job, output, program))
        except (Refused, Failed, OSError) as error:
            failures[job["machine"]] = str(error)
    return failures


def beside(jobs, output, program, progress, client, seen=lambda job: None):
    """Does the jobs on the workers of a Dask `client`, one at a time of each machine. Returns what failed, by machine.

    A machine's next job is given out when the one before is done, so that the graph stays small and the order is kept
    whatever dies. `seen` is called after each job.
    """
    from dask.distributed import as_completed

    waiting, failures = chains(jobs), {}

    def next_of(machine):
        job = waiting[machine].popleft()
        future = client.submit(step, job, output, program, key=f"{machine}-{job['index']}", pure=False)
        future.job = job
        return future

    running = as_completed([next_of(machine) for machine in waiting])
    for future in running:
        job = future.job
        try:
            progress.job(job, future.result())
        except Exception as error:  # A worker's death is an exception of Dask's.
            failures[job["machine"]] = f"{type(error).__name__}: {error}"
            continue
        finally:
            future.release()
        if waiting[job["machine"]]:
            running.add(next_of(job["machine"]))
        seen(job)
    return failures


@contextmanager
def workers(count=None, address=None):
    """A client of so many processes here, or of the scheduler at `address`: a tcp:// address, or a scheduler file."""
    import dask
    from dask.distributed import Client, LocalCluster

    dask.config.set({"distributed.scheduler.allowed-failures": DEATHS})
    if address is not None:
        named = {"address": address} if "://" in address else {"scheduler_file": address}
        with Client(**named) as client:
            client.upload_file(packed())
            yield client
        return
    local = {"n_workers": count, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    with LocalCluster(**local) as cluster, Client(cluster) as client:
        yield client


def packed():
    """This package as a file for workers elsewhere."""
    import tempfile
    import zipfile
    from pathlib import Path

    here = Path(__file__).parent
    target = Path(tempfile.mkdtemp()) / "tertius_fleet.zip"
    with zipfile.ZipFile(target, "w") as archive:
        for file in sorted(here.glob("*.py")):
            archive.write(file, f"{here.name}/{file.name}")
    return str(target)
