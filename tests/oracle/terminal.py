"""A person at `tertius monitor`, on a pseudo-terminal of 80 columns and 24 lines, read by an independent emulator.

    terminal.py gateway PROGRAM URL PID
    terminal.py bus PROGRAM CONFIG
    terminal.py words PROGRAM WORDS ARGUMENT...

`gateway` watches the gateway at URL, on whose cylinder 3 a fault of C1 has to arrive while this runs; at the end it
kills the gateway's process PID. `bus` listens to the bus of CONFIG until all is judged. `words` calls `monitor ARGUMENT...`
until WORDS are on the screen. Writes what was found as JSON,
and fails with what a person would complain about.
"""

import fcntl
import json
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import threading
import time
import urllib.request

import pyte

COLOUR = re.compile(rb"\x1b\[[0-9;]*m")
LAMPS = "⊗▼▲◆●"
PATIENCE = 60


class Terminal:
    """A program on a pseudo-terminal, and what it shows there."""

    def __init__(self, arguments, columns=80, lines=24, **environment):
        self.screen = pyte.Screen(columns, lines)
        self.stream = pyte.ByteStream(self.screen)
        self.raw = b""
        # When something came.
        self.bursts = []
        self.fd, self.tty = pty.openpty()
        self.resize(columns, lines)
        self.before = termios.tcgetattr(self.tty)
        given = {"TERM": "xterm-256color", "LANG": "C.UTF-8", "LC_ALL": "C.UTF-8", "PATH": os.environ["PATH"]}
        given.update(environment)
        self.process = subprocess.Popen(
            arguments, stdin=self.tty, stdout=self.tty, stderr=self.tty, env=given, start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0))

    def resize(self, columns, lines):
        fcntl.ioctl(self.fd, termios.TIOCSWINSZ, struct.pack("HHHH", lines, columns, 0, 0))
        self.screen.resize(lines, columns)

    def read(self, seconds):
        """Takes what comes within this time."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            if not select.select([self.fd], [], [], left)[0]:
                return
            piece = os.read(self.fd, 65536)
            now = time.monotonic()
            if not self.bursts or now - self.bursts[-1][1] > 0.05:
                self.bursts.append([now, now])
            self.bursts[-1][1] = now
            self.raw += piece
            self.stream.feed(piece)

    def text(self):
        return "\n".join(line.rstrip() for line in self.screen.display)

    def wait(self, what, until, seconds=PATIENCE):
        """Waits until the screen is so; returns the time of it."""
        end = time.monotonic() + seconds
        while not until(self.text()):
            if time.monotonic() > end or self.process.poll() is not None:
                raise AssertionError(f"no {what} on the screen:\n{self.text()}")
            self.read(0.05)
        return time.monotonic()

    def press(self, keys):
        os.write(self.fd, keys.encode())

    def end(self, code):
        """Waits for the end, after which the terminal is as it was."""
        self.read(1.0)
        found = self.process.wait(timeout=10)
        assert found == code, f"it ended with {found}, not {code}:\n{self.text()}"
        assert self.raw.rfind(b"\x1b[?1049l") > self.raw.rfind(b"\x1b[?1049h") >= 0, "the other screen stayed"
        assert self.raw.rfind(b"\x1b[?25h") > self.raw.rfind(b"\x1b[?25l") >= 0, "the cursor stayed away"
        assert termios.tcgetattr(self.tty) == self.before, "the terminal was left in another mode"


def row(text, number):
    """The line of a cylinder."""
    return next((line for line in text.splitlines() if re.match(rf"[> ]{number} ", line)), "")


def standing(url, seen):
    """Notes when the first warning stands."""
    while "warned" not in seen:
        try:
            with urllib.request.urlopen(f"{url}/health", timeout=2) as answer:
                if json.load(answer)["warnings_standing"] > 0:
                    seen["warned"] = time.monotonic()
        except OSError:
            pass
        time.sleep(0.02)


def colours(raw):
    """The colours that are set in these bytes."""
    codes = [code for found in COLOUR.findall(raw) for code in found[2:-1].split(b";") if code]
    return [int(code) for code in codes if int(code) in (*range(30, 39), *range(40, 49), *range(90, 98), *range(100, 108))]


def keys(terminal):
    terminal.press("\x1b[B\x1b[B")
    terminal.wait("selection of cylinder 3", lambda text: row(text, 3).startswith(">3"))
    terminal.press("s")
    terminal.wait("cylinder 3 first", lambda text: row(text, 3) == text.splitlines()[4])
    terminal.press("s")
    terminal.wait("cylinder 1 first", lambda text: row(text, 1) == text.splitlines()[4])
    terminal.press("z")
    terminal.wait("zoom", lambda text: text.splitlines()[3].startswith("Cylinder 3") and "Incidents" not in text)
    terminal.press("\x1b")
    terminal.wait("way back", lambda text: "Incidents" in text)
    terminal.press("?")
    terminal.wait("help", lambda text: "no evidence, neither good nor bad" in text)
    terminal.press("?")
    terminal.wait("way back", lambda text: "Incidents" in text)
    terminal.press(" ")
    terminal.wait("FROZEN", lambda text: "FROZEN since" in text)
    frozen = terminal.text().splitlines()[1:]
    terminal.read(1.5)
    assert terminal.text().splitlines()[1:] == frozen, "a frozen picture moved"
    terminal.press(" ")
    terminal.wait("way on", lambda text: "FROZEN" not in text)
    terminal.resize(110, 34)
    terminal.wait("wide picture", lambda text: len(max(text.splitlines(), key=len)) > 100)
    terminal.resize(60, 12)
    terminal.wait("word on its size", lambda text: "60 columns and 12 lines" in text)
    terminal.resize(80, 24)
    terminal.wait("whole picture", lambda text: row(text, 6) != "")


def refusals(program, url):
    """What cannot be drawn on is refused in words."""
    piped = subprocess.run([program, "monitor", url], capture_output=True, text=True, check=False)
    assert piped.returncode == 2 and "no terminal" in piped.stderr, piped
    dumb = Terminal([program, "monitor", url], TERM="dumb")
    dumb.read(1.0)
    assert dumb.process.wait(timeout=10) == 2 and "TERM" in dumb.text(), dumb.text()
    assert b"\x1b" not in dumb.raw, dumb.raw


def gateway(program, url, pid):
    result, seen = {}, {}
    threading.Thread(target=standing, args=(url, seen), daemon=True).start()
    terminal = Terminal([program, "monitor", url])
    terminal.wait("good lamp", lambda text: row(text, 3).startswith(" 3 ● good"))
    assert "warned" not in seen, "the fault was there before anybody looked"
    lit = terminal.wait("failure", lambda text: row(text, 3).startswith(" 3 ⊗ failure"))
    result["lamp_after_s"] = round(lit - seen["warned"], 3)
    assert result["lamp_after_s"] <= 1.0, result
    terminal.wait("incident", lambda text: re.search(r"^ (yellow|orange|red|black) +cylinder 3, C1", text, re.M))
    assert colours(terminal.raw), "there are colours"

    # A slow line: what goes over it while nothing is pressed.
    terminal.read(1.0)
    bursts, bytes_before, wiped = len(terminal.bursts), len(terminal.raw), terminal.raw.count(b"\x1b[2J")
    terminal.read(5.0)
    result["redraws_per_s"] = (len(terminal.bursts) - bursts) / 5
    result["bytes_per_s"] = (len(terminal.raw) - bytes_before) // 5
    assert result["redraws_per_s"] <= 5.2, result
    assert result["bytes_per_s"] <= 4000, result
    assert terminal.raw.count(b"\x1b[2J") == wiped, "it was wiped to be drawn again"

    keys(terminal)
    terminal.press("q")
    terminal.end(0)
    plain = Terminal([program, "monitor", url], NO_COLOR="1")
    plain.wait("failure", lambda text: "⊗ failure" in row(text, 3))
    assert not colours(plain.raw), colours(plain.raw)
    plain.process.send_signal(signal.SIGTERM)
    plain.end(0)
    ascii_only = Terminal([program, "monitor", url], LC_ALL="C")
    ascii_only.wait("failure", lambda text: "X failure" in row(text, 3))
    assert ascii_only.raw.isascii()
    ascii_only.press("\x03")
    ascii_only.end(0)
    refusals(program, url)
    broken = Terminal([program, "monitor", url])
    broken.wait("failure", lambda text: "⊗ failure" in row(text, 3))
    # The line breaks, as that of ssh does.
    os.close(broken.fd)
    os.close(broken.tty)
    broken.process.wait(timeout=10)

    lonely = Terminal([program, "monitor", url])
    lonely.wait("failure", lambda text: "⊗ failure" in row(text, 3))
    os.kill(pid, signal.SIGKILL)
    killed = time.monotonic()
    lost = lonely.wait("word on the loss", lambda text: "trying again" in text and not any(lamp in text for lamp in LAMPS))
    result["unknown_after_s"] = round(lost - killed, 3)
    assert result["unknown_after_s"] <= 4.0, result
    assert "level unknown" in lonely.text(), lonely.text()
    lonely.press("q")
    lonely.end(0)
    return result


def bus(program, config):
    terminal = Terminal([program, "monitor", "--config", config])
    judged = lambda text: all(row(text, number).count("● good") == 2 for number in range(1, 7))
    terminal.wait("good lamps", judged)
    result = {"screen": terminal.text()}
    terminal.press("q")
    terminal.end(0)
    return result


def words(program, wanted, *arguments):
    terminal = Terminal([program, "monitor", *arguments], columns=200)
    terminal.wait(wanted, lambda text: wanted in text)
    result = {"screen": terminal.text()}
    terminal.press("q")
    terminal.end(0)
    return result


def main():
    what, program, *rest = sys.argv[1:]
    if what == "gateway":
        result = gateway(program, rest[0], int(rest[1]))
    else:
        result = {"bus": bus, "words": words}[what](program, *rest)
    print(json.dumps(result))


main()
