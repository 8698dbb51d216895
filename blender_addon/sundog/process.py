# SPDX-License-Identifier: GPL-3.0-or-later
"""The program as a child process: one line of JSON an event, frames of raw floats in a folder.

Knows nothing of Blender.
"""

import atexit
import collections
import json
import os
import queue
import shutil
import signal
import subprocess
import tempfile
import threading
import time

# How long the last frame is waited for after an interrupt: with the poll before it and the copying
# after it, half a second from Esc to the end.
PATIENCE = 0.3
# A process that has closed its standard output has this long to end by itself.
LAST_BREATH = 2.0
# Lines of the program's standard error that are kept as its last words.
LAST_WORDS = 40

_running, _folders = set(), set()


class ProgramError(Exception):
    """Why there is no picture, in one sentence, with the program's last words."""


class Run:
    """One run of the program, from its start to its end. Use it in a `with` block; the `folder` goes with it.

    Its environment is this process's if none is given.
    """

    def __init__(self, command, folder=None, environment=None):
        self.program, self._folder = command[0], folder
        self._reaper = None
        self._events = queue.SimpleQueue()
        self._stderr = collections.deque(maxlen=LAST_WORDS)
        self._strange = None
        self._ended = False
        self.error = None
        self.interrupted = False
        try:
            self._child = subprocess.Popen(
                command,
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                # A group of its own: the terminal's Ctrl-C is Blender's to pass on.
                start_new_session=True,
            )
        except OSError as error:
            raise ProgramError(
                f"the program {self.program} cannot be started: {error.strerror or error}; choose another one in the"
                " preferences of the add-on"
            ) from error
        if folder is not None:
            folder.lent = True
        _running.add(self)
        self._threads = [
            threading.Thread(target=self._read_events, name="sundog events", daemon=True),
            threading.Thread(target=self._read_words, name="sundog words", daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    # What it says

    def _read_events(self):
        # A crash may cut a line in its middle: that is no event.
        for line in self._child.stdout:
            try:
                event = json.loads(line)
                kind = event["event"]
            except (ValueError, KeyError, TypeError):
                self._strange = line.decode(errors="replace").strip()[:200]
                continue
            if kind == "error":
                self.error = str(event.get("message", "it does not say why"))
            self._events.put(event)
        self._events.put(None)

    def _read_words(self):
        for line in self._child.stderr:
            self._stderr.append(line.decode(errors="replace").rstrip())

    def next(self, seconds):
        """The next event; None if there is none within `seconds`, or ever."""
        if self._ended:
            return None
        try:
            event = self._events.get(timeout=seconds)
        except queue.Empty:
            return None
        self._ended = event is None
        return event

    @property
    def ended(self):
        """Whether all events have been read and no more will come."""
        return self._ended

    @property
    def memory(self):
        """Megabytes that the program holds now, and the most it held; zeros where that cannot be told."""
        found = {"VmRSS": 0.0, "VmHWM": 0.0}
        try:
            with open(f"/proc/{self._child.pid}/status", encoding="ascii", errors="replace") as file:
                for line in file:
                    name, _, rest = line.partition(":")
                    if name in found:
                        found[name] = int(rest.split()[0]) / 1024
        except (OSError, ValueError, IndexError):
            pass
        return found["VmRSS"], found["VmHWM"]

    # How it ends

    def interrupt(self):
        """Asks for the picture as it is. A second interrupt would end the program without one."""
        if not self.interrupted:
            self.interrupted = True
            self._signal(signal.SIGINT)

    def _signal(self, number):
        # Not yet waited for, so the number is still this child's.
        if self._child.returncode is None:
            try:
                os.killpg(self._child.pid, number)
            except (ProcessLookupError, PermissionError):
                pass

    def rest(self, seconds):
        """The events that come within `seconds` after an interrupt, until the last frame."""
        deadline = time.monotonic() + seconds
        while not self.ended:
            event = self.next(max(deadline - time.monotonic(), 0))
            if event is None and time.monotonic() >= deadline:
                return
            if event is not None:
                yield event
                if event["event"] == "frame" and event.get("final"):
                    return

    def check(self):
        """Waits for the end after all events are read; raises ProgramError if it was not a good one."""
        try:
            code = self._child.wait(LAST_BREATH)
        except subprocess.TimeoutExpired:
            self._signal(signal.SIGKILL)
            code = self._child.wait()
        if code == 0 or self.interrupted:
            return
        for thread in self._threads:
            thread.join(0.2)
        if code < 0:
            raise ProgramError(f"the program crashed ({_signal_name(-code)}){self._last_words()}")
        if self.error:
            raise ProgramError(self.error)
        raise ProgramError(f"the program ended with exit code {code}{self._last_words()}")

    def _last_words(self):
        words = [line for line in self._stderr if line.strip()]
        if self.error:
            words.append(self.error)
        elif not words and self._strange:
            words.append(self._strange)
        return f"; its last words: {' / '.join(words[-3:])}" if words else " without a word"

    def close(self):
        """Ends the program if it still runs, and waits for it, so that neither a zombie nor a file stays. Safe to call twice."""
        if self._reaper is None:
            self._reap()

    def leave(self):
        """As `close`, but waits in a thread: the end of a process with much memory takes its time."""
        self._reaper = threading.Thread(target=self._reap, name="sundog end")
        self._reaper.start()

    def _reap(self):
        self._signal(signal.SIGKILL)
        self._child.wait()
        for thread in self._threads:
            thread.join(1.0)
        for pipe in (self._child.stdout, self._child.stderr):
            pipe.close()
        if self._folder is not None:
            self._folder.remove()
        _running.discard(self)


def _signal_name(number):
    try:
        return f"{signal.Signals(number).name}: {signal.strsignal(number)}"
    except ValueError:
        return f"signal {number}"


class Folder:
    """A new folder in `place` for one run; it goes with the `with` block, or with Blender."""

    def __init__(self, place):
        try:
            self.path = tempfile.mkdtemp(prefix="sundog-", dir=place)
        except OSError as error:
            raise ProgramError(
                f"no folder can be made in {place} ({error.strerror or error}): choose another one in Blender's"
                " preferences, File Paths, Temporary Files"
            ) from error
        # A run has it and removes it after its end.
        self.lent = False
        _folders.add(self)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if not self.lent:
            self.remove()

    def remove(self):
        """Takes it away with all that is in it."""
        shutil.rmtree(self.path, ignore_errors=True)
        _folders.discard(self)


@atexit.register
def _end_all():
    for run in list(_running):
        run.close()
    for folder in list(_folders):
        folder.remove()
