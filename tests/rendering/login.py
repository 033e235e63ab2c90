"""A person who logs in to a gateway's page over https, with a real browser.

    login.py PORT TOKEN AXE

Chromium is that of the environment's CHROMIUM; AXE is the script of axe-core. The gateway asks whoever comes for its
token. Writes what was found as JSON, and fails with what the person would complain about.
"""

import json
import os
import sys

from playwright.sync_api import sync_playwright

PORT, TOKEN, AXE = sys.argv[1:]
# As from another computer: a page at this one's own addresses does not offer to log out.
URL = f"https://box.test:{PORT}"


def look(page, name, findings):
    page.evaluate(open(AXE, encoding="utf-8").read())
    found = page.evaluate("() => axe.run(document, { resultTypes: ['violations'] }).then((it) => it.violations)")
    findings += [f"{name}: {it['impact']}: {it['help']}: {it['nodes'][0]['html'][:160]}" for it in found]
    width = page.evaluate("() => document.documentElement.scrollWidth - innerWidth")
    assert width <= 0, f"{name}: it is {width} px wider than the screen"


def visit(browser, width, height, scheme, findings):
    context = browser.new_context(
        viewport={"width": width, "height": height}, color_scheme=scheme, ignore_https_errors=True)
    page = context.new_page()
    errors = []
    page.on("pageerror", lambda it: errors.append(str(it)))
    page.on("request", lambda it: None if it.url.startswith(URL) else errors.append(f"asks elsewhere: {it.url}"))

    page.goto(f"{URL}/")
    assert page.url == f"{URL}/login", page.url
    look(page, f"login {scheme}", findings)
    assert page.evaluate("() => document.activeElement.name") == "token", "one can type at once"
    page.keyboard.type("not the token")
    page.keyboard.press("Enter")
    page.wait_for_function("() => document.querySelector('[role=alert]').textContent.includes('not the token')")
    look(page, f"refused {scheme}", findings)
    assert context.cookies() == [], context.cookies()

    page.keyboard.type(TOKEN)
    page.keyboard.press("Enter")
    page.wait_for_selector("#view-overview .card .lamp.good", timeout=60_000)
    assert page.url.split("#")[0] == f"{URL}/", page.url
    (cookie,) = context.cookies()
    assert cookie["httpOnly"] and cookie["secure"] and cookie["sameSite"] == "Strict", cookie
    look(page, f"overview {scheme}", findings)

    page.get_by_role("button", name="Log out").click()
    page.wait_for_url(f"{URL}/login")
    assert context.cookies() == [], context.cookies()
    page.goto(f"{URL}/#trends/1")
    assert page.url.startswith(f"{URL}/login"), page.url
    context.close()
    assert not errors, errors


def main():
    findings = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=os.environ["CHROMIUM"],
            args=["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--host-resolver-rules=MAP box.test 127.0.0.1"])
        visit(browser, 1280, 900, "light", findings)
        visit(browser, 390, 844, "dark", findings)
        browser.close()
    assert not findings, findings
    print(json.dumps({"logged_in": 2, "axe": findings}))


main()
