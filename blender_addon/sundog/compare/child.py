# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison in a Blender of its own, so that the window stays free: how it is started, and what it runs."""

import collections
import json
import os
import signal
import subprocess
import sys
import threading

import bpy

from .. import preferences
from . import job, settings

# How the child's own lines begin; Blender prints others.
MARK = "SUNDOG-COMPARE "
_LAST_WORDS = 12


def main(order_path):
    """In the child: carries out an order (a JSON file) and tells on the standard output how it goes."""
    with open(order_path, encoding="utf-8") as file:
        order = json.load(file)

    def tell(**event):
        print(MARK + json.dumps(event), flush=True)

    try:
        job.run(order["file"], order["folder"], settings.Options(**order["options"]), report=lambda f, t: tell(fraction=f, text=t))
    except job.CompareError as error:
        tell(error=str(error))
    except Exception as error:
        tell(error=f"a mistake in the add-on, please report it: {type(error).__name__}: {error}")
        raise


def command_line(order_path):
    """Blender without a window (or, in Blender as a Python module, that Python), with the add-on enabled as it is here."""
    add_on = __package__.rpartition(".")[0]
    code = (
        "import addon_utils, importlib;"
        # The preferences with which it is enabled here may not be saved yet.
        f" addon_utils.check({add_on!r})[1] or addon_utils.enable({add_on!r});"
        f" importlib.import_module({__name__!r}).main({order_path!r})"
    )
    if bpy.app.binary_path:
        # Drivers run there if they run here.
        scripts = "--disable-autoexec" if bpy.app.autoexec_fail else "--enable-autoexec"
        return [bpy.app.binary_path, "--background", scripts, "--python-exit-code", "1", "--python-expr", code]
    return [sys.executable, "-c", f"import sys; sys.path.extend({sys.path!r}); import bpy; {code}"]


class Child:
    """A comparison that is under way."""

    def __init__(self, blend, folder, options, order_path):
        with open(order_path, "w", encoding="utf-8") as file:
            json.dump({"file": blend, "folder": folder, "options": options.__dict__}, file)
        environment = dict(os.environ)
        # The child has the user's saved preferences, which may name another program than the window's.
        environment["SUNDOG_PROGRAM"] = preferences.find_program()[0]
        self._process = subprocess.Popen(
            command_line(order_path), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            errors="replace", env=environment, start_new_session=True,
        )  # fmt: skip
        self.fraction, self.text, self.error = 0.0, "Starting Blender", None
        self._words = collections.deque(maxlen=_LAST_WORDS)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self._process.stdout:
            if not line.startswith(MARK):
                self._words.append(line.strip())
                continue
            event = json.loads(line.removeprefix(MARK))
            self.fraction, self.text = event.get("fraction", self.fraction), event.get("text", self.text)
            self.error = event.get("error", self.error)

    def ended(self):
        """Whether it is over; `error` then says why it failed, if it did."""
        if self._process.poll() is None:
            return False
        self._reader.join(timeout=2.0)
        if self.error is None and self._process.returncode != 0:
            words = " / ".join(word for word in self._words if word)
            self.error = f"the Blender that compares has ended with {self._process.returncode}: {words}"
        return True

    def wait(self, seconds):
        """Waits so long at most."""
        try:
            self._process.wait(timeout=seconds)
        except subprocess.TimeoutExpired:
            pass

    def stop(self):
        """Ends it, with the program that it may be running (they are one process group)."""
        try:
            os.killpg(self._process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        self._process.wait()
        self._reader.join(timeout=2.0)
