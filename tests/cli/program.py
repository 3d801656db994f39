# SPDX-License-Identifier: MIT
"""The program under test, whose path is the first argument, and a folder that the tests of a file share."""

import atexit
import os
import subprocess
import sys
import tempfile

MMLINS = sys.argv[1] if len(sys.argv) > 1 else "mmlins"
SHARED = tempfile.TemporaryDirectory()
atexit.register(SHARED.cleanup)


def mmlins(*arguments, folder=None):
    """Runs a command to its end. folder: where, if not here."""
    return subprocess.run([MMLINS, *map(str, arguments)], capture_output=True, text=True, timeout=300, cwd=folder)


def shared(name):
    return os.path.join(SHARED.name, name)
