# SPDX-License-Identifier: GPL-3.0-or-later
"""Another Blender that renders worlds, kept between frames: its start takes longer than its work."""

import atexit
import json
import os
import queue
import signal
import subprocess
import sys
import threading
import time

import bpy

# The longest that one world may take.
MOST_SECONDS = 300
# A Blender that is told nothing for so long ends.
IDLE_SECONDS = 120
# Seconds between two looks at whether the bake shall go on.
POLL = 0.02

ANSWER = "SUNDOG-BAKED "


class BakeError(Exception):
    """Why a world could not be baked, in one sentence."""


class _Ended(BakeError):
    """The child has ended, by itself or by somebody else."""


class Baker:
    """One child process."""

    def __init__(self):
        script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "bake_world.py")
        if bpy.app.binary_path:
            command = [bpy.app.binary_path, "--background", "--factory-startup", "--python-exit-code", "1", "--python", script]
        else:
            command = [sys.executable, script]
        command += ["--", str(IDLE_SECONDS)]
        try:
            self.child = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
                start_new_session=True,
            )  # fmt: skip
        except OSError as error:
            raise BakeError(str(error)) from error
        self.lines = queue.SimpleQueue()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        for line in self.child.stdout:
            self.lines.put(line)
        self.lines.put(None)

    def ask(self, request, report):
        """The answer to a request. `report` is told all the while, and may stop it by raising."""
        deadline = time.monotonic() + MOST_SECONDS
        try:
            self.child.stdin.write(json.dumps(request) + "\n")
            self.child.stdin.flush()
        except OSError as error:
            raise _Ended(f"Blender ended ({error.strerror})") from error
        last = ""
        while True:
            if report:
                report("baking the world")
            if time.monotonic() > deadline:
                raise BakeError(f"it takes longer than {MOST_SECONDS} s")
            try:
                line = self.lines.get(timeout=POLL)
            except queue.Empty:
                continue
            if line is None:
                raise _Ended(last or f"Blender ended with {self.child.wait()}")
            if line.startswith(ANSWER):
                answer = json.loads(line[len(ANSWER) :])
                if "error" in answer:
                    raise BakeError(answer["error"])
                return answer
            last = line.strip() or last

    def is_alive(self):
        """Whether it can be asked."""
        return self.child.poll() is None

    def end(self):
        """Ends it, whatever it does."""
        try:
            os.killpg(self.child.pid, signal.SIGKILL)
        except OSError:
            pass
        self.child.wait()
        for pipe in (self.child.stdin, self.child.stdout):
            try:
                pipe.close()
            except OSError:
                pass


class _Kept:
    baker = None
    lock = threading.Lock()


def start():
    """Starts a Blender, if there is none: its start then runs beside other work."""
    with _Kept.lock:
        _running()


def _running():
    if _Kept.baker is None or not _Kept.baker.is_alive():
        if _Kept.baker is not None:
            _Kept.baker.end()
        _Kept.baker = Baker()
    return _Kept.baker


def ask(request, report=None):
    """The answer of a Blender to a request, see bake_world.bake."""
    with _Kept.lock:
        kept = _Kept.baker is not None
        while True:
            baker = _running()
            try:
                return baker.ask(request, report)
            except BaseException as error:
                # It may still be busy with what nobody waits for.
                _Kept.baker = None
                baker.end()
                # One that has waited for long may end just now.
                if not (kept and isinstance(error, _Ended)):
                    raise
                kept = False


def end():
    """Ends what is kept."""
    with _Kept.lock:
        if _Kept.baker is not None:
            _Kept.baker.end()
            _Kept.baker = None


atexit.register(end)
