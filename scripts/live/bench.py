"""Load, latency and nominal load of the live gateway; run by scripts/bench-live, see there."""

import argparse
import sys
from pathlib import Path

import latency
import load
import nominal

parser = argparse.ArgumentParser(prog="scripts/bench-live")
parser.add_argument("what", nargs="*", help="load, latency, nominal; all of them unless named")
parser.add_argument("--seconds", type=float, default=600, help="of nominal load")
parser.add_argument("--binary", type=Path, required=True)
parser.add_argument("--echo", type=Path, required=True)
options = parser.parse_args()
known = {
    "load": lambda: load.measure(options.binary),
    "latency": lambda: latency.measure(options.binary, options.echo),
    "nominal": lambda: nominal.measure(options.binary, options.seconds),
}
wrong = [name for name in options.what if name not in known]
if wrong:
    parser.error(f"'{wrong[0]}' is none of {', '.join(known)}")
good = True
for name in options.what or known:
    good &= known[name]()
    sys.stdout.flush()
sys.exit(0 if good else 1)
