#!/usr/bin/env python3
"""Renders one of the project's scenes as its NAME.json (by scenes/build.py) says.

    render_scene.py NAME.json [--program SUNDOG] ARGUMENTS OF sundog render...

Arguments given here are handed on after those from NAME.json.
"""

import json
import os
import subprocess
import sys


def arguments(sidecar):
    """The arguments of `sundog render` that NAME.json stands for."""
    folder = os.path.dirname(os.path.abspath(sidecar))
    with open(sidecar) as file:
        settings = json.load(file)
    given = [os.path.join(folder, settings["scene"])]
    for key in ("width", "height", "bounces", "filter", "view", "exposure"):
        # With "=", so that a negative number is not taken for a flag.
        given.append(f"--{key}={settings[key]}")
    if settings["environment"]:
        given.append(f"--environment={os.path.join(folder, settings['environment'])}")
        given.append(f"--environment-strength={settings['environment_strength']}")
        given.append(f"--environment-rotation={settings['environment_rotation']}")
    return given


def main():
    words = sys.argv[1:]
    program = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../target/release/sundog")
    if "--program" in words:
        at = words.index("--program")
        program = words[at + 1]
        del words[at : at + 2]
    if not words:
        sys.exit(__doc__)
    return subprocess.call([os.path.normpath(program), "render", *arguments(words[0]), *words[1:]])


if __name__ == "__main__":
    sys.exit(main())
