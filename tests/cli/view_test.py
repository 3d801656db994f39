#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""mmlins view: what it refuses, what it serves, and the page in a real browser, of a run whose two maps were merged.

The browser is Chromium, driven by Playwright for Python; where one of them is missing these tests are skipped and say so.
"""

import contextlib
import hashlib
import json
import os
import pathlib
import re
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.error
import urllib.request

import chromium
from program import MMLINS, mmlins, shared


def has_page():
    """Whether the program was built with npm."""
    return "without the viewer" not in mmlins("view", shared("nothing")).stderr


@contextlib.contextmanager
def viewing(*arguments):
    """The address at which a run is shown."""
    process = subprocess.Popen([MMLINS, "view", *arguments, "--no-browser"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        line = process.stdout.readline()
        url = re.search(r"http://\S+/", line)
        assert url, line + process.stderr.read()
        yield url.group(), process
    finally:
        process.terminate()
        process.communicate()


def get(url, **headers):
    with urllib.request.urlopen(urllib.request.Request(url, headers=headers), timeout=20) as answer:
        return answer.read()


def status_of(url, method="GET", **headers):
    try:
        return urllib.request.urlopen(urllib.request.Request(url, headers=headers, method=method), timeout=20).status
    except urllib.error.HTTPError as error:
        return error.code


def setUpModule():
    """Dark for 21 s on the way round; then the place of the beginning comes again, and the two maps are joined."""
    if not has_page():
        print("mmlins was built without the viewer (there was no npm): nothing to test")
        sys.exit(77)
    for command in (["simulate", "demo", "--out", shared("loop"), "--set", "duration=65", "--set", "sensor.columns=160",
                     "--set", "trajectory.stand_still=1.5", "--set", "events=[{kind: blackout, start: 20, duration: 21}]"],
                    ["run", shared("loop/recording.bag"), "--rig", shared("loop/rig.yaml"), "--out", shared("out")]):
        result = mmlins(*command)
        assert result.returncode == 0, result.stderr


class Refusals(unittest.TestCase):
    def refused(self, *arguments):
        """The one line that it is."""
        result = mmlins("view", *arguments)
        self.assertEqual(result.returncode, 1, result.stderr)
        lines = result.stderr.strip().splitlines()
        self.assertEqual(len(lines), 1, result.stderr)
        self.assertEqual(result.stdout, "")
        return lines[0]

    def half(self, *missing):
        folder = os.path.join(tempfile.mkdtemp(dir=shared("")), "out")
        shutil.copytree(shared("out"), folder)
        for name in missing:
            path = os.path.join(folder, name)
            shutil.rmtree(path) if os.path.isdir(path) else os.remove(path)
        return folder

    def test_a_folder_that_is_no_result(self):
        self.assertIn("there is no such folder", self.refused(shared("nothing")))
        self.assertIn("is not the result of a run", self.refused(shared("loop")))
        self.assertIn("is not a folder", self.refused(shared("loop/recording.bag")))

    def test_a_result_that_is_half_written(self):
        self.assertIn("there are no maps in it", self.refused(self.half("atlas")))
        self.assertIn("has not come to its end (trajectory.tum is missing)", self.refused(self.half("trajectory.tum")))
        self.assertIn("has not come to its end (summary.json is missing)", self.refused(self.half("summary.json")))

    def test_an_index_that_is_damaged(self):
        folder = self.half()
        with open(os.path.join(folder, "atlas/index.sqlite"), "wb") as file:
            file.write(b"nonsense" * 1000)
        self.assertIn("index.sqlite", self.refused(folder))

    def test_a_port_in_use(self):
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            port = str(taken.getsockname()[1])
            self.assertIn(f"port {port} of 127.0.0.1 is in use", self.refused(shared("out"), "--port", port))

    def test_an_address_of_nobody(self):
        self.assertIn("--listen nobody", self.refused(shared("out"), "--listen", "nobody"))
        self.assertIn("192.0.2.1", self.refused(shared("out"), "--listen", "192.0.2.1"))

    def test_a_port_that_is_none(self):
        self.assertEqual(mmlins("view", shared("out"), "--port", "70000").returncode, 2)


class Answers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.url, _ = cls.enterClassContext(viewing(shared("out")))

    def test_the_scene_agrees_with_the_files(self):
        scene = json.loads(get(self.url + "api/scene"))
        with open(shared("out/summary.json")) as file:
            summary = json.load(file)
        self.assertEqual(scene["name"], "out")
        self.assertFalse(scene["live"])
        self.assertEqual(len(scene["scans"]["t"]), summary["scans"])
        self.assertEqual(len(scene["scans"]["pose"]), 7 * summary["scans"])
        self.assertEqual(len(scene["atlas"]["keyframes"]["id"]), summary["mapping"]["keyframes"])
        self.assertEqual(len(scene["atlas"]["maps"]), len(summary["maps"]))
        with open(shared("out/merges.json")) as file:
            merges = json.load(file)
        self.assertEqual([(m["map"], m["into"]) for m in scene["atlas"]["merges"]], [(m["map"], m["into"]) for m in merges])
        told = {edge["closure"] for edge in scene["atlas"]["edges"]}
        self.assertTrue({evidence["closure"] for evidence in merges[0]["evidence"]} <= told)

    def test_tiles_hold_every_point_once(self):
        atlas = json.loads(get(self.url + "api/scene"))["atlas"]
        count = 0
        for _, first, last, points in atlas["blocks"]:
            tiles = [get(f"{self.url}api/tiles/{first}-{last}/{level}") for level in range(5)]
            counts = [struct.unpack_from("<I", tiles[0], 12 + 8 * level)[0] for level in range(5)]
            self.assertEqual([(len(tile) - 68) / 10 for tile in tiles], counts)
            self.assertEqual(sum(counts), points)
            count += points
        self.assertEqual(count, sum(atlas["keyframes"]["points"]))

    def test_bad_requests(self):
        for path, status in (("api/tiles/0-1/9", 400), ("api/tiles/x", 400), ("api/tiles/90000-90001/0", 404), ("secret", 404), ("api/live", 404)):
            self.assertEqual(status_of(self.url + path), status, path)
        self.assertEqual(status_of(self.url, "POST"), 405)
        self.assertEqual(status_of(self.url, "DELETE"), 405)

    def test_other_names_and_pages_are_not_answered(self):
        self.assertEqual(status_of(self.url, Host="example.org"), 403)
        self.assertEqual(status_of(self.url + "api/scene", Host="localhost"), 200)

    def test_nonsense_does_not_end_it(self):
        port = int(re.search(r":(\d+)/", self.url).group(1))
        for nonsense in (b"\x00\xff\x16\x03", b"GET / HTTP/1.1\r\n" + b"X: y\r\n" * 5000, b"GET http://[ HTTP/9.9\r\n\r\n"):
            with socket.create_connection(("127.0.0.1", port), timeout=5) as connection:
                with contextlib.suppress(OSError):
                    connection.sendall(nonsense)
        self.assertEqual(status_of(self.url), 200)

    def test_nothing_outside_is_asked_for(self):
        page = get(self.url).decode()
        self.assertNotRegex(page, r"(?:src|href)=[\"']https?:")
        with urllib.request.urlopen(self.url) as answer:
            self.assertIn("default-src 'none'", answer.headers["Content-Security-Policy"])


class Ending(unittest.TestCase):
    def test_ctrl_c_ends_it_and_the_folder_is_as_before(self):
        def sums():
            return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in pathlib.Path(shared("out")).rglob("*")
                    if path.is_file() and path.suffix not in (".sqlite-shm", ".sqlite-wal")}
        before = sums()
        for number in (signal.SIGINT, signal.SIGTERM):
            with viewing(shared("out")) as (url, process):
                get(url + "api/scene")
                get(url + "api/tiles/0-3/4")
                process.send_signal(number)
                self.assertEqual(process.wait(timeout=10), 0)
        self.assertEqual(sums(), before)
        self.assertEqual(sorted(os.listdir(shared("out/atlas"))), ["index.sqlite", "points_0000.chunk", "writer.lock"])


@chromium.required
class Browser(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.url, _ = cls.enterClassContext(viewing(shared("out")))
        cls.browser = chromium.launch(cls)
        cls.page = cls.new_page(900, 560, "dark")

    @classmethod
    def new_page(cls, width, height, scheme):
        context = cls.browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme, accept_downloads=True)
        cls.addClassCleanup(context.close)
        page = context.new_page()
        page.complaints = chromium.watch(page, cls.url)
        page.goto(cls.url)
        return page

    def open(self, page=None):
        """A page with all points, which must neither complain nor ask others for anything. Most tests share one."""
        page = page or self.page
        self.settle(page)
        page.evaluate("""() => { mmlins.timeline.isPlaying = false; mmlins.measure.toggle(false); mmlins.colourBy = 'height';
                                 mmlins.closeMerge(); mmlins.timeline.set(mmlins.timeline.end); mmlins.stage.show(mmlins.box(), 'aslant', true); }""")
        self.settle(page)
        self.addCleanup(lambda: self.assertEqual(page.complaints, []))
        return page

    def settle(self, page):
        """Until everything has come and stands still."""
        deadline = time.monotonic() + 40
        while not page.evaluate("Boolean(window.mmlins?.scene && mmlins.cloud.isComplete && mmlins.stage.isAtRest)"):
            self.assertLess(time.monotonic(), deadline, "it never comes to rest")
            page.wait_for_timeout(50)

    def picture(self, page):
        """Width, height and RGBA bytes of what is drawn."""
        return page.evaluate("""() => {
            const source = mmlins.stage.renderer.domElement, canvas = document.createElement('canvas');
            mmlins.stage.render(1e7, true);
            canvas.width = 200; canvas.height = 150;
            const context = canvas.getContext('2d');
            context.drawImage(source, 0, 0, 200, 150);
            return [...context.getImageData(0, 0, 200, 150).data];
        }""")

    @staticmethod
    def difference(a, b):
        """Share of the bytes that differ visibly."""
        return sum(abs(x - y) > 12 for x, y in zip(a, b)) / len(a)

    def test_the_map_is_drawn(self):
        page = self.open()
        full = self.picture(page)
        total = sum(page.evaluate("mmlins.scene.atlas.keyframes.points"))
        self.assertGreater(page.evaluate("mmlins.cloud.drawn"), 0.2 * total)
        page.uncheck("#show-points")
        self.assertGreater(self.difference(full, self.picture(page)), 0.2)
        page.check("#show-points")
        self.assertLess(self.difference(full, self.picture(page)), 0.01)

    def test_each_way_to_colour_looks_different(self):
        page = self.open()
        pictures = {}
        for mode in ("height", "intensity", "map", "time"):
            page.click(f"[data-colour={mode}]")
            pictures[mode] = self.picture(page)
        for a in pictures:
            for b in pictures:
                if a < b:
                    self.assertGreater(self.difference(pictures[a], pictures[b]), 0.05, f"{a} and {b}")

    def test_the_slider_replays_how_maps_grew_fell_asleep_and_were_joined(self):
        page = self.open()
        end = self.picture(page)

        def at(t):
            page.locator("#slider").evaluate("(slider, t) => { slider.value = t; slider.dispatchEvent(new Event('input')); }", t)
            self.settle(page)
            return self.picture(page), page.locator("#maps").inner_text()

        early, maps = at(10)
        self.assertIn("awake", maps)
        self.assertIn("not yet", maps)
        dark, maps = at(38)
        self.assertRegex(maps, r"Map 0\s+asleep")
        between, maps = at(44)
        self.assertRegex(maps, r"Map 0\s+asleep")
        self.assertRegex(maps, r"Map 1\s+awake")
        late, maps = at(65)
        self.assertRegex(maps, r"Map 0\s+awake")
        self.assertRegex(maps, r"Map 1\s+awake, in world 0")
        for a, b in ((early, dark), (dark, between), (between, late)):
            self.assertGreater(self.difference(a, b), 0.02)
        self.assertLess(self.difference(late, end), 0.02)

    def test_it_plays(self):
        page = self.open()
        page.click("#play")  # at the end: from the beginning
        page.wait_for_timeout(1200)
        self.assertGreater(page.evaluate("mmlins.timeline.t"), 1)
        page.keyboard.press("End")
        page.evaluate("mmlins.timeline.isPlaying = false")

    def test_a_merge_shows_its_evidence_and_the_clouds_before_and_after(self):
        page = self.open()
        page.click("[data-merge]")
        self.settle(page)
        text = page.locator("#evidence").inner_text()
        with open(shared("out/merges.json")) as file:
            merge = json.load(file)[0]
        self.assertIn(f"Merge: map {merge['map']} into map {merge['into']}", text)
        shown = page.locator("#evidence tbody tr td:first-child").all_text_contents()
        self.assertEqual(shown, [str(evidence["closure"]) for evidence in merge["evidence"]])
        self.assertIn(f"{100 * merge['evidence'][0]['overlap']:.0f} %", text)
        after = self.picture(page)
        moved = page.evaluate("[...mmlins.poses.current]")
        page.click("[data-side=before]")
        self.settle(page)
        self.assertGreater(self.difference(after, self.picture(page)), 0.01)
        before = page.evaluate("[...mmlins.poses.current]")
        # The merge moved the other map by as much as is on record, apart from what the optimisation did within it.
        step = max(abs(a - b) for a, b in zip(moved, before))
        size = sum(merge["moved_by"][axis] ** 2 for axis in "xyz") ** 0.5
        self.assertGreater(step, 0.3 * size)
        page.locator("#evidence tbody tr").first.click()
        page.keyboard.press("Escape")
        self.assertFalse(page.locator("#evidence").is_visible())

    def test_a_merge_can_be_opened_in_the_scene_and_on_the_timeline(self):
        page = self.open()
        page.click("[data-flag]")
        self.assertTrue(page.locator("#evidence").is_visible())
        page.click("#evidence .close")
        page.click("#lanes .mark")
        self.assertTrue(page.locator("#evidence").is_visible())

    def test_a_distance_is_measured(self):
        page = self.open()
        page.keyboard.press("t")
        page.wait_for_timeout(900)
        self.settle(page)
        page.click("#measure")
        # Two keyframes, as points of the ground below them are as far from each other as they are, to within its slope.
        box = page.locator("#stage canvas").bounding_box()
        at = page.evaluate("[3, 20].map(i => mmlins.stage.project(mmlins.poses.current.subarray(7 * i, 7 * i + 3)))")
        true = page.evaluate("(() => { const p = mmlins.poses.current; return Math.hypot(p[140] - p[21], p[141] - p[22]); })()")
        for point in at:
            page.mouse.click(box["x"] + point["x"], box["y"] + point["y"])
        label = page.locator(".label.measure").inner_text()
        level = float(re.search(r"level ([\d.]+) m", label).group(1))
        self.assertAlmostEqual(level, true, delta=0.15 * true)
        page.keyboard.press("Escape")
        self.assertEqual(page.locator(".label.measure").count(), 0)

    def test_a_screenshot_is_a_picture(self):
        page = self.open()
        with page.expect_download() as download:
            page.click("#screenshot")
        self.assertRegex(download.value.suggested_filename, r"^out_\d+\.\ds\.png$")
        with open(download.value.path(), "rb") as file:
            content = file.read()
        self.assertEqual(content[:8], b"\x89PNG\r\n\x1a\n")
        width, _ = struct.unpack(">II", content[16:24])
        self.assertEqual(width, page.locator("#stage canvas").evaluate("e => e.width"))
        self.assertGreater(len(content), 20000)

    def test_dark_and_light(self):
        brightness = "getComputedStyle(document.body).backgroundColor.match(/\\d+/g).slice(0, 3).map(Number).reduce((a, b) => a + b)"
        page = self.open(self.new_page(900, 560, "light"))
        self.assertGreater(page.evaluate(brightness), 600)
        page.click("#theme")
        self.assertLess(page.evaluate(brightness), 150)

    def test_a_phone_has_all_of_it(self):
        page = self.open(self.new_page(390, 780, "dark"))
        self.assertEqual(page.evaluate("document.documentElement.scrollWidth"), 390)
        page.click("#menu")
        page.click("[data-merge]")
        self.assertTrue(page.locator("#evidence").is_visible())


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]])
