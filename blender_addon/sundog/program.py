# SPDX-License-Identifier: GPL-3.0-or-later
"""Which program renders, and what it can do. Knows nothing of Blender."""

import functools
import json
import os
import shutil
import subprocess

from . import bundled
from .process import ProgramError

NAME = "sundog"
# Wins over the program that came with the add-on; for tests and developers.
VARIABLE = "SUNDOG_PROGRAM"


def find(chosen=""):
    """(path, where it comes from); `chosen` is the preferences' choice. Raises ProgramError."""
    named = ((chosen, "the preferences"), (os.environ.get(VARIABLE), f"the variable {VARIABLE}"))
    for path, source in named:
        if path:
            path = os.path.abspath(os.path.expanduser(path))
            _check(path, source)
            return path, source
    inside = bundled.program()
    if inside:
        return inside, "the add-on"
    on_path = shutil.which(NAME)
    if on_path:
        return on_path, "PATH"
    checkout = os.path.dirname(os.path.dirname(bundled.FOLDER))
    built = os.path.join(checkout, "target", "release", NAME)
    if os.path.isfile(built):
        return built, "the checkout"
    raise ProgramError(
        "there is no sundog program: this copy of the add-on has none, and neither has PATH; choose one in the preferences"
        " of the add-on"
    )


def _check(path, source):
    if not os.path.isfile(path):
        raise ProgramError(f"the program {path}, named by {source}, does not exist: choose another one in the preferences of the add-on")
    if not os.access(path, os.X_OK):
        raise ProgramError(f"the program {path}, named by {source}, is not executable: make it so, or choose another one")


def ask(path, *arguments, seconds=20):
    """What the program says to a short question. Raises ProgramError."""
    try:
        done = subprocess.run(
            [path, *arguments], stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace", timeout=seconds, check=False
        )
    except subprocess.TimeoutExpired as error:
        raise ProgramError(f"the program {path} does not answer within {seconds} s: choose another one in the preferences of the add-on") from error
    except OSError as error:
        raise ProgramError(f"the program {path} cannot be started: {error.strerror or error}; choose another one in the preferences of the add-on") from error
    if done.returncode != 0:
        words = (done.stderr.strip() or done.stdout.strip() or "without a word").splitlines()[-1]
        raise ProgramError(f"the program {path} ended with exit code {done.returncode}: {words}")
    return done.stdout


class Abilities:
    """What `sundog flags --json` says that the program can do."""

    def __init__(self, flags):
        self.version = flags.get("version", "?")
        self._flags = {}
        for command in flags.get("commands", ()):
            arguments = [a for group in command.get("groups", ()) for a in group.get("arguments", ())]
            self._flags[command["name"]] = {argument["name"]: argument for argument in arguments}

    def has(self, flag, command="render"):
        """Whether a command knows a flag."""
        return flag in self._flags.get(command, {})


def abilities(path):
    """Abilities of the program; asked anew when the file changes. Raises ProgramError."""
    try:
        stamp = os.stat(path).st_mtime_ns
    except OSError as error:
        raise ProgramError(f"the program {path} cannot be read: {error.strerror}") from error
    found = _abilities(path, stamp)
    if isinstance(found, ProgramError):
        raise found
    return found


@functools.lru_cache(maxsize=4)
def _abilities(path, _stamp):
    # An error is kept too: the preferences ask at each drawing.
    try:
        return Abilities(json.loads(ask(path, "flags", "--json")))
    except ProgramError as error:
        return error
    except (ValueError, KeyError, TypeError, AttributeError):
        return ProgramError(f"the program {path} does not tell its flags: it is no sundog program, or an old one")
