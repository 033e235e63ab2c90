"""A technician at the page of a gateway on a real SocketCAN; run by scripts/technician, see there."""

import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

import bus
import machine
from gateway import Gateway, configuration

TOP = Path(__file__).resolve().parents[2]
INTERFACE = "page0"
TOKEN = "c8d1f0a3c8d1f0a3c8d1f0a3c8d1f0a3"
# When cylinder 3's C1 is 4 mm off, s: the browser takes half a minute to start there.
AT = 60.0
# The gateway, the machine and a browser of ten processes share the one processor of User-mode Linux, s.
LAMP_WITHIN = "5"


def settings():
    digest = hashlib.sha256(TOKEN.encode()).hexdigest()
    return f"""
[http]
listen = "127.0.0.1:9481"
token = "{digest}"
[store]
file = "events.db"
[recorder]
folder = "recordings"
before = 10.0
after = 5.0
"""


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--binary", required=True)
    parser.add_argument("--axe", required=True)
    options = parser.parse_args()
    bus.ip("link", "set", "up", "lo")
    bus.add_vcan(INTERFACE)
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        gateway = Gateway(options.binary, folder, configuration(INTERFACE, settings()))
        gateway.start_and_wait()
        # Before the browser: it is another computer's work, and must not wait for it.
        played = machine.Machine(INTERFACE, machine.cycles(250.0, 650.0))
        threading.Timer(AT, played.fault, (3, "c1", 0.004)).start()
        technician = [sys.executable, TOP / "tests/rendering/technician.py", "http://127.0.0.1:9481", TOKEN]
        technician = subprocess.Popen([*technician, options.axe, options.binary], stdin=subprocess.PIPE,
                                      stdout=subprocess.PIPE, text=True,
                                      env={**os.environ, "LAMP_WITHIN": LAMP_WITHIN})
        said = technician.stdout.readline()
        print(said.strip(), flush=True)
        code = 0
        if "stop" in said:
            played.stop()
            code = gateway.stop()
            technician.stdin.write("\n")
            technician.stdin.close()
            print(json.dumps(json.loads(technician.stdout.readline()), indent=2), flush=True)
        code = code or technician.wait()
        for line in gateway.log().splitlines()[-12:]:
            print(line)
    sys.exit(code)


main()
