"""`tertius run` as a process: its configuration, its log, its counts."""

import configparser
import re
import signal
import subprocess
import time
import urllib.request
from datetime import datetime, timezone
from pathlib import Path

TOP = Path(__file__).resolve().parents[2]
PORT = 9481  # of its own HTTP server, unless it is configured otherwise
UNIT = TOP / "config/systemd/tertius.service"
PLACE = re.compile(r"receive buffer (\d+) KiB")


def configuration(interface, extra=""):
    """That of the recordings, on `interface`."""
    text = (TOP / "tests/recordings/e-type.toml").read_text()
    text = text.replace('"can0"', f'"{interface}"')
    text = text.replace('"../../dbc/e-type.dbc"', f'"{TOP / "dbc/e-type.dbc"}"')
    return f"{text}\n{extra}"


def limits():
    """Memory, bytes, and number of threads, as the unit gives them."""
    unit = configparser.ConfigParser(strict=False, interpolation=None)
    unit.optionxform = str
    unit.read(UNIT)
    memory = unit["Service"]["MemoryMax"]
    assert memory.endswith("M"), memory
    return int(memory[:-1]) << 20, int(unit["Service"]["TasksMax"])


class Gateway:
    """Not started yet. `before` is what runs it, such as /usr/bin/time."""

    def __init__(self, binary, folder, text, before=()):
        self.config, self.log_path = folder / "machine.toml", folder / "gateway.log"
        self.command = [*before, str(binary), "run", "--config", str(self.config)]
        self.configure(text)
        self.process = None

    def configure(self, text):
        self.config.write_text(text)

    def start(self):
        with open(self.log_path, "ab") as log:
            self.process = subprocess.Popen(self.command, stdin=subprocess.DEVNULL, stdout=log,
                                            stderr=log)

    def start_and_wait(self):
        """Until it has opened its interface."""
        before = self.said("open: ")
        self.start()
        wait_for("the gateway's start", lambda: self.said("open: ") > before)

    def log(self):
        return self.log_path.read_text(errors="replace") if self.log_path.exists() else ""

    def said(self, text):
        return self.log().count(text)

    def times_of(self, text):
        """When it said lines with `text`: ns since 1970."""
        return [line_time(line) for line in self.log().splitlines() if text in line]

    def receive_buffer(self):
        """Bytes, as the kernel counts them."""
        return int(PLACE.findall(self.log())[-1]) * 1024

    def pid(self):
        """Its own, where something runs it."""
        children = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text()
        return int(children.split()[0]) if children.split() else self.process.pid

    def counts(self):
        """Its totals by their names, from its own HTTP server."""
        with urllib.request.urlopen(f"http://127.0.0.1:{PORT}/metrics", timeout=30) as answer:
            text = answer.read().decode()
        totals = re.findall(r"^tertius_(\w+)_total (\d+)$", text, re.MULTILINE)
        return {name: int(value) for name, value in totals}

    def stop(self):
        """By SIGTERM; its exit code."""
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(timeout=30)

    def kill(self):
        self.process.kill()
        self.process.wait()


def line_time(line):
    text = line.split()[0].rstrip("Z")
    at = datetime.strptime(text, "%Y-%m-%dT%H:%M:%S.%f").replace(tzinfo=timezone.utc)
    since = at - datetime(1970, 1, 1, tzinfo=timezone.utc)
    return (since.days * 86400 + since.seconds) * 10**9 + since.microseconds * 1000


def wait_for(what, done, seconds=60):
    end = time.monotonic() + seconds
    while not done():
        if time.monotonic() > end:
            raise SystemExit(f"{what} took more than {seconds} s")
        time.sleep(0.05)
