"""One recording of one machine: the unchanged program, from the state before it to the state behind it.

A step may be done any number of times, in any process: what it leaves takes its place by renaming, and its `.done` comes
last. A step whose `.done` is there is done, and is not done again.
"""

import json
import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

#: How often a step is tried that failed for a reason outside of the call, such as a full disk.
ATTEMPTS = 3


class Refused(Exception):
    """The call or a file is wrong: trying again would change nothing."""


class Failed(Exception):
    """The program failed; it may go better next time."""


def folder_of(output, machine):
    """The folder with what is handed on from one recording of a machine to the next."""
    return Path(output) / "folded" / machine


def name_of(index):
    return f"{index:06d}"


def identity(job):
    """What the result of a job depends on, but for the program."""
    it = {key: job[key] for key in ("machine", "index", "recording", "configuration")}
    if not job["is_url"]:
        found = os.stat(job["recording"])
        it["bytes"], it["modified"] = found.st_size, found.st_mtime_ns
    return it


def step(job, output, program, attempts=ATTEMPTS):
    """Does a job of the plan below the folder `output` with the `program`, and returns what its `.done` says.

    Raises Refused where the call or a file is wrong, and Failed after so many `attempts`.
    """
    folder = folder_of(output, job["machine"])
    folder.mkdir(parents=True, exist_ok=True)
    name, mine = name_of(job["index"]), identity(job)
    done = known(folder / f"{name}.done")
    if done is not None:
        if done["of"] != mine:
            raise Refused(
                f"{folder / name}.done is of another recording or configuration than the plan's "
                f"{job['recording']}; to begin the machine anew, delete {folder}"
            )
        return done
    if job["index"] > 1 and known(folder / f"{name_of(job['index'] - 1)}.done") is None:
        raise Refused(f"machine {job['machine']}: recording {job['index']} comes before the one ahead of it")
    for attempt in range(1, attempts + 1):
        try:
            return attempted(job, folder, Path(output), program, mine, attempt)
        except Failed:
            if attempt == attempts:
                raise
            time.sleep(0.5 * 2**attempt)


def known(path):
    try:
        return json.loads(path.read_text())
    except FileNotFoundError:
        return None


def attempted(job, folder, output, program, mine, attempt):
    """One attempt, in a folder of its own: another process may be doing the same job."""
    name, before = name_of(job["index"]), name_of(job["index"] - 1)
    with tempfile.TemporaryDirectory(prefix=f".{name}.", dir=folder) as scratch:
        scratch = Path(scratch)
        state, dwells = scratch / "state", scratch / "dwells"
        copy(folder / f"{before}.state", state)
        history = []
        if job["history"] is not None:
            copy(job["history"] if job["index"] == 1 else folder / f"{before}.dwells", dwells)
            history = ["--history", str(dwells)]
        seen = inode(state)
        call = [program, *job["arguments"], "--state", str(state), *history]
        call += ["--parquet", str(output / "columns")]
        began = time.monotonic()
        code, used, said = called(call, job, scratch / "lines")
        seconds = time.monotonic() - began
        summary = last_line(scratch / "lines")
        # Where nothing was judged the exit code is 1, and the state was left all the same.
        told = code == 1 and summary is not None and (inode(state) != seen or summary["frames"] == 0)
        if code == 2:
            raise Refused(f"machine {job['machine']}, {job['recording']}: {said}")
        if code != 0 and not told:
            raise Failed(f"machine {job['machine']}, {job['recording']}: exit code {code}: {said}")
        settle(scratch / "lines", folder / f"{name}.jsonl")
        settle(dwells, folder / f"{name}.dwells")
        settle(state, folder / f"{name}.state")
        done = {
            "of": mine,
            "exit": code,
            "said": said,
            "attempts": attempt,
            "seconds": round(seconds, 3),
            "processor_seconds": round(used, 3),
            "duration": summary["duration"],
            "judged": summary["judged"],
            "incidents": summary["incidents"],
        }
        (scratch / "done").write_text(json.dumps(done) + "\n")
        settle(scratch / "done", folder / f"{name}.done")
    # From here on nobody goes on from the state before, and whoever died at the job before has left its folder.
    for old in (folder / f"{before}.state", folder / f"{before}.dwells"):
        old.unlink(missing_ok=True)
    for old in folder.glob(f".{before}.*"):
        shutil.rmtree(old, ignore_errors=True)
    return done


def called(call, job, lines):
    """Runs the program; its exit code, the processor time that it used, s, and what it said."""
    with open(lines, "wb") as out, tempfile.TemporaryFile() as said:
        source = subprocess.PIPE if job["is_url"] else subprocess.DEVNULL
        running = subprocess.Popen(call, stdin=source, stdout=out, stderr=said)
        if job["is_url"]:
            fetched(job["recording"], running)
        _, status, usage = os.wait4(running.pid, 0)
        running.returncode = os.waitstatus_to_exitcode(status)
        said.seek(0)
        text = said.read().decode(errors="replace").strip()
    return running.returncode, usage.ru_utime + usage.ru_stime, text[-2000:]


def fetched(url, running):
    """Passes what is at a URL on to the program."""
    import fsspec

    try:
        with fsspec.open(url, "rb") as source:
            shutil.copyfileobj(source, running.stdin, 1 << 20)
    except BrokenPipeError:
        pass  # The program says why.
    except Exception as error:
        running.kill()
        raise Failed(f"{url}: {error}") from error
    finally:
        try:
            running.stdin.close()
        except BrokenPipeError:
            pass


def last_line(path):
    """The summary, where the program came to its end."""
    with open(path, "rb") as lines:
        lines.seek(0, os.SEEK_END)
        lines.seek(max(0, lines.tell() - (1 << 20)))
        tail = lines.read().splitlines()
    try:
        line = json.loads(tail[-1]) if tail else {}
    except ValueError:
        return None
    return line if line.get("type") == "summary" else None


def copy(source, target):
    if os.path.exists(source):
        shutil.copyfile(source, target)


def inode(path):
    return os.stat(path).st_ino if os.path.exists(path) else None


def settle(source, target):
    if os.path.exists(source):
        os.replace(source, target)
