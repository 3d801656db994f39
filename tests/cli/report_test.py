#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""report.html of a run in which the pose is lost: its data against the other files, and the page in a real browser.

The browser is Chromium, driven by Playwright for Python; where one of them is missing these tests are skipped and say so.
"""

import csv
import json
import os
import re
import sys
import unittest

import chromium
from program import mmlins, shared


def text_of(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def data_of(report):
    return json.loads(re.search(r'id="data">(.*?)</script>', text_of(report), re.DOTALL).group(1))


def run(out, *options):
    return mmlins("run", shared("dark/recording.bag"), "--rig", shared("dark/rig.yaml"), "--out", shared(out), *options)


def setUpModule():
    """Dark for 25 s of 40: two maps."""
    result = mmlins("simulate", "demo", "--out", shared("dark"), "--set", "duration=40", "--set", "sensor.columns=160",
                    "--set", "trajectory.stand_still=1.5", "--set", "events=[{kind: blackout, start: 8, duration: 25}]")
    assert result.returncode == 0, result.stderr
    result = run("out", "--truth", shared("dark/truth.tum"))
    assert result.returncode == 0, result.stderr
    with open(shared("stdout"), "w") as file:
        file.write(result.stdout)


class Data(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.data = data_of(shared("out/report.html"))
        cls.summary = json.loads(text_of(shared("out/summary.json")))
        with open(shared("out/health.csv"), newline="") as file:
            cls.rows = list(csv.DictReader(file))

    def test_figures_are_those_of_the_summary(self):
        figures = self.data["figures"]
        for key in ("mmlins", "recording", "lidar_topic", "imu_topic", "threads", "scans", "scans_by_state", "scans_left_out", "scans_ahead_left_out",
                    "imu_samples_not_later", "clock_jumps_back", "interrupted", "read_error", "duration_s", "path_length_m",
                    "map_points", "stages", "wall_s", "real_time_factor"):
            self.assertEqual(figures[key], self.summary[key], key)
        for key in ("keyframes", "closures", "merges", "seconds", "seconds_between_maps", "rebuilt_local_maps"):
            self.assertEqual(figures["mapping"][key], self.summary["mapping"][key], key)
        self.assertGreaterEqual(figures["peak_memory_mib"], self.summary["peak_memory_mib"])  # taken later
        self.assertEqual(sum(figures["histogram"]["counts"]), self.summary["scans"])

    def test_stretches_are_the_rows_of_health(self):
        told = []
        for _, _, state, cause, number, scans in self.data["stretches"]:
            told += [(self.data["states"][state], self.data["causes"][cause], str(number))] * scans
        self.assertEqual(told, [(row["state"], row["cause"], row["map"]) for row in self.rows])

    def test_curves_are_the_columns_of_health(self):
        """Fewer scans than samples: nothing is thinned."""
        for name, column in (("t1_std", "t1_std"), ("r3_noise_share", "r3_noise_share"), ("total_ms", "total_ms"), ("points", "points")):
            curve = self.data["curves"][name]
            self.assertEqual(len(curve["y"]), len(self.rows), name)
            for value, row in zip(curve["y"], self.rows):
                if value is None:
                    self.assertEqual(row["iterations"], "0", name)
                elif value < 1e9:
                    # Four digits here, three decimals or four digits there.
                    self.assertAlmostEqual(value, float(row[column]), delta=1e-3 * abs(value) + 6e-4, msg=name)

    def test_maps_and_gaps_are_those_of_the_summary(self):
        self.assertEqual(len(self.data["maps"]), len(self.summary["maps"]))
        for told, known in zip(self.data["maps"], self.summary["maps"]):
            for key in ("id", "world", "began", "fell_asleep"):
                self.assertEqual(told[key], known[key])
        gap = self.data["maps"][1]["gap"]
        self.assertAlmostEqual(gap["seconds"], self.summary["maps"][1]["gap"]["seconds"], places=6)
        self.assertAlmostEqual(gap["std_position_m"] / self.summary["maps"][1]["gap"]["std_position_m"], 1.0, places=3)

    def test_headline_says_that_the_pose_was_lost(self):
        self.assertIn("lost once", self.data["findings"]["headline"]["text"])
        carried = sum(row["state"] in ("BRIDGING", "LOST", "RELOCATING") for row in self.rows)
        self.assertTrue(any(f"{carried} of {len(self.rows)} scans" in finding["text"] for finding in self.data["findings"]["list"]))

    def test_errors_are_those_of_evaluate(self):
        for name in ("odometry", "trajectory"):
            result = mmlins("evaluate", shared("dark/truth.tum"), shared(f"out/{name}.tum"), "--json")
            known = json.loads(result.stdout)["ate_m"]["rmse"]
            # The file has nine decimals.
            self.assertAlmostEqual(self.data["truth"][name]["ate_m"]["rmse"], known, places=6)
            self.assertRegex(text_of(shared("stdout")), rf"{name}\.tum against the truth *: ATE {known:.4f} m")
            curve = [y for y in self.data["curves"][f"{name}_error_m"]["y"] if y is not None]
            self.assertAlmostEqual((sum(y * y for y in curve) / len(curve)) ** 0.5 / known, 1.0, places=2)


class Truth(unittest.TestCase):
    def refused(self, path, *words):
        result = run("refused", "--truth", path)
        self.assertEqual(result.returncode, 1)
        lines = result.stderr.strip().splitlines()
        self.assertEqual(len(lines), 1, result.stderr)
        for word in (path, *words):
            self.assertIn(word, lines[0])
        self.assertFalse(os.path.exists(shared("refused")))

    def test_a_file_that_is_not_there_is_one_line_before_the_run(self):
        self.refused(shared("nothing.tum"), "no such file")

    def test_a_file_that_is_no_trajectory_is_one_line_before_the_run(self):
        with open(shared("bad.tum"), "w") as file:
            file.write("1 2 three\n")
        self.refused(shared("bad.tum"))

    def test_another_time_is_a_warning_and_a_report_without_it(self):
        with open(shared("early.tum"), "w") as file:
            file.writelines(f"{t}.0 {t} {t * t} 0 0 0 0 1\n" for t in range(1, 9))
        result = run("early", "--truth", shared("early.tum"))
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("no common time", result.stderr)
        self.assertIsNone(data_of(shared("early/report.html"))["truth"])


class Writing(unittest.TestCase):
    def test_a_report_that_cannot_be_written_is_one_clear_line_and_the_rest_is_there(self):
        os.makedirs(shared("blocked/report.html/occupied"))
        result = run("blocked")
        self.assertEqual(result.returncode, 1)
        self.assertIn("report.html", result.stderr.strip().splitlines()[-1])
        self.assertTrue(os.path.exists(shared("blocked/trajectory.tum")))
        self.assertFalse(os.path.exists(shared("blocked/report.html.part")))


@chromium.required
class Browser(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.browser = chromium.launch(cls)
        cls.summary = json.loads(text_of(shared("out/summary.json")))

    def open(self, width=1280, scheme="light"):
        """The page, which must neither complain nor ask for anything."""
        context = self.browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme)
        self.addCleanup(context.close)
        page = context.new_page()
        complaints = chromium.watch(page, "file:")
        page.goto("file://" + shared("out/report.html"))
        self.addCleanup(lambda: self.assertEqual(complaints, []))
        return page

    def test_figures_shown_agree_with_the_summary(self):
        page = self.open()
        shown = lambda name: re.sub(r"[^\d.]", "", page.locator(f'[data-figure="{name}"]').evaluate("e => e.firstChild.textContent"))
        total = self.summary["stages"]["total"]
        self.assertAlmostEqual(float(shown("work")) / total["mean_ms"], 1.0, delta=0.006)  # three digits
        self.assertAlmostEqual(float(shown("path")) / self.summary["path_length_m"], 1.0, delta=0.006)
        self.assertEqual(int(shown("closures")), self.summary["mapping"]["closures"]["counts"])
        self.assertAlmostEqual(float(shown("speed")) * self.summary["real_time_factor"], 1.0, delta=0.06)  # two digits
        placed = sum(self.summary["scans_by_state"][s] for s in ("INITIALIZING", "TRACKING", "DEGRADED"))
        self.assertAlmostEqual(float(shown("scans")), 100 * placed / self.summary["scans"], delta=0.051)
        for name, stage in self.summary["stages"].items():
            cells = page.locator(f'[data-stage="{name}"] td').all_text_contents()
            self.assertEqual(cells[:5], [name, *(f"{stage[k]:.2f}" for k in ("mean_ms", "median_ms", "p99_ms", "max_ms"))])
        self.assertIn("lost once", page.locator("h1").inner_text())

    def test_shows_every_section_with_a_drawing(self):
        page = self.open()
        for name in ("#map", "#timeline", "#observability .plot", "#matches .plot", "#histogram", "#work-charts .plot", "#truth-charts .plot"):
            box = page.locator(f"{name} svg").first.bounding_box()
            self.assertGreater(box["width"], 200, name)
            self.assertGreater(box["height"], 60, name)
        self.assertGreater(page.locator("#config .settings > div").count(), 100)
        self.assertNotIn("NaN", re.sub(r"base64,[\w+/=]+", "", page.content().split('id="data"')[0]))
        self.assertNotIn("undefined", page.locator("main").inner_text())

    def test_what_happened_can_be_selected_for_its_evidence(self):
        page = self.open()
        page.get_by_role("button", name=re.compile("LOST: no points")).first.click()
        self.assertIn("LOST: no points", page.locator("#evidence").inner_text())
        page.get_by_role("button", name=re.compile("before map 1")).press("Enter")
        self.assertIn("Gap before map 1", page.locator("#evidence").inner_text())
        self.assertIn(f"{self.summary['maps'][1]['gap']['seconds']:.2f} s", page.locator("#evidence").inner_text())

    def test_the_moment_under_the_pointer_is_told(self):
        page = self.open()
        page.locator("#timeline svg").scroll_into_view_if_needed()
        box = page.locator("#timeline svg").bounding_box()
        page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 10)
        self.assertRegex(page.locator("#time-readout").inner_text(), r"s · (BRIDGING|LOST): no points · map 0")
        self.assertEqual(page.locator("#map circle.cursor").get_attribute("visibility"), "visible")

    def test_the_way_can_be_coloured_by_state(self):
        page = self.open()
        page.click("button[data-colour=state]")
        self.assertIn("LOST", page.locator("#map-legend").inner_text())
        page.click("button[data-colour=map]")
        self.assertIn("map 1", page.locator("#map-legend").inner_text())

    def test_nothing_is_wider_than_a_phone(self):
        page = self.open(width=390)
        self.assertEqual(page.evaluate("document.documentElement.scrollWidth"), 390)
        page.evaluate("for (const node of document.querySelectorAll('details')) node.open = true")
        self.assertEqual(page.evaluate("document.documentElement.scrollWidth"), 390)

    def test_dark_is_dark_and_light_is_light(self):
        brightness = "getComputedStyle(document.body).backgroundColor.match(/\\d+/g).slice(0, 3).map(Number).reduce((a, b) => a + b)"
        self.assertLess(self.open(scheme="dark").evaluate(brightness), 150)
        self.assertGreater(self.open(scheme="light").evaluate(brightness), 600)

    def test_on_paper_everything_is_unfolded(self):
        page = self.open()
        page.pdf(path=shared("report.pdf"))
        page.emulate_media(media="print")
        page.evaluate("dispatchEvent(new Event('beforeprint'))")
        self.assertEqual(page.locator("details:not([open])").count(), 0)
        self.assertFalse(page.locator("#map-controls").is_visible())
        page.evaluate("dispatchEvent(new Event('afterprint'))")
        self.assertGreater(page.locator("details:not([open])").count(), 0)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]])
