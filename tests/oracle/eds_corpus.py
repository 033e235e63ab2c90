"""Compares two readers over EDS files and prints a table in Markdown.

  eds_corpus.py FOLDER READER

READER is the program of examples/eds_objects.rs; the other reader is canopen (eds.py). Of two lines that
describe a variable everything is compared: object type, data type, access, PDO mapping, default, value,
limits and name; and the identifiers and mappings of all PDOs that are on. Of variables that CompactSubObj makes, which canopen does not keep, see `essence`.
"""

import pathlib
import subprocess
import sys

import eds


def blocks(text):
    """The lines of each file."""
    found = {}
    for line in text.splitlines():
        if line.startswith("file\t"):
            lines = found.setdefault(line[5:], [])
        else:
            lines.append(line)
    return found


def compact_addresses(theirs):
    return {line.split("\t")[1] for line in theirs if line.startswith("compact\t")}


def essence(line, compact):
    """What is compared: all, but for a variable of CompactSubObj its types, access and default, and for
    their number its types."""
    parts = line.removeprefix("compact\t").split("\t")
    if parts[0] in compact:
        return tuple(parts[:3] if parts[0].endswith(":00") else parts[:4] + parts[5:6])
    return tuple(parts)


def row(name, ours, theirs):
    findings = [line for line in ours if line.startswith("finding")]
    errors = sum(line.startswith("finding\tError") for line in findings)
    ours = [line for line in ours if not line.startswith("finding")]
    refused = [lines[0].split("\t")[1] if lines and lines[0].startswith("refused") else None
               for lines in (ours, theirs)]
    compact = compact_addresses(theirs)
    mine, other = ({essence(line, compact) for line in lines} for lines in (ours, theirs))
    pdos = sum(line.startswith("pdo") for line in theirs)
    if any(refused):
        verdict = "not compared"
    elif mine == other:
        verdict = f"equal, {pdos} PDO{'s' * (pdos != 1)} too" if pdos else "equal"
    else:
        verdict = f"{len(mine ^ other)} lines differ"
        for line in sorted(mine ^ other):
            print(f"{name}: {'ours' if line in mine else 'theirs'}: {line}", file=sys.stderr)
    count = sum(line.startswith("0x") for line in ours)
    told = f"refused: {refused[0]}" if refused[0] else f"{count} variables"
    counts = [(len(findings) - errors, "warning"), (errors, "error")]
    noted = ", ".join(f"{n} {what}{'s' * (n > 1)}" for n, what in counts if n) or "none"
    return [name, told, noted, f"refused: {refused[1]}" if refused[1] else "read", verdict]


def main():
    folder, reader = pathlib.Path(sys.argv[1]), sys.argv[2]
    paths = sorted(str(path) for path in folder.rglob("*")
                   if path.suffix.lower() in (".eds", ".dcf"))
    run = lambda command: subprocess.run(command, check=True, capture_output=True, text=True).stdout
    ours = blocks(run([reader, *paths]))
    theirs = blocks(run([sys.executable, eds.__file__, *paths]))
    rows = [row(str(pathlib.Path(path).relative_to(folder)), ours[path], theirs[path])
            for path in paths]
    print("| file | read | findings | canopen | compared |\n| --- | --- | --- | --- | --- |")
    for cells in rows:
        print("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    read = sum(not cells[1].startswith("refused") for cells in rows)
    theirs_read = sum(cells[3] == "read" for cells in rows)
    equal = sum(cells[4].startswith("equal") for cells in rows)
    print(f"\n{len(rows)} files: {read} read; canopen reads {theirs_read}, {equal} of them equally.")


main()
