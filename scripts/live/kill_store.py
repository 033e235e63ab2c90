"""Kills a gateway while incidents come, and examines its event store. See scripts/kill-store."""

import argparse
import json
import pathlib
import random
import signal
import sqlite3
import subprocess
import sys
import time
from datetime import datetime, timezone

TOP = pathlib.Path(__file__).resolve().parents[2]
# An incident that stood for so long before the kill has to be there, s.
STOOD = 1.0
# The recording is played so much faster, so that incidents come all the time.
SPEED = "60"


def configuration(folder: pathlib.Path) -> pathlib.Path:
    text = (TOP / "tests/recordings/e-type.toml").read_text()
    text = text.replace('"can0"', '"virtual"')
    text = text.replace('"../../dbc/e-type.dbc"', json.dumps(str(TOP / "dbc/e-type.dbc")))
    store = '[store]\nfile = "kept.events"\n\n[http]\nlisten = "off"\n\n'
    path = folder / "machine.toml"
    path.write_text(store + text)
    return path


def told(log: pathlib.Path, before: float) -> set[int]:
    """Numbers of the incidents that the log told of before that time, s since 1970."""
    numbers = set()
    for line in log.read_text().splitlines():
        try:
            entry = json.loads(line)
        except json.JSONDecodeError:
            continue  # The last line may be cut.
        fields = entry.get("fields", entry)
        if "incident" not in fields or not fields.get("message", "").startswith("incident opened"):
            continue
        stamp = datetime.fromisoformat(entry["timestamp"].replace("Z", "+00:00"))
        if stamp.astimezone(timezone.utc).timestamp() < before:
            numbers.add(int(fields["incident"]))
    return numbers


def examine(store: pathlib.Path, expected: set[int], number: int) -> list[str]:
    if not store.exists():
        return [f"kill {number}: no store, but {len(expected)} incidents"] if expected else []
    database = sqlite3.connect(f"file:{store}?mode=ro", uri=True)
    (run,) = database.execute("SELECT max(id) FROM runs").fetchone() or (None,)
    kept = {row[0] for row in database.execute("SELECT number FROM incidents WHERE run = ?", [run])}
    faults = [f"kill {number}: incidents {sorted(expected - kept)} are missing"] * bool(expected - kept)
    if number % 10 == 0:
        (sound,) = database.execute("PRAGMA integrity_check").fetchone()
        faults += [f"kill {number}: {sound}"] * (sound != "ok")
    database.close()
    return faults


def main() -> int:
    parser = argparse.ArgumentParser()
    for name, kind in [("--kills", int), ("--seed", int), ("--binary", str), ("--folder", str)]:
        parser.add_argument(name, type=kind, required=True)
    options = parser.parse_args()
    folder = pathlib.Path(options.folder)
    config, store = configuration(folder), folder / "kept.events"
    chance = random.Random(options.seed)
    recording = str(TOP / "tests/recordings/e-type-faults.log.zst")
    command = [options.binary, "run", "--config", str(config), "--log", "json"]
    command += ["--play", recording, "--speed", SPEED]
    faults, checked, runs = [], 0, 0
    for number in range(1, options.kills + 1):
        log = folder / f"{number}.log"
        with log.open("w") as out:
            gateway = subprocess.Popen(command, stdout=out, stderr=out)
        time.sleep(chance.uniform(1.2, 7.0))
        killed = time.time()
        gateway.send_signal(signal.SIGKILL)
        gateway.wait()
        text = log.read_text()
        for trouble in ("set aside", "is not written", "panicked"):
            faults += [f"kill {number}: {trouble}"] * (trouble in text)
        # Before anything is known of its run there is nothing of it to be missed.
        if "the event store is" not in text:
            continue
        runs += 1
        expected = told(log, killed - STOOD)
        checked += len(expected)
        faults += examine(store, expected, number)
    left = [path.name for path in folder.glob("*aside*")]
    print(f"{options.kills} kills, {runs} of them with the store open: {checked} incidents looked for, "
          f"{len(faults)} faults, {len(left)} files set aside")
    for fault in faults:
        print(fault)
    return 1 if faults or left or not checked else 0


if __name__ == "__main__":
    sys.exit(main())
