"""A page in Chromium that complains of nothing and fetches nothing, for tests."""

import io
import os
import shutil
import unittest
from pathlib import Path

from PIL import Image, ImageChops
from playwright.sync_api import sync_playwright

PAGES = Path(__file__).resolve().parents[2] / "target" / "tmp" / "report"
SHOTS = PAGES / "shots"
DESKTOP, PHONE = (1200, 900), (360, 740)

# Everything that can be worked with by keyboard.
INTERACTIVE = "a[href], button, select, input, summary, [tabindex='0']"


def chromium():
    """The Chromium of this machine, or nothing."""
    named = os.environ.get("SUNDOG_CHROMIUM")
    return named or shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


class Browser(unittest.TestCase):
    """Opens pages; what they complain of or fetch fails the test at its end."""

    @classmethod
    def setUpClass(cls):
        if chromium() is None:
            return
        SHOTS.mkdir(parents=True, exist_ok=True)
        cls.playwright = sync_playwright().start()
        # Chromium's own sandbox does not work for root and in containers; the pages are ours.
        cls.browser = cls.playwright.chromium.launch(executable_path=chromium(), args=["--no-sandbox"])

    @classmethod
    def tearDownClass(cls):
        if chromium() is None:
            return
        cls.browser.close()
        cls.playwright.stop()

    def setUp(self):
        self.complaints, self.contexts = [], []
        # (Test by test, so that each is named as skipped.)
        if chromium() is None:
            self.skipTest("there is no Chromium on this machine (apt-get install chromium)")

    def tearDown(self):
        for context in self.contexts:
            context.close()
        self.assertEqual(self.complaints, [])

    def open(self, name="page.html", size=DESKTOP, scheme="light", **options):
        """The page, opened in a window of its own without a network."""
        path = PAGES / name
        self.assertTrue(path.exists(), f"{path} is not there: run cargo test first")
        context = self.browser.new_context(
            viewport={"width": size[0], "height": size[1]}, color_scheme=scheme, offline=True, **options)
        self.contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: self.complaints.append(f"console: {message.text}"))
        page.on("pageerror", lambda error: self.complaints.append(f"error: {error}"))

        def requested(request):
            if not request.url.startswith("data:") and request.url.split("#")[0] != path.as_uri():
                self.complaints.append(f"fetches {request.url[:200]}")

        page.on("request", requested)
        page.goto(path.as_uri())
        page.wait_for_function("document.documentElement.classList.contains('js')")
        return page

    def shoot(self, page, name, **options):
        """A screenshot, kept, as a picture."""
        data = page.screenshot(path=str(SHOTS / f"{name}.png"), **options)
        return Image.open(io.BytesIO(data)).convert("RGB")


def center(locator):
    """Where to point at an element."""
    box = locator.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def differ(a, b):
    """How many pixels of two screenshots differ by more than 8 code values."""
    if a.size != b.size:
        return max(a.size[0] * a.size[1], b.size[0] * b.size[1])
    difference = ImageChops.difference(a, b).convert("L")
    return sum(count for value, count in enumerate(difference.histogram()) if value > 8)
