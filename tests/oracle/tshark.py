"""Compares our captures with Wireshark's tshark and editcap; see scripts/tshark.

    tshark.py TERTIUS [LOG…]
"""

import os
import random
import subprocess
import sys
import tempfile

LENGTHS = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64]
# Classes of errors in the order of their bits.
CLASSES = ["tx_timeout", "lostarb", "ctrl", "prot", "trx", "ack", "busoff", "buserror", "restarted"]
# What would take payloads for something that it knows.
GUESSES = ["signal_pdu", "obd-ii", "autosar-nm", "ipdum"]
FIELDS = ["frame.time_epoch", "frame.interface_name", "can.id", "can.flags.xtd", "can.flags.rtr", "can.len"]
FIELDS += ["canfd.flags.brs", "canfd.flags.esi", "data.data", "can.flags.err", "can.err.reserved"]
FIELDS += [f"can.err.{name}" for name in CLASSES]


def made(path):
    """Frames of every kind, at times to the nanosecond."""
    chance = random.Random(1)
    nanos = 1_700_000_000_000_000_000
    with open(path, "w", encoding="ascii") as log:
        for _ in range(20_000):
            nanos += chance.randrange(1, 2_000_000)
            extended = chance.random() < 0.5
            word = f"{chance.randrange(1 << 29):08X}" if extended else f"{chance.randrange(1 << 11):03X}"
            kind = chance.choice(["data", "data", "fd", "remote", "error"])
            if kind == "fd":
                text = f"{word}##{chance.randrange(4):X}" + chance.randbytes(chance.choice(LENGTHS)).hex().upper()
            elif kind == "remote":
                length = chance.randrange(9)
                text = f"{word}#R{length or ''}"
            elif kind == "error":
                text = f"{1 << 29 | chance.randrange(1, 1 << 9):08X}#" + chance.randbytes(8).hex().upper()
            else:
                text = f"{word}#" + chance.randbytes(chance.randrange(9)).hex().upper()
            print(f"({nanos // 10**9}.{nanos % 10**9:09}) can{chance.randrange(3)} {text}", file=log)


def run(*call):
    return subprocess.run(call, check=True, capture_output=True, text=True).stdout


def lines(path):
    """A log's lines, with times in nanoseconds."""
    with open(path, encoding="ascii") as log:
        for line in log:
            stamp, interface, frame = line.split()[:3]
            seconds, decimals = stamp.strip("()").split(".")
            yield int(seconds) * 10**9 + int(decimals.ljust(9, "0")), interface, frame


def told(capture):
    """A capture's frames as tshark tells them, written as candump writes them; of error frames without their data."""
    call = ["tshark", "-r", capture, "-T", "fields", "-E", "separator=,"]
    for guess in GUESSES:
        call += ["--disable-protocol", guess]
    for field in FIELDS:
        call += ["-e", field]
    for line in run(*call).splitlines():
        stamp, interface, identifier, extended, remote, length, switch, state, data, error, *classes = line.split(",")
        seconds, decimals = stamp.split(".")
        nanos = int(seconds) * 10**9 + int(decimals.ljust(9, "0"))
        if error == "1":
            word = int(classes[0] or "0", 0) << len(CLASSES) | 1 << 29
            word |= sum((bit == "1") << place for place, bit in enumerate(classes[1:]))
            yield nanos, interface, f"{word:08X}#{length}"
            continue
        identifier = int(identifier)
        word = f"{identifier:08X}" if extended == "1" else f"{identifier:03X}"
        if switch:
            flags = int(switch) | int(state) << 1
            text = f"{word}##{flags:X}{data.upper()}"
        elif remote == "1":
            text = f"{word}#R" + (length if length != "0" else "")
        else:
            text = f"{word}#{data.upper()}"
        assert remote == "1" or len(data) == 2 * int(length), line
        yield nanos, interface, text


def without_errors_data(frames):
    for nanos, interface, frame in frames:
        word, _, data = frame.partition("#")
        is_error = len(word) == 8 and int(word, 16) >> 29 & 1
        yield nanos, interface, f"{word}#{len(data) // 2}" if is_error else frame


def compare(what, ours, theirs):
    ours, theirs = list(ours), list(theirs)
    differing = [pair for pair in zip(ours, theirs) if pair[0] != pair[1]]
    for pair in differing[:5]:
        print(f"{what}: {pair[0]} is {pair[1]}", file=sys.stderr)
    number = len(differing) + abs(len(ours) - len(theirs))
    print(f"| {what} | {len(ours)} | {len(theirs)} | {number} |", flush=True)
    return number


def main(tertius, logs):
    failures = 0
    print(f"{run('tshark', '--version').splitlines()[0]}\n")
    print("| what | frames of ours | frames of Wireshark | differing |\n| --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as folder:
        path = lambda name: os.path.join(folder, name)  # noqa: E731
        made(path("made.log"))
        for log in [path("made.log"), *logs]:
            name = os.path.basename(log)
            plain, capture = path("plain.log"), path("ours.pcapng")
            run(tertius, "convert", log, plain, "--force")
            run(tertius, "convert", log, capture, "--force")
            frames = list(lines(plain))
            what = f"{name}, pcapng of ours in tshark"
            failures += compare(what, without_errors_data(frames), told(capture))
            for form, unit, named in [("pcapng", 1, True), ("nsecpcap", 1, False), ("pcap", 1000, False)]:
                theirs, back = path("theirs"), path("back.log")
                run("editcap", "-F", form, capture, theirs)
                run(tertius, "convert", theirs, back, "--force")
                # A pcap has no names, and times in its unit.
                expected = [(n // unit * unit, i if named else "if0", frame) for n, i, frame in frames]
                failures += compare(f"{name}, {form} of editcap in ours", lines(back), expected)
    return failures > 0


sys.exit(main(sys.argv[1], sys.argv[2:]))
