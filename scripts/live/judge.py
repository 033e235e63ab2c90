"""Says whether what soak.py wrote down was right: prints a table, exits with 1 if anything was not.
May be called again on the same folder."""

import json
import sqlite3
import sys
from bisect import bisect_left, bisect_right
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import cantools
from cantools.autosar.end_to_end import check_profile5_crc

import judge_attacks
from gateway import TOP, line_time
from judge_attacks import AFTER_ATTACK, Attacked

SECOND = 10**9
STATUS, WARNING = 0x1D1, 0x2D1
OWN = {STATUS, WARNING, 0x3D1}
HEALTHY, STALE, STOPPING = 1, 7, 4
PLAUSIBILITY = 4
DETECTORS = [None, "fde1", "fde2", "fde3", "plausibility", "sequential", "process"]
SUSPECTS = ["undecided", "c1", "c2", "process"]
FAULTS = ["unclassified", "abrupt", "noise", "incipient", "out of range", "broken wire", "frozen",
          "stale"]

# What the configuration promises: max_gap, guard and max_age. The rest is what this test bed takes
# to give a process its turn.
SILENT = round(0.1 * SECOND) + round(0.01 * SECOND) + round(0.05 * SECOND)
JAMMED = round(0.2 * SECOND)
# A transducer that steps is not healthy after this.
FOUND = round(0.3 * SECOND)
# A warning of a fault comes with its step or its end, or so much later.
AFTER_FAULT = round(0.5 * SECOND)
# So long (alarm.clear) a warning stands after its residual has gone, and is repeated.
STANDS = round(1.1 * SECOND)
# What takes frames of the gateway away.
TAKERS = {"jam", "link down", "deleted", "bus off"}
# A warning of missing frames comes within this of what took them away.
AFTER_DISTURBANCE = SECOND
# One of the model comes within this of a cycle that the player of the machine lost or spread over
# more than it should, as where the computer was busy: its frames are then of different moments, and
# an observer is believed again after observer.settle.
AFTER_STALL = SECOND
# What waited in the interface's own queue comes out this soon after a jam: a handful of frames.
QUEUED = round(0.1 * SECOND)
BURST, BURST_TIME = 10, round(0.05 * SECOND)
# A standing warning is repeated every second.
REPEATED = round(1.5 * SECOND)
# The longest back-off is 2 s.
BACK = 4 * SECOND


@dataclass
class Span:
    what: str
    begin: int
    end: int

    def has(self, at, after=0):
        return self.begin <= at <= self.end + after


class Run:
    """What was written down, in order."""

    def __init__(self, folder):
        run = json.loads((folder / "run.json").read_text())
        self.run = run
        self.log = (folder / "gateway.log").read_text(errors="replace")
        self.dbc = cantools.database.load_file(TOP / "dbc/e-type.dbc", strict=True)
        self.frames = [(at, identifier, bytes.fromhex(data)) for at, identifier, data in
                       sorted(run["frames"])]
        self.syncs = sorted(run["syncs"])
        self.bus_offs = sorted(at for what, at in run["notes"] if what == "bus-off")
        self.releases = sorted(at for what, at in run["notes"] if what == "release")
        self.kills = sorted(at for what, at in run["notes"] if what == "kill")
        self.disturbances = [Span(*words) for words in run["disturbances"]]
        own = [Span(*words) for words in run["machine"]]
        self.faults = [span for span in own if span.what.startswith("fault")]
        self.attacked = [Attacked(span) for span in own if span.what.startswith("attack")]
        self.machines = [span for span in own if not span.what.startswith(("fault", "attack"))]
        self.statuses, self.warnings = [], []
        for at, identifier, data in self.frames:
            if identifier in (STATUS, WARNING) and len(data) == 8:
                message = self.dbc.get_message_by_frame_id(identifier)
                signals = message.decode(data, decode_choices=False, scaling=False)
                (self.statuses if identifier == STATUS else self.warnings).append((at, signals))
        # The log leaves lines out where many come at once; the event store has them all.
        with sqlite3.connect(folder / "kept.events") as store:
            self.doubts = store.execute("SELECT at_ns, text FROM events WHERE kind = 'doubt' ORDER BY at_ns").fetchall()
        self.status_times = [at for at, _ in self.statuses]

    def said(self, text):
        return [line_time(line) for line in self.log.splitlines() if text in line]

    def of(self, what):
        return [span for span in self.disturbances if span.what == what]

    def attack_on(self, cylinder, begin, end):
        """Whether the cylinder was attacked then, in a way that changes what is known of it."""
        return any(it.harms(cylinder) and it.span.begin <= end and it.span.end >= begin for it in self.attacked)

    def disturbed(self, begin, end):
        """Whether anything but a fault or an attack befell it then. A lost cycle is no excuse."""
        machines = [s for s in self.machines if s.what != "stall" or s.end - s.begin > SECOND // 10]
        return any(span.begin <= end and span.end >= begin for span in self.disturbances + machines)

    def just_released(self, at):
        return any(release <= at <= release + QUEUED for release in self.releases)


def place(cylinder, transducer):
    """Which state of Fd_Status that is."""
    return 2 * (cylinder - 1) + ["c1", "c2"].index(transducer)


def states(data):
    bits = int.from_bytes(data, "little") >> 24
    return [bits >> 2 * i & 3 for i in range(12)]


class Judge:
    def __init__(self, run):
        self.run = run
        self.rows, self.details, self.good = [], [], True
        self.states = [states(data) for _, identifier, data in run.frames
                       if identifier == STATUS and len(data) == 8]

    def row(self, what, found, bad, wanted="0"):
        """`bad`: what contradicts it, a list of lines or times."""
        ok = not bad
        self.good &= ok
        self.rows.append((what, found, wanted, "ok" if ok else "FAILS"))
        self.details += [f"{what}: {line}" for line in bad[:20]]

    def healthy(self, i):
        return self.states[i].count(HEALTHY)

    def seconds(self, at):
        return f"{(at - self.run.frames[0][0]) / SECOND:.3f} s"

    def process(self):
        run = self.run.run
        deaths = [f"at {self.seconds(at)} with {code}" for at, code in run["deaths"]]
        panics = [line for line in self.run.log.splitlines() if "panicked" in line]
        self.row("the gateway ended by itself, or panicked", len(deaths) + len(panics),
                 deaths + panics)
        code = [] if run["code"] == 0 else [f"exit code {run['code']}"]
        last = self.run.statuses[-1][1]["Mode"]
        code += [] if last == STOPPING else [f"its last status has mode {last}"]
        self.row("exit code upon SIGTERM, last status", f"{run['code']}, mode {last}", code,
                 "0, mode 4")
        refused, read = len(self.run.said("the old one stays in force")), len(self.run.said("read again"))
        wrong = [] if (refused, read) == (run["refusals"], run["reloads"]) else ["see the log"]
        self.row("configurations refused, read again", f"{refused}, {read}", wrong,
                 f"{run['refusals']}, {run['reloads']}")

    def own_frames(self):
        foreign = [f"{identifier:X} at {self.seconds(at)}"
                   for at, identifier, data in self.run.frames
                   if identifier not in OWN or len(data) != 8]
        self.row("frames that are not its own", len(foreign), foreign)
        broken = [f"{data.hex()} at {self.seconds(at)}" for at, identifier, data in self.run.frames
                  if identifier in OWN and not check_profile5_crc(data, identifier)]
        self.row("own frames whose E2E does not hold (cantools)", len(broken), broken)
        unheard = self.run.run["unheard"]
        self.row("frames that the listener lost", unheard, ["see run.json"] if unheard else [])

    def first_statuses(self):
        run = self.run
        times = {"start, reopening or reload": run.said("open: "), "bus-off": run.bus_offs}
        for what, moments in times.items():
            bad, seen = [], 0
            for moment in moments:
                i = bisect_right(run.status_times, moment)
                if i == len(self.states) or any(moment < m <= run.status_times[i] for m in moments):
                    continue
                seen += 1
                if self.healthy(i):
                    bad.append(f"{self.healthy(i)} healthy at {self.seconds(run.status_times[i])}")
            self.row(f"first status after a {what}: healthy", f"{len(bad)} of {seen}", bad)

    def off(self):
        """A controller that is bus-off sends nothing; what it is given would burst out."""
        restarts = sorted(at for what, at in self.run.run["notes"] if what == "restarted")
        opened, bad, unheard = self.run.said("open: "), [], 0
        for begin, end in zip(self.run.bus_offs, restarts):
            # A gateway whose port was not open as the error frame came cannot know of it; of a real
            # controller it would be told by netlink as it opens, of a vxcan it is not.
            if any(begin < at < end for at in opened):
                unheard += 1
                continue
            # It may be sending just then.
            bad += [self.seconds(at) for at, *_ in self.run.frames if begin + 10**7 < at < end]
        told = f"{len(bad)} in {len(self.run.bus_offs) - unheard}"
        self.row(f"frames sent while bus-off ({unheard} unheard of left out)", told, bad)

    def silences(self):
        run, bad, looked = self.run, [], 0
        for i, at in enumerate(run.status_times):
            heard = bisect_right(run.syncs, at)
            silent = at - run.syncs[heard - 1] if heard else SECOND * 3600
            limit = SILENT + JAMMED * any(jam.has(at, JAMMED) for jam in run.of("jam"))
            if silent > limit and not run.just_released(at):
                looked += 1
                if self.healthy(i):
                    bad.append(f"{self.healthy(i)} healthy at {self.seconds(at)}, "
                               f"{silent / SECOND:.3f} s after the machine's last cycle")
        self.row("healthy without a word of the machine", f"{len(bad)} of {looked} statuses", bad)

    def faulty_ones(self):
        run, bad, looked, found, blamed, clear = self.run, [], 0, 0, 0, 0
        missed = []
        for fault in run.faults:
            _, cylinder, transducer = fault.what.split()
            cylinder = int(cylinder)
            for i in range(bisect_left(run.status_times, fault.begin + FOUND),
                           bisect_right(run.status_times, fault.end)):
                at = run.status_times[i]
                # An attack may hide it, and takes as long as a fault to be over.
                if run.attack_on(cylinder, at - AFTER_ATTACK, at):
                    continue
                looked += 1
                if self.states[i][place(cylinder, transducer)] == HEALTHY \
                        and not run.just_released(at):
                    disturbed = run.disturbed(fault.begin - 2 * SECOND, at)
                    bad.append(f"{fault.what} of {self.seconds(fault.begin)} is healthy at "
                               f"{self.seconds(at)}{', disturbed' if disturbed else ''}")
            before, found_by = fault.begin - 2 * SECOND, fault.begin + FOUND
            if run.disturbed(before, found_by) or run.attack_on(cylinder, before, found_by):
                continue
            clear += 1
            told = [w for at, w in run.warnings if w["Raised"] and w["Cylinder"] == cylinder
                    and fault.begin <= at <= fault.begin + FOUND]
            found += bool(told)
            blamed += any(SUSPECTS[w["Suspect"]] == transducer for w in told)
            if not told:
                missed.append(f"{fault.what} at {self.seconds(fault.begin)}")
        self.row("healthy while its fault stands", f"{len(bad)} of {looked} statuses", bad)
        self.row("undisturbed faults found within 0.3 s", f"{found}, {blamed} blamed right",
                 missed, f"{clear} of {len(run.faults)}")

    def accounted(self):
        """Each raise, by what it is accounted to."""
        run, accounts, others = self.run, Counter(), []
        standing = {}
        restarts = sorted(run.kills + run.said("was read again"))
        takers = [span for span in run.disturbances if span.what not in ("refuse", "jam")]
        takers += run.machines
        for at, warning in run.warnings:
            detector, suspect = warning["Detector"], warning["Suspect"]
            key = warning["Cylinder"], detector, suspect if detector == PLAUSIBILITY else None
            before = standing.pop(key, None)
            if not warning["Raised"]:
                continue
            standing[key] = at
            # The repetitions of what stands, also over a time in which nothing got out.
            if before and bisect_right(restarts, before) == bisect_right(restarts, at):
                away = sum(min(span.end + AFTER_DISTURBANCE, at) - max(span.begin, before)
                           for span in run.disturbances + run.machines
                           if span.begin < at and span.end + AFTER_DISTURBANCE > before)
                if at - before <= REPEATED + max(0, away):
                    continue
            account = self.account(at, warning, takers)
            accounts[account] += 1
            if account == "other":
                others.append(f"cylinder {key[0]} {DETECTORS[detector]} "
                              f"{FAULTS[warning['Fault']]}, {SUSPECTS[suspect]}, "
                              f"at {self.seconds(at)}; {self.around(at)}")
        told = ", ".join(f"{count} {what}" for what, count in sorted(accounts.items()))
        self.row("warnings raised that nothing accounts for",
                 f"{len(others)} of {sum(accounts.values())}", others)
        return told

    def account(self, at, warning, takers):
        cylinder = warning["Cylinder"]
        causes = [(it, "by a fault", AFTER_FAULT) for it in self.run.faults
                  if int(it.what.split()[1]) == cylinder]
        causes += [(it.span, "by an attack", AFTER_ATTACK) for it in self.run.attacked if it.harms(cylinder)]
        for fault, account, after in causes:
            if fault.has(at, after):
                return account
            # Where its raise was lost with other frames, what is seen first is a repetition; and a
            # gateway that hears nothing learns of its end when it hears again.
            ends = [span.end for span in self.run.disturbances if span.what in TAKERS
                    and span.begin < at and fault.begin < span.end and span.begin < fault.end]
            if ends and fault.begin <= at <= max(*ends, fault.end) + after + STANDS:
                return account
        if warning["Fault"] == STALE:
            for span in takers:
                if span.has(at, AFTER_DISTURBANCE):
                    return f"stale by {span.what}"
        if any(span.what == "stall" and span.has(at, AFTER_STALL) for span in self.run.machines):
            return "by a stall of the player"
        return "other"

    def around(self, at):
        """What was going on then."""
        attacks = [Span(it.attack.name, it.span.begin, it.span.end) for it in self.run.attacked]
        near = [f"{span.what} {(at - span.begin) / SECOND:.2f} s before"
                for span in self.run.disturbances + self.run.machines + self.run.faults + attacks
                if span.begin - SECOND < at < span.end + 3 * SECOND]
        return ", ".join(near) or "nothing was going on"

    def bursts(self):
        run, worst, bad = self.run, 0, []
        times = [at for at, *_ in run.frames]

        def attacked(at):
            """Transducers under attack then or shortly before: a warning of each may begin or end in the first cycle."""
            return sum(len(it.attack.places) for it in run.attacked if it.span.has(at, BACK))

        moments = run.releases + [s.end for w in ("link down", "deleted") for s in run.of(w)]
        for moment in moments:
            # `ip` returns after the interface is up.
            first = bisect_left(times, moment - SECOND // 10)
            for i in range(first, bisect_right(times, moment + SECOND)):
                burst = bisect_right(times, times[i] + BURST_TIME) - i
                burst -= attacked(times[i])
                worst = max(worst, burst)
                if burst > BURST:
                    bad.append(f"{burst} at {self.seconds(times[i])}")
        self.row(f"most frames within 50 ms after {len(moments)} jams and losses, beyond one for each "
                 "transducer attacked", worst, bad, f"up to {BURST}")

    def returns(self):
        run, worst, bad = self.run, 0, []
        for span in run.disturbances:
            heard = bisect_right(run.syncs, span.end)
            if heard == len(run.syncs):
                continue
            spoke = bisect_right(run.status_times, run.syncs[heard])
            if spoke == len(run.status_times):
                continue
            wait = run.status_times[spoke] - run.syncs[heard]
            worst = max(worst, wait)
            if wait > BACK:
                bad.append(f"{wait / SECOND:.1f} s after {span.what} at {self.seconds(span.end)}")
        self.row("longest wait for a status after a disturbance", f"{worst / SECOND:.2f} s", bad,
                 f"up to {BACK / SECOND:.0f} s")

    def evidence(self):
        """That there was something to be wrong about."""
        whole = sum(states.count(HEALTHY) == 12 for states in self.states)
        share = 100 * whole / len(self.states)
        few = [] if share > 10 else ["too few to say anything"]
        self.row("statuses with all transducers healthy", f"{whole} of {len(self.states)}", few,
                 "above 10 %")

    def all(self):
        self.process()
        self.own_frames()
        self.first_statuses()
        self.off()
        self.silences()
        self.faulty_ones()
        told = self.accounted()
        self.bursts()
        self.returns()
        judge_attacks.judge(self, self.run.attacked)
        self.evidence()
        return told


def main():
    run = Run(Path(sys.argv[1]))
    judge = Judge(run)
    told = judge.all()
    counts = Counter(span.what for span in run.disturbances)
    counts.update("fault" if s.what.startswith("fault") else s.what
                  for s in run.faults + run.machines)
    counts.update({"attack": len(run.attacked), "crowd of readers": len(run.run["readers"])})
    print(f"soak of {run.run['seconds']:.0f} s, seed {run.run['seed']}: "
          + ", ".join(f"{count} {what}" for what, count in sorted(counts.items())))
    print(f"{run.run['sent']} frames of the machine, {len(run.frames)} of the gateway, "
          f"{len(run.statuses)} of them statuses and {len(run.warnings)} warnings")
    print(f"warnings raised: {told}")
    print(f"connections of readers: {', '.join(f'{n} {kind}' for kind, n in run.run['connections'].items())}")
    width = max(len(row[0]) for row in judge.rows)
    print(f"{'':{width}}  {'found':>22}  {'wanted':>12}")
    for what, found, wanted, verdict in judge.rows:
        print(f"{what:{width}}  {found:>22}  {wanted:>12}  {verdict}")
    for line in judge.details:
        print(f"  {line}")
    sys.exit(0 if judge.good else 1)


if __name__ == "__main__":
    main()
