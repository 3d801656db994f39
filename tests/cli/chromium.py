# SPDX-License-Identifier: MIT
"""A real browser for tests of pages: Chromium of the distribution, driven by Playwright for Python."""

import shutil
import unittest

try:
    from playwright.sync_api import sync_playwright
except ImportError:
    sync_playwright = None

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
# Nothing but the page itself; pictures in three dimensions are drawn by the processor.
ARGUMENTS = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
             "--disable-sync", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


def required(test):
    """Skips what needs the browser where there is none."""
    test = unittest.skipIf(sync_playwright is None, "Playwright for Python is not installed")(test)
    return unittest.skipIf(CHROMIUM is None, "there is no Chromium here")(test)


def launch(test_class):
    """A browser until the tests of the class are over."""
    driver = sync_playwright().start()
    test_class.addClassCleanup(driver.stop)
    browser = driver.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
    test_class.addClassCleanup(browser.close)
    return browser


def watch(page, own):
    """What the page complains of, and what it asks for that is not its own; filled while it is used."""
    complaints = []
    page.on("console", lambda message: complaints.append(message.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("request", lambda request: request.url.startswith((own, "data:", "blob:")) or complaints.append(request.url))
    return complaints
