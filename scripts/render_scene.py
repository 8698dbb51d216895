#!/usr/bin/env python3
"""Renders one of the project's scenes as its NAME.json (by scenes/build.py) says.

    render_scene.py NAME.json [--program SUNDOG] [--pixels N] ARGUMENTS OF sundog render...

Arguments given here are handed on after those from NAME.json. --pixels makes the picture as small as that.
"""

import json
import math
import os
import subprocess
import sys


def arguments(sidecar, pixels=None):
    """The arguments of `sundog render` that NAME.json stands for, in a picture of its size or of about so many pixels."""
    folder = os.path.dirname(os.path.abspath(sidecar))
    with open(sidecar) as file:
        settings = json.load(file)
    if pixels is not None:
        factor = math.sqrt(pixels / (settings["width"] * settings["height"]))
        for side in ("width", "height"):
            settings[side] = max(round(settings[side] * factor), 1)
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
    own = {"--program": os.path.join(os.path.dirname(os.path.abspath(__file__)), "../target/release/sundog"), "--pixels": None}
    for option in own:
        if option in words:
            at = words.index(option)
            own[option] = words[at + 1]
            del words[at : at + 2]
    if not words:
        sys.exit(__doc__)
    pixels = None if own["--pixels"] is None else int(own["--pixels"])
    return subprocess.call([os.path.normpath(own["--program"]), "render", *arguments(words[0], pixels), *words[1:]])


if __name__ == "__main__":
    sys.exit(main())
