#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""mmlins run --view: the same files as without it, whoever looks on; what is told by WebSocket; and the page meanwhile."""

import base64
import contextlib
import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import unittest

import chromium
from program import MMLINS, mmlins, shared

# Times of work are told in these; an index is compared by what is in it.
TIMED = {"health.csv", "summary.json", "report.html", "index.sqlite"}


def command(out, *options):
    return [MMLINS, "run", shared("loop/recording.bag"), "--rig", shared("loop/rig.yaml"), "--out", shared(out), *options]


def files_of(out):
    folder = pathlib.Path(shared(out))
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file() and path.name not in TIMED}


@contextlib.contextmanager
def running(out, *options):
    """A run that is shown, and the port."""
    with open(shared(f"{out}.err"), "w") as errors:
        process = subprocess.Popen(command(out, "--view", "--no-browser", *options), stdout=subprocess.PIPE, stderr=errors, text=True)
        try:
            line = process.stdout.readline()
            found = re.search(r"http://127.0.0.1:(\d+)/", line)
            assert found, line
            yield process, int(found.group(1))
        finally:
            process.kill()
            process.communicate()


@contextlib.contextmanager
def slowed(process):
    """Lets it run for a quarter of the time only: the run may be over before a browser has opened a page."""
    done = threading.Event()

    def brake():
        while not done.wait(0.02) and process.poll() is None:
            process.send_signal(signal.SIGSTOP)
            done.wait(0.06)
            process.send_signal(signal.SIGCONT)

    thread = threading.Thread(target=brake)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


class Listener:
    """The client's half of a WebSocket, for text that comes unfragmented."""

    def __init__(self, port, origin=None, small=False):
        self.socket = socket.socket()
        if small:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self.socket.settimeout(60)
        self.socket.connect(("127.0.0.1", port))
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall((f"GET /api/live HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                             f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n{'Origin: ' + origin + chr(13) + chr(10) if origin else ''}\r\n").encode())
        self.file = self.socket.makefile("rb")
        self.status = int(self.file.readline().split()[1])
        while self.file.readline().strip():
            pass

    def messages(self):
        while True:
            head = self.file.read(2)
            if len(head) < 2 or head[0] & 15 == 8:
                return
            length = head[1] & 127
            if length == 126:
                length = int.from_bytes(self.file.read(2), "big")
            elif length == 127:
                length = int.from_bytes(self.file.read(8), "big")
            text = self.file.read(length)
            if head[0] & 15 == 1:
                yield json.loads(text)

    def close(self):
        self.file.close()
        self.socket.close()


def setUpModule():
    if "without the viewer" in mmlins("view", shared("nothing")).stderr:
        print("mmlins was built without the viewer (there was no npm): nothing to test")
        sys.exit(77)
    result = mmlins("simulate", "demo", "--out", shared("loop"), "--set", "duration=65", "--set", "sensor.columns=160",
                    "--set", "trajectory.stand_still=1.5", "--set", "events=[{kind: blackout, start: 20, duration: 21}]")
    assert result.returncode == 0, result.stderr
    result = subprocess.run(command("plain"), capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, result.stderr


class Run(unittest.TestCase):
    def test_the_files_are_the_same_whoever_looks_on(self):
        plain = files_of("plain")
        self.assertIn("atlas/points_0000.chunk", plain)
        with running("watched", "--view-exit") as (process, port):
            quick, stalled = Listener(port), Listener(port, small=True)  # the second one never reads
            self.addCleanup(stalled.close)
            self.addCleanup(quick.close)
            scans, keyframes = 0, 0
            with contextlib.suppress(OSError):
                for message in quick.messages():
                    if "scans" in message:
                        self.assertEqual(message["scans"]["from"], scans)
                        scans += len(message["scans"]["t"])
                    keyframes = len(message.get("atlas", {}).get("keyframes", {}).get("id", [])) or keyframes
            self.assertEqual(process.wait(timeout=120), 0)
        self.assertGreater(scans, 300)
        self.assertGreater(keyframes, 20)
        watched = files_of("watched")
        self.assertEqual(set(watched), set(plain))
        for name in plain:
            self.assertEqual(watched[name], plain[name], name)
        for what in (["list"], ["show", "1"], ["check"]):
            told = [mmlins("maps", shared(out), *what).stdout.replace(shared(out), "") for out in ("plain", "watched")]
            self.assertEqual(told[0], told[1])

    def test_after_the_run_the_result_is_shown_until_ctrl_c(self):
        with running("stays") as (process, port):
            with contextlib.closing(Listener(port)) as listener:
                last = {}
                for last in listener.messages():
                    if last.get("ended"):
                        break
                self.assertEqual(last, {"ended": True})
            while "until Ctrl-C" not in process.stdout.readline():
                pass
            # It is a whole result by now, for others as well.
            self.assertEqual(mmlins("maps", shared("stays"), "check").returncode, 0)
            process.send_signal(signal.SIGINT)
            self.assertEqual(process.wait(timeout=10), 0)
        self.assertEqual(sorted(os.listdir(shared("stays/atlas"))), sorted(os.listdir(shared("plain/atlas"))))

    def test_ctrl_c_during_the_run_saves_and_ends(self):
        with running("stopped") as (process, port):
            with contextlib.closing(Listener(port)) as listener:
                next(listener.messages())
                process.send_signal(signal.SIGINT)
            self.assertEqual(process.wait(timeout=60), 130)
        self.assertTrue(os.path.exists(shared("stopped/trajectory.tum")))

    def test_pages_of_others_cannot_listen(self):
        with running("others", "--view-exit") as (_, port):
            for origin, status in (("http://example.org", 404), ("null", 404), (f"http://127.0.0.1:{port}", 101)):
                with contextlib.closing(Listener(port, origin)) as listener:
                    self.assertEqual(listener.status, status, origin)

    def test_a_port_in_use_is_one_line_before_the_run(self):
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            port = str(taken.getsockname()[1])
            result = subprocess.run(command("refused", "--view", "--port", port), capture_output=True, text=True, timeout=60)
        self.assertEqual(result.returncode, 1)
        self.assertEqual(len(result.stderr.strip().splitlines()), 1, result.stderr)
        self.assertIn(f"port {port}", result.stderr)
        self.assertFalse(os.path.exists(shared("refused")))

    def test_its_options_mean_nothing_without_it(self):
        for option in (["--port", "1234"], ["--view-exit"], ["--no-browser"]):
            self.assertEqual(subprocess.run(command("unasked", *option), capture_output=True).returncode, 2)


@chromium.required
class Browser(unittest.TestCase):
    def test_the_page_grows_with_the_run_and_then_shows_the_result(self):
        browser = chromium.launch(type(self))
        page = browser.new_page(viewport={"width": 700, "height": 500})
        counts, deadline = set(), time.monotonic() + 120

        def is_going_on():
            self.assertLess(time.monotonic(), deadline)
            page.wait_for_timeout(100)
            live, num_scans = page.evaluate("window.mmlins?.scene ? [mmlins.live, mmlins.scene.scans.t.length] : ['', 0]")
            counts.add(num_scans)
            return live != "ended"

        with running("seen") as (process, port):
            with slowed(process):  # at once: it may be over before the page has opened
                complaints = chromium.watch(page, f"http://127.0.0.1:{port}")
                page.goto(f"http://127.0.0.1:{port}/")
                while is_going_on() and len(counts) <= 4:
                    pass
            while is_going_on():
                pass
            self.assertGreater(len(counts), 2, "it was not told of scans as they came")
            deadline = time.monotonic() + 40
            while not page.evaluate("mmlins.cloud.isComplete && mmlins.cloud.drawn > 0"):
                self.assertLess(time.monotonic(), deadline)
                page.wait_for_timeout(100)
            self.assertEqual(page.locator("#name .live").inner_text(), "ended")
            self.assertEqual(page.locator("[data-merge]").count(), 1)
            self.assertEqual(complaints, [])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]])
