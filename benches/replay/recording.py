"""A long recording, made by repeating a short one.

    recording.py SOURCE.log.zst REPETITIONS TARGET…

Time stamps go on by the source's own length, rounded to its cycle, and alive counters count on, so
that nothing is missing and nothing jumps where one repetition follows the other. Each TARGET is
written plain, or compressed where it ends in .gz or .zst.
"""

import contextlib
import gzip
import sys

import zstandard

CYCLE = 0.02  # s

# Byte in which a message of the default layout counts its cycles.
COUNTER = {0x080: 0, 0x1C1: 3}
COUNTER |= {base + n: 5 for base in (0x180, 0x190) for n in range(1, 7)}


def parts(line):
    """The second, the text up to the counter, the counter or None, the text behind it."""
    second, rest = int(line[1:11]), line[11:]
    data = rest.index(b"#") + 1
    byte = COUNTER.get(int(rest[data - 4 : data - 1], 16))
    if byte is None:
        return second, rest, None, b""
    at = data + 2 * byte
    return second, rest[:at], int(rest[at : at + 2], 16), rest[at + 2 :]


def length(lines):
    """Of one repetition: seconds, which must be whole, and cycles."""
    cycles = sum(b" 080#" in line for line in lines)
    seconds = cycles * CYCLE
    if abs(seconds - round(seconds)) > 1e-9:
        sys.exit(f"{cycles} cycles are no whole number of seconds: repeat another recording")
    return round(seconds), cycles


def repeated(lines, repetitions):
    """The pieces of the long recording, one for each repetition."""
    seconds, cycles = length(lines)
    split = [parts(line) for line in lines]
    for repetition in range(repetitions):
        later, more = repetition * seconds, repetition * cycles
        piece = []
        for second, before, counter, behind in split:
            if counter is None:
                piece.append(b"(%d%b" % (second + later, before))
            else:
                count = (counter + more) % 256
                piece.append(b"(%d%b%02X%b" % (second + later, before, count, behind))
        yield b"".join(piece)


def opened(path):
    if path.endswith(".gz"):
        return gzip.open(path, "wb", compresslevel=6)
    if path.endswith(".zst"):
        return zstandard.open(path, "wb", cctx=zstandard.ZstdCompressor(level=3))
    return open(path, "wb")


def main():
    source, repetitions, *targets = sys.argv[1:]
    with zstandard.open(source, "rb") as file:
        lines = file.read().splitlines(keepends=True)
    with contextlib.ExitStack() as stack:
        files = [stack.enter_context(opened(path)) for path in targets]
        for piece in repeated(lines, int(repetitions)):
            for file in files:
                file.write(piece)


if __name__ == "__main__":
    main()
