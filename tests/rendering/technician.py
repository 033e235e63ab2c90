"""A technician at the page of a running gateway, with a real browser.

    technician.py URL TOKEN AXE PROGRAM [FOLDER]

Chromium is that of the environment's CHROMIUM; AXE is the script of axe-core, PROGRAM
is tertius; FOLDER gets a picture of each view. LAMP_WITHIN of the environment is how soon the lamp has to turn, s, 1
unless set. A fault has to arrive on cylinder 3's C1 while this runs. Writes what was found as JSON, and fails with
what a technician would complain about.
"""

import json
import os
import subprocess
import sys
import tarfile
import tempfile
import threading
import time
import urllib.request

from playwright.sync_api import sync_playwright

URL, TOKEN, AXE, PROGRAM = sys.argv[1:5]
FOLDER = sys.argv[5] if len(sys.argv) > 5 else None
# Cylinder 3 and its C1 as the configuration calls them.
NAMED, TAGGED = "cylinder 3 (<u>Fwd</u>)", "C1 (LT-103A)"
LAMP_WITHIN = float(os.environ.get("LAMP_WITHIN", "1"))
SEEN = {}


def health():
    try:
        with urllib.request.urlopen(f"{URL}/health", timeout=2) as answer:
            return json.load(answer)
    except OSError:
        return None


def watch_health():
    """Notes when the first warning stands."""
    while "warned" not in SEEN:
        found = health()
        if found and found["warnings_standing"] > 0:
            SEEN["warned"] = time.monotonic()
        time.sleep(0.02)


def new_page(browser, width, height, scheme, complaints):
    context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme, accept_downloads=True)
    page = context.new_page()
    page.on("console", lambda it: complaints.append(it.text) if it.type in ("error", "warning") else None)
    page.on("pageerror", lambda it: complaints.append(str(it)))
    page.on("request", lambda it: None if it.url.startswith(URL) else complaints.append(f"asks elsewhere: {it.url}"))
    return page


def first_load(page):
    """Bytes of everything that the first view needs, as sent."""
    total = []
    page.on("requestfinished", lambda it: total.append(it.sizes()["responseBodySize"]))
    page.goto(URL)
    page.wait_for_selector("#view-overview .card .lamp svg")
    return sum(total)


# The longest time by which a timer of the page came late, ms.
HEARTBEAT = """() => {
    window.withheld = 0;
    let before = performance.now();
    setInterval(() => {
        const now = performance.now();
        window.withheld = Math.max(window.withheld, now - before - 50);
        before = now;
    }, 50);
}"""


def tab_to(page, name):
    """Goes to what is called `name` by the keyboard alone."""
    for _ in range(80):
        page.keyboard.press("Tab")
        focused = page.evaluate("() => document.activeElement.getAttribute('aria-label') ?? document.activeElement.textContent")
        if focused and focused.startswith(name):
            return
    raise AssertionError(f"the keyboard does not reach {name!r}")


def fill_by_keyboard(page, texts):
    for text in texts:
        if text is not None:
            page.keyboard.type(text)
        page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    page.wait_for_selector("dialog", state="detached", timeout=8000)


def replayed(archive):
    """The incident that a replay of the downloaded recording tells, and that it was told live."""
    with tempfile.TemporaryDirectory() as folder, tarfile.open(archive) as tar:
        tar.extractall(folder, filter="data")
        (name,) = os.listdir(folder)
        recording = os.path.join(folder, name)
        replay = subprocess.run([PROGRAM, "replay", recording, "--format", "jsonl"], stdout=subprocess.PIPE, check=True)
        with open(os.path.join(recording, "incident.json"), encoding="utf-8") as file:
            manifest = json.load(file)
        live, told = manifest["lines"], [json.loads(line) for line in replay.stdout.splitlines()]
        assert told[-1]["type"] == "summary" and told[-1]["configuration"] == manifest["configuration"], manifest
        # Others may have begun in the same minute.
        told = [line for line in told if line["type"] == "incident" and line["incident"] == live[0]["incident"]]
        assert live and told[: len(live)] == live, f"live {live}, replayed {told}"
        return live[0]["summary"]


def look(page, view, name, findings):
    page.goto(f"{URL}/#{view}")
    page.wait_for_timeout(700)
    width = page.evaluate("() => document.documentElement.scrollWidth - innerWidth")
    assert width <= 0, f"{name}: it is {width} px wider than the screen"
    page.evaluate(open(AXE, encoding="utf-8").read())
    found = page.evaluate("() => axe.run(document, { resultTypes: ['violations'] }).then((it) => it.violations)")
    findings += [f"{name}: {it['impact']}: {it['help']}: {it['nodes'][0]['html'][:160]}" for it in found]
    if FOLDER:
        page.screenshot(path=os.path.join(FOLDER, f"{name}.png"), full_page=True)


def main():
    result, complaints, findings = {}, [], []
    watcher = threading.Thread(target=watch_health, daemon=True)
    watcher.start()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=os.environ["CHROMIUM"], args=["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"])
        page = new_page(browser, 1280, 900, "light", complaints)
        result["first_load_bytes"] = first_load(page)
        assert result["first_load_bytes"] <= 150_000, result

        lamp = page.locator(".card").nth(2).locator(".lamp").first
        assert "failure" not in lamp.get_attribute("class"), "the fault was there before anybody looked"
        page.wait_for_selector(".card:nth-child(3) .lamp.good", timeout=60_000)
        page.evaluate(HEARTBEAT)
        page.wait_for_selector(".card:nth-child(3) .lamp.failure", timeout=60_000, state="visible")
        lit = time.monotonic()
        watcher.join(5)
        result["lamp_after_s"] = round(lit - SEEN["warned"], 3)
        # What a busy computer withheld from the browser is not the page's.
        result["withheld_s"] = round(page.evaluate("() => window.withheld") / 1e3, 3)
        assert result["lamp_after_s"] <= LAMP_WITHIN + result["withheld_s"], result
        assert page.locator("#view-overview .incidents a").first.inner_text().startswith(f"{NAMED}, {TAGGED}")
        # Names are texts, wherever they are shown.
        assert page.locator(".card h3").nth(2).inner_text() == f"C{NAMED[1:]}"
        assert page.locator(".card").nth(2).locator(".transducer .name").all_inner_texts() == [TAGGED, "C2"]
        assert page.locator(".card h3").nth(1).inner_text() == "Cylinder 2"

        # By the keyboard alone: acknowledged, then shelved.
        page.goto(f"{URL}/#alarms")
        page.wait_for_selector("#view-alarms .unacknowledged")
        tab_to(page, "Acknowledge: cylinder 3")
        page.keyboard.press("Enter")
        fill_by_keyboard(page, ["Eva", "the connector is wet", TOKEN])
        page.wait_for_selector("#view-alarms li.acknowledged")
        tab_to(page, "Shelve: cylinder 3")
        page.keyboard.press("Enter")
        fill_by_keyboard(page, [None, "new cable tomorrow", None, None])
        page.wait_for_selector("#view-alarms li.shelved")
        text = page.locator("#view-alarms li.shelved").inner_text()
        assert "Eva" in text and "new cable tomorrow" in text, text
        # The lamp is not muted by it.
        page.goto(f"{URL}/#overview")
        assert "failure" in page.locator(".card").nth(2).locator(".lamp").first.get_attribute("class")

        page.goto(f"{URL}/#incidents")
        page.get_by_label("Words").fill("cylinder 3")
        page.get_by_role("button", name="Search").click()
        page.wait_for_selector("#view-incidents li")
        page.locator("#view-incidents li a").first.click()
        page.wait_for_selector("#view-incidents article h3")
        result["incident"] = page.locator("#view-incidents article h3").first.inner_text()
        number = page.url.rsplit("/", 1)[1]

        # The frames around it, which the gateway writes 5 s after it opened.
        deadline = time.monotonic() + 40
        while page.locator("article a[download]").count() == 0:
            assert time.monotonic() < deadline, "there is no recording of the incident"
            page.wait_for_timeout(500)
            page.reload()
            page.wait_for_selector("#view-incidents article h3")
        with page.expect_download() as download:
            page.locator("article a[download]").first.click()
        result["archive"] = str(download.value.path())

        views = ["overview", "trends/3", "alarms", "incidents", f"incidents/{number}", "maintenance"]
        phone = new_page(browser, 390, 844, "dark", complaints)
        phone.goto(URL)
        phone.wait_for_selector(".card .lamp svg")
        for one, suffix in [(page, "wide-light"), (phone, "phone-dark")]:
            for view in views:
                name = "incident" if view == f"incidents/{number}" else view.split("/")[0]
                look(one, view, f"{name}-{suffix}", findings)
        page.goto(f"{URL}/#maintenance")
        assert page.locator("#view-maintenance tr", has_text=f"C{NAMED[1:]}, {TAGGED}").count() == 1
        assert "Trends of cylinder 3 (<u>Fwd</u>)" == phone.locator("#trends-title").text_content()
        assert page.locator("u").count() == 0, "a name is no markup"
        row = page.locator("#view-maintenance tr", has_text="Calibration").inner_text()
        days = int((time.time() - 1_698_796_800) // 86_400)
        assert row.endswith(f"from recordings until 2023-11-01, {days} days ago"), row

        result["axe"] = findings
        result["complaints"] = complaints
        assert not findings, result
        assert not complaints, result

        # What is not heard of any more is unknown, whatever it was.
        print(json.dumps({"stop": True}), flush=True)
        sys.stdin.readline()
        page.evaluate("() => { location.hash = 'overview' }")
        page.wait_for_function(
            "() => document.querySelectorAll('.card .lamp').length === document.querySelectorAll('.card .lamp.unknown').length",
            timeout=10_000)
        assert "No connection" in page.locator("#condition").inner_text()
        result["replayed"] = replayed(result.pop("archive"))
        browser.close()
    print(json.dumps(result), flush=True)


main()
