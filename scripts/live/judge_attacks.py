"""The checks of judge.py for a gateway whose bus is attacked and whose page has hostile readers."""

from bisect import bisect_left, bisect_right

from attacks import C1, TrueReadings
from gateway import limits
from machine import attack_of

SECOND = 10**9
HEALTHY = 1
# The lamps of an attack that must be seen are no longer green after this, from its begin or from whatever else befell the
# gateway meanwhile; some take longer to be told from a healthy machine, in s.
SEEN = 0.5
LONGER = {
    # A rod at rest reads the same; the command has to travel first.
    "all twelve frozen, the counters go on": 6.0,
    "both of one cylinder frozen": 6.0,
    # 1.5 mm of C1 − C2.
    "C1 drifts by 1 mm/s": 3.0,
    # It is valid for a second.
    "the platform's state does not come": 1.2,
}
# Attacks that this machine cannot notice: it has neither tables of spool and pressures nor sequential ones.
UNSEEN = {
    "all twelve of ten seconds before instead",
    "the command of one cylinder is zero",
    "the command of one cylinder reversed",
}
# After an attack all is healthy again within this: what stands clears in 1.1 s, a contradiction is doubted for 1 s.
OVER = 3 * SECOND
# A warning by an attack comes with it, or so much later.
AFTER_ATTACK = round(1.5 * SECOND)
# The log lines for the beginning and the end of an attack, by words of its name; `{id}` is that of C1.
TOLD = {
    "a second C1 with length 2": ("frames 0x{id} are too short", "frames 0x{id} are no longer too short"),
    "cut off": ("frames 0x{id} are too short", "frames 0x{id} are no longer too short"),
    "a second": ("frames 0x{id} contradict each other", "frames 0x{id} no longer contradict"),
    "the same": ("frames 0x{id} contradict each other", "frames 0x{id} no longer contradict"),
    "comes first": ("frames 0x{id} contradict each other", "frames 0x{id} no longer contradict"),
    "at random": ("frames 0x{id} does not count", "frames 0x{id} counts again"),
    "18 more Syncs": ("arrives more often than once per cycle", "arrives once per cycle again"),
    "no Sync": ("is missing in more than half of the cycles", "(0x080) arrives again"),
    "forged": ("another device sends frames 0x1D1", "no other device sends frames 0x1D1"),
}
# An attack that lasts this long has to be logged.
LEAST = 3 * SECOND
# Fd_Status is sent every 0.1 s.
LATE = 3 * SECOND // 10


class Attacked:
    """An attack, from the first cycle that it changed until the first that is as it was."""

    def __init__(self, span):
        _, kind, seed = span.what.split()
        self.span = span
        self.attack = attack_of(int(kind), int(seed))
        self.cylinders = {place // 2 + 1 for place in self.attack.places}
        self.keeps_readings = isinstance(self.attack.why, TrueReadings)
        self.must_be_seen = self.attack.why is None and self.attack.name not in UNSEEN
        self.seen = round(LONGER.get(self.attack.name, SEEN) * SECOND)

    def harms(self, cylinder):
        """Whether it changes what is known of that cylinder; the machine, where it is 0."""
        return not self.keeps_readings and (cylinder == 0 or cylinder in self.cylinders)


def judge(judge, attacked):
    """Adds what is asked of the attacks to the rows of `judge`."""
    green(judge, attacked)
    told(judge, attacked)
    over(judge, attacked)
    on_time(judge)
    sizes(judge)


def green(judge, attacked):
    run, bad, looked, kinds = judge.run, [], 0, set()
    opened = run.said("open: ")
    for it in attacked:
        if not it.must_be_seen:
            continue
        for i in range(bisect_left(run.status_times, it.span.begin + it.seen), bisect_right(run.status_times, it.span.end)):
            at = run.status_times[i]
            is_new = any(at - it.seen <= moment <= at for moment in opened)
            if is_new or run.disturbed(at - it.seen, at) or run.just_released(at):
                continue
            looked += 1
            kinds.add(it.attack.name)
            places = [place for place in it.attack.places if judge.states[i][place] == HEALTHY]
            if places:
                bad.append(f"{it.attack.name}, cylinder {places[0] // 2 + 1}, {(at - it.span.begin) / SECOND:.2f} s after it "
                           f"began at {judge.seconds(it.span.begin)}")
    judge.row(f"green under an attack, {len(kinds)} kinds", f"{len(bad)} of {looked} statuses", bad)


def calm(run, span):
    """The longest part of it in which nothing else befell the gateway, and its interface was open."""
    befell = [(it.begin, it.end) for it in run.disturbances + run.machines if it.what != "stall"]
    befell += [(at, at) for at in run.said("open: ")] + [(span.begin, span.begin), (span.end, span.end)]
    inside = sorted(it for it in befell if it[1] >= span.begin and it[0] <= span.end)
    parts, last = [], span.begin
    for begin, end in inside:
        parts.append((last, begin))
        last = max(last, end)
    return max(parts, key=lambda part: part[1] - part[0])


def told(judge, attacked):
    run, missed, looked = judge.run, [], 0
    for it in attacked:
        texts = next((texts for words, texts in TOLD.items() if words in it.attack.name), None)
        begin, end = calm(run, it.span)
        if texts is None or end - begin < LEAST:
            continue
        looked += 1
        texts = [text.format(id=f"{C1[it.attack.places[0] // 2]:X}") for text in texts]
        raised, ended = ([at for at, told in run.doubts if text in told] for text in texts)
        # It may stand since an attack before.
        last = max((at for at in raised if at <= end + SECOND), default=None)
        if last is None or any(last < at < begin for at in ended + run.kills):
            missed.append(f"{it.attack.name} at {judge.seconds(begin)}")
    judge.row("attacks that are not told", f"{len(missed)} of {looked}", missed)


def over(judge, attacked):
    run, bad, looked = judge.run, [], 0
    for it in attacked:
        begin, end = it.span.end - SECOND // 2, it.span.end + OVER
        i = bisect_left(run.status_times, end)
        others = [other.span for other in attacked if other is not it and other.cylinders & it.cylinders]
        faults = [fault for fault in run.faults if int(fault.what.split()[1]) in it.cylinders]
        # After a lost cycle an observer has to settle again.
        stalls = [it for it in run.machines if it.has(end, SECOND)]
        is_befallen = run.disturbed(begin, end) or stalls
        is_befallen = is_befallen or any(s.begin <= end and s.end >= begin for s in others + faults)
        # The recording begins with a platform that is not monitored.
        anew = max((it.end for it in run.machines if it.what == "wrap" and it.end <= end), default=0)
        since = bisect_left(run.status_times, anew)
        is_befallen = is_befallen or not any(HEALTHY in judge.states[j] for j in range(since, i + 1))
        if i == len(run.status_times) or is_befallen:
            continue
        looked += 1
        odd = [place for place in it.attack.places if judge.states[i][place] != HEALTHY]
        if odd:
            bad.append(f"{it.attack.name}, over at {judge.seconds(it.span.end)}: cylinder {odd[0] // 2 + 1}; "
                       f"{judge.around(end)}")
    judge.row(f"attacks that are not over after {OVER // SECOND} s", f"{len(bad)} of {looked}", bad)


def on_time(judge):
    run, late, looked, worst = judge.run, [], 0, 0
    for before, at in zip(run.status_times, run.status_times[1:]):
        if run.disturbed(before - SECOND, at):
            continue
        looked += 1
        worst = max(worst, at - before)
        if at - before > LATE:
            late.append(f"{(at - before) / SECOND:.3f} s at {judge.seconds(at)}")
    judge.row(f"statuses later than {LATE / SECOND:.1f} s, at most {worst / SECOND:.2f} s", f"{len(late)} of {looked}", late)


def sizes(judge):
    memory, tasks = limits()
    found = [(resident, threads) for _, resident, threads in judge.run.run["sizes"]]
    most, threads = (max(values) for values in zip(*found))
    judge.row("memory at the most", f"{most / 1024:.1f} MiB", [] if most << 10 <= memory else ["see run.json"],
              f"{memory >> 20} MiB")
    judge.row("threads at the most", threads, [] if threads <= tasks else ["see run.json"], f"{tasks}")
